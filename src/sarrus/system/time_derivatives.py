"""How the equations change with the time itself, where motions or forces depend on it; and with numbers of curves.

After an event a motion goes on sooner or later, so that what depends on time by itself comes at another place of it.
The time at which it goes on has a column behind those of all numbers of the system.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np

from .._jit.differentiate import jacobian
from .._jit.expression import Expression
from .._jit.replay import needed
from ..algebra import Array
from ..elements.recorder import Variant
from .curve_derivatives import CurveDerivatives, Part, constant, entries_of
from .population import Population
from .system import System

FORCES_AND_MOTIONS = ("Phi", "Q")


class TimeDerivatives(CurveDerivatives):
    """The derivatives of a system's operators by the numbers of its curves, and by the time at which a motion began."""

    def concerns(self, p: Population) -> bool:
        """Whether elements of a kind have curves, or depend on time by themselves."""
        return super().concerns(p) or depends_on_time(p)

    @property
    def width(self) -> int:
        """How many columns there are: the last one is that of the time."""
        return super().width + 1

    def _parts(
        self, p: Population, name: str, b: Array, memory: Mapping[int, Any], operands: Any
    ) -> list[Part]:
        parts = super()._parts(p, name, b, memory, operands) if super().concerns(p) else []
        graph, places, by_t = _by_time(p.variant, name)
        if not places:
            return parts
        slopes = self.on_elements(p, graph, by_t, needed(graph, by_t), b, memory, operands)
        columns = np.full((1, *operands["t"].shape), self.width - 1)
        rows = [[self._row(p, k, name, *place) for place in places] for k in range(p.count)]
        own = [Part(np.array(rows[k]), slopes[:, k], columns, np.ones(columns.shape)) for k in range(p.count)]
        return [*parts, *own]


def depends_on_time(p: Population) -> bool:
    """Whether an element's equations contain the time."""
    own = [name for name in FORCES_AND_MOTIONS if any(operator.name == name for operator in p.kind.family)]
    return p.count > 0 and any(_by_time(p.variant, name)[1] for name in own)


def timed(system: System) -> bool:
    """Whether anything in a system depends on time by itself."""
    return any(depends_on_time(p) for p in system.populations)


@cache
def _by_time(variant: Variant, name: str) -> tuple[Any, list[tuple[int, int]], list[Expression]]:
    """The derivatives of a vector's entries by the time, with their places; none where it does not contain it."""
    graph, places, entries = entries_of(variant, name)
    times = [
        n for n in needed(graph, entries) if graph.nodes[n].op == "input" and graph.nodes[n].value == ("t",)
    ]
    if not times:
        return graph, [], []
    slopes = jacobian(graph, entries, [Expression(graph, times[0])])[:, 0]
    return graph, places, [constant(graph, slope) for slope in slopes]
