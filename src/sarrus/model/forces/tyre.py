"""Tyres as a vertical spring and damper: on a flat road, or with lift-off on a road with a profile or a surface."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from ... import elements
from ..geometry.points import Point
from ..geometry.pose import Poses
from ..laws.curve import Curve, Formula
from ..laws.law import Law, scaled, varies
from ..laws.surface import Surface
from ..measure import In, Length
from ..primitive import Primitive
from ..quantity import Vec3, not_negative, number, positive
from .force import Force, refuse_ground


@dataclass(frozen=True, eq=False)
class Tyre(Force):
    """Vertical tyre without lift-off: force k (radius − (z − road)) − c ż at ``point``.

    Parameters
    ----------
    point
        The wheel's centre; z is its global height [m].
    k, c
        Stiffness [N/m] and damping [N s/m].
    radius
        Of the unloaded wheel [m].
    road
        Height of the road [m].
    """

    point: Point
    k: Annotated[float, In("N/m")]
    c: Annotated[float, In("N s/m")]
    radius: Length
    road: Length = 0.0

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        body, wheel = _wheel(self, poses)
        yield Primitive(elements.Tyre, (body,), (*wheel, number(self.road, "road")), "tyre")


@dataclass(frozen=True, eq=False)
class RoadTyre(Force):
    """Vertical tyre on a road profile, with lift-off: force k δ + c δ̇ for the compression δ = radius − (z − road).

    Parameters
    ----------
    point
        The wheel's centre; z is its global height [m].
    k, c
        Stiffness [N/m] and damping [N s/m].
    radius
        Of the unloaded wheel [m].
    road
        Height of the road [m]: a number, a law over the global x [m] of the wheel's centre, or a `Surface`.
    bump
        Height [m] that is added under this tyre: a number, or a law over time [s].
    rounding
        Compression [m] over which the force increases smoothly, centred at the first contact; beyond half of it, the
        law is exact.
    """

    point: Point
    k: Annotated[float, In("N/m")]
    c: Annotated[float, In("N s/m")]
    radius: Length
    road: Annotated[Law | Surface, In("m", over="m")] = 0.0
    bump: Annotated[Law, In("m", over="s")] = 0.0
    rounding: Length = 1e-3

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        body, wheel = _wheel(self, poses)
        width = positive(self.rounding, "rounding", "Give a small length in m.")
        rise, bump = _height(self.bump, "bump", "t")
        if isinstance(self.road, Surface):
            yield Primitive(elements.SurfaceTyre, (body,), (*wheel, rise, width, bump, self.road), "tyre")
            return
        height, profile = _height(self.road, "road", "x")
        yield Primitive(elements.RoadTyre, (body,), (*wheel, height + rise, width, bump, profile), "tyre")


def _wheel(tyre: Tyre | RoadTyre, poses: Poses) -> tuple[str, tuple[Vec3, float, float, float]]:
    """Return the body of a wheel, its centre, stiffness, damping and radius."""
    point = tyre.point.resolve(poses, "point")
    refuse_ground(point.body, "point")
    k = positive(tyre.k, "k", "Give the stiffness in N/m.")
    c = not_negative(tyre.c, "c", "Give the damping in N s/m.")
    return point.body, (point.s, k, c, positive(tyre.radius, "radius", "Give the unloaded radius in m."))


def _height(value: Law, field: str, variable: str) -> tuple[float, Curve | Formula]:
    """Return a constant height and what is added to it."""
    size, curve = scaled(value, field, variable)
    return (0.0, curve) if varies(value) else (size, Curve.constant(0.0))
