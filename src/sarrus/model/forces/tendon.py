"""Tendon: a force along the length of a path through points, or along a combination of coordinates of joints."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, NamedTuple

import numpy as np

from ... import elements
from ..._jit.formulas.differentiate import directional
from ..._jit.formulas.expression import Expression as Recorded
from ..._jit.formulas.expression import Graph
from ..._jit.formulas.replay import replay
from ...algebra import Block, Row, outer, present, scaled, total
from ...elements.element import Grid
from ...elements.evaluation import partition, symbols
from ...elements.follows import contracted
from ...elements.operators import DERIVATIVES, Derivative
from ..errors import ModelError
from ..laws.recorded import Recording
from ..measure import In
from ..primitive import Primitive
from ..quantity import not_negative
from ..signals import Measure, Signals
from .by_formula import ByFormula, with_full
from .force import Force
from .formula_element import OutputLaws, Target, inertia_primitive, load_primitive
from .paths.path import PathPart, Pull


@dataclass(frozen=True, eq=False)
class Tendon(PathPart, ByFormula, Force):
    """A force along x, the length of a path from point to point, or a sum of factors times coordinates of joints.

    A positive ``value`` increases x: it does work at the rate value · v, as that of a `Force`. A spring with a damper
    is ``value="-k*(x - L0) - c*v"``, a rope ``value="-k*max(x - L0, 0)"``.

    Parameters
    ----------
    inertia
        [kg] of what moves along with the length, such as the rotor of a winch divided by the square of its radius: its
        kinetic energy is ½ inertia · v². For angles of joints in kg m², without the unit.
    value
        As of a `Force`; x and v are the length and its rate.
    """

    inertia: Annotated[float, In("kg")] = 0.0

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        """Yield the load and the inertia."""
        inertia = not_negative(self.inertia, "inertia", "Give it in kg.")
        if self.value is None and not inertia:
            raise ModelError("value is missing. Give a formula, a function or a table.", field="value")
        path = self.path(signals)
        if self.value is not None:
            yield self._load(path, signals)
        if inertia:
            yield path_inertia(inertia, path)

    def _load(self, path: Measure, signals: Signals) -> Primitive:
        x, v = self.coordinates(path)
        own = {"x": x, "length": x, "v": v, "rate": v}
        r = Recording("value", with_full(own, self), self.checked_parameters(), variables=signals.variables)
        value = r.law(self.value, self.over)
        laws = [value, value, r.named("x"), r.named("v")]
        signals.refuse_hidden(r)
        pairs = zip(r.signals, r.fields, strict=True)
        found = [own[name] if name in own else signals.find(name, field) for name, field in pairs]
        outputs = ("value", "N" if self.points else ""), ("length", x.unit), ("rate", v.unit)
        return load_primitive(Target(path, Pull(outputs)), laws, r, found)


class PathInertia(OutputLaws, elements.InertiaElement, abstract=True):
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


class PathInertiaKind(NamedTuple):
    """The kind of such an inertia."""

    label: str = "path"

    @property
    def base(self) -> type[PathInertia]:
        """The base of the class."""
        return PathInertia


def path_inertia(inertia: Any, path: Measure) -> Primitive:
    """Return the inertia of a path."""
    r = Recording("inertia", {}, {})
    return inertia_primitive(PathInertiaKind(), path, [r.number(inertia)], r)
