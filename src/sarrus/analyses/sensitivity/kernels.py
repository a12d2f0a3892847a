"""Which operators do sweeps evaluate together, and what do their compiled drivers take?"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from ..._jit.pointer import run
from ...algebra import Array
from ...system import System
from ..dynamics.placed import entries_of

GROUPS: dict[str, tuple[tuple[str, ...], int, int]] = {  # operators; scalars and arrays of their driver
    "velocity": (("Phi_q_xi", "Phi_t"), 1, 4),
    "jacobian": (("Phi_q", "Phi_qT_lam_q"), 1, 4),
    "inertia": (("M", "M_a_q", "S_q", "S_v"), 0, 7),
    "stiffness": (("Q_q", "Q_v"), 1, 4),
    "gamma_v": (("gamma_v",), 1, 3),
    "gamma_q_v": (("gamma_q", "gamma_v"), 1, 4),
    "Phi_q_xi_q": (("Phi_q_xi_q",), 1, 3),
    "Phi_b": (("Phi_b",), 1, 2),
    "Phi_qT_lam_b": (("Phi_qT_lam_b",), 1, 3),
    "Phi_q_xi_b": (("Phi_q_xi_b",), 1, 3),
    "Phi_t_b": (("Phi_t_b",), 1, 2),
    "M_a_b": (("M_a_b",), 0, 3),
    "S_b": (("S_b",), 0, 3),
    "Q_b": (("Q_b",), 1, 3),
    "gamma_b": (("gamma_b",), 1, 3),
}


def calls(names: Iterable[str]) -> dict[str, Any]:
    """What calls the drivers of groups by their address, by the names under which loops know them."""
    return {name.upper(): run(*GROUPS[name][1:]) for name in names}


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
