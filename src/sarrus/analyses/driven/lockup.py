"""Location of the configuration where a driven motion reverses, and the equations that lock up there."""

from __future__ import annotations

import numpy as np
from scipy.sparse import block_array, csr_array

from ...algebra import Array
from ...linalg.factors import Factored, SingularSystem
from ..equations.normalizations import normalizations
from ..equations.projection.constraint_projection import largest
from .steps import Instant, Path

FINE = 1e-5  # length of the last step, relative to the first
ROUND_OFF = 1e-14  # of a time: a step so short is none
NAMED = 0.1  # equations are named down to this part of the largest share
FOLD_STEPS = 10
FOLD_SETTLED = 1e-10


def last_before(path: Path, before: Instant, h: float) -> Instant:
    """The last state that can be reached: steps are halved until nothing is gained, `h` long at first."""
    shortest = max(FINE * h, ROUND_OFF * abs(before.t))
    while h > shortest:
        found = path.step(before, before.t + h)
        if found is not None and found.sign == before.sign:
            before = found
        else:
            h *= 0.5
    return before


def fold_time(path: Path, near: Instant) -> float | None:
    """The time of reversal, by Newton's method on Φ = 0, Φ_q w = 0, wᵀw₀ = 1.

    With the exact (Φ_q w)_q and (Φ_q w)_t the answer is exact to round-off; nothing, if there is no simple fold nearby.
    """
    try:
        _, _, w0 = path.weakest(near.t, near.q)
        t, q, w = near.t, near.q, w0
        for _ in range(FOLD_STEPS):
            step = Factored(_fold_matrix(path, t, q, w, w0)).solve(-_fold_residual(path, t, q, w, w0))
            q, w, t = q + step[: len(q)], w + step[len(q) : -1], t + step[-1]
            if largest(step / np.append(np.tile(path.unit, 2), 1.0)) <= FOLD_SETTLED:
                return float(t)
    except SingularSystem:
        return None
    return None


def _fold_residual(path: Path, t: float, q: Array, w: Array, w0: Array) -> Array:
    system, b = path.system, path.b
    stretch = system.Phi_q_xi(q, w, t, b=b)[path.rows]
    return np.concatenate([system.Phi(q, t, b=b)[path.rows], stretch, [(w0 / path.unit**2) @ w - 1]])


def _fold_matrix(path: Path, t: float, q: Array, w: Array, w0: Array) -> csr_array:
    system, b, rows = path.system, path.b, path.rows
    J, bend = system.Phi_q(q, t, b=b)[rows], system.Phi_q_xi_q(q, w, t, b=b)[rows]
    Phi_t, J_w_t = system.Phi_t(q, t, b=b)[rows], system.Phi_q_xi_t(q, w, t, b=b)[rows]
    line = csr_array((w0 / path.unit**2)[None, :])
    return block_array(
        [[J, None, csr_array(Phi_t[:, None])], [bend, J, csr_array(J_w_t[:, None])], [None, line, None]]
    ).tocsc()


def involved(path: Path, near: Instant) -> str:
    """The joints whose equations become dependent there, those with the largest shares first, and these equations."""
    share = abs(path.weakest(near.t, near.q)[1]) * ~normalizations(path.system)
    names, found = path.system.row_names, dict[str, list[str]]()
    for n in np.argsort(-share, kind="stable"):
        if share[n] > NAMED * share.max():
            joint, row = names[n].split(": ", 1)
            found.setdefault(joint, []).append(row)
    return ", ".join(f"{joint} ({', '.join(rows)})" for joint, rows in found.items())
