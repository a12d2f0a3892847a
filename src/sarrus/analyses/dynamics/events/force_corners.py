"""Corners of force laws along a run: functions whose sign changes a law, found in the recorded formulas of elements.

A contact that touches or leaves, the ends of a rounding, an absolute value and a maximum in a user's formula. A step
ends at each of them, so that the law is smooth within every step.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ...._jit.formulas.expression import Expression, Graph
from ...._jit.formulas.replay import needed
from ....algebra import Array
from ....elements.operators import OPERATORS
from ....elements.recorder import Variant
from ....model import Formula
from ....model.tape import Traced
from ....outputs.recording import TRACED, Recording
from ....system import System
from ....system.curves.curve_derivatives import (
    CurveDerivatives,
    entries_of,
    evaluated,
    formula_graph,
    formula_values,
    steps_in,
    stored,
)
from ....system.structure.population import Population
from ..stepping.nodes import Nodes, between

LOOKS = np.array([0.25, 0.5, 0.75, 1.0])  # parts of a step at which signs are compared
NEAR = 1e-10  # of a step: so long before a corner a step ends, and so long behind it the next one begins
ROUND = 1e-14  # of the time: the same, at least
ROUNDS, POINTS = 2, 33  # of the search within a step; the steps themselves do the rest
GRAZES = 1e-2  # of what a function changes within a step: slower crossings only graze


class ForceFunctions(NamedTuple):
    """The forces of a kind of element, arguments whose sign counts, of tanh, and of curves with their places."""

    graph: Graph
    entries: list[Expression]
    signs: list[Expression]
    reversals: list[Expression]
    curves: list[tuple[int, Expression]]


@cache
def force_functions(variant: Variant) -> ForceFunctions:
    """What the recorded force of a kind of element consists of."""
    graph, _, entries = entries_of(variant, "Q")
    nodes = {n: graph.nodes[n] for n in needed(graph, entries)}

    def arguments(op: str) -> list[Expression]:
        return [Expression(graph, node.args[-1]) for node in nodes.values() if node.op == op]

    places = [graph.nodes[node.args[0]].value[1] for node in nodes.values() if node.op == "curve"]
    curves = list(zip(places, arguments("curve"), strict=True))
    return ForceFunctions(graph, entries, arguments("positive"), arguments("tanh"), curves)


def law_signs(law: Any) -> list[Expression]:
    """The expressions of a formula whose sign changes it."""
    if not isinstance(law, Formula):
        return []
    graph, found = formula_graph(law)
    return steps_in(graph, [found])


@dataclass(frozen=True, eq=False)
class Corner:
    """A function of one element whose sign changes its force: one of the force, or one of a formula in it.

    Attributes
    ----------
    owner : the part of the model
    population, element : index among the system's populations, and the element in it
    sign : index of the function
    curve : index of the formula among those of the force; negative for the force itself
    """

    owner: str
    population: int
    element: int
    sign: int
    curve: int = -1

    def record(self, recording: Recording) -> Traced:
        """Its value along a recorded motion, which can be differentiated."""
        p = recording.system.populations[self.population]
        known = force_functions(p.variant)
        if self.curve < 0:
            return recording.replayed(p, self.element, known.graph, [known.signs[self.sign]])[0]
        place, x = known.curves[self.curve]
        law = stored(p, self.element, place)
        argument = recording.replayed(p, self.element, known.graph, [x])[0]
        graph, signs = formula_graph(law)[0], law_signs(law)
        found: Traced = evaluated(graph, [signs[self.sign]], {("x",): argument}, TRACED)[0]
        return found


class Located(NamedTuple):
    """A corner that a step passes: the step, the time, the sign before it, and the function's rate [1/s]."""

    corner: int
    step: int
    t: float
    before: float
    rate: float


