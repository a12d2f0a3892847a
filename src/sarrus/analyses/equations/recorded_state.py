"""Constraint violations and energies of a state, which trajectories store beside q, v, a and the multipliers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...algebra import Array
from ...system import System
from .projection.constraint_projection import largest


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
