"""The result of the search for a static equilibrium."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from ..algebra import Array
from .result import Result

Stability = Literal["stable", "neutral", "unstable", "unknown"]


@dataclass(frozen=True)
class Equilibrium(Result):
    """Result of `equilibrium`: a position in which all forces balance, or the best approximation.

    Attributes
    ----------
    name : of the system
    q : (nq,)
    lam : (m,) multipliers of the joints and normalizations; for reactions, `System.reaction`
    success : whether the forces balance
    message : the outcome and the stability
    stability : from the smallest of `squares`; "neutral" if a motion has no stiffness, "unknown" without success
    squares : (d,) eigenvalues of the constrained Hessian Zᵀ((Φ_qᵀ lam)_q - Q_q)Z in the metric of the mass matrix,
        increasing: squares of the undamped angular frequencies [rad²/s²], negative if the equilibrium is unstable
    motions : (nq, d) the corresponding directions
    residual : largest entry of the unbalanced force [N], [N m]
    iterations : number of steps
    t : time at which drivers and forces are evaluated [s]
    """

    name: str
    q: Array = field(repr=False)
    lam: Array = field(repr=False)
    success: bool
    message: str
    stability: Stability
    squares: Array = field(repr=False)
    motions: Array = field(repr=False)
    residual: float
    iterations: int
    t: float = 0.0

    def summary(self) -> str:
        """Return the outcome and the stability of the position."""
        return self.message
