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
        self._orders: dict[Any, list[int]] = {}
        self._laws = {
            (n, k, place): (law, law_signs(law)) for n, p in self._groups for k in range(p.count)
            for place, _ in force_functions(p.variant).curves for law in [stored(p, k, place)]
        }  # fmt: skip

    def __bool__(self) -> bool:
        return bool(self.all)

    def values(self, b: Array, at: Nodes) -> Array:
        """The functions of all corners (corners, nt)."""
        rows = list[Array]()
        for n, p in self._groups:
            known = force_functions(p.variant)
            found = self._on(p, (*known.signs, *(x for _, x in known.curves)), b, at)
            signs, curves = found[: len(known.signs)], found[len(known.signs) :]
            for k in range(p.count):
                rows += [*signs[:, k]]
                for (place, _), x in zip(known.curves, curves[:, k], strict=True):
                    law, own = self._laws[n, k, place]
                    rows += [*formula_values(law, own, x)] if own else []
        return np.array(rows)

    def value(self, corner_index: int, b: Array, at: Nodes) -> Array:
        """The function of one corner (nt,)."""
        corner = self.all[corner_index]
        p = self._system.populations[corner.population]
        known = force_functions(p.variant)
        if corner.curve < 0:
            return np.asarray(self._on(p, (known.signs[corner.sign],), b, at)[0, corner.element])
        place, x = known.curves[corner.curve]
        law, own = self._laws[corner.population, corner.element, place]
        found = self._on(p, (x,), b, at)[0, corner.element]
        return np.asarray(formula_values(law, [own[corner.sign]], found)[0])

    def acting(self, b: Array, at: Nodes) -> Array:
        """Whether the forces that the corners belong to act (corners, nt)."""
        forces = {n: self._on(p, tuple(force_functions(p.variant).entries), b, at) for n, p in self._groups}
        return np.array([np.any(forces[one.population][:, one.element] != 0, axis=0) for one in self.all])

    def _on(self, p: Population, wanted: tuple[Expression, ...], b: Array, at: Nodes) -> Array:
        """Recorded expressions (wanted, elements, nt) of all elements of a population."""
        key = (p.variant, tuple(one.id for one in wanted))
        graph = force_functions(p.variant).graph
        if key not in self._orders:
            self._orders[key] = needed(graph, list(wanted))
        places = dict(zip(self._system.memory_places.tolist(), at.memory.T, strict=True))
        operands = {"q": at.q, "v": at.v, "t": at.t}
        return self._derivatives.on_elements(p, graph, list(wanted), self._orders[key], b, places, operands)

    def first(self, nodes: Nodes, b: Array, apart: bool) -> Located | None:
        """The first corner that a step passes, if there is one."""
        if len(nodes.t) < 2:
            return None
        looks = _looks(nodes, apart)
        values = self.values(b, looks)
        passed = values[:, 1:] * values[:, :-1] < 0
        if not passed.any():
            return None
        acts = self.acting(b, looks)
        passed &= acts[:, 1:] | acts[:, :-1]
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
            after = self.value(corner, b, there) * before <= 0
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
        pairs = ((at.t, 1.0), (at.q, at.v), (at.v, at.a))
        t, q, v = (np.concatenate([x, x + ahead * dx]) for x, dx in pairs)
        a, lam, memory = (np.repeat(x, 2, axis=0) for x in (at.a, at.lam, at.memory))
        before, after = self.value(corner, b, Nodes(t, q, v, a, lam, memory))
        return float(after - before) / ahead


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
    first, rest = nodes.part(slice(1)), _within(nodes, LOOKS, apart)
    return Nodes._make(np.concatenate(columns) for columns in zip(first, rest, strict=True))


def _within(nodes: Nodes, parts: Array, apart: bool) -> Nodes:
    """States at parts of every step, one step after another."""
    steps, size = len(nodes.t) - 1, nodes.q.shape[1]
    kinds = [x[None, :, None] for x in (nodes.q, nodes.v, nodes.a)]
    ends: list[Any] = [
        np.ascontiguousarray(x[:, rows]) for rows in (slice(-1), slice(1, None)) for x in kinds
    ]
    h, s = np.diff(nodes.t)[:, None, None], np.broadcast_to(parts[None, :, None], (steps, len(parts), 1))
    found = np.zeros((3, 1, steps, len(parts), size))
    given: tuple[Any, ...] = (*ends, s, h, apart, *found)
    between(*given)  # of one entry, whose parts are arrays over steps and their parts
    times = (nodes.t[:-1, None] + parts * h[:, :, 0]).ravel()
    lam, memory = (np.repeat(x[:-1], len(parts), axis=0) for x in (nodes.lam, nodes.memory))
    q, v, a = found.reshape(3, -1, size)
    return Nodes(times, q, v, a, lam, memory)
