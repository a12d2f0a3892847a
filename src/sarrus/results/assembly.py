"""The result of an assembly."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ..algebra import Array
from .result import Result

NONE = np.zeros(0)


@dataclass(frozen=True)
class AssemblyRequest:
    """The estimate and the options of an assembly.

    Attributes
    ----------
    q, v : (nq,) the guess, its Euler parameters at unit length
    weight, weight_v : (nq,) the diagonals of the metrics W of coordinates and of velocities
    held : (nq,) true for coordinates that keep their q and v
    followed : (nq,) true for states that drivers follow, which keep their initial values, but not their rates
    rates : given rates of coordinates and joints [m/s], [rad/s]
    unit_metric : whether W follows the model's dimensions, by the metric "unit"
    t : time [s]
    """

    q: Array = field(repr=False)
    v: Array = field(repr=False)
    weight: Array = field(repr=False)
    weight_v: Array = field(repr=False)
    held: Array = field(repr=False)
    followed: Array = field(repr=False)
    rates: Mapping[str, float]
    t: float = 0.0
    unit_metric: bool = False

    @property
    def held_positions(self) -> Array:
        """True for coordinates that keep their q (nq,)."""
        return self.held | self.followed

    @property
    def held_velocities(self) -> Array:
        """True for coordinates that keep their v (nq,)."""
        return self.held & ~self.followed


@dataclass(frozen=True, eq=False)
class Assembly(Result):
    """Result of `assemble`: coordinates and velocities that satisfy the constraints, or the best approximation.

    Attributes
    ----------
    q, v : (nq,)
    success : whether the constraints hold within the tolerance
    message : one message: the outcome, or the joints that remain open, with their gaps
    residual : largest entry of |Φ|
    iterations : Newton steps taken
    lam : (m,) multipliers of the smallest change of q: W (q - q₀) + Φ_qᵀ lam = 0 for coordinates that are not fixed
    mu : (m,) and those of v: W (v - v₀) + Φ_qᵀ mu + Cᵀ nu = 0, with C the rows of the given rates
    nu : (number of rates,)
    nearest : whether q is, to round-off, the position nearest to the estimate in its neighbourhood
    asked : the estimate and the options
    changes : bodies with visible changes of the given position or velocity, with both values
    memory : state variables of elements, see `State`; empty if they are initialized
    revolutions : (nc,) of the angles of joints, see `State`; empty if they are initialized
    settled : whether q is an equilibrium, whose dependence on the parameters is included in derivatives; lam are then
        the multipliers that balance the forces
    bodies : their names, in the order of q
    """

    q: Array = field(repr=False)
    v: Array = field(repr=False)
    success: bool
    message: str
    residual: float
    iterations: int
    lam: Array = field(default_factory=lambda: NONE, repr=False)
    mu: Array = field(default_factory=lambda: NONE, repr=False)
    nu: Array = field(default_factory=lambda: NONE, repr=False)
    nearest: bool = False
    asked: AssemblyRequest | None = field(default=None, repr=False)
    changes: tuple[str, ...] = field(default=(), repr=False)
    memory: Array = field(default_factory=lambda: NONE, repr=False)
    revolutions: Array = field(default_factory=lambda: NONE, repr=False)
    settled: bool = False
    bodies: tuple[str, ...] = field(default=(), repr=False)

    def summary(self) -> str:
        """Return the outcome and the violation of the constraints."""
        return f"{self.message}; |Φ| < {max(self.residual, 1e-16):.0e}"

    @property
    def t(self) -> float:
        """Its time [s]."""
        return self.asked.t if self.asked else 0.0
