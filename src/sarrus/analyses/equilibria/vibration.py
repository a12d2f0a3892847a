"""Vibration modes: eigenvalues of the linearized equations of motion, and the stability that follows.

Steady motion: one that looks the same at all times to an observer who rotates with it.

In a steady motion all bodies turn with a common angular velocity Ω in global axes, and each with a constant angular
velocity in its own axes, as a rotor about its axis of symmetry. Both are linear maps of q = [r; p], and so of v and of
small changes of either: v = X q + constant, a = X v.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array, vstack

from ...algebra import Array, skew
from ...euler import A, E, bar, bar_E
from ...linalg.threads import one_thread_if_small
from ...model.announcement import announce, reports_warnings
from ...results import Modes
from ...system import System
from ...system.layout import Layout
from ...system.terms import Terms, terms_of
from ..arguments import refuse_other_system
from ..equations.length import extent, units
from ..equations.minimum_norm import least_multipliers
from ..equations.nullspace import NullSpace, refuse_missing_inertia
from ..equations.projection import largest
from ..equations.states_at_rest import places, sizes, with_states, without_states
from ..position.initial_state import PartialState, Start, consistent_state_of
from .balance import RESOLVED

STEADY = 1e-6  # of the forces on a body before they cancel: what may accelerate it


class FirstOrderSystem(NamedTuple):
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


class BaseState(NamedTuple):
    """A state, and the acceleration and multipliers there."""

    t: float
    q: Array
    v: Array
    a: Array
    lam: Array
    b: Array


def around(system: System, state: PartialState) -> tuple[BaseState, NullSpace]:
    """Accelerations along and across the free directions, then the shortest multipliers."""
    q, t, b = state.q, state.t, state.parameters(system)
    speed = np.zeros(system.nq) if state.v is None else state.v
    J, M = system.Phi_q(q, t, b=b), system.M(q, b=b)
    space = NullSpace(J, units(system, q, J))
    force = system.Q(q, speed, t, b=b) + system.S(q, speed, b=b)
    refuse_missing_inertia(system, q, space.Z, M)
    across = space.change(system.gamma(q, speed, t, b=b))
    along = np.linalg.solve(space.Z.T @ (M @ space.Z), space.Z.T @ (force - M @ across))
    a = across + space.Z @ along
    return BaseState(t, q, speed, a, least_multipliers(system, space, J, q, b, force - M @ a), b), space


def reduced(system: System, at: BaseState, space: NullSpace, turning: Array) -> FirstOrderSystem:
    """The linear equations along the free directions."""
    t, q, v, a, lam, b = at
    X = generator(system.layout, q, v, turning)
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
    return FirstOrderSystem(A, left, right[:, n:], right[:, :n], Z, P, W, largest(a - X @ v))


def _of_positions(system: System, at: BaseState, space: NullSpace) -> NullSpace:
    """The directions in which positions can change: those of the velocities, if all constraints are holonomic."""
    if system.m_holonomic == system.m:
        return space
    J = system.holonomic.Phi_q(at.q, at.t, b=at.b)
    return NullSpace(J, units(system, at.q, system.Phi_q(at.q, at.t, b=at.b)))


def _turned(system: System, at: BaseState, gamma_v: csr_array) -> csr_array:
    """-(Φ_q v + Φ_t)_q, which is ½ γ_v for holonomic constraints only."""
    along, count = system.Phi_q_xi_q(at.q, at.v, at.t, b=at.b), system.m_holonomic
    return csr_array(vstack([0.5 * gamma_v[:count], -along[count:]]))


@reports_warnings
@one_thread_if_small
def modes(
    system: System,
    q: Start,
    v: ArrayLike | None = None,
    *,
    t: float | None = None,
    turning: ArrayLike = (0.0, 0.0, 0.0),
) -> Modes:
    """Compute the vibration modes about an equilibrium or a steady motion, with exact derivatives.

    Parameters
    ----------
    system : System
    q, v : (nq,) an equilibrium, or a state of a steady motion. `q` may be what `equilibrium` returns, an `Assembly` or
        a `State`, which has its own velocities and time
    t : time [s]; by default that of the state, or 0
    turning : (3,) angular velocity in global axes of the observer to whom the motion looks steady [rad/s]

    Returns
    -------
    Modes
        With ``success`` false and the reason in ``message``, if this is neither an equilibrium nor a steady motion.
    """
    refuse_other_system(system, "modes")
    at, space = around(system, consistent_state_of(system, q, v, t))
    linear, terms = reduced(system, at, space, np.asarray(turning, dtype=float)), terms_of(system, *at)
    changes = np.hstack([linear.Z, 0 * linear.W]), np.hstack([linear.P, linear.W])
    eigenvalues = terms.eigenvalues(linear.A, linear.M, *changes, system.moving)
    keep = eigenvalues.order
    values, round_off = eigenvalues.s[keep], eigenvalues.round_off[keep]
    stability = _stability(values, round_off)
    steady = _is_steady(system, at, np.asarray(turning, dtype=float), terms)
    success, message = _verdict(system, at, linear, steady, stability, values)
    advice = ". Give a state that `equilibrium` returns" if len(linear.A) else ""
    announce([] if success else [message + advice])
    n, states = linear.Z.shape[1], places(system)
    shapes = linear.Z @ eigenvalues.right[:n, keep]
    shapes[states] = (linear.W @ eigenvalues.right[n:, keep])[states]
    return Modes(
        *(system.name, tuple(system.bodies), at.q.copy(), values, _normalized(shapes, system.moving)),
        *(linear.A, linear.M, linear.D, linear.K, linear.Z, round_off, _energy_shares(system, at, shapes)),
        *(linear.unsteady, success, message, stability),
        t=at.t,
        v=at.v,
        lam=at.lam,
        system=system,
    )


def _stability(values: Array, round_off: Array) -> Literal["stable", "marginal", "unstable"]:
    """Return the stability from the real parts, each compared with the round-off of its eigenvalue."""
    if np.any(values.real > round_off):
        return "unstable"
    return "stable" if np.all(values.real < -round_off) else "marginal"


def _verdict(
    system: System, at: BaseState, linear: FirstOrderSystem, steady: bool, stability: str, values: Array
) -> tuple[bool, str]:
    kind = "steady motion" if np.any(at.v[: system.moving]) else "equilibrium"
    if not len(linear.A):
        return False, f"{system.name} has no degree of freedom, and so no modes. Replace a driver by a force"
    free = int(np.count_nonzero(values == 0))
    also = f", with {free} free motion{'s' if free > 1 else ''}" if free else ""
    if not steady:
        size = f"it accelerates by {linear.unsteady:.3g}; the modes are of no use"
        return False, f"{system.name} is in no {kind} there: {size}"
    return True, f"{system.name}: this {kind} is {stability}{also}"


def _is_steady(system: System, at: BaseState, turning: Array, terms: Terms) -> bool:
    """Whether M (a - X v) is small on every body, or what round-off in q makes of the forces."""
    X, unit = generator(system.layout, at.q, at.v, turning), system.layout.scales(extent(system, at.q))
    X[system.moving :] = 0.0
    missing = unit * abs(system.M(at.q, b=at.b) @ (at.a - X @ at.v))
    force = unit * (terms.force + terms.M @ abs(X @ at.v))
    round_off = RESOLVED * unit * (terms.K @ (abs(at.q) + unit))
    largest = np.maximum.reduceat(force, system.layout.firsts)[system.layout.owner_of]
    speed = abs(at.v)
    speed[places(system)] = sizes(system, with_states(system, at.q, at.v))  # some states are zero at rest
    rates = force + unit * (terms.D @ speed + terms.K @ abs(at.q))  # of states, before terms cancel
    largest[system.moving :] = rates[system.moving :]
    small = missing <= STEADY * largest + round_off
    return bool(np.all(small[: system.moving]) and np.all(small[places(system)]))


def _energy_shares(system: System, at: BaseState, shapes: Array) -> Array:
    """Part of the kinetic energy of each mode that each owner of coordinates has (owners, k)."""
    energy = (shapes.conj() * (system.M(at.q, b=at.b) @ shapes)).real[: system.moving]
    energy = np.add.reduceat(energy, system.layout.moving.firsts)
    total = energy.sum(axis=0)
    return np.asarray(energy / np.where(total > 0, total, 1.0))


def largest_entries(shapes: Array, moving: int) -> Array:
    """Places of the largest change of a coordinate of bodies, or of a first-order state where no body moves (k,)."""
    still = ~np.any(shapes[:moving], axis=0)
    places = np.where(still, np.argmax(abs(shapes), axis=0), np.argmax(abs(shapes[:moving]), axis=0))
    return np.asarray(places)


def _normalized(shapes: Array, moving: int) -> Array:
    """The largest change of a coordinate of bodies is 1, or that of a first-order state where no body moves."""
    if not shapes.size:
        return shapes
    top = shapes[largest_entries(shapes, moving), np.arange(shapes.shape[1])]
    return np.asarray(shapes / np.where(abs(top) > 0, top, 1.0))


def generator(layout: Layout, q: Array, v: Array, turning: Array) -> Array:
    """The matrix X (nq, nq) of the steady motion through a state, for a given Ω = `turning` in global axes [rad/s].

    For each body, ṙ = Ω x r and ṗ = ½ Eᵀ(p) Ω + ½ Gᵀ(p) ω', with ω' = Aᵀ(ω - Ω) its own angular velocity.
    """
    X = np.zeros((len(q), len(q)))
    for r, turned in zip(layout.positions[..., None], layout.bodies.rotations[..., None], strict=True):
        p, pd = q[turned[:, 0]], v[turned[:, 0]]
        omega = A(p).T @ (2 * E(p) @ pd - turning)
        X[r, r.T] = skew(turning)
        X[turned, turned.T] = 0.5 * (bar_E(turning) + bar(omega))
    return X
