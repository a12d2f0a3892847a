"""Derivatives of the equations with respect to time, for explicitly time-dependent motions and forces; and to curves.

After an event a motion continues earlier or later, so that explicitly time-dependent terms act at another phase of it.
The time at which it continues has a column behind those of all parameters of the system.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from ..._jit.formulas.differentiate import jacobian
from ..._jit.formulas.expression import Expression
from ..._jit.formulas.replay import needed
from ...algebra import Array
from ...elements.recorder import Variant
from ..structure.population import Population
from .curve_derivatives import CurveDerivatives, Part, entries_of, values_of_elements

if TYPE_CHECKING:
    from ..system import System

FORCES_AND_MOTIONS = ("Phi", "Q")


class TimeDerivatives(CurveDerivatives):
    """The derivatives of a system's operators with respect to its curves, and to the initial time of a motion."""

    def concerns(self, p: Population) -> bool:
        """Whether elements of a kind have curves, or depend explicitly on time."""
        return super().concerns(p) or depends_on_time(p)

    @property
    def width(self) -> int:
        """Number of columns; the last one is that of the time."""
        return super().width + 1

    def _parts(
        self, p: Population, name: str, b: Array, memory: Mapping[int, Any], operands: Any
    ) -> list[Part]:
        parts = super()._parts(p, name, b, memory, operands) if super().concerns(p) else []
        graph, places, by_t = _by_time(p.variant, name)
        if not places:
            return parts
        slopes = values_of_elements(p, graph, by_t, needed(graph, by_t), b, memory, operands)
        columns = np.full((1, *operands["t"].shape), self.width - 1)
        rows = [[self._row(p, k, name, *place) for place in places] for k in range(p.count)]
        own = [Part(np.array(rows[k]), slopes[:, k], columns, np.ones(columns.shape)) for k in range(p.count)]
        return [*parts, *own]


def depends_on_time(p: Population) -> bool:
    """Whether an element's equations contain the time."""
    own = [name for name in FORCES_AND_MOTIONS if any(operator.name == name for operator in p.kind.family)]
    return p.count > 0 and any(_by_time(p.variant, name)[1] for name in own)


def timed(system: System) -> bool:
    """Whether anything in a system depends explicitly on time."""
    return any(depends_on_time(p) for p in system.populations)


@cache
def _by_time(variant: Variant, name: str) -> tuple[Any, list[tuple[int, int]], list[Expression]]:
    """The derivatives of a vector's components with respect to time, with their indices; only nonzero ones."""
    graph, places, entries = entries_of(variant, name)
    times = [
        n for n in needed(graph, entries) if graph.nodes[n].op == "input" and graph.nodes[n].value == ("t",)
    ]
    if not times:
        return graph, [], []
    slopes = jacobian(graph, entries, [Expression(graph, times[0])])[:, 0]
    return graph, places, graph.expressions(slopes)
