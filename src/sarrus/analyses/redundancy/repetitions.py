"""Dependent equations by joint and direction: the later joint repeats the earlier ones."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from ...algebra import Array
from ...results import Repetition
from ...system import System
from ..position.restraint import restraint

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
    found: dict[str, list[tuple[int, set[str]]]] = {}
    for row, combination in _later_first(null, sorted(owner)):
        others = {
            owner[n] for n in np.flatnonzero(abs(combination) > PART).tolist() if n in owner and n != row
        }
        found.setdefault(owner[row], []).append((row, others - {owner[row]}))
    return tuple(_repetition(system, q, J, joint, found[joint]) for joint in system.rows if joint in found)


def _repetition(
    system: System, q: Array, J: csr_array, joint: str, found: list[tuple[int, set[str]]]
) -> Repetition:
    rows = tuple(sorted(row for row, _ in found))
    names = set().union(*(others for _, others in found))
    words = tuple(restraint(J, row, q).words() for row in rows)
    repeats = tuple(name for name in system.rows if name in names)
    return Repetition(joint, repeats, rows, words, len(rows) == len(system.rows[joint]))


def _later_first(null: Array, rows: list[int]) -> list[tuple[int, Array]]:
    """Each dependent row with the combination of it and rows before it that vanishes.

    Going back from the last row, a row with a part in the combinations that are left takes one of them away.
    """
    left, found = null, []
    for row in reversed(rows):
        size = float(np.linalg.norm(left[row])) if left.shape[1] else 0.0
        if size > PIVOT:
            axis = left[row] / size
            found.append((row, left @ axis / size))
            rest = np.linalg.svd(axis[None, :])[2][1:].T
            left = left @ rest
    return found
