"""Steady motion: one that looks the same at all times to an observer who rotates with it.

In a steady motion all bodies turn with a common angular velocity Ω in global axes, and each with a constant angular
velocity in its own axes, as a rotor about its axis of symmetry. Both are linear maps of q = [r; p], and so of v and of
small changes of either: v = X q + constant, a = X v.
"""

from __future__ import annotations

import numpy as np

from ...algebra import Array, skew
from ...euler import A, E, bar, bar_E


def generator(q: Array, v: Array, turning: Array) -> Array:
    """The matrix X (nq, nq) of the steady motion through a state, for a given Ω = `turning` in global axes [rad/s].

    For each body, ṙ = Ω x r and ṗ = ½ Eᵀ(p) Ω + ½ Gᵀ(p) ω', with ω' = Aᵀ(ω - Ω) its own angular velocity.
    """
    X = np.zeros((len(q), len(q)))
    for at in range(0, len(q), 7):
        p, pd = q[at + 3 : at + 7], v[at + 3 : at + 7]
        own = A(p).T @ (2 * E(p) @ pd - turning)
        X[at : at + 3, at : at + 3] = skew(turning)
        X[at + 3 : at + 7, at + 3 : at + 7] = 0.5 * (bar_E(turning) + bar(own))
    return X
