"""Drivers for these tests, written as a user would: only Φ is given, all derivatives are made from it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from sarrus.algebra import row
from sarrus.elements import Element, Primitive
from sarrus.elements.element import Pair, Scalar, Time, Vec3
from sarrus.euler import rotate
from sarrus.functions import cos, sin
from sarrus.model import Joint, ground
from sarrus.model.frame import LocalFrame
from sarrus.model.primitive import Primitive as Piece
from sarrus.model.quantity import Vector
from sarrus.model.solid import Solid


class Turn(Primitive, rows=1, derivatives="automatic"):
    """f_j, turned back by θ(t) about h_i, stays perpendicular to g_i: θ = angle + rate t + ½ growth t²."""

    f_i: Vec3
    g_i: Vec3
    f_j: Vec3
    angle: Scalar
    rate: Scalar
    growth: Scalar
    t: Time

    def Phi(self, x: Pair) -> Any:
        theta = self.angle + self.rate * self.t + self.growth * self.t * self.t / 2
        f_j = rotate(x.p_j, self.f_j)
        c, s = rotate(x.p_i, self.f_i) @ f_j, rotate(x.p_i, self.g_i) @ f_j
        return np.array([s * cos(theta) - c * sin(theta)])


class Push(Primitive, rows=1, derivatives="automatic"):
    """h_i · (r_j - r_i) = place + rate t."""

    h_i: Vec3
    place: Scalar
    rate: Scalar
    t: Time

    def Phi(self, x: Pair) -> Any:
        return row(rotate(x.p_i, self.h_i)) @ (x.r_j - x.r_i) - self.place - self.rate * self.t


@dataclass(frozen=True, eq=False)
class TurnDriver(Joint):
    """Body j turns about the global axis `h` of the ground; θ counts from its pose at the start."""

    body: Solid | None = None
    h: Vector = (0.0, 0.0, 1.0)
    angle: float = 0.0
    rate: float = 0.0
    growth: float = 0.0

    def frames(self, poses: Any) -> Any:
        frame = ground.frame((0, 0, 0), z=self.h).resolve(poses, "h")
        A = poses[self.body.name].A
        there = LocalFrame(self.body.name, (0.0, 0.0, 0.0), *(tuple(A.T @ np.array(x)) for x in frame[2:]))
        return frame, there

    def primitives(self, poses: Any) -> Any:
        i, j = self.frames(poses)
        yield Piece(Turn, (i.body, j.body), (i.f, i.g, j.f, self.angle, self.rate, self.growth), "angle")


@dataclass(frozen=True, eq=False)
class PushDriver(Joint):
    """The origin of a body is moved along a global axis."""

    body: Solid | None = None
    h: Vector = (1.0, 0.0, 0.0)
    place: float = 0.0
    rate: float = 0.0

    def primitives(self, poses: Any) -> Any:
        yield Piece(Push, ("ground", self.body.name), (self.h, self.place, self.rate), "travel")


for name in ("turn_driver", "push_driver"):  # so that other tests see only the library's own
    del Joint.kinds[name]
for name in ("Turn", "Push"):
    del Element.registry[name]
