"""The Newton matrix of HHT and generalized-α, [M + β'K + γ'C, Φ_qᵀ; Φ_q, 0], and that of the equations of motion.

K = (M a)_q + (Φ_qᵀλ)_q - Q_q - S_q, C = -Q_v - S_v; with β' = γ' = 0 it is [M, Φ_qᵀ; Φ_q, 0].
"""

from __future__ import annotations

from ...._jit.linking.link import compiled
from ....algebra import Array
from ....system import System
from ...equations.block_matrix import LEFT_OUT, Numbers, Part, PlacedMatrix

BLOCKS = ("M", "M_a_q", "S_q", "S_v", "Q_q", "Q_v", "Phi_qT_lam_q")  # of the upper left block
NUMBERS = (*BLOCKS, LEFT_OUT, "Phi_q")


def alpha_parts(nq: int) -> list[Part]:
    """Where operators stand in the Newton matrix, with a 1 for every equation left out. `weigh` has their weights."""
    return [*(Part(name, 0, 0) for name in BLOCKS), *constraint_parts(nq)]


def constraint_parts(nq: int) -> list[Part]:
    """The rows and columns of the multipliers."""
    return [Part(LEFT_OUT, nq, nq), Part("Phi_q", nq, 0), Part("Phi_q", 0, nq, transposed=True)]


@compiled
def weigh(weights: Array, beta: float, gamma: float) -> None:
    """The weights of the parts of the Newton matrix for a scheme's β' and γ', in the order of `alpha_parts`."""
    weights[1], weights[2], weights[4], weights[6] = beta, -beta, -beta, beta
    weights[3], weights[5] = -gamma, -gamma


def newton_matrix(system: System) -> PlacedMatrix:
    """The matrix of the index-3 equations."""
    return PlacedMatrix(Numbers(system, NUMBERS), system.nq + system.m, alpha_parts(system.nq))


def motion_matrix(system: System, host: PlacedMatrix | None = None) -> PlacedMatrix:
    """[M, Φ_qᵀ; Φ_q, 0]; a matrix whose pattern contains it may be its `host`."""
    numbers = Numbers(system, ("M", LEFT_OUT, "Phi_q"))
    return PlacedMatrix(numbers, system.nq + system.m, motion_parts(system.nq), host=host)


def motion_parts(nq: int) -> list[Part]:
    """Where operators stand in the matrix of the equations of motion."""
    return [Part("M", 0, 0), *constraint_parts(nq)]
