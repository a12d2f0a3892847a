"""A constant torque on a body."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ... import elements
from ..measure import TorqueVector
from ..names import find
from ..point import Axes
from ..pose import Poses
from ..primitive import Primitive
from ..quantity import vector
from ..solid import Solid
from .force import Force, choose, refuse_ground


@dataclass(frozen=True, eq=False)
class Torque(Force):
    """A ``torque`` [N m] on ``body``, constant in global axes, or in body axes: it follows the body."""

    body: Solid
    torque: TorqueVector
    axes: Axes = "global"

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the torque."""
        find(self.body.name, poses, "body")
        refuse_ground(self.body.name, "body")
        element = choose(self.axes, of_global=elements.Torque, of_body=elements.BodyTorque)
        yield Primitive(element, (self.body.name,), (vector(self.torque, "torque"),), "torque")
