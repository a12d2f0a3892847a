"""Which numbers have no derivative, since equations that others imply contradict their change?

Where a combination n of equations vanishes, nᵀΦ_q = 0, a number may change only if nᵀΦ_b b' = 0 all along the motion:
else the mechanism cannot be assembled, or is stuck.
"""

from __future__ import annotations

import numpy as np

from ...algebra import Array
from ...results import Pieces, StepsTaken
from ...system import System
from ..assembly_derivatives import NoDerivative
from ..length import lever, scaled
from ..rank import rank_of, row_lengths
from .chain import Gradients
from .parameters import Parameters

# Smallest sum of contradictions, of equations scaled to unit gradients, for a change by one unit [m, rad]
CONTRADICTED = 1e-6
SUMS = 3  # random sums of vanishing combinations that are looked at in one position


def undefined(system: System, steps: StepsTaken | Pieces, parameters: Parameters) -> Array:
    """True for parameters whose change alone contradicts dependent equations at the start, halfway or at the end."""
    pieces = steps.pieces if isinstance(steps, Pieces) else [steps]
    sums = [
        contradictions(system, steps.b, piece.t[n], piece.q[n])
        for piece in pieces
        if len(piece.left_out)
        for n in (0, len(piece) // 2, len(piece))
    ]
    if not sums:
        return np.zeros(len(parameters.names), dtype=bool)
    by_b = np.concatenate(sums, axis=1)
    nothing = (np.zeros((size, by_b.shape[1])) for size in (system.nq, system.nq, parameters.c_size))
    by_q, by_v, by_c = nothing
    found = abs(parameters.gradient(Gradients(by_b, by_q, by_v), by_c)).max(axis=1)
    return np.asarray(found > CONTRADICTED)


def refuse(system: System, steps: StepsTaken | Pieces, parameters: Parameters) -> None:
    """Refuse parameters without a derivative.

    Raises
    ------
    NoDerivative
    """
    missing = undefined(system, steps, parameters)
    if np.any(missing):
        name = parameters.names[int(np.argmax(missing))]
        raise NoDerivative(
            f"{system.name}: a change of {name} alone contradicts equations that repeat others; change together what "
            "keeps them consistent, by a formula"
        )


def contradictions(system: System, b: Array, t: float, q: Array) -> Array:
    """Random sums of nᵀΦ_b (len(b), SUMS)."""
    J = system.Phi_q(q, t, b=b)
    J = scaled(J, lever(system, q, J))
    null = rank_of(J).null
    chosen = null @ np.random.default_rng(0).normal(size=(null.shape[1], SUMS))
    by_b = np.zeros((len(b), SUMS))
    by_b[: system.nb] = system.Phi_b(q, t, b=b).T @ (chosen / row_lengths(J)[:, None])
    return by_b
