"""Degrees of freedom and dependent equations of a system at one position, in words."""

from __future__ import annotations

import numpy as np
from scipy.linalg import null_space
from scipy.sparse import csr_array

from ...algebra import Array
from ...linalg.quadratic_forms import common_zeros
from ...linalg.rank import Rank, independent_rows, rank_of, row_lengths
from ...linalg.threads import one_thread_if_small
from ...model.announcement import reports_warnings
from ...results import Mobility, Repetition
from ...results.mobility import Kind
from ...system import System
from ..arguments import refuse_other_system
from ..equations.length import scaled, units
from ..equations.nullspace import DENSE_UP_TO, normalizations
from ..equations.states_at_rest import places
from ..position.assembly import assemble
from ..position.initial_state import Start, state_of
from ..position.restraint import restraint

STRAIGHT = 1e-6  # curvature that counts as zero, relative to the largest before contributions cancel
PIVOT = 1e-4  # least part that an equation has in a combination from which it follows
PART = 1e-5  # least part of an equation that counts as taking part
LENGTH = 1e-6


def repetitions(system: System, q: Array, J: csr_array, null: Array) -> tuple[Repetition, ...]:
    """Name what is redundant.

    Parameters
    ----------
    system : System
    q : (nq,)
    J : (m, nq) Φ_q
    null : (m, k) orthonormal combinations of equations, scaled to unit gradients, that vanish
    """
    owner = {int(row): joint for joint, rows in system.rows.items() for row in rows}
    dependent: dict[str, list[tuple[int, set[str]]]] = {}
    for row, combination in _later_first(null, sorted(owner)):
        others = {
            owner[n] for n in np.flatnonzero(abs(combination) > PART).tolist() if n in owner and n != row
        }
        dependent.setdefault(owner[row], []).append((row, others - {owner[row]}))
    return tuple(
        _repetition(system, q, J, joint, dependent[joint]) for joint in system.rows if joint in dependent
    )


def _repetition(
    system: System, q: Array, J: csr_array, joint: str, dependent: list[tuple[int, set[str]]]
) -> Repetition:
    rows = tuple(sorted(row for row, _ in dependent))
    names = set().union(*(others for _, others in dependent))
    words = tuple(restraint(system.layout, J, row, q).words() for row in rows)
    repeats = tuple(name for name in system.rows if name in names)
    return Repetition(joint, repeats, rows, words, len(rows) == len(system.rows[joint]))


def _later_first(null: Array, rows: list[int]) -> list[tuple[int, Array]]:
    """Each dependent row with the combination of it and rows before it that vanishes.

    Going back from the last row, a row with a part in the combinations that are left takes one of them away.
    """
    left, dependent = null, []
    for row in reversed(rows):
        size = float(np.linalg.norm(left[row])) if left.shape[1] else 0.0
        if size > PIVOT:
            axis = left[row] / size
            dependent.append((row, left @ axis / size))
            rest = np.linalg.svd(axis[None, :])[2][1:].T
            left = left @ rest
    return dependent


