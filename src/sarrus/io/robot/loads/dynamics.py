"""Springs, dampers, dry friction and reflected inertia of joints, as forces of the model."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ....model import (
    RSDA,
    AngleFriction,
    AngleInertia,
    Bushing,
    DisplacementFriction,
    DisplacementInertia,
    Torque,
    ViscousDrag,
)
from ....model.errors import ModelError
from ....model.expression import Name
from ....model.forces import Force
from ....model.geometry.frame import Frame
from ....model.geometry.motion import Ball, Free, Motion, Slide, Turn
from ....model.geometry.point import Point
from ....model.geometry.solid import GROUND
from ....model.show import quote
from ..description import Dynamics
from ..joints import Hinge
from ..tree.carried import on_body

CREEP = 1e-3  # [rad/s, m/s] speed below which what would stick creeps


def forces_of(hinge: Hinge, motion: Motion, given: Dynamics) -> Iterator[Force]:
    """Yield the forces of one motion; they are named after it.

    Raises
    ------
    ModelError
        For what a ball or a free body cannot have.
    """
    if isinstance(motion, Turn):
        yield from _about(hinge, motion, given)
    elif isinstance(motion, Slide):
        yield from _along(hinge, motion, given)
    else:
        yield from _ball_damping(hinge, motion, given)


def _about(hinge: Hinge, motion: Turn, given: Dynamics) -> Iterator[Force]:
    i, j = hinge.frames(motion.point, motion.axis)
    if given.stiffness or given.damping:
        k, c = given.stiffness, given.damping
        yield RSDA(f"{motion.name}_spring", frame_i=i, frame_j=j, k=k, c=c, angle=given.free)
    if given.friction:
        load, name = given.friction, f"{motion.name}_friction"
        yield AngleFriction(name, frame_i=i, frame_j=j, load=load, mu=1.0, creep=CREEP, radius=1.0)
    if given.inertia:
        yield AngleInertia(f"{motion.name}_inertia", frame_i=i, frame_j=j, inertia=given.inertia)


def _along(hinge: Hinge, motion: Slide, given: Dynamics) -> Iterator[Force]:
    i, j = hinge.frames(np.zeros(3), motion.axis)
    if given.stiffness or given.damping:
        yield _spring_along(f"{motion.name}_spring", i, j, given)
    if given.friction:
        load, name = given.friction, f"{motion.name}_friction"
        yield DisplacementFriction(name, frame_i=i, frame_j=j, load=load, mu=1.0, creep=CREEP)
    if given.inertia:
        yield DisplacementInertia(f"{motion.name}_inertia", frame_i=i, frame_j=j, inertia=given.inertia)


def _spring_along(name: str, i: Frame, j: Frame, given: Dynamics) -> Bushing:
    third = np.eye(6)[2]
    return Bushing(
        name,
        frame_i=i,
        frame_j=j,
        stiffness=tuple(given.stiffness * third),
        damping=tuple(given.damping * third),
        preload=tuple(given.stiffness * given.free * third),
    )


def _ball_damping(hinge: Hinge, motion: Motion, given: Dynamics) -> Iterator[Force]:
    """Yield the damping of a ball, or of a free body on the ground."""
    on_ground = hinge.parent.name == GROUND
    if given != Dynamics(damping=given.damping) or not (on_ground or isinstance(motion, Ball)):
        message = "only damping can be given to a ball, and to a body that moves freely from the ground"
        remedy = "Put hinges and slides in its place, or import it with ignore=['dynamics']"
        raise ModelError(f"{message}. {remedy}.", part=f"joint {quote(motion.name)}")
    if not on_ground:
        yield from _between(hinge, f"{motion.name}_drag", given.damping)
        return
    at = motion.point if isinstance(motion, Ball) else np.zeros(3)
    c = given.damping if isinstance(motion, Free) else 0.0
    yield ViscousDrag(f"{motion.name}_drag", Point(hinge.child, at), c=c, c_turn=given.damping)


def _between(hinge: Hinge, name: str, damping: float) -> Iterator[Force]:
    """Yield the torque damping · (ω_i − ω_j) on the child j, and the opposite one on the parent i."""
    rates = [
        [str(Name(f"{on_body(end).name}.angular_velocity.{axis}")) for axis in "xyz"]
        for end in (hinge.parent, hinge.child)
    ]
    slip = [f"c*({i} - {j})" for i, j in zip(*rates, strict=True)]
    yield Torque(name, hinge.child, torque=slip, parameters={"c": damping})
    opposite = [f"-{one}" for one in slip]
    yield Torque(f"{name}_reaction", hinge.parent, torque=opposite, parameters={"c": damping})
