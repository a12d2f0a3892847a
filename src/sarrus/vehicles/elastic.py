"""Sweeps of suspensions with bushings: equilibria at displacements, with their exact derivatives along the sweep."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from ..algebra import Array
from ..analyses.equilibria.statics import equilibrium
from ..analyses.sensitivity.implicit.equilibrium_path import PathPoint
from ..model import SarrusError
from ..results import Equilibrium, Trajectory
from ..system import System


def equilibria(system: System, displacements: Iterable[float]) -> tuple[list[Equilibrium], str]:
    """The equilibria of the rig at displacements, each from the one before, and why they end early.

    Raises
    ------
    SarrusError
        If no force keeps a part in place, already at the first of them.
    """
    found: list[Equilibrium] = []
    for t in displacements:
        rest = equilibrium(system, found[-1].q if found else None, t=float(t), stable=False)
        if not rest.success or rest.stability in ("neutral", "unstable"):
            if not found:
                raise SarrusError(rest.message)
            return found, rest.message
        found.append(rest)
    return found, ""


def elastic_motion(system: System, displacements: Array) -> tuple[Trajectory, tuple[str, str]]:
    """The equilibria at displacements on both sides of 0 as a motion, and why they end early on each side."""
    down, below = equilibria(system, displacements[displacements <= 0.0][::-1])
    up, above = equilibria(system, displacements[displacements >= 0.0])
    return _as_motion(system, [*down[:0:-1], *up]), (below, above)


def whole_motion(system: System, displacements: Array) -> Trajectory:
    """The same as one result, which fails if the equilibria end early."""
    run, messages = elastic_motion(system, displacements)
    message = " ".join(filter(None, messages))
    return replace(run, success=False, status="failed", message=message) if message else run


def _as_motion(system: System, rests: list[Equilibrium]) -> Trajectory:
    """The equilibria over the displacement, with their derivatives along it as velocities and accelerations."""
    q, lam = (np.array([getattr(one, name) for one in rests]) for name in ("q", "lam"))
    points = [PathPoint(system, one.q, one.lam, one.t, one.memory) for one in rests]
    count, none = len(rests), np.zeros(len(rests))
    return Trajectory(
        system.name,
        tuple(system.bodies),
        tuple(system.coordinate_names),
        np.array([one.t for one in rests]),
        q,
        np.array([one.velocity for one in points]),
        np.array([one.acceleration() for one in points]),
        lam,
        violation=none,
        velocity_violation=none,
        kinetic_energy=none,
        potential_energy=none,
        success=True,
        status="finished",
        message="reached the end",
        nfev=sum(one.iterations for one in rests),
        nsteps=count,
        joints=system.joint_coordinates,
        system=system,
        memory=np.array([one.memory for one in rests]),
        revolutions=np.array([one.revolutions for one in rests]),
        analysis="equilibria",
    )
