"""From arrays of states to a trajectory."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....results import Trajectory
from ....system import System
from ..dense_output.sample_loop import Samples


def trajectory_of(system: System, samples: Samples, *, status: str, **message: Any) -> Trajectory:
    """The trajectory of sampled states."""
    return Trajectory(
        system.name,
        tuple(system.bodies),
        tuple(system.coordinate_names),
        *(samples.t, samples.q, samples.v, samples.a, samples.lam, samples.violation[:, 0]),
        velocity_violation=samples.violation[:, 1],
        kinetic_energy=samples.energy[:, 0],
        potential_energy=samples.energy[:, 1],
        memory=samples.memory,
        revolutions=samples.revolutions,
        success=status in ("finished", "event"),
        status=status,
        joints=system.joint_coordinates,
        system=system,
        **message,
    )


def nothing(system: System, status: str, message: str) -> Trajectory:
    """A trajectory without states: it failed at the start."""
    widths = (system.nq, system.nq, system.nq, system.m, 2, 2)
    remembered = np.zeros((0, len(system.memory_places))), np.zeros((0, system.joint_coordinates.m))
    samples = Samples._make(
        [np.zeros(0), *(np.zeros((0, width)) for width in widths), np.zeros(0), *remembered]
    )
    return trajectory_of(system, samples, status=status, message=message)
