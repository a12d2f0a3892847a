"""The matrix of the equations of motion, [M, Φ_qᵀ; Φ_q, 0]."""

from __future__ import annotations

from ....system import System
from ...equations.block_matrix import LEFT_OUT, Numbers, Part, PlacedMatrix


def motion_matrix(system: System, host: PlacedMatrix | None = None) -> PlacedMatrix:
    """The matrix, with a 1 for every equation left out; one whose pattern contains it may be its `host`."""
    numbers = Numbers(system, ("M", LEFT_OUT, "Phi_q"))
    return PlacedMatrix(numbers, system.nq + system.m, motion_parts(system.nq), host=host)


def motion_parts(nq: int) -> list[Part]:
    """Return the positions of operators in the matrix."""
    return [
        Part("M", 0, 0),
        Part(LEFT_OUT, nq, nq),
        Part("Phi_q", nq, 0),
        Part("Phi_q", 0, nq, transposed=True),
    ]
