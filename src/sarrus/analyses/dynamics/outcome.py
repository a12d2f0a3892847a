"""From arrays of states to a trajectory."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...algebra import Array
from ...results import Trajectory
from ...system import System


def trajectory_of(system: System, states: tuple[Array, ...], *, status: str, **told: Any) -> Trajectory:
    """The trajectory of the arrays t, q, v, a, lam."""
    t, q, v, a, lam = states
    violation = np.array(list(_violations(system, t, q)))
    return Trajectory(
        system.name,
        tuple(system.bodies),
        tuple(system.coordinate_names),
        *(t, q, v, a, lam, violation),
        success=status == "finished",
        status=status,
        joints=system.joint_coordinates,
        system=system,
        **told,
    )


def _violations(system: System, t: Array, q: Array) -> Iterator[float]:
    """The largest entry of |Φ| at each time, with what elements remember of the times before."""
    b = system.b.copy()
    for time, state in zip(t, q, strict=True):
        system.remember(state, b, float(time))
        yield float(abs(system.Phi(state, time, b=b)).max(initial=0.0))


def nothing(system: System, status: str, message: str) -> Trajectory:
    """A trajectory without states: it failed at the start."""
    widths = (system.nq, system.nq, system.nq, system.m)
    states = (np.zeros(0), *(np.zeros((0, width)) for width in widths))
    return trajectory_of(system, states, status=status, message=message)
