"""What forces along a line share: two points, or the displacement of a joint in their place."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple

from ..coordinate import DISPLACEMENT, chosen
from ..errors import ModelError
from ..geometry.placement import points_apart
from ..geometry.point import Point
from ..signals import Measure, Signal, Signals
from .formula_element import Line, Target, along_coordinate, along_line


class Along(NamedTuple):
    """A target of a load, the coordinate that it acts along, and the rate of the coordinate."""

    target: Target
    x: Signal
    v: Signal


def along_joint(joint: str, kind: Any, signals: Signals) -> Along:
    """Return a coordinate of a joint, of a kind if one is wanted."""
    found = chosen(joint, kind, signals.known, "joint")
    measure = Measure.of(found.measure)
    unit = "m" if found.measure.element is DISPLACEMENT else "rad"
    x, v = Signal(measure, "Phi", 1, 0, unit), Signal(measure, "Phi_q_xi", 2, 0, f"{unit}/s")
    return Along(Target(measure, along_coordinate), x, v)


@dataclass(frozen=True, eq=False)
class OnLine:
    """A force between two points, or on the displacement of a joint.

    Parameters
    ----------
    point_i, point_j
        The ends, which must not coincide; x is their distance [m], v its rate.
    joint
        Instead of points, a joint by name, ``slide``, or if it has several displacements ``table.displacement_x``; x is
        the displacement of its second body [m].
    """

    point_i: Point | None = None
    point_j: Point | None = None
    joint: str | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        given: Any = self.point_i
        if isinstance(given, str) and self.point_j is None and self.joint is None:
            object.__setattr__(self, "joint", given)  # Force("name", "slide", ...), as of a Torque
            object.__setattr__(self, "point_i", None)

    def line(self, signals: Signals) -> Along:
        """Return what it acts along; a positive force pushes the points apart, or increases the displacement."""
        if self.joint is not None:
            if self.point_i is not None or self.point_j is not None:
                raise ModelError("has points and a joint. Give one or the other.", field="joint")
            return along_joint(self.joint, DISPLACEMENT, signals)
        if self.point_i is None or self.point_j is None:
            raise ModelError(
                "its place is missing. Give point_i and point_j, or joint; for a force at one point, a "
                "PointForce.",
                field="point_i",
            )
        i, j = points_apart(self.point_i, self.point_j, signals.poses)
        measure = Measure(Line, (i.body, j.body), (i.s, j.s))
        x, v = Signal(measure, "length", 1, 0, "m"), Signal(measure, "rate", 2, 0, "m/s")
        return Along(Target(measure, along_line), x, v)
