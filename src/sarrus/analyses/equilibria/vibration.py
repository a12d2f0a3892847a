"""Vibration modes: eigenvalues of the linearized equations of motion, and the stability that follows."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from ...algebra import Array
from ...linalg.threads import one_thread_if_small
from ...model.announcement import announce, reports_warnings
from ...results import Modes
from ...system import System
from ...system.terms import Terms, terms_of
from ..arguments import refuse_other_system
from ..equations.length import extent, units
from ..equations.states_at_rest import places, sizes, with_states
from ..position.initial_state import Start, state_of
from .linearization import Around, Linear, around, reduced
from .steady_motion import generator

STEADY = 1e-6  # of the forces on a body before they cancel: what may accelerate it
RESOLVED = 100 * np.finfo(float).eps  # of a coordinate: smaller changes are round-off


@reports_warnings
@one_thread_if_small
def modes(
    system: System,
    q: Start,
    v: ArrayLike | None = None,
    *,
    t: float | None = None,
    turning: ArrayLike = (0.0, 0.0, 0.0),
    strict: bool = False,
) -> Modes:
    """Compute the vibration modes about an equilibrium or a steady motion, with exact derivatives.

    Parameters
    ----------
    system : System
    q, v : (nq,) an equilibrium, or a state of a steady motion. `q` may be what `equilibrium` returns, an `Assembly` or
        a `State`, which has its own velocities and time
    t : time [s]; by default that of the state, or 0
    turning : (3,) angular velocity in global axes of the observer to whom the motion looks steady [rad/s]
    strict : raise the first warning as a `StrictError`

    Returns
    -------
    Modes
        With ``success`` false and the reason in ``message``, if this is neither an equilibrium nor a steady motion.
    """
    refuse_other_system(system, "modes")
    at, space = around(system, state_of(system, q, v, t))
    linear, terms = reduced(system, at, space, np.asarray(turning, dtype=float)), terms_of(system, *at)
    changes = np.hstack([linear.Z, 0 * linear.W]), np.hstack([linear.P, linear.W])
    found = terms.eigenvalues(linear.A, linear.M, *changes, system.moving)
    keep = found.order
    values, round_off = found.s[keep], found.round_off[keep]
    stability = _stability(values, round_off)
    steady = _is_steady(system, at, np.asarray(turning, dtype=float), terms)
    success, message = _verdict(system, at, linear, steady, stability, values)
    advice = ". Give a state that `equilibrium` returns" if len(linear.A) else ""
    announce([] if success else [message + advice])
    n, own = linear.Z.shape[1], places(system)
    shapes = linear.Z @ found.right[:n, keep]
    shapes[own] = (linear.W @ found.right[n:, keep])[own]
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
    system: System, at: Around, linear: Linear, steady: bool, stability: str, values: Array
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


def _is_steady(system: System, at: Around, turning: Array, terms: Terms) -> bool:
    """Whether M (a - X v) is small on every body, or what round-off in q makes of the forces."""
    X, unit = generator(at.q, at.v, turning), units(system.nq, extent(system, at.q))
    X[system.moving :] = 0.0
    missing = unit * abs(system.M(at.q, b=at.b) @ (at.a - X @ at.v))
    force = unit * (terms.force + terms.M @ abs(X @ at.v))
    round_off = RESOLVED * unit * (terms.K @ (abs(at.q) + unit))
    largest = np.repeat(force.reshape(-1, 7).max(axis=1), 7)
    speed = abs(at.v)
    speed[places(system)] = sizes(system, with_states(system, at.q, at.v))  # some states are zero at rest
    rates = force + unit * (terms.D @ speed + terms.K @ abs(at.q))  # of states, before terms cancel
    largest[system.moving :] = rates[system.moving :]
    allowed = STEADY * largest + round_off
    return bool(np.all(missing <= allowed))


def _energy_shares(system: System, at: Around, shapes: Array) -> Array:
    """Part of the kinetic energy of each mode that each body has (bodies, k)."""
    energy = (shapes.conj() * (system.M(at.q, b=at.b) @ shapes)).real[: system.moving]
    energy = energy.reshape(len(system.bodies), 7, shapes.shape[1]).sum(axis=1)
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
