"""Second derivatives of the equations of an operation by the parameters of curves and by a time that moves, contracted.

ℓ = μᵀR (`shares`) depends on curves f(x; c) through their values and slopes. Along a direction of states, multipliers,
parameters and time it changes by

    ℓ' = ∇ℓ · x' + ℓ_t t' + Σ ∂ℓ/∂f⁽ᵒ⁾ g⁽ᵒ⁾(x),    g = ∂f/∂c · c',

which is recorded; g is a function of the same kind as f. The gradient of ℓ' by everything is the change of the gradient
of ℓ. `lagrangian` compiles the part of ∇ℓ · x' in states, multipliers and parameters of elements; the rest is here, for
all occurrences of an operation at once.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ...._jit.formulas.differentiate import directional
from ...._jit.formulas.expression import Expression, Graph
from ...._jit.formulas.replay import needed
from ...._jit.formulas.reverse import gradient
from ...._jit.kernels.emit import NUMBERS_DOT
from ....algebra import Array
from ....elements.recorder import Variant
from ....system import System
from ....system.curves.curve_derivatives import ORDERS, ROWS, CurveDerivatives, curves_of, values_of_elements
from ....system.curves.time_derivatives import TimeDerivatives
from ....system.structure.population import Population
from .elements import STATES, Share, concerned

CURVES_DOT = "curves_dot"  # changes of curves


class Additions(NamedTuple):
    """Additions to the change of the gradient of ℓ by q, v, a (nt, nq), λ (nt, m), parameters and times."""

    q: Array
    v: Array
    a: Array
    lam: Array
    b: Array
    t: Array


class Call(NamedTuple):
    """A call of a curve, or of its change: place of the curve's number, order of the derivative, argument."""

    changed: bool
    place: int
    order: int
    x: Expression


class _Recipe(NamedTuple):
    """Recorded parts of the change for one kind of element: by bodies, equations, numbers, time and calls of curves."""

    graph: Graph
    calls: list[Call]
    parts: dict[str, list[Expression]]

    @property
    def wanted(self) -> list[Expression]:
        """All of them, the arguments of the calls first."""
        return [*(call.x for call in self.calls), *(x for part in self.parts.values() for x in part)]


class CurveLagrangian:
    """Second derivatives of Lagrangians by the parameters of curves, and by the time if it moves.

    Parameters
    ----------
    system : System
    curves : whether the parameters of curves change
    moving : whether the time does
    """

    def __init__(self, system: System, curves: bool, moving: bool) -> None:
        self._system, self._moving = system, moving
        self._of = TimeDerivatives(system) if moving else CurveDerivatives(system)
        self._own = [p for p in system.populations if p.count and self._of.concerns(p)]
        self._own = self._own if curves or moving else []

    def __bool__(self) -> bool:
        return bool(self._own)

    def change(
        self, kind: str, b: Array, b_dot: Array, memory: Mapping[int, Array], **given: Array
    ) -> Additions:
        """The part of the change of the gradient of ℓ at many times.

        Parameters
        ----------
        kind : of ℓ, see `shares`
        b, b_dot : (len(system.b),) parameters and their changes
        memory : what elements remember at each time (nt,), by place in b
        given : operands of ℓ (nt, nq) or (nt, m), and their changes; the times ``t``, ``t_dot`` (nt,); others are zero
        """
        system, count = self._system, len(given["t"])
        of_bodies = (*STATES, *(f"{name}_dot" for name in STATES), "xi")
        operands: dict[str, Array] = {name: np.zeros((count, system.nq)) for name in of_bodies}
        operands |= {name: np.zeros((count, system.m)) for name in ROWS}
        operands |= {"t_dot": np.zeros(count), **given}
        q, v, a, lam = (np.zeros((count, width)) for width in (system.nq, system.nq, system.nq, system.m))
        found = Additions(q, v, a, lam, np.zeros(len(b)), np.zeros(count))
        own = {p.variant for p in concerned(system, kind)}
        for p in self._own:
            if p.variant in own:
                self._add(p, kind, b, b_dot, memory, operands, found)
        return found

    def _add(
        self, p: Population, kind: str, b: Array, b_dot: Array, memory: Mapping[int, Array],
        operands: Mapping[str, Array], to: Additions,
    ) -> None:  # fmt: skip
        """The part of all elements of a population."""
        recipe, size = _recipe(p.variant, kind, self._moving), p.kind.size()
        places = [n for _, n in curves_of(p.kind)]
        changes = {n: [self._of.change_of(p, k, n, b_dot) for k in range(p.count)] for n in places}
        dots = b_dot[p.at : p.end].reshape(p.count, size)
        more: dict[tuple[Any, ...], Any] = {(NUMBERS_DOT, n): dots[:, n, None] for n in range(size)}
        more |= {(CURVES_DOT, n): own for n, own in changes.items()}
        wanted = recipe.wanted
        values = values_of_elements(
            p, recipe.graph, wanted, needed(recipe.graph, wanted), b, memory, operands, more
        )
        x, values = values[: len(recipe.calls)], values[len(recipe.calls) :]
        part, at = {}, 0
        for name, own in recipe.parts.items():
            part[name], at = values[at : at + len(own)], at + len(own)
        for name in STATES:
            for place, moved in enumerate(part[name]):
                np.add.at(getattr(to, name).T, p.coordinates[:, place], moved)
        for n, moved in enumerate(part["lam"]):
            np.add.at(to.lam.T, p.rows + n, moved)
        for n, moved in enumerate(part["b"]):
            to.b[p.at + n : p.end : size] += moved.sum(axis=1)
        to.t[:] += part["t"].sum(axis=(0, 1))
        for j, call in enumerate(recipe.calls):
            for k in range(p.count):
                change = changes[call.place][k] if call.changed else None
                columns, basis = self._of.by_parameters(p, k, call.place, call.order, x[j, k], change)
                weights = (basis * part["calls"][j, k]).reshape(-1)
                to.b[:] += np.bincount(columns.reshape(-1), weights, minlength=len(to.b))


