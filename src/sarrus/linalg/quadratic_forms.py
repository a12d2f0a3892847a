"""Test whether quadratic forms have a common zero direction."""

from __future__ import annotations

import numpy as np

from ..algebra import Array
from .rank import DEPENDENT

STARTS = 30


def common_zeros(forms: Array) -> bool:
    """Whether a ξ ≠ 0 exists with ξᵀH_k ξ = 0 for all symmetric matrices H_k (count, d, d).

    One form is decided by its eigenvalues: none of one sign strictly. Several are searched from random directions.
    """
    values = np.linalg.eigvalsh(forms[0])
    if len(forms) == 1:
        small = 1e-8 * abs(values).max()
        return not (np.all(values > small) or np.all(values < -small))
    random = np.random.default_rng(0)
    return any(_search(forms, random.normal(size=len(values))) for _ in range(STARTS))


def _search(forms: Array, xi: Array) -> bool:
    from scipy.optimize import least_squares  # 0.2 s to import, and hardly ever needed

    def residual(x: Array) -> Array:
        return np.append(np.einsum("i,kij,j->k", x, forms, x), x @ x - 1)

    return bool(
        least_squares(residual, xi / np.linalg.norm(xi), xtol=1e-15, ftol=1e-15, gtol=1e-15).cost
        < DEPENDENT**2
    )
