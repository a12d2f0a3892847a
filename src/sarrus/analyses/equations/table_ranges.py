"""Tables, surfaces and elements that are used outside of their range: tables continue along the tangent at an end."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from ..._jit.formulas.expression import Expression, Graph
from ..._jit.formulas.replay import needed
from ..._jit.formulas.surfaces import ORDERS
from ...algebra import Array
from ...model import Curve
from ...model.announcement import announce, collected
from ...system import System
from ...system.cached import once
from ...system.curves.curve_derivatives import calls_of, entries_of, tables_of, values_of_elements
from ...system.curves.lanes import recorded_element
from ...system.structure.population import Population

ROUND_OFF = np.finfo(float).eps ** 0.5  # of the range of a table: its tangent changes nothing there
TANGENT = "continued by its tangent."
OF_TABLE = (
    "its table ends at",
    f"{TANGENT} Extend the table, or make it periodic, as by Curve.table(pairs, periodic=True).",
)


class _Range(NamedTuple):
    """The range of an argument of an element, with the texts of a message before and after its values."""

    argument: int
    element: int
    low: float
    high: float
    ends: str
    remedy: str


class _Tables(NamedTuple):
    """The arguments of curves and surfaces in the recorded formulas of a kind of element, and the ranges of tables."""

    population: Population
    graph: Graph
    arguments: list[Expression]
    order: list[int]
    ranges: list[_Range]


def announce_left_ranges(system: System, b: Array, t: Array, q: Array, v: Array, memory: Array) -> None:
    """Announce each range that is left, once in an analysis.

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
    """The tables of a system that are not periodic, and what its elements declare."""
    return tuple(
        tables for p in system.populations if p.count for tables in (*_tables_of(p), *_validity_of(p))
    )


def _validity_of(p: Population) -> Iterator[_Tables]:
    """The range that a kind of element declares, see `Validity`."""
    valid = p.kind.validity
    if valid is None:
        return
    graph = Graph()
    element, (x, v, _) = recorded_element(p.variant, graph, graph.inputs("numbers", p.kind.size()))
    wanted = graph.expressions([getattr(element, valid.of)(x, v)])
    ranges = [_Range(0, k, *valid[1:]) for k in range(p.count)]
    yield _Tables(p, graph, wanted, needed(graph, wanted), ranges)


def _messages(
    own: _Tables, b: Array, memory: Mapping[int, Any], motion: Mapping[str, Array]
) -> Iterator[str]:
    values = values_of_elements(own.population, own.graph, own.arguments, own.order, b, memory, motion)
    for argument, k, low, high, ends, remedy in own.ranges:
        x = values[argument, k]
        outside = np.flatnonzero(abs(x - 0.5 * (low + high)) > (0.5 + ROUND_OFF) * (high - low))
        about = f"{own.population.owners[k]}: {ends} {low:g} and {high:g}, but is used at "
        if len(outside) and not any(message.startswith(about) for message in collected()):
            first = outside[0]
            yield f"{about}{x[first]:.6g} at t = {motion['t'][first]:.6g} s, {remedy}"


def _tables_of(p: Population) -> Iterator[_Tables]:
    """The tables and surfaces of a population, if it has any."""
    curves, surfaces = ({place: m for m, place in tables_of(p.kind, field)} for field in ("Curve", "Surface"))
    if not p.kind.family or not (curves or surfaces):
        return
    graph, _, entries = entries_of(p.variant, "Phi" if p.kind.rows else "Q")
    arguments: list[Expression] = []
    ranges: list[_Range] = []
    for _, place, x in calls_of(graph, entries):
        for k, values in enumerate(p.values):
            law = values[curves[place]]
            if isinstance(law, Curve) and law.pairs and not law.periodic:
                ranges.append(_Range(len(arguments), k, law.pairs[0][0], law.pairs[-1][0], *OF_TABLE))
        arguments.append(x)
    for node in (graph.nodes[n] for n in needed(graph, entries) if graph.nodes[n].op in ORDERS):
        surface = surfaces[graph.nodes[node.args[0]].value[1]]
        for axis, at in zip("xy", node.args[1:], strict=True):
            for k, values in enumerate(p.values):
                knots = getattr(values[surface], axis)
                ends = f"its road ends at {axis} ="
                low, high = float(knots[0]), float(knots[-1])
                ranges.append(_Range(len(arguments), k, low, high, ends, f"{TANGENT} Extend its grid."))
            arguments.append(Expression(graph, at))
    if ranges:
        yield _Tables(p, graph, arguments, needed(graph, arguments), ranges)
