"""Linearization about an equilibrium or a steady motion, with exact matrices in independent coordinates."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array, vstack

from ...algebra import Array
from ...system import System
from ..equations.length import lever
from ..equations.minimum_norm import least_multipliers
from ..equations.missing_inertia import refuse_missing_inertia
from ..equations.nullspace import NullSpace
from ..equations.projection.constraint_projection import largest
from ..equations.states_at_rest import without_states
from ..position.initial_state import Given
from .steady_motion import generator


class Linear(NamedTuple):
    """The first-order equations ẋ = A x of small changes, x = [y; w].

    y has n entries, w has d: as many, but with nonholonomic constraints less, and with first-order states, whose
    changes are in w, more.

    Attributes
    ----------
    A : (n + d, n + d)
    M, D, K : (d, d), (d, d), (d, n) mass, damping and stiffness along the free directions: M ẇ + D w + K y = 0 about a
        position at rest
    Z : (nq, n) the coordinates change by Z y
    P : (nq, n) the velocities by W w + P y
    W : (nq, d); Z, but with nonholonomic constraints or first-order states
    unsteady : largest entry of a - X v, zero in a steady motion
    warnings : short messages about what may not be as the user expects
    """

    A: Array
    M: Array
    D: Array
    K: Array
    Z: Array
    P: Array
    W: Array
    unsteady: float
    warnings: tuple[str, ...] = ()


class Around(NamedTuple):
    """A state, and the acceleration and multipliers there."""

    t: float
    q: Array
    v: Array
    a: Array
    lam: Array
    b: Array


def around(system: System, given: Given) -> tuple[Around, NullSpace]:
    """Accelerations along and across the free directions, then the shortest multipliers."""
    q, t, b = given.q, given.t, given.parameters(system)
    speed = np.zeros(system.nq) if given.v is None else given.v
    J, M = system.Phi_q(q, t, b=b), system.M(q, b=b)
    space = NullSpace(J, lever(system, q, J))
    force = system.Q(q, speed, t, b=b) + system.S(q, speed, b=b)
    refuse_missing_inertia(system, q, space.Z, M)
    across = space.change(system.gamma(q, speed, t, b=b))
    along = np.linalg.solve(space.Z.T @ (M @ space.Z), space.Z.T @ (force - M @ across))
    a = across + space.Z @ along
    return Around(t, q, speed, a, least_multipliers(system, space, J, q, b, force - M @ a), b), space


def reduced(system: System, at: Around, space: NullSpace, turning: Array) -> Linear:
    """The linear equations along the free directions."""
    t, q, v, a, lam, b = at
    X = generator(q, v, turning)
    X[system.moving :] = 0.0
    W, M = space.Z, system.M(q, b=b)
    of_positions = _of_positions(system, at, space)
    Z, share = without_states(system, of_positions.Z, of_positions.share)
    K = system.M_a_q(q, a, b=b) + system.Phi_qT_lam_q(q, lam, t, b=b)
    K = K - system.Q_q(q, v, t, b=b) - system.S_q(q, v, b=b)
    D = -(system.Q_v(q, v, t, b=b) + system.S_v(q, v, b=b))
    gamma_v = system.gamma_v(q, v, t, b=b)
    P = space.change(0.5 * (gamma_v @ Z) if of_positions is space else _turned(system, at, gamma_v) @ Z)
    turn = system.gamma_q(q, v, t, b=b) - system.Phi_q_xi_q(q, a, t, b=b)
    across = space.change(np.hstack([turn @ Z + gamma_v @ P, gamma_v @ W]))
    left = W.T @ (M @ W)
    right = W.T @ (np.hstack([K @ Z + D @ P, D @ W]) + M @ across)
    acceleration = across - W @ np.linalg.solve(left, right)
    n = Z.shape[1]
    speed = np.hstack([P, W])
    A = np.vstack([share @ (speed - X @ np.hstack([Z, 0 * W])), space.share @ (acceleration - X @ speed)])
    return Linear(A, left, right[:, n:], right[:, :n], Z, P, W, largest(a - X @ v))


def _of_positions(system: System, at: Around, space: NullSpace) -> NullSpace:
    """The directions in which positions can change: those of the velocities, if all constraints are holonomic."""
    if system.m_holonomic == system.m:
        return space
    J = system.holonomic.Phi_q(at.q, at.t, b=at.b)
    return NullSpace(J, lever(system, at.q, system.Phi_q(at.q, at.t, b=at.b)))


def _turned(system: System, at: Around, gamma_v: csr_array) -> csr_array:
    """-(Φ_q v + Φ_t)_q, which is ½ γ_v for holonomic constraints only."""
    along, count = system.Phi_q_xi_q(at.q, at.v, at.t, b=at.b), system.m_holonomic
    return csr_array(vstack([0.5 * gamma_v[:count], -along[count:]]))
