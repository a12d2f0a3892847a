"""The damped step of least size onto linearized constraints: it exists for Jacobians of any rank."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from scipy.sparse import csr_array, eye_array

from ..algebra import Array
from .factors import DENSE_BELOW, LUFactors

Matrix: TypeAlias = "Array | csr_array"
FLOOR = (
    16 * np.finfo(float).eps
)  # of the damping, relative: keeps the matrix positive for dependent equations


class MinimumStep:
    """Levenberg and Marquardt's step s = -W⁻¹Jᵀ y with (J W⁻¹ Jᵀ + μ I) y = Φ, for one Jacobian and any μ.

    Parameters
    ----------
    J : (m, n) Jacobian
    inverse_weight : (n,) the diagonal of W⁻¹, zero for what is held
    """

    def __init__(self, J: csr_array, inverse_weight: Array) -> None:
        self._dense = J.shape[0] < DENSE_BELOW
        self._J: Matrix = J.toarray() if self._dense else J
        self._JW: Matrix = (
            self._J * inverse_weight if self._dense else (J @ _diagonal(inverse_weight)).tocsr()
        )
        self._normal: Matrix = self._JW @ self._J.T
        self.scale = float(np.max(self._normal.diagonal(), initial=0.0)) or 1.0

    def gradient(self, residual: Array) -> Array:
        """-W⁻¹JᵀΦ, the direction of steepest descent in the metric (n,)."""
        return np.asarray(-(residual @ self._JW))

    def __call__(self, residual: Array, damping: float) -> Array:
        """The step (n,) for Φ (m,) and a damping μ, which is at least `FLOOR` of the largest diagonal entry."""
        return self.gradient(self.multipliers(residual, damping))

    def multipliers(self, residual: Array, damping: float = 0.0) -> Array:
        """y = (J W⁻¹ Jᵀ + μ I)⁻¹ Φ (m,)."""
        return self._factored(damping + FLOOR * self.scale).solve(residual)

    def _factored(self, damping: float) -> LUFactors:
        size = self._normal.shape[0]
        if not self._dense:
            return LUFactors(self._normal + damping * eye_array(size))
        matrix = self._normal.copy()
        matrix[np.diag_indices(size)] += damping
        return LUFactors(matrix)


def _diagonal(values: Array) -> csr_array:
    n = np.arange(len(values))
    return csr_array((values, (n, n)), shape=(len(values), len(values)))
