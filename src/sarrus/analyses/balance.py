"""The forces at one position at rest, and their exact change along the free directions."""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.linalg import eigh

from ..algebra import Array
from ..system import System
from .nullspace import NullSpace

NEUTRAL = 1e-9  # an eigenvalue of (H, W), relative to the largest, that counts as zero


class Spectrum(NamedTuple):
    """Eigenvalues ω² (d,) of H y = ω² W y, H's symmetric part, and vectors as columns (d, d) with yᵀ W y = 1."""

    squares: Array
    vectors: Array

    @property
    def neutral(self) -> Array:
        """Which of them count as zero (d,)."""
        return np.asarray(abs(self.squares) <= NEUTRAL * abs(self.squares).max(initial=0.0))


class Balance:
    """Q - Φ_qᵀ lam and its derivative at a position q at rest, with the shortest change of multipliers.

    Attributes
    ----------
    Z : (nq, d) the free directions
    lam : (m,) the multipliers that balance the forces best
    g : (d,) the part of the forces along Z, that no constraint balances
    """

    def __init__(self, system: System, q: Array, t: float, b: Array) -> None:
        self.system, self.q, self.t, self.b = system, q, t, b
        space = NullSpace(system.Phi_q(q, t, b=b))
        self.rest = np.zeros(system.nq)
        self.Q = system.Q(q, self.rest, t, b=b)
        self.Z, self.lam = space.Z, space.multipliers(self.Q)
        self.g = self.Z.T @ self.Q

    @cached_property
    def H(self) -> Array:
        """The constrained Hessian Zᵀ ((Φ_qᵀ lam)_q - Q_q) Z (d, d)."""
        K = self.system.Phi_qT_lam_q(self.q, self.lam, self.t, b=self.b)
        K = K - self.system.Q_q(self.q, self.rest, self.t, b=self.b)
        return np.asarray(self.Z.T @ (K @ self.Z))

    @cached_property
    def W(self) -> Array:
        """The mass matrix along the free directions, Zᵀ M Z (d, d)."""
        return np.asarray(self.Z.T @ (self.system.M(self.q, b=self.b) @ self.Z))

    @cached_property
    def spectrum(self) -> Spectrum:
        """Squares of the undamped angular frequencies, if the forces are conservative."""
        if not len(self.g):
            return Spectrum(np.zeros(0), np.zeros((0, 0)))
        return Spectrum(*eigh(0.5 * (self.H + self.H.T), self.W))

    @property
    def asymmetry(self) -> float:
        """How far H is from symmetric: zero, where the forces have a potential."""
        return float(abs(self.H - self.H.T).max(initial=0.0) / (abs(self.H).max(initial=0.0) or 1.0))

    @property
    def residual(self) -> float:
        """Largest entry of what is not balanced, Z g [N], [N m]."""
        return float(abs(self.Z @ self.g).max(initial=0.0))
