"""Compensated weights of an MJCF model, ``gravcomp``: a force against gravity at the centre of mass."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...model import PointForce
from ...model.geometry.solid import GROUND
from ..robot import Robot
from .bodies import names_of
from .flags import disabled


def weight_compensations(compiled: Any, robot: Robot) -> Iterator[PointForce]:
    """Yield the force on each moving body that has one."""
    if disabled(compiled, "GRAVITY"):
        return
    bodies = names_of(compiled)
    moving = [
        k
        for k in np.flatnonzero(compiled.body_gravcomp * compiled.body_mass)
        if bodies[k] in robot.links and robot.link(bodies[k]).body.name != GROUND
    ]
    names = robot.free_names([f"{bodies[k]}_gravcomp" for k in moving], "_force")
    for k, name in zip(moving, names, strict=True):
        lift = -compiled.body_gravcomp[k] * compiled.body_mass[k] * compiled.opt.gravity
        center = tuple(float(x) for x in compiled.body_ipos[k])
        yield PointForce(name, robot.point(bodies[k], center), tuple(float(x) for x in lift))
