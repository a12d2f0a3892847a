"""Groups of operators that sweeps evaluate together, and operators by the numbers of elements."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from ...algebra import Array
from ...system import System
from ..equations.block_matrix import entries_of

GROUPS: dict[str, tuple[str, ...]] = {
    "jacobian": ("Phi_q", "Phi_qT_lam_q"),
    "inertia": ("M", "M_a_q", "S_q", "S_v"),
    "stiffness": ("Q_q", "Q_v"),
    "gamma_v": ("gamma_v",),
    "gamma_q_v": ("gamma_q", "gamma_v"),
    "Phi_q_xi_q": ("Phi_q_xi_q",),
    "Phi_b": ("Phi_b",),
    "Phi_qT_lam_b": ("Phi_qT_lam_b",),
    "Phi_q_xi_b": ("Phi_q_xi_b",),
    "Phi_t_b": ("Phi_t_b",),
    "M_a_b": ("M_a_b",),
    "S_b": ("S_b",),
    "Q_b": ("Q_b",),
    "gamma_b": ("gamma_b",),
}


class ByB(NamedTuple):
    """Numbers of operators by b, one after another, and where those that are not multiplied by zero stand.

    values, cuts : all numbers, and which are an operator's (from, to)
    rows, columns, segments, chosen : of the chosen ones, which are an operator's, and their places in `values`
    """

    values: Array
    cuts: Array
    rows: Array
    columns: Array
    segments: Array
    chosen: Array


def operators_by_b(system: System, names: Iterable[str], b_dot: Array | None) -> ByB:
    """Room for operators by b; `b_dot` (len(system.b), k): for those numbers only that change."""
    rows, columns, cuts = flat([entries_of(system, name) for name in names])
    used = np.ones(len(system.b), dtype=bool) if b_dot is None else np.any(b_dot != 0, axis=1)
    chosen = np.flatnonzero(used[columns])
    return ByB(
        np.zeros(len(rows)), cuts, rows[chosen], columns[chosen], np.searchsorted(chosen, cuts), chosen
    )


def flat(parts: list[tuple[Array, Array]]) -> tuple[Array, Array, Array]:
    """Rows and columns of several operators one after another, and where each begins and ends."""
    ends = np.cumsum([0, *(len(rows) for rows, _ in parts)])
    rows, columns = (np.concatenate([part[k] for part in parts]) for k in (0, 1))
    return rows, columns, np.column_stack([ends[:-1], ends[1:]])
