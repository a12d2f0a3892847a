"""Point driver: a point of a body follows a path in space. 1 to 3 equations."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from ... import elements
from ..coordinate import Known
from ..errors import ModelError
from ..forces.force import refuse_ground
from ..geometry.point import Point
from ..geometry.pose import Poses
from ..geometry.solid import GROUND
from ..laws.prescribed import Motion, motion_of
from ..measure import In
from ..primitive import Primitive
from .driver import Driver

ORIGIN = (0.0, 0.0, 0.0)
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


@dataclass(frozen=True, eq=False)
class PointDriver(Driver):
    """Global coordinates ``x``, ``y``, ``z`` [m] of a ``point`` follow functions of time; those left out are free."""

    point: Point
    x: Annotated[Motion | None, In("m", over="s", states=True)] = None
    y: Annotated[Motion | None, In("m", over="s", states=True)] = None
    z: Annotated[Motion | None, In("m", over="s", states=True)] = None

    def primitives(self, poses: Poses, known: Known) -> Iterator[Primitive]:
        """Yield e·P - f(t) for each given coordinate."""
        at = self.point.resolve(poses, "point")
        refuse_ground(at.body, "point")
        paths = {
            name: path for name, path in (("x", self.x), ("y", self.y), ("z", self.z)) if path is not None
        }
        if not paths:
            raise ModelError("has no path. Give at least one of x, y and z.", field="x")
        for name, path in paths.items():
            values = (AXES[name], ORIGIN, at.s, *motion_of(path, name))
            yield Primitive(elements.DisplacementDriver, (GROUND, at.body), values, name)