@cache
def _recipe(variant: Variant, kind: str, moving: bool) -> _Recipe:
    share, size = Share(variant, kind), variant.kind.size()
    graph, time = share.graph, share.graph.input("t")
    (value,) = graph.expressions([share.value])
    states = {name: list(share.moving[name].flat) for name in STATES}
    pairs = [
        (x, dot)
        for name in STATES
        for x, dot in zip(states[name], share.coordinates(f"{name}_dot").flat, strict=True)
    ]
    pairs += zip(share.lam, share.rows("lam_dot"), strict=True)
    free = [n for n, held in enumerate(share.held) if not held]
    dots = graph.inputs(NUMBERS_DOT, size)
    pairs += [(share.numbers[n], dots[n]) for n in free]
    slopes = gradient(graph, value, [time, *(call for _, call in _calls(graph, value))])
    moved = [slopes[0] * graph.input("t_dot")] if moving else []
    moved += [
        slope * graph.input(CURVES_DOT, call.place).call(graph.nodes[own.id].op, call.x)
        for slope, (call, own) in zip(slopes[1:], _calls(graph, value), strict=True)
    ]
    (beyond,) = graph.expressions([sum(moved)])
    whole = directional(graph, [value], pairs)[0] + beyond

    def by(of: Expression, variables: list[Expression]) -> list[Expression]:
        return gradient(graph, of, variables)

    numbers = dict(zip(free, by(beyond, [share.numbers[n] for n in free]), strict=True))
    calls = _calls(graph, whole)
    parts = {name: by(beyond, xs) for name, xs in states.items()}
    parts |= {"lam": by(beyond, list(share.lam))}
    parts |= {"b": [numbers.get(n, graph.constant(0)) for n in range(size)]}
    parts |= {"t": by(whole, [time]) if moving else [], "calls": by(whole, [own for _, own in calls])}
    return _Recipe(graph, [call for call, _ in calls], parts)


def _calls(graph: Graph, of: Expression) -> list[tuple[Call, Expression]]:
    """All calls of curves that an expression needs, and what each gives."""
    found = []
    for n in needed(graph, [of]):
        node = graph.nodes[n]
        if node.op in ORDERS:
            name, place = graph.nodes[node.args[0]].value
            call = Call(name == CURVES_DOT, place, ORDERS[node.op], Expression(graph, node.args[1]))
            found.append((call, Expression(graph, n)))
    return found
