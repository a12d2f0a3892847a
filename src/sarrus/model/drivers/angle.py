"""Angle driver: the angle of a joint is a function of time. 1 equation."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from ... import elements
from ..coordinate import ANGLE, Known, chosen
from ..measure import In
from ..pose import Poses
from ..prescribed import Motion, motion_of
from ..primitive import Primitive
from .driver import Driver


@dataclass(frozen=True, eq=False)
class AngleDriver(Driver):
    """The angle [rad] of a ``joint`` follows a ``motion``, a number or a function of time, with all revolutions.

    The joint is given by name, ``pin``, or where it has several angles ``hook.angle_i``.
    """

    joint: str
    motion: Annotated[Motion, In("rad", over="s")]

    def primitives(self, poses: Poses, known: Known) -> Iterator[Primitive]:
        """Yield θ - f(t)."""
        bodies, values = chosen(self.joint, ANGLE, known, "joint").measure[1:3]
        law = motion_of(self.motion, "motion")
        yield Primitive(elements.AngleDriver, bodies, (*values[:3], *law), "angle")
