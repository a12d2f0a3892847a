"""Stiffness and damping of a one-sided contact law in place of MuJoCo's ``solref`` and ``solimp``.

MuJoCo solves a soft constraint of the depth r, a₁ = (1 − d) a₀ + d a_ref with a_ref = −b ṙ − k r, for accelerations;
its force depends on the acceleration. At rest this force is that of a spring, m d k/(1 − d), where m is the inverse of
the constraint's inverse inertia in the pose of the file, and d the impedance. The contact law has this spring at the
largest impedance, so that bodies rest at the same depth under a large load; and the damper b/k · spring at the depth
``width``.

MuJoCo's equalities are elastic. Where they hold a mechanism to a body that may be anywhere, they act as a spring and
not as a joint: the spring has MuJoCo's stiffness at rest and its damping, see `compliance`. MuJoCo measures a rotation
by φ as e = torquescale · sin(φ/2), so that its torque is k e de/dφ = torquescale²/4 · k sin φ, that of the spring φ in
place of sin φ.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from ....model import CartesianSpring, Fixed, Force, Joint, Spherical, SphericalSpring
from ....model.errors import ModelError
from ....model.show import quote
from ..compiled import disabled

LARGEST, SMALLEST = 0.9999, 0.0001  # impedances in MuJoCo
DEFAULT = (0.02, 1.0)  # MuJoCo's `solref`, which it takes in place of one with a single positive number
# Ratio of a mass to the inertia along a constraint that does not move it in the file's pose
STATIONARY = 1e-9
NARROW = 1e-3  # [rad, m] the least depth of the equal damper: MuJoCo's default of `width`


class Compliance(NamedTuple):
    """A linear contact law: stiffness [N/m, N m/rad], and damping [s/m, s/rad] after Hunt and Crossley."""

    stiffness: float
    damping: float


class SpringDamper(NamedTuple):
    """Stiffness [N/m, N m/rad], and damping [N s/m, N m s/rad]."""

    k: float
    c: float


def compliance(compiled: Any, solref: Any, solimp: Any, inverse_inertia: float, part: str) -> Compliance:
    """Return the contact law of a constraint, see `spring_damper`."""
    k, c = spring_damper(compiled, solref, solimp, inverse_inertia, part)
    return Compliance(k, c / k / max(float(solimp[2]), NARROW))


def spring_damper(compiled: Any, solref: Any, solimp: Any, inverse_inertia: float, part: str) -> SpringDamper:
    """Return the spring and damper with the force of a constraint at rest, and for a steady speed.

    Parameters
    ----------
    compiled : the model
    solref : (2,) time constant [s] and damping ratio, or negative stiffness [1/s²] and damping [1/s]
    solimp : (5,) smallest and largest impedance, width, midpoint, power
    inverse_inertia : [1/kg, 1/(kg m²)] along the constraint
    part : for messages, ``joint "elbow"``

    Raises
    ------
    ModelError
        If the constraint has no stiffness, or moves no mass.
    """
    largest = min(max(float(solimp[1]), SMALLEST), LARGEST)
    first, second = map(float, solref[:2])
    if (first > 0) != (second > 0):
        first, second = DEFAULT
    if first > 0:
        if not disabled(compiled, "REFSAFE"):
            first = max(first, 2 * float(compiled.opt.timestep))
        spring, damper = 1 / (first * second) ** 2, 2 / first
    else:
        spring, damper = -first, -second
    if not spring > 0 or not inverse_inertia > 0:
        message = (
            "has a contact or limit without stiffness" if not spring > 0 else "has a limit, but moves no mass"
        )
        remedy = 'Correct `solref` or the mass, or import it with ignore=["contacts", "limits"].'
        raise ModelError(f"{message}. {remedy}", part=part)
    mass = 1 / (1 - largest) / inverse_inertia
    return SpringDamper(spring * mass, damper * mass)


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
