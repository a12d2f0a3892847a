"""Outputs that depend on the position alone as functions of q, with all operators of a constraint."""

from __future__ import annotations

from ..model.expansion.blueprint import Placement
from ..system import System
from ..system.cached import once
from ..system.operators.joints import JointCoordinate, JointCoordinates
from .output import Level, Output, UnknownOutput, find_output


def measured(system: System, name: str, where: str) -> JointCoordinate:
    """An output of the position with its derivatives.

    Raises
    ------
    UnknownOutput
        If there is no such output, or it depends on more than the position.
    """
    output = find_output(system, name, Level.POSITION, where)
    if output.name in system.joint_coordinates.names:
        return JointCoordinate(system.joint_coordinates, output.name)
    return JointCoordinate(_alone(system, name, where), output.name)


@once
def _alone(system: System, name: str, where: str) -> JointCoordinates:
    output = find_output(system, name)
    found = JointCoordinates([placed_of(system, output, where)], system.layout)
    found.names = (output.name,)
    return found


def placed_of(system: System, output: Output, where: str) -> Placement:
    """The element that measures an output.

    Raises
    ------
    UnknownOutput
        If there is none.
    """
    if output.element is None:
        raise UnknownOutput(
            f"{system.name}: {where} takes coordinates of bodies, points and joints, and lengths of forces, "
            f"not {output.name!r}. Write it by these, as in 'b.z - a.z'."
        )
    return output.element(system)
