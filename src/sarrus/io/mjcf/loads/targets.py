"""Equalities with a body that a program moves (``mocap``), such as the target of a robot's hand, as springs.

MuJoCo's equalities are elastic. Where they hold a mechanism to a body that may be anywhere, they act as a spring and
not as a joint: the spring has MuJoCo's stiffness at rest and its damping, see `compliance`. MuJoCo measures a rotation
by φ as e = torquescale · sin(φ/2), so that its torque is k e de/dφ = torquescale²/4 · k sin φ, that of the spring φ in
place of sin φ.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ....model import CartesianSpring, Fixed, Force, Joint, Spherical, SphericalSpring
from ....model.show import quote
from .compliance import spring_damper

TORQUE_SCALE = 10  # place in the data of a weld


def has_target(compiled: Any, bodies: tuple[int, int]) -> bool:
    """Return whether a program moves one of two bodies."""
    return any(int(compiled.body_mocapid[k]) >= 0 for k in bodies)


def springs_in_place(compiled: Any, k: int, joint: Joint, bodies: tuple[int, int]) -> Iterator[Force]:
    """Yield the springs in place of the joint of an equality."""
    inverse = compiled.body_invweight0[list(bodies)].sum(axis=0)
    law = compiled.eq_solref[k], compiled.eq_solimp[k]
    part = f"equality {quote(joint.name)}"
    along, about = (spring_damper(compiled, *law, float(one), part) for one in inverse)
    ends: Any = joint
    points = (
        (ends.point_i, ends.point_j)
        if isinstance(joint, Spherical)
        else (ends.frame_i.point, ends.frame_j.point)
    )
    yield CartesianSpring(joint.name, *points, stiffness=(along.k,) * 3, damping=(along.c,) * 3)
    if isinstance(joint, Fixed):
        share = float(compiled.eq_data[k, TORQUE_SCALE]) ** 2 / 4
        frames = {"frame_i": ends.frame_i, "frame_j": ends.frame_j}
        yield SphericalSpring(f"{joint.name}_rotation", **frames, k=share * about.k, c=share * about.c)