@reports_warnings
@one_thread_if_small
def mobility(
    system: System,
    q: Start | None = None,
    *,
    t: float | None = None,
    tolerance: float | None = None,
) -> Mobility:
    """Compute the degrees of freedom, name redundant constraints, and test infinitesimal motions to second order.

    A velocity ξ with Φ_q ξ = 0 belongs to a motion only if nᵀ (Φ_q ξ)_q ξ = 0 for every combination n of
    equations with nᵀΦ_q = 0. These forms are evaluated with the exact (Φ_qᵀ n)_q.

    Parameters
    ----------
    system : System
    q : (nq,) a position that satisfies the constraints, or an `Assembly`, a `State` or an `Equilibrium`; by default the
        model's, assembled
    t : time [s]; by default that of the state, or 0
    tolerance : relative size of a singular value that counts as zero; by default 1e-8, and less, down to 1e-10, for
        more than 250 connected equations, because the smallest value of a chain of N links falls with 1/N²

    Returns
    -------
    Mobility
        Printed, it is a summary in words.

    Raises
    ------
    ValueError
        If no position is given and the model cannot be assembled.
    """
    refuse_other_system(system, "mobility")
    at, _, t, *_ = state_of(system, _assembled(system, t or 0.0) if q is None else q, None, t)
    J = system.Phi_q(at, t)
    unit = units(system, at, J)
    unitless = scaled(J, unit)
    rank = rank_of(unitless, tolerance)
    rows = row_lengths(unitless)
    null, motions = rank.null / rows[:, None], unit[:, None] * _motions(unitless, rank)
    motions = motions @ null_space(motions[places(system)]) if system.states else motions
    curvature = largest_curvature(system, at, t, rows, unit)
    kind, finite = _kind(system, at, t, null, motions, curvature)
    return Mobility(
        system.name,
        *(system.nq, system.m, rank.rank, system.nq - rank.rank - len(system.states), kind, finite),
        repetitions=repetitions(system, at, J, rank.null),
        independent_rows=independent_rows(rank.null, normalizations(system)),
        null_vectors=null,
        motions=np.linalg.qr(motions)[0],
        smallest=rank.smallest,
        configuration_dimension=_configurations(system, unitless, tolerance),
    )


def _configurations(system: System, J: csr_array, tolerance: float | None) -> int | None:
    """Return the dimension of the configuration space with nonholonomic constraints."""
    count, followed = system.m_holonomic, len(system.followed_states)  # each with an equation of its rate
    if count + followed == system.m:
        return None
    coordinates = system.nq - len(system.states) - followed
    return coordinates - rank_of(csr_array(J[:count]), tolerance).rank


def _assembled(system: System, t: float) -> Array:
    start = assemble(system, t=t)
    if not start.success:
        raise ValueError(start.message)
    return start.q


def _motions(J: csr_array, rank: Rank) -> Array:
    if J.shape[1] > DENSE_UP_TO:
        return np.zeros((J.shape[1], 0))
    right = np.linalg.svd(J.toarray() / row_lengths(J)[:, None], full_matrices=True)[2]
    return np.asarray(right[rank.rank :].T)


def largest_curvature(system: System, q: Array, t: float, rows: Array, unit: Array) -> float:
    """Largest entry of (Φ_qᵀ n)_q, before the elements' contributions cancel, for n of any equation at unit length."""
    terms = system.magnitude("Phi_qT_lam_q", q=q, lam=1 / rows, t=t)
    row = np.repeat(np.arange(system.nq), np.diff(terms.indptr))
    return float((terms.data * unit[row] * unit[terms.indices]).max(initial=0.0))


def _kind(
    system: System, q: Array, t: float, null: Array, motions: Array, curvature: float
) -> tuple[Kind, int | None]:
    """Return the kind of the position and its finite degrees of freedom, by second-order terms."""
    freedom, repeated = motions.shape[1], null.shape[1]
    if system.nq > DENSE_UP_TO:
        return "untested", None
    if not repeated or not freedom:
        return "redundant" if repeated else "regular", freedom
    forms = _independent(
        np.array([_form(system, q, t, null[:, n], motions) / (curvature or 1.0) for n in range(repeated)])
    )
    if not len(forms):
        return "redundant", freedom
    return ("branching", None) if common_zeros(forms) else ("shaky", 0)


def _independent(forms: Array) -> Array:
    """Return a basis of symmetric matrices (count, d, d) for some forms, empty if all vanish."""
    count, d, _ = forms.shape
    _, sizes, span = np.linalg.svd(forms.reshape(count, d * d), full_matrices=False)
    return np.asarray(span[sizes > STRAIGHT].reshape(-1, d, d))


def _form(system: System, q: Array, t: float, n: Array, motions: Array) -> Array:
    """Zᵀ (Φ_qᵀ n)_q Z for the possible velocities Z; its symmetric part, as a quadratic form."""
    form = np.asarray(motions.T @ (system.Phi_qT_lam_q(q, n, t) @ motions))
    return form if system.m_holonomic == system.m else 0.5 * (form + form.T)
