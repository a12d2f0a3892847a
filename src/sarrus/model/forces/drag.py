"""Resistance of a fluid: quadratic at a point, or viscous."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from ... import elements
from ..geometry.point import Point
from ..geometry.pose import Poses
from ..measure import In, Velocity
from ..primitive import Primitive
from ..quantity import not_negative, positive, vector
from .force import Force, refuse_ground


@dataclass(frozen=True, eq=False)
class Drag(Force):
    """Quadratic drag: force −c |u| u at ``point``, with u its velocity relative to the air.

    Parameters
    ----------
    point
        The centre of pressure.
    c
        Half of density, area and drag coefficient [N s²/m²].
    wind
        Velocity of the air in global axes [m/s].
    creep
        [m/s] |u| is √(u² + creep²), so that the law has all its derivatives at rest.
    """

    point: Point
    c: Annotated[float, In("N s^2/m^2")]
    wind: Velocity = (0.0, 0.0, 0.0)
    creep: Annotated[float, In("m/s")] = 1e-3

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the drag."""
        point = self.point.resolve(poses, "point")
        refuse_ground(point.body, "point")
        c = not_negative(self.c, "c", "Give it in N s²/m².")
        creep = positive(self.creep, "creep", "Give a small speed in m/s.")
        values = (point.s, c, vector(self.wind, "wind"), creep)
        yield Primitive(elements.Drag, (point.body,), values, "drag")


@dataclass(frozen=True, eq=False)
class ViscousDrag(Force):
    """A force −c v at ``point``, v its velocity, and a torque −c_turn ω, as in a thick fluid.

    Parameters
    ----------
    point
        Where the force acts.
    c
        [N s/m]
    c_turn
        [N m s/rad]
    """

    point: Point
    c: Annotated[float, In("N s/m")] = 0.0
    c_turn: Annotated[float, In("N m s/rad")] = 0.0

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the drag."""
        point = self.point.resolve(poses, "point")
        refuse_ground(point.body, "point")
        c, c_turn = (
            not_negative(self.c, "c", "Give it in N s/m."),
            not_negative(self.c_turn, "c_turn", "Give N m s/rad."),
        )
        yield Primitive(elements.ViscousDrag, (point.body,), (point.s, c, c_turn), "drag")
