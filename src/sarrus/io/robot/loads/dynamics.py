"""Springs, dampers, dry friction and reflected inertia of joints, as forces of the model."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ....model import (
    RSDA,
    AngleFriction,
    AngleInertia,
    Bushing,
    DisplacementFriction,
    DisplacementInertia,
    PointForce,
    SphericalInertia,
    SphericalSpring,
    ViscousDrag,
)
from ....model.errors import ModelError
from ....model.expression import Name
from ....model.forces import Force
from ....model.geometry.motion import Ball, Motion, Slide, Turn
from ....model.geometry.points import GROUND, Frame, Point
from ....model.show import quote
from ..description import Dynamics
from ..joints import Hinge

CREEP = 1e-3  # [rad/s, m/s] speed below which what would stick creeps


def forces_of(hinge: Hinge, motion: Motion, dynamics: Dynamics) -> Iterator[Force]:
    """Yield the forces of one motion; they are named after it.

    Raises
    ------
    ModelError
        For what a free body cannot have.
    """
    if isinstance(motion, Turn):
        yield from _about(hinge, motion, dynamics)
    elif isinstance(motion, Slide):
        yield from _along(hinge, motion, dynamics)
    elif isinstance(motion, Ball):
        yield from _of_ball(hinge, motion, dynamics)
    else:
        yield from _of_free(hinge, motion, dynamics)


def _about(hinge: Hinge, motion: Turn, dynamics: Dynamics) -> Iterator[Force]:
    i, j = hinge.frames(motion.point, motion.axis)
    if dynamics.stiffness or dynamics.damping:
        k, c = dynamics.stiffness, dynamics.damping
        yield RSDA(f"{motion.name}_spring", frame_i=i, frame_j=j, k=k, c=c, angle=dynamics.free)
    if dynamics.friction:
        load, name = dynamics.friction, f"{motion.name}_friction"
        yield AngleFriction(name, frame_i=i, frame_j=j, load=load, mu=1.0, creep=CREEP, radius=1.0)
    if dynamics.inertia:
        yield AngleInertia(f"{motion.name}_inertia", frame_i=i, frame_j=j, inertia=dynamics.inertia)


def _along(hinge: Hinge, motion: Slide, dynamics: Dynamics) -> Iterator[Force]:
    i, j = hinge.frames(np.zeros(3), motion.axis)
    if dynamics.stiffness or dynamics.damping:
        yield _spring_along(f"{motion.name}_spring", i, j, dynamics)
    if dynamics.friction:
        load, name = dynamics.friction, f"{motion.name}_friction"
        yield DisplacementFriction(name, frame_i=i, frame_j=j, load=load, mu=1.0, creep=CREEP)
    if dynamics.inertia:
        yield DisplacementInertia(f"{motion.name}_inertia", frame_i=i, frame_j=j, inertia=dynamics.inertia)


def _spring_along(name: str, i: Frame, j: Frame, dynamics: Dynamics) -> Bushing:
    third = np.eye(6)[2]
    return Bushing(
        name,
        frame_i=i,
        frame_j=j,
        stiffness=tuple(dynamics.stiffness * third),
        damping=tuple(dynamics.damping * third),
        preload=tuple(dynamics.stiffness * dynamics.free * third),
    )


def _of_ball(hinge: Hinge, motion: Ball, given: Dynamics) -> Iterator[Force]:
    i, j = hinge.frames(motion.point, np.eye(3)[2])
    if given.stiffness or given.damping or given.friction:
        values: Any = {"k": given.stiffness, "c": given.damping, "friction": given.friction, "creep": CREEP}
        yield SphericalSpring(f"{motion.name}_spring", frame_i=i, frame_j=j, **values)
    if given.inertia:
        yield SphericalInertia(f"{motion.name}_inertia", hinge.parent, hinge.child, inertia=given.inertia)


def _of_free(hinge: Hinge, motion: Motion, given: Dynamics) -> Iterator[Force]:
    """Yield the damping, dry friction and armature of a free body, along the axes of the ground and about its own."""
    if given.stiffness or hinge.parent.name != GROUND:
        message = (
            "only damping, friction and armature, of a motion from the ground, can be given to a free body"
        )
        remedy = "Put hinges and slides in its place, or import it with ignore=['dynamics']"
        raise ModelError(f"{message}. {remedy}.", part=f"joint {quote(motion.name)}")
    name, ground, body = motion.name, hinge.parent, hinge.child
    origin = Point(body, np.zeros(3))
    if given.damping:
        yield ViscousDrag(f"{name}_drag", origin, c=given.damping, c_turn=given.damping)
    if given.friction:
        speeds = (Name(f"{body.name}.velocity.{axis}") for axis in "xyz")
        force = [f"-friction*tanh({speed}/creep)" for speed in speeds]
        numbers: Any = {"friction": given.friction, "creep": CREEP}
        yield PointForce(f"{name}_friction", origin, force, parameters=numbers)
        yield SphericalSpring(f"{name}_friction_rotation", ground, body, (0.0, 0.0, 0.0), **numbers)
    if given.inertia:
        for axis, direction in zip("xyz", np.eye(3), strict=True):
            i, j = Frame(Point(ground, np.zeros(3)), z=direction), Frame(origin)
            yield DisplacementInertia(f"{name}_inertia_{axis}", frame_i=i, frame_j=j, inertia=given.inertia)
        yield SphericalInertia(f"{name}_inertia_rotation", ground, body, inertia=given.inertia)
