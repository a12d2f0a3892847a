"""Tables that are used outside of their range, where they go on along the tangent at an end."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from ..._jit.formulas.expression import Expression, Graph
from ..._jit.formulas.replay import needed
from ...algebra import Array
from ...elements import Bushing
from ...elements.evaluation import element_from
from ...model import Curve
from ...model.announcement import announce, collected
from ...system import System
from ...system.curves.curve_derivatives import CurveDerivatives, calls_of, curves_of, entries_of, stored
from ...system.structure.local import GROUND, firsts
from ...system.structure.population import Population

ROUND_OFF = np.finfo(float).eps ** 0.5  # of the range of a table: its tangent changes nothing there
LARGEST = 0.5**0.5  # cosine of the angle of the largest torque


class _Tables(NamedTuple):
    """The arguments of curves in the recorded formulas of a kind of element, and the tables among the curves."""

    population: Population
    graph: Graph
    arguments: list[Expression]
    tables: list[tuple[int, int, Curve]]  # of which argument, of which element


class TableRanges:
    """The tables of a system that are not periodic, looked at along a motion."""

    def __init__(self, system: System) -> None:
        self._system = system
        self._derivatives, self._places = CurveDerivatives(system), system.memory_places.tolist()
        self._own = [found for p in system.populations if p.count for found in _tables_of(p)]

    def look(self, b: Array, t: Array, q: Array, v: Array, memory: Array) -> None:
        """Announce each table that is left, once in an analysis, at states (n,), (n, nq), (n, places of memory)."""
        announce_turned_bushings(self._system, b, t, q)
        for own in self._own:
            remembered = dict(zip(self._places, memory.T, strict=True))
            for message in self._messages(own, b, remembered, {"t": t, "q": q, "v": v}):
                announce([message])

    def _messages(
        self, own: _Tables, b: Array, memory: Mapping[int, Any], motion: Mapping[str, Array]
    ) -> Iterator[str]:
        order = needed(own.graph, own.arguments)
        values = self._derivatives.on_elements(
            own.population, own.graph, own.arguments, order, b, memory, motion
        )
        for argument, k, table in own.tables:
            low, high, x = table.pairs[0][0], table.pairs[-1][0], values[argument, k]
            outside = np.flatnonzero(abs(x - 0.5 * (low + high)) > (0.5 + ROUND_OFF) * (high - low))
            about = f"{own.population.owners[k]}: its table ends at {low:g} and {high:g}, but is used at "
            if len(outside) and not any(one.startswith(about) for one in collected()):
                first = outside[0]
                yield (
                    f"{about}{x[first]:.6g} at t = {motion['t'][first]:.6g} s, continued by its tangent. Extend the "
                    "table, or make it periodic, as by Curve.table(pairs, periodic=True)."
                )


def _tables_of(p: Population) -> Iterator[_Tables]:
    """The tables of a population, if it has any."""
    places = {place for _, place in curves_of(p.kind)} if p.kind.family else set()
    laws = {(place, k): stored(p, k, place) for place in places for k in range(p.count)}
    laws = {at: x for at, x in laws.items() if isinstance(x, Curve) and x.pairs and not x.periodic}
    if laws:
        graph, _, entries = entries_of(p.variant, "Phi" if p.kind.rows else "Q")
        calls = [(place, x) for _, place, x in calls_of(graph, entries)]
        tables = [
            (n, k, laws[place, k])
            for n, (place, _) in enumerate(calls)
            for k in range(p.count)
            if (place, k) in laws
        ]
        yield _Tables(p, graph, [x for _, x in calls], tables)


def announce_turned_bushings(system: System, b: Array, t: Array, q: Array) -> None:
    """Announce each bushing that is turned too far, once in an analysis, at states (n,), (n, nq)."""
    for p in system.populations if len(t) else ():
        for k in range(p.count if p.kind is Bushing else 0):
            at, about = p.at + k * p.kind.size(), f"{p.owners[k]}: it is turned by more than 45° at t = "
            element: Any = element_from(p.kind, b[at : at + p.kind.size()], b)
            if not np.reshape(element.K, (6, 6))[3:, 3:].any():
                continue
            i, j = (np.tile(GROUND, (len(t), 1)) if x < 0 else q[:, x : x + 7] for x in firsts(p, k))
            axes = [(getattr(element, f"{n}_i"), getattr(element, f"{n}_j")) for n in "fgh"]
            trace = sum(np.sum(_turned(i, a) * _turned(j, c), axis=1) for a, c in axes)
            far = np.flatnonzero(0.5 * (trace - 1) < LARGEST)
            if len(far) and not any(message.startswith(about) for message in collected()):
                announce([f"{about}{t[far[0]]:.6g} s, where its torque falls. Use an RSDA for large angles."])


def _turned(q: Array, a: Array) -> Array:
    """A body-fixed vector in global axes, at all states (n, 3)."""
    e0, e, a = q[:, 3:4], q[:, 4:7], np.asarray(a, dtype=float)[None]
    across = np.cross(e, a)
    return np.asarray(a + 2 * (np.cross(e, across) + e0 * across))
