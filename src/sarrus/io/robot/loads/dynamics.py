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
    SphericalInertia,
    SphericalSpring,
    ViscousDrag,
)
from ....model.errors import ModelError
from ....model.forces import Force
from ....model.geometry.frame import Frame
from ....model.geometry.motion import Ball, Motion, Slide, Turn
from ....model.geometry.point import Point
from ....model.geometry.solid import GROUND
from ....model.show import quote
from ..description import Dynamics
from ..joints import Hinge

CREEP = 1e-3  # [rad/s, m/s] speed below which what would stick creeps


def forces_of(hinge: Hinge, motion: Motion, given: Dynamics) -> Iterator[Force]:
    """Yield the forces of one motion; they are named after it.

    Raises
    ------
    ModelError
        For what a free body cannot have.
    """
    if isinstance(motion, Turn):
        yield from _about(hinge, motion, given)
    elif isinstance(motion, Slide):
        yield from _along(hinge, motion, given)
    elif isinstance(motion, Ball):
        yield from _of_ball(hinge, motion, given)
    else:
        yield from _of_free(hinge, motion, given)


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


def _of_ball(hinge: Hinge, motion: Ball, given: Dynamics) -> Iterator[Force]:
    i, j = hinge.frames(motion.point, np.eye(3)[2])
    if given.stiffness or given.damping or given.friction:
        values: Any = {"k": given.stiffness, "c": given.damping, "friction": given.friction, "creep": CREEP}
        yield SphericalSpring(f"{motion.name}_spring", frame_i=i, frame_j=j, **values)
    if given.inertia:
        yield SphericalInertia(f"{motion.name}_inertia", hinge.parent, hinge.child, inertia=given.inertia)


def _of_free(hinge: Hinge, motion: Motion, given: Dynamics) -> Iterator[Force]:
    """Yield the damping of a free body."""
    if given != Dynamics(damping=given.damping) or hinge.parent.name != GROUND:
        message = "only damping, of a motion from the ground, can be given to a body that moves freely"
        remedy = "Put hinges and slides in its place, or import it with ignore=['dynamics']"
        raise ModelError(f"{message}. {remedy}.", part=f"joint {quote(motion.name)}")
    yield ViscousDrag(
        f"{motion.name}_drag", Point(hinge.child, np.zeros(3)), c=given.damping, c_turn=given.damping
    )
