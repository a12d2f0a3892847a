"""A force by a formula or function of outputs and the time, between two points or along a joint's displacement."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from ..coordinate import DISPLACEMENT
from ..errors import ModelError
from ..geometry.placement import points_apart
from ..geometry.point import Point
from ..primitive import Primitive
from ..signals import Measure, Signal, Signals
from .by_formula import ByFormula, own_names
from .force import Force as BaseForce
from .formula_element import Line, Target, along_line


@dataclass(frozen=True, eq=False)
class Force(ByFormula, BaseForce):
    """A force [N] between two points, or along the displacement of a joint, by a formula of outputs and the time.

    A positive value pushes the points apart, or increases the displacement: it does work at the rate value · v. (The
    ``force`` of a TSDA is a tension, with the opposite sign.)

    Parameters
    ----------
    point_i, point_j
        The ends, which must not coincide; x is their distance [m], v its rate. Or instead of both the name of a joint,
        ``Force("jack", "slide", value=5)``.
    joint
        Instead of points, a joint by name, ``slide``, or if it has several displacements ``table.displacement_x``; x is
        the displacement of its second body [m].
    value
        See above; for example ``"p*A*step(t, 0, 0, 1 ms, 1) - c*v"``, or ``lambda x, v, t: -100*x**3``.
    """

    point_i: Point | None = None
    point_j: Point | None = None
    joint: str | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        given: Any = self.point_i
        if isinstance(given, str) and self.point_j is None and self.joint is None:
            object.__setattr__(self, "joint", given)  # Force("name", "slide", ...), as of a Torque
            object.__setattr__(self, "point_i", None)

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        """Yield the load."""
        if self.value is None:
            raise ModelError(
                "value is missing. Give a number, a formula, a function or a table.", field="value"
            )
        if self.joint is not None:
            if self.point_i is not None or self.point_j is not None:
                raise ModelError("has points and a joint. Give one or the other.", field="joint")
            yield self.on_joint(self.joint, DISPLACEMENT, signals)
        elif self.point_i is None or self.point_j is None:
            raise ModelError(
                "its place is missing. Give point_i and point_j, or joint; for a force at one point, a "
                "PointForce.",
                field="point_i",
            )
        else:
            yield self._between(self.point_i, self.point_j, signals)

    def _between(self, point_i: Point, point_j: Point, signals: Signals) -> Primitive:
        i, j = points_apart(point_i, point_j, signals.poses)
        measure = Measure(Line, (i.body, j.body), (i.s, j.s))
        own = own_names(Signal(measure, "length", 1, 0, "m"), Signal(measure, "rate", 2, 0, "m/s"))
        return self.loaded(Target(measure, along_line), own | {"length": own["x"]}, signals)
