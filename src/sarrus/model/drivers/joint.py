"""Drivers of a joint: its angle or its displacement is a function of time. 1 equation each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from ... import elements
from ..coordinate import ANGLE, DISPLACEMENT, Known, chosen
from ..geometry.pose import Poses
from ..laws.prescribed import Motion, motion_of
from ..measure import In
from ..primitive import Primitive
from .driver import Driver


@dataclass(frozen=True, eq=False)
class AngleDriver(Driver):
    """The angle [rad] of a ``joint`` follows a ``motion``, a number or a function of time, with all revolutions.

    The joint is given by name, ``pin``, or where it has several angles ``hook.angle_i``.
    """

    joint: str
    motion: Annotated[Motion, In("rad", over="s", states=True)]

    def primitives(self, poses: Poses, known: Known) -> Iterator[Primitive]:
        """Yield θ - f(t)."""
        bodies, values = chosen(self.joint, ANGLE, known, "joint").measure[1:3]
        law = motion_of(self.motion, "motion")
        yield Primitive(elements.AngleDriver, bodies, (*values[:3], *law), "angle")


@dataclass(frozen=True, eq=False)
class DisplacementDriver(Driver):
    """The displacement [m] of a ``joint`` follows a ``motion``, a number or a function of time.

    The joint is given by name, ``slide``, or if it has several displacements ``table.displacement_x``.
    """

    joint: str
    motion: Annotated[Motion, In("m", over="s", states=True)]

    def primitives(self, poses: Poses, known: Known) -> Iterator[Primitive]:
        """Yield h_i·d - f(t)."""
        bodies, values = chosen(self.joint, DISPLACEMENT, known, "joint").measure[1:3]
        law = motion_of(self.motion, "motion")
        yield Primitive(elements.DisplacementDriver, bodies, (*values[:3], *law), "displacement")
