"""First-order states at rest: where an equilibrium is sought, q holds the states instead of their integrals.

Q(q, v(q), t) with v(q) = 0 but for the states,    dQ/dq = Q_q + Q_v v_q
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.linalg import null_space
from scipy.sparse import csr_array

from ...algebra import Array
from ...system import System

ITERATIONS, SETTLED = 50, 1e-13  # of Newton's method; the last change of a state, relative to it
LEAST = 1e-3  # of the nominal value of a state: smaller ones count as this
SINGULAR = 1e12  # condition number from which states are not determined by the position


def places(system: System) -> Array:
    """Places of the states in v, and of their integrals in q."""
    return np.array([one.place for one in system.states.values()], dtype=np.int64)


def sizes(system: System, q: Array) -> Array:
    """Sizes of the states that q holds, at least a thousandth of their nominal values (ns,)."""
    least = [LEAST * one.nominal for one in system.states.values()]
    return np.asarray(np.maximum(abs(q[places(system)]), least))


def at_rest(system: System, q: Array) -> Array:
    """Velocities of bodies at rest, with the states that q holds (nq,)."""
    v, own = np.zeros(system.nq), places(system)
    v[own] = q[own]
    return v


def with_states(system: System, q: Array, v: Array) -> Array:
    """Coordinates that hold the states of v in the places of their integrals (nq,)."""
    found, own = q.copy(), places(system)
    found[own] = v[own]
    return found


def by_position(system: System, matrix: Callable[[str], csr_array]) -> Array:
    """Q_q + Q_v v_q: the derivative of forces at rest by coordinates that hold the states (nq, nq).

    `matrix` is called with "Q_q", and with "Q_v" if there are states.
    """
    found, own = np.asarray(matrix("Q_q").toarray()), places(system)
    if len(own):
        found[:, own] += matrix("Q_v").toarray()[:, own]
    return found


def following(system: System, q: Array, t: float, b: Array) -> Array:
    """Places of the states that may follow the position: not those whose rates depend on none of these states.

    The rate of an integral depends on the error alone.
    """
    own = places(system)
    while True:
        J = _rates_by_states(system, q, t, b, own)
        depends = abs(J).max(axis=1, initial=0.0) > 0.0
        if np.all(depends):
            return own
        own = own[depends]


def _rates_by_states(system: System, q: Array, t: float, b: Array, own: Array) -> Array:
    v = at_rest(system, q)
    J = by_position(system, lambda name: getattr(system, name)(q, v, t, b=b))
    return np.asarray(J[own][:, own])


def settled_states(system: System, q: Array, t: float, b: Array, own: Array) -> Array | None:
    """Coordinates with states that have no rates at a position at rest; None where there are none, or many.

    `own` are the places of these states; the others keep their values.
    """
    q = q.copy()
    for _ in range(ITERATIONS):
        rates = system.Q(q, at_rest(system, q), t, b=b)[own]
        J = _rates_by_states(system, q, t, b, own)
        size = abs(J).max(axis=1, initial=0.0)
        if (
            not np.all(size > 0.0)
            or not np.all(np.isfinite(rates))
            or np.linalg.cond(J / size[:, None]) > SINGULAR
        ):
            return None
        change = np.linalg.solve(J, -rates)
        q[own] += change
        if np.all(abs(change) <= SETTLED * sizes(system, q)[np.isin(places(system), own)]):
            return q
    return None


def undetermined(system: System, Z: Array, H: Array) -> list[str]:
    """Names of the states that change along directions Z in which neither forces nor rates do, for H = Zᵀ K Z."""
    rows = abs(H).max(axis=1, initial=0.0)
    H = H / np.where(rows > 0, rows, 1.0)[:, None]
    columns = abs(H).max(axis=0, initial=0.0)
    columns = np.where(columns > 0, columns, 1.0)
    motions = abs(Z @ (null_space(H / columns, rcond=1 / SINGULAR) / columns[:, None])).max(
        axis=1, initial=0.0
    )
    least = LEAST * motions.max(initial=0.0)
    return [name for name, one in system.states.items() if motions[one.place] > least]


def states_last(own: Array, Z: Array, share: Array) -> tuple[Array, Array]:
    """A basis of free directions (nq, d) with share Z = I, of which the last are states and no other has a part.

    `own` are the places of these states.
    """
    if not len(own):
        return Z, share
    turn = np.hstack([null_space(Z[own]), share[:, own]])
    Z, share = Z @ turn, np.linalg.solve(turn, share)
    Z[own, : -len(own)] = 0.0
    return Z, share


def without_states(system: System, Z: Array, share: Array) -> tuple[Array, Array]:
    """A basis of those free directions in which bodies move alone, and its share."""
    Z, share = states_last(places(system), Z, share)
    count = Z.shape[1] - len(system.states)
    return Z[:, :count], share[:count]
