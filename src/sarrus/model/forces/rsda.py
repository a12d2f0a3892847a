"""RSDA: a spring, damper and actuator about an axis."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import atan2

import numpy as np

from ... import elements
from ..frame import LocalFrame
from ..law import Law, scaled, varies
from ..names import find
from ..placement import AboutAxis
from ..pose import Poses
from ..primitive import Primitive
from ..quantity import Array, Vec3, number
from .force import Force


@dataclass(frozen=True, eq=False)
class RSDA(AboutAxis, Force):
    """A torque n = k (θ − angle) + c θ̇ + torque about h_i, Eq. (106), against the rotation θ.

    θ is the rotation of body j relative to body i about h_i, right-handed, with counted
    revolutions. Placed by a global ``point`` [m] and ``axis`` in the initial pose, where θ then
    starts at 0, or by ``frame_i`` and ``frame_j``, where θ is the angle from f_i to f_j.

    Parameters
    ----------
    k
        Stiffness [N m/rad], or a law k(θ) over the angle θ [rad].
    c
        Damping [N m s/rad], or a law c(θ̇) over its rate [rad/s].
    angle
        Free angle [rad].
    torque
        Actuator's torque [N m], or a law over time [s].

    Notes
    -----
    A law is a table of pairs, a `Curve`, or a function made of arithmetic and of `sarrus.functions`.
    """

    k: Law = field(kw_only=True)
    c: Law = 0.0
    angle: float = 0.0
    torque: Law = 0.0

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the linear RSDA, or the nonlinear one if a law is a curve, with its initial angle."""
        i, j = self.frames(poses)
        laws = ((self.k, "k"), (self.c, "c"), (self.torque, "torque"))
        (k, kappa), (c, chi), (torque, phi) = (scaled(value, name) for value, name in laws)
        angle, start = number(self.angle, "angle", "give radians"), initial_angle(i, j, poses)
        values = (i.f, i.g, i.h, j.f, j.h, k, c, angle, torque)
        if any(varies(value) for value, _ in laws):
            curved = (*values, kappa, chi, phi, start)
            yield Primitive(elements.NonlinearRSDA, (i.body, j.body), curved, "rsda")
        else:
            yield Primitive(elements.RSDA, (i.body, j.body), (*values, start), "rsda")


def initial_angle(i: LocalFrame, j: LocalFrame, poses: Poses) -> float:
    """Return θ = atan2(g_i·f_j, f_i·f_j) in the initial pose. [rad]"""
    f_j = _turned(j.f, j.body, poses)
    return atan2(float(_turned(i.g, i.body, poses) @ f_j), float(_turned(i.f, i.body, poses) @ f_j))


def _turned(local: Vec3, body: str, poses: Poses) -> Array:
    return np.asarray(find(body, poses, "body").A @ np.array(local))
