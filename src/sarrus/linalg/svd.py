"""Singular values and vectors by QR iterations.

NumPy's own function divides and conquers, which does not converge for some Jacobians of planar mechanisms: finite and
well-conditioned, but with entries of 1e-30 where exact arithmetic has zeros.
"""

from __future__ import annotations

from scipy.linalg import svd

from ..algebra import Array


def singular(matrix: Array) -> tuple[Array, Array, Array]:
    """U, sizes and Vᵀ with all vectors: matrix = U[:, :k] · sizes · Vᵀ[:k]."""
    left, sizes, right = svd(matrix, lapack_driver="gesvd", check_finite=False)
    return left, sizes, right