class ForceCorners:
    """The corners of all forces of a system."""

    def __init__(self, system: System) -> None:
        self._system, self._derivatives = system, CurveDerivatives(system)
        self._groups = [
            (n, p) for n, p in enumerate(system.populations)
            if p.count and OPERATORS["Q"] in p.kind.family and _has_corners(p)
        ]  # fmt: skip
        self.all = [corner for n, p in self._groups for corner in _corners_of(n, p)]

    def __bool__(self) -> bool:
        return bool(self.all)

    def values(self, b: Array, memory: Array, t: Array, q: Array, v: Array) -> tuple[Array, Array]:
        """The functions of all corners (corners, nt), and whether the forces that they belong to act."""
        places = dict(zip(self._system.memory_places.tolist(), memory.T, strict=True))
        operands, rows, acts = {"q": q, "v": v, "t": t}, list[Array](), list[Array]()
        for _, p in self._groups:
            known = force_functions(p.variant)
            wanted = [*known.entries, *known.signs, *(x for _, x in known.curves)]
            found = self._derivatives.on_elements(
                p, known.graph, wanted, needed(known.graph, wanted), b, places, operands
            )
            forces, signs, curves = np.split(
                found, [len(known.entries), len(known.entries) + len(known.signs)]
            )
            for k in range(p.count):
                own = [*signs[:, k]]
                for (place, _), x in zip(known.curves, curves[:, k], strict=True):
                    law = stored(p, k, place)
                    own += [*formula_values(law, law_signs(law), x)] if law_signs(law) else []
                rows += own
                acts += [np.any(forces[:, k] != 0, axis=0)] * len(own)
        return np.array(rows), np.array(acts)

    def first(self, nodes: Nodes, b: Array, apart: bool) -> Located | None:
        """The first corner that a step passes, if there is one."""
        if len(nodes.t) < 2:
            return None
        looks = _looks(nodes, apart)
        values, acts = self.values(b, looks.memory, looks.t, looks.q, looks.v)
        acting = acts[:, 1:] | acts[:, :-1]
        passed = (values[:, 1:] * values[:, :-1] < 0) & acting
        found = list[Located]()
        for at in np.flatnonzero(passed.any(axis=0)):
            for corner in np.flatnonzero(passed[:, at]):
                one = self._located(int(corner), int(at), looks, nodes, values[corner], b, apart)
                found += [one] if one else []
            if found:
                return min(found, key=lambda one: one.t)
        return None

    def _located(
        self, corner: int, at: int, looks: Nodes, nodes: Nodes, values: Array, b: Array, apart: bool
    ) -> Located | None:
        """One sign change between two looks; nothing where the step begins or ends with it, or where it grazes."""
        step = at // len(LOOKS)
        pair = nodes.part(slice(step, step + 2))
        h = float(pair.t[1] - pair.t[0])
        low, high = ((looks.t[at + n] - pair.t[0]) / h for n in (0, 1))
        before = float(np.sign(values[at]))

        for _ in range(ROUNDS):
            parts = np.linspace(low, high, POINTS)
            there = _within(pair, parts, apart)
            after = self.values(b, there.memory, there.t, there.q, there.v)[0][corner] * before <= 0
            first = int(np.argmax(after)) if after.any() else POINTS - 1
            low, high = float(parts[max(first - 1, 0)]), float(parts[first])
        t = float(pair.t[0] + high * h)
        wide = width(t, h)
        rate = self.rate(corner, _within(pair, np.array([min(low, 1 - 1e-6)]), apart), b, 1e-6 * h)
        own = values[step * len(LOOKS) : (step + 1) * len(LOOKS) + 1]
        if min(t - pair.t[0], pair.t[1] - t) < 10 * wide or abs(rate) * h < GRAZES * np.ptp(own):
            return None
        return Located(corner, step, t, before, rate)

    def rate(self, corner: int, at: Nodes, b: Array, ahead: float) -> float:
        """The rate of a function at a state, for the search of its zero."""
        t, q, v = (np.concatenate([x, x + ahead * dx]) for x, dx in ((at.t, 1.0), (at.q, at.v), (at.v, at.a)))
        values = self.values(b, np.repeat(at.memory, 2, axis=0), t, q, v)[0][corner]
        return float(values[1] - values[0]) / ahead


def width(t: float, h: float) -> float:
    """How near to a corner a step ends [s]."""
    return max(NEAR * h, ROUND * abs(t))


def _has_corners(p: Population) -> bool:
    return bool(force_functions(p.variant).signs) or any(law_signs(x) for own in p.values for x in own)


def _corners_of(n: int, p: Population) -> list[Corner]:
    known, found = force_functions(p.variant), list[Corner]()
    for k, owner in enumerate(p.owners):
        found += [Corner(owner, n, k, sign) for sign in range(len(known.signs))]
        for curve, (place, _) in enumerate(known.curves):
            signs = law_signs(stored(p, k, place))
            found += [Corner(owner, n, k, sign, curve) for sign in range(len(signs))]
    return found


def _looks(nodes: Nodes, apart: bool) -> Nodes:
    """States at which signs are compared: the first node, then some of each step."""
    parts = [nodes.part(slice(1))]
    parts += [_within(nodes.part(slice(k, k + 2)), LOOKS, apart) for k in range(len(nodes.t) - 1)]
    return Nodes._make(np.concatenate(columns) for columns in zip(*parts, strict=True))


def _within(pair: Nodes, parts: Array, apart: bool) -> Nodes:
    """States at parts of one step."""
    h, size = float(pair.t[1] - pair.t[0]), pair.q.shape[1]
    q, v, a = np.zeros((3, len(parts), size))
    ends: list[Any] = [np.ascontiguousarray(x[e : e + 1]) for e in (0, 1) for x in (pair.q, pair.v, pair.a)]
    for n, s in enumerate(parts):
        between(*[*ends, float(s), h, apart, q[n : n + 1], v[n : n + 1], a[n : n + 1]])
    times = pair.t[0] + parts * h
    rest = (np.repeat(x[:1], len(parts), axis=0) for x in (pair.lam, pair.memory))
    return Nodes(times, q, v, a, *rest)
