"""Inertia of what moves along with a tendon: M = m l_qᵀ l_q, with the length l of its path."""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import numpy as np

from .... import elements
from ...._jit.formulas.differentiate import directional
from ...._jit.formulas.expression import Expression as Recorded
from ...._jit.formulas.expression import Graph
from ...._jit.formulas.replay import replay
from ....algebra import Block, Row, outer, present, scaled, total
from ....elements.element import Grid
from ....elements.evaluation import partition, symbols
from ....elements.follows import contracted
from ....elements.operators import DERIVATIVES, Derivative
from ...laws.recorded import Recording
from ...primitive import Primitive
from ...signals import Measure
from ..formula_element import OfOutputs, inertia_primitive


class PathInertia(OfOutputs, elements.InertiaElement, abstract=True):
    """Base of the classes of such inertias, whose value is m.

    S = -m l_qᵀ (l_q v)_q v, as for the inertia of a joint's coordinate. Derivatives of M a are those of m l_qᵀ (l_q a).
    """

    rules = DERIVATIVES | {"M_a_q": Derivative("M_a", None, "q"), "M_a_b": Derivative("M_a", None, "b")}

    def gradient(self, x: Any) -> list[Block]:
        """The derivatives of the length to the coordinates of all bodies."""
        found: list[Block] = [None] * (2 * self.structure.bodies)
        for k, block in enumerate(self._measures()[0].gradient(self._local(0, x))):
            at = 2 * self.structure.parts[0].places[k // 2] + k % 2
            found[at] = total((found[at], block))
        return found

    def M(self, x: Any) -> Grid:
        m, gradient = self.values(x, x, 0)[0], self.gradient(x)
        return tuple(
            tuple(None if a is None or b is None else m * outer(a, b) for b in gradient) for a in gradient
        )

    def M_a(self, x: Any, a: Any) -> Row:
        m, gradient = self.values(x, x, 0)[0], self.gradient(x)
        rate = present(contracted(tuple(gradient), a))
        return tuple(scaled(m * rate, block) for block in gradient)

    def S(self, x: Any, v: Any) -> Row:
        m, bend = self.values(x, x, 0)[0], self._bend(x, v)
        return tuple(scaled(-m * bend, block) for block in self.gradient(x))

    def _bend(self, x: Any, v: Any) -> Any:
        """(l_q v)_q v, the acceleration of the length where those of the coordinates are zero."""
        graph, found = _bend_of(type(self))
        inputs: dict[tuple[Any, ...], Any] = {("t",): 0}
        numbers = [np.ravel(getattr(self, name)) for name in self.fields]
        for name, parts in (("q", x), ("v", v), ("numbers", numbers)):
            inputs |= {
                (name, n): value for n, value in enumerate(np.concatenate([np.ravel(p) for p in parts]))
            }
        return replay(graph, [found], inputs)[0]


@cache
def _bend_of(kind: Any) -> tuple[Graph, Recorded]:
    """The recorded (l_q v)_q v of a class."""
    graph = Graph()
    element: Any
    element, operands = symbols(graph, kind)
    x, v = (partition(kind, operands[name]) for name in ("q", "v"))
    parts = zip(element.gradient(x), v, strict=True)
    rate = sum((block @ part for block, part in parts if block is not None), graph.constant(0))
    pairs = list(zip(operands["q"], operands["v"], strict=True))
    return graph, directional(graph, [rate], pairs)[0]


class OfPath(NamedTuple):
    """The kind of such an inertia."""

    label: str = "path"

    @property
    def base(self) -> type[PathInertia]:
        """The base of the class."""
        return PathInertia


def path_inertia(inertia: Any, path: Measure) -> Primitive:
    """Return the inertia of a path."""
    r = Recording("inertia", {}, {})
    return inertia_primitive(OfPath(), path, [r.number(inertia)], r)
