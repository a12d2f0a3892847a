"""The Newton matrix of implicit methods on the stabilized index-2 equations: where operators stand, and their weights.

    [ 1 I             -I             0     Pᵀ  ] [ δq    ]
    [ β' (...)_q      M + γ' (...)_v  Φ_qᵀ  0  ] [ β' δa ]
    [ Φ_q              0             0     0   ] [ β' δλ ]
    [ β'/γ' (Φ_q v + Φ_t)_q   Φ_q    0     0   ] [ δη    ],    δv = γ' δa,

P = Φ_q, at the same or another state. Its condition does not depend on the step. With Radau β' = 1/s² and γ' = 1/s.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from ..._jit.driver import compiled_function
from ...algebra import Array
from ...system import System
from ..linear import compiled as factors
from . import placed
from .placed import LEFT_OUT, UNIT, Numbers, Part, Placed, PlacedMatrix

MATRICES = ("Phi_q", "Phi_qT_lam_q", "M", "M_a_q", "S_q", "S_v", "Q_q", "Q_v", "gamma_v")
START = "Phi_q_start"  # Φ_q at the start of the step
FACTORS = ("row_place", "column_order", "factors", "weights")


def newton_parts(nq: int, m: int, P: str = "Phi_q") -> list[Part]:
    """Where operators stand in the Newton matrix; (Φ_q v + Φ_t)_q is -½ γ_v. `weigh` has their weights."""
    v, lam, mu = nq, 2 * nq, 2 * nq + m
    return [
        Part(UNIT, 0, 0),
        Part(UNIT, 0, v),
        Part(P, 0, mu, transposed=True),
        Part("Phi_q", v, lam, transposed=True),
        Part("M_a_q", v, 0),
        Part("Phi_qT_lam_q", v, 0),
        Part("S_q", v, 0),
        Part("Q_q", v, 0),
        Part("M", v, v),
        Part("S_v", v, v),
        Part("Q_v", v, v),
        Part("Phi_q", lam, 0),
        Part("Phi_q", mu, v),
        Part("gamma_v", mu, 0),
        Part(LEFT_OUT, lam, lam),
        Part(LEFT_OUT, mu, mu),
    ]


def weigh(weights: Any, beta: Any, gamma: Any) -> None:
    """The weights of the parts of a Newton matrix, in the order of `newton_parts`."""
    weights[1] = -1.0
    weights[4], weights[5], weights[6], weights[7] = beta, beta, -beta, -beta
    weights[9], weights[10] = -gamma, -gamma
    weights[13] = -0.5 * beta / gamma


@cache
def compiled_solver() -> dict[str, Any]:
    """`refactor` and `backsolve` of `placed`, compiled."""
    known = {"REFACTOR": factors()["refactor"], "SOLVE": factors()["solve"]}
    known["ASSEMBLE"] = compiled_function(placed.assemble)
    return {name: compiled_function(getattr(placed, name), **known) for name in ("refactor", "backsolve")}


class StabilizedMatrix:
    """The matrix of a stabilized α method, as `NewtonMatrix` is that of the index-3 equations.

    Attributes
    ----------
    values, views : numbers of all operators; `views[name]` is an operator's part
    row_of : the equation that each number of Φ_q belongs to
    left_out : (m,) 1 for equations that are left out because others imply them, else 0: they become λ_k = η_k = 0
    placed : the matrix as compiled code takes it, or None before pivots are chosen
    """

    def __init__(self, system: System, kept: Array | None) -> None:
        numbers = Numbers(system, (*MATRICES, START, UNIT, LEFT_OUT), {START: "Phi_q"})
        parts = newton_parts(system.nq, system.m, START)
        self._matrix = PlacedMatrix(numbers, 2 * (system.nq + system.m), parts)
        self.values, self.views = numbers.values, numbers.views
        self.row_of, self.left_out = numbers.entries("Phi_q")[0], self.views[LEFT_OUT]
        self.placed: Placed | None = None
        self.keep(kept)

    def keep(self, kept: Array | None) -> None:
        """Solve only the equations in these places of Φ (None: all)."""
        self.left_out[:] = 0 if kept is None else 1
        self.left_out[kept if kept is not None else []] = 0

    def weigh(self, beta: float, gamma: float) -> None:
        """The weights of the operators for a scheme's β' and γ'."""
        weigh(self._matrix.weights, beta, gamma)

    def choose_pivots(self) -> None:
        """Choose the pivot order for the numbers that are there now.

        Raises
        ------
        SingularMatrix
            If the matrix is singular.
        """
        for name in ("Phi_q", START):
            self.views[name][self.left_out[self.row_of] > 0] = 0.0
        self.placed = self._matrix.placed()

    def state(self) -> dict[str, Array]:
        """Pivot order, factors and weights; nothing before pivots are chosen."""
        return {} if self.placed is None else {name: getattr(self.placed, name) for name in FACTORS}

    def resume(self, **state: Array) -> None:
        """Take over such a state."""
        self.placed = self._matrix.resumed(**state)
