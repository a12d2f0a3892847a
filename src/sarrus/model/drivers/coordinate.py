"""Coordinate driver: one of the seven coordinates of a body is a function of time. 1 equation."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Literal

from ... import elements
from ..checks.names import find
from ..coordinate import Known
from ..errors import ModelError
from ..forces.force import refuse_ground
from ..geometry.pose import Poses
from ..geometry.solid import Solid
from ..laws.prescribed import Motion, motion_of
from ..measure import In
from ..primitive import Primitive
from .driver import Driver

NAMES = ("x", "y", "z", "e0", "e1", "e2", "e3")


@dataclass(frozen=True, eq=False)
class CoordinateDriver(Driver):
    """A ``coordinate`` of a ``body``, x, y, z [m] of its origin or an Euler parameter, follows a ``motion``."""

    body: Solid
    coordinate: Literal["x", "y", "z", "e0", "e1", "e2", "e3"]
    motion: Annotated[Motion, In("", over="s", states=True)]

    @property
    def law_measures(self) -> dict[str, In]:
        """The quantity of the motion: a length for x, y and z."""
        return {"motion": In("m" if self.coordinate in ("x", "y", "z") else "1", over="s", states=True)}

    def primitives(self, poses: Poses, known: Known) -> Iterator[Primitive]:
        """Yield coordinate - f(t)."""
        refuse_ground(self.body.name, "body")
        find(self.body.name, poses, "body")
        if self.coordinate not in NAMES:
            message = f"coordinate must be one of {', '.join(NAMES)}, but is {self.coordinate!r}. Choose one."
            raise ModelError(message, field="coordinate")
        form = [float(name == self.coordinate) for name in NAMES]
        values = (tuple(form[:3]), form[3], tuple(form[4:]), *motion_of(self.motion, "motion"))
        yield Primitive(elements.CoordinateDriver, (self.body.name,), values, self.coordinate)
