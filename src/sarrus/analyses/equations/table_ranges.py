"""Tables that are used outside of their range, where they go on along the tangent at an end."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from ..._jit.formulas.expression import Expression, Graph
from ..._jit.formulas.replay import needed
from ...algebra import Array
from ...model import Curve
from ...model.announcement import announce, collected
from ...system import System
from ...system.cached import once
from ...system.curves.curve_derivatives import calls_of, curves_of, entries_of, stored, values_of_elements
from ...system.structure.population import Population

ROUND_OFF = np.finfo(float).eps ** 0.5  # of the range of a table: its tangent changes nothing there


class _Tables(NamedTuple):
    """The arguments of curves in the recorded formulas of a kind of element, and the tables among the curves."""

    population: Population
    graph: Graph
    arguments: list[Expression]
    order: list[int]
    tables: list[tuple[int, int, Curve]]  # of which argument, of which element


def announce_left_tables(system: System, b: Array, t: Array, q: Array, v: Array, memory: Array) -> None:
    """Announce each table whose range is left, once in an analysis.

    Parameters
    ----------
    b : (len(system.b),) the parameters
    t, q, v, memory : (n,), (n, nq), (n, nq), (n, places of memory), states of a motion
    """
    for tables in _tables(system):
        remembered = dict(zip(system.memory_places.tolist(), memory.T, strict=True))
        for message in _messages(tables, b, remembered, {"t": t, "q": q, "v": v}):
            announce([message])


@once
def _tables(system: System) -> tuple[_Tables, ...]:
    """The tables of a system that are not periodic."""
    return tuple(tables for p in system.populations if p.count for tables in _tables_of(p))


def _messages(
    own: _Tables, b: Array, memory: Mapping[int, Any], motion: Mapping[str, Array]
) -> Iterator[str]:
    values = values_of_elements(own.population, own.graph, own.arguments, own.order, b, memory, motion)
    for argument, k, table in own.tables:
        low, high, x = table.pairs[0][0], table.pairs[-1][0], values[argument, k]
        outside = np.flatnonzero(abs(x - 0.5 * (low + high)) > (0.5 + ROUND_OFF) * (high - low))
        about = f"{own.population.owners[k]}: its table ends at {low:g} and {high:g}, but is used at "
        if len(outside) and not any(message.startswith(about) for message in collected()):
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
        arguments = [x for _, x in calls]
        yield _Tables(p, graph, arguments, needed(graph, arguments), tables)
