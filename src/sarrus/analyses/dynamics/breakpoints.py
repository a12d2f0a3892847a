"""Times at which a model's laws are not smooth: where its tables over time have their points."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from ...algebra import Array
from ...elements import OPERATORS
from ...elements.recorder import Variant, record
from ...model import Curve
from ...system import System
from ...system.once import once
from ...system.population import Population


@once
def breakpoints(system: System) -> tuple[Array, Array]:
    """Rising times of the points of all tables over time, and those among them where second derivatives jump.

    A table is a cubic spline, twice continuously differentiable at its inner points, and straight beyond its ends.
    """
    curves = list(_curves_of_time(system.populations))
    every = [x for curve in curves for x in curve.knots[1:-1]]  # the outer pieces are straight
    ends = [x for curve in curves for x in (curve.knots[1], curve.knots[-2]) if len(curve.knots) > 3]
    return np.unique(np.array(every)), np.unique(np.array(ends))


ROUND = 1e-12  # [-] of the end time, below which two times to stop at are the same


def stops_of(system: System, given: Array, until: float, begin: float = 0.0) -> tuple[Array, Array]:
    """The times to hit, and those of them after which a method starts anew."""
    if given.ndim != 1 or not np.all(np.isfinite(given)):
        raise ValueError("breakpoints must be a list of times in s")
    every, ends = breakpoints(system)
    stops, kinks = np.unique(np.concatenate([given, every])), np.unique(np.concatenate([given, ends]))
    return _apart(stops, begin, until), _apart(kinks, begin, until)


def _apart(times: Array, begin: float, until: float) -> Array:
    """The times inside of the run, without those that differ from the one before by round-off alone."""
    least = ROUND * max(abs(begin), abs(until))
    inside = times[(times > begin + least) & (times < until - least)]
    return inside[np.diff(inside, prepend=-np.inf) > least]


def _curves_of_time(populations: Iterable[Population]) -> Iterator[Curve]:
    for p in populations:
        if p.count:
            for n in _fields_of_time(p.variant):
                yield from (
                    values[n]
                    for values in p.values
                    if isinstance(values[n], Curve) and len(values[n].cubics) > 1
                )


def _fields_of_time(variant: Variant) -> list[int]:
    """Which fields of an element, Time apart, are curves that are called with the time itself."""
    kinds = [kind for kind in variant.kind.fields.values() if kind != "Time"]
    if "Curve" not in kinds:
        return []
    operator = "Phi" if variant.kind.rows else "Q"
    assert operator in OPERATORS
    nodes = record(variant, (operator,)).graph.nodes
    called = {
        nodes[node.args[0]].value[1]
        for node in nodes
        if node.op == "curve" and nodes[node.args[1]].value == ("t",)
    }
    widths = [
        width
        for width, kind in zip(variant.kind.widths(), variant.kind.fields.values(), strict=True)
        if kind != "Time"
    ]
    starts = np.cumsum([0, *widths])
    return [n for n in range(len(kinds)) if int(starts[n]) in called]
