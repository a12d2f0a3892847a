"""RSDA: a spring, damper and actuator about an axis."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Annotated, ClassVar

from ... import elements
from ..coordinate import angle
from ..geometry.placement import AboutAxis
from ..geometry.pose import Poses
from ..laws.law import Law, of_one_variable, refuse_negative, scaled, varies
from ..measure import Angle, In
from ..primitive import Primitive
from ..quantity import number
from .force import Force


@dataclass(frozen=True, eq=False)
class RSDA(AboutAxis, Force):
    """Rotational spring-damper-actuator: torque n = k (θ − angle) + c θ̇ + torque about h_i, Eq. (106).

    θ is the rotation of body j relative to body i about h_i, right-handed, with counted
    revolutions. Placed by a global ``point`` [m] and ``axis`` in the initial pose, where θ then
    starts at 0, or by ``frame_i`` and ``frame_j``, where θ is the angle from f_i to f_j. A positive torque decreases θ.

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
    A law is a function of the variable named above only (`Torque` takes formulas of several): a formula in a text (in
    t over time, else in x), a table of pairs, a `Curve`, or a Python function made of arithmetic and of
    `sarrus.functions`. Numbers for k and c are not negative; what drives a motion is a law.
    """

    of_several: ClassVar[str] = "sr.Torque on the joint for a formula of angle, rate and t"

    k: Annotated[Law, In("N m/rad", over="rad")] = field(kw_only=True)
    c: Annotated[Law, In("N m s/rad", over="rad/s")] = 0.0
    angle: Angle = 0.0
    torque: Annotated[Law, In("N m", over="s")] = 0.0

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the linear RSDA, or the nonlinear one if a law is a curve, with its initial angle."""
        i, j = self.frames(poses)
        laws = ((self.k, "k", "x"), (self.c, "c", "x"), (self.torque, "torque", "t"))
        with of_one_variable(self):
            (k, kappa), (c, chi), (torque, phi) = (scaled(*law) for law in laws)
        refuse_negative(k, "k")
        refuse_negative(c, "c")
        free, start = number(self.angle, "angle", "Give radians."), angle(i, j, poses).start
        values = (i.f, i.g, i.h, j.f, j.h, k, c, free, torque)
        if any(varies(value) for value, *_ in laws):
            curved = (*values, kappa, chi, phi, start)
            yield Primitive(elements.NonlinearRSDA, (i.body, j.body), curved, "rsda")
        else:
            yield Primitive(elements.RSDA, (i.body, j.body), (*values, start), "rsda")
