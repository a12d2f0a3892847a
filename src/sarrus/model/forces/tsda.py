"""TSDA: a spring, damper and actuator along the line between two points."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from ... import elements
from ..curve import Curve
from ..errors import ModelError
from ..measure import In, Length
from ..placement import Points, refuse_same_body
from ..point import Point
from ..pose import Poses
from ..primitive import Primitive
from ..quantity import SMALLEST_LENGTH, not_negative, number
from .force import Force


class Law(NamedTuple):
    """A factor and the curve that it scales."""

    factor: float
    curve: Curve


@dataclass(frozen=True, eq=False)
class TSDA(Force):
    """A tension f = k (l − length) + c l̇ + force between two points at the distance l, Eq. (60).

    Parameters
    ----------
    point_i, point_j
        The ends; they must not coincide.
    k
        Stiffness [N/m], or a `Curve` k(l) of the length l [m].
    length
        Free length [m].
    c
        Damping [N s/m], or a `Curve` c(l̇) of the rate l̇ [m/s].
    force
        Actuator's tension [N], or a `Curve` of time [s].
    """

    point_i: Point
    point_j: Point
    k: Annotated[float | Curve, In("N/m", over="m")]
    length: Length
    c: Annotated[float | Curve, In("N s/m", over="m/s")] = 0.0
    force: Annotated[float | Curve, In("N", over="s")] = 0.0

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the linear TSDA, or the nonlinear one if a law is a curve."""
        i, j = self._points(poses)
        length = not_negative(self.length, "length", "give the free length in m")
        laws = [_law(value, field) for value, field in self._laws()]
        (k, kappa), (c, chi), (force, phi) = laws
        values = (i.s, j.s, k, c, length, force)
        if any(isinstance(value, Curve) for value, _ in self._laws()):
            yield Primitive(elements.NonlinearTSDA, (i.body, j.body), (*values, kappa, chi, phi), "tsda")
        else:
            yield Primitive(elements.TSDA, (i.body, j.body), values, "tsda")

    def _laws(self) -> tuple[tuple[float | Curve, str], ...]:
        return (self.k, "k"), (self.c, "c"), (self.force, "force")

    def _points(self, poses: Poses) -> Points:
        points = Points(self.point_i.resolve(poses, "point_i"), self.point_j.resolve(poses, "point_j"))
        refuse_same_body(points.i.body, points.j.body, "point_j")
        apart = points.j.position(poses) - points.i.position(poses)
        if float(np.linalg.norm(apart)) < SMALLEST_LENGTH:
            told = "has zero length, its two points coincide in the initial pose; move one of them"
            raise ModelError(told, field="point_i")
        return points


def _law(value: float | Curve, field: str) -> Law:
    if isinstance(value, Curve):
        return Law(1.0, value)
    return Law(number(value, field), Curve.constant(1.0))
