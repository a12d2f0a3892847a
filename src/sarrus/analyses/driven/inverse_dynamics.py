"""Inverse dynamics: the multipliers, and so the forces of drivers and joints, that a given motion needs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...algebra import Array
from ...linalg.threads import one_thread_if_small
from ...model.announcement import reports_warnings
from ...results import Trajectory
from ...system import System
from ..arguments import kind, refuse_other_system
from ..equations.length import units
from ..equations.minimum_norm import least_multipliers
from ..equations.nullspace import NullSpace
from ..equations.projection import largest

BALANCED = 1e-7  # of the largest force on a body before forces cancel: what a motion may miss


class Multipliers(NamedTuple):
    """lam (m,), and the generalized force that no constraint can give, Q + S - M a - Φ_qᵀ lam (nq,)."""

    lam: Array
    missing: Array


def multipliers(
    system: System, q: ArrayLike, v: ArrayLike, a: ArrayLike, t: float = 0.0, *, b: Array | None = None
) -> Multipliers:
    """Solve M a + Φ_qᵀ lam = Q + S for lam, Eq. (1). Where equations are redundant, the shortest lam.

    Parameters
    ----------
    system : System
    q, v, a : (nq,) the motion
    t : time [s]
    b : (nb,) other numbers than the model's

    Returns
    -------
    Multipliers
    """
    J = system.Phi_q(q, t, b=b)
    needed = system.Q(q, v, t, b=b) + system.S(q, v, b=b) - system.M_a(q, a, b=b)
    place = np.asarray(q, dtype=float)
    lam = least_multipliers(system, NullSpace(J, units(system, place, J)), J, place, b, needed)
    return Multipliers(lam, needed - J.T @ lam)


@reports_warnings
@one_thread_if_small
def inverse_dynamics(system: System, run: Trajectory) -> Trajectory:
    """Compute the multipliers (reactions and driving forces) that a given motion requires.

    Parameters
    ----------
    system : System
        Its drivers and joints supply the forces; they may differ from those of the system of `run`.
    run : Trajectory
        Its t, q, v and a are used unchanged.

    Returns
    -------
    Trajectory
        With ``success`` false and the body in the message, if no joint or driver can supply a necessary force.

    Raises
    ------
    ValueError
        If the motion has other bodies.
    """
    refuse_other_system(system, "inverse_dynamics")
    if not isinstance(run, Trajectory):
        raise TypeError(
            f"inverse_dynamics needs the Trajectory of a run, got {kind(run)}. Call sr.kinematics or sr.simulate first."
        )
    if run.bodies != tuple(system.bodies):
        raise ValueError(f"{run.name} has other bodies than {system.name}. Give a run of this system.")
    b, solutions, states = system.b.copy(), list[Multipliers](), list[RecordedState]()
    for t, q, v, a in zip(run.t, run.q, run.v, run.a, strict=True):
        system.remember(q, b, t)
        solutions.append(multipliers(system, q, v, a, t, b=b))
        states.append(recorded_state(system, t, q, v, b))
    lam = np.array([each.lam for each in solutions]).reshape(-1, system.m)
    failure = _failure(system, run, np.array([each.missing for each in solutions]).reshape(-1, system.nq))
    message = failure or "every force is borne by joints and drivers"
    status = "not balanced" if failure else "finished"
    verdict: dict[str, Any] = {"success": not failure, "status": status, "message": message}
    known = run.analysis == "kinematics" and run.system is system  # its multipliers are these already
    analysis = run.analysis if known else "inverse dynamics"
    return replace(run, lam=lam, system=system, analysis=analysis, steps=None, **verdict, **histories(states))


def _failure(system: System, run: Trajectory, missing: Array) -> str:
    """A message about the largest missing force (nt, nq), or nothing."""
    states = list(zip(run.t, run.q, run.v, run.a, strict=True))
    scale = max(
        (largest(system.M_a(q, a)) + largest(system.magnitude("Q", q=q, v=v, t=t)) for t, q, v, a in states),
        default=0.0,
    )
    if largest(missing.reshape(-1)) <= BALANCED * max(scale, 1e-300):
        return ""
    at, n = np.unravel_index(np.argmax(abs(missing)), missing.shape)
    return (
        f"{system.name} does not move so by itself: at t = {run.t[at]:.6g} s a force of {missing[at, n]:.3g} "
        f"along {system.coordinate_names[n]} is missing. Add a driver or a force"
    )


class RecordedState(NamedTuple):
    """Largest entries of |Φ| and of |Φ_q v + Φ_t|, and the energies [J]; named as in `Trajectory`."""

    violation: float
    velocity_violation: float
    kinetic_energy: float
    potential_energy: float


def recorded_state(system: System, t: float, q: Array, v: Array, b: Array) -> RecordedState:
    """Return the quantities of a state, for parameters b that contain the state variables of elements."""
    rate = system.Phi_q_xi(q, v, t, b=b) + system.Phi_t(q, t, b=b)
    energies = system.kinetic_energy(q, v, b=b), system.potential_energy(q, t, b=b)
    return RecordedState(largest(system.Phi(q, t, b=b)), largest(rate), *energies)


def histories(states: Sequence[RecordedState]) -> dict[str, Any]:
    """The fields of a trajectory (nt,) with these states."""
    columns = np.array(states, dtype=float).reshape(-1, len(RecordedState._fields)).T
    return dict(zip(RecordedState._fields, columns, strict=True))
