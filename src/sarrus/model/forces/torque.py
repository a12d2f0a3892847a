"""A torque on a body, constant or varying in time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from ... import elements
from ..law import Law
from ..measure import In
from ..names import find
from ..point import Axes
from ..pose import Poses
from ..primitive import Primitive
from ..solid import Solid
from .force import Force, choose, refuse_ground
from .history import Load, history


@dataclass(frozen=True, eq=False)
class Torque(Force):
    """A ``torque`` [N m] on ``body``, in global axes, or in body axes: it follows the body.

    Parameters
    ----------
    body
        On which it acts.
    torque
        Three components; each a number, or a law over time [s].
    axes
        "global" or "body".
    factor
        A number, or a law over time [s], that scales the torque.
    """

    body: Solid
    torque: Annotated[Load, In("N m", over="s")]
    axes: Axes = "global"
    factor: Annotated[Law, In("1", over="s")] = 1.0

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the torque."""
        find(self.body.name, poses, "body")
        refuse_ground(self.body.name, "body")
        torque, curves = history(self.torque, self.factor, "torque")
        element = choose(self.axes, of_global=elements.Torque, of_body=elements.BodyTorque)
        if curves:
            element = choose(self.axes, of_global=elements.VaryingTorque, of_body=elements.VaryingBodyTorque)
        yield Primitive(element, (self.body.name,), (torque, *curves), "torque")
