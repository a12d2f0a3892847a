"""Comparison of unknowns: p and -p are one orientation, (lam, c) and -(lam, c) one normal."""

from __future__ import annotations

import numpy as np

from ....algebra import Array
from ....model.coordinates import WIDTH
from .stratum import Stratum

SAME = 1e-6  # free of units: nearer positions are one


def signs(stratum: Stratum, x: Array, like: Array) -> Array:
    """The signs (size,) that bring x nearest to another one."""
    n = stratum.n
    found = np.ones(stratum.size)
    found[:n] = body_signs(x[:n], like[:n])
    if x[n:] @ like[n:] < 0:
        found[n:] = -1.0
    return found


def body_signs(q: Array, like: Array) -> Array:
    """The signs (n,) of the Euler parameters alone."""
    products = (q * like).reshape(-1, WIDTH)[:, 3:].sum(axis=1)
    found = np.ones((len(q) // WIDTH, WIDTH))
    found[products < 0, 3:] = -1.0
    return found.reshape(-1)


def apart(q: Array, like: Array) -> float:
    """Return the distance of two positions, without units."""
    return float(np.linalg.norm(q * body_signs(q, like) - like))
