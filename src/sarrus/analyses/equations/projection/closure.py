"""Tolerances of constraints, from their gradients and the round-off of their terms."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from ....algebra import Array
from ..length import row_sizes

ROUND_OFF = 16 * np.finfo(float).eps  # of the terms of an equation before they cancel, |Φ_q| |q|


def allowed(J: csr_array, q: Array, length: float, tolerance: float) -> Array:
    """The largest |Φ| that is allowed, for each equation (m,).

    `tolerance` is a displacement in parts of the length, or a rotation [rad]; round-off is always allowed, so that a
    mechanism far from the origin can be assembled, too.
    """
    return np.maximum(tolerance * row_sizes(J, length), round_off_of(J, q))


def round_off_of(J: csr_array, q: Array) -> Array:
    """The round-off of Φ, for each equation (m,)."""
    rows = np.repeat(np.arange(J.shape[0]), np.diff(J.indptr))
    terms = np.bincount(rows, weights=abs(J.data) * abs(q)[J.indices], minlength=J.shape[0])
    return np.asarray(ROUND_OFF * terms)
