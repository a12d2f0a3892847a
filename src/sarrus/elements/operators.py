"""The operators of the equations of motion: their operands, and the shape of their results.

    M a + Phi_qᵀ lam = Q + S,    Phi = 0,    Phi_q a = gamma

A suffix differentiates all before it, `T` transposes: ``Phi_qT_lam_q`` is (Φ_qᵀλ)_q.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Axis(Enum):
    """Quantity that the rows or columns of an operator belong to."""

    ROWS = "constraint equations"
    COORDINATES = "coordinates"
    PARAMETERS = "parameters"


@dataclass(frozen=True)
class Operator:
    """One operator: its name, equation, operands, the axes of its result (one for vectors, two for matrices).

    `origin` is the origin of its kernel: coded by the author of each element, following from other operators by one
    formula for all elements, or derived by differentiating the recorded kernels of others.
    """

    name: str
    formula: str
    family: str
    operands: tuple[str, ...]
    axes: tuple[Axis, ...]
    origin: str = "coded"

    @property
    def sums(self) -> bool:
        """Whether entries of different elements add (they do, where the rows are coordinates)."""
        return self.axes[0] is Axis.COORDINATES and Axis.PARAMETERS not in self.axes

    @property
    def is_vector(self) -> bool:
        return len(self.axes) == 1


R, X, N = Axis.ROWS, Axis.COORDINATES, Axis.PARAMETERS


def _operators(family: str, *table: tuple[str, str, str, tuple[Axis, ...], str]) -> list[Operator]:
    return [
        Operator(name, formula, family, tuple(ops.split()), axes, f) for name, formula, ops, axes, f in table
    ]


CODED, FOLLOWS, DERIVED = "coded", "follows", "derived"

CONSTRAINT = _operators(
    "constraint",
    ("Phi", "Φ", "t", (R,), CODED),
    ("Phi_q", "Φ_q", "t", (R, X), CODED),
    ("Phi_q_xi", "Φ_q ξ", "xi t", (R,), FOLLOWS),
    ("Phi_q_xi_q", "(Φ_q ξ)_q", "xi t", (R, X), CODED),
    ("Phi_q_xi_q_eta_q", "((Φ_q ξ)_q η)_q", "xi eta t", (R, X), CODED),
    ("Phi_qT_lam", "Φ_qᵀ λ", "lam t", (X,), FOLLOWS),
    ("Phi_qT_lam_q", "(Φ_qᵀ λ)_q", "lam t", (X, X), CODED),
    ("Phi_qT_lam_q_xi_q", "((Φ_qᵀ λ)_q ξ)_q", "lam xi t", (X, X), CODED),
    ("Phi_t", "Φ_t", "t", (R,), DERIVED),
    ("Phi_tt", "Φ_tt", "t", (R,), DERIVED),
    ("Phi_q_xi_t", "(Φ_q ξ)_t", "xi t", (R,), DERIVED),
    ("gamma", "γ = -(Φ_q v)_q v - 2 (Φ_q v)_t - Φ_tt", "v t", (R,), FOLLOWS),
    ("gamma_q", "γ_q", "v t", (R, X), FOLLOWS),
    ("gamma_v", "γ_v", "v t", (R, X), FOLLOWS),
    ("Phi_b", "Φ_b", "t", (R, N), CODED),
    ("Phi_t_b", "(Φ_t)_b", "t", (R, N), DERIVED),
    ("Phi_q_xi_b", "(Φ_q ξ)_b", "xi t", (R, N), CODED),
    ("Phi_q_xi_q_eta_b", "((Φ_q ξ)_q η)_b", "xi eta t", (R, N), CODED),
    ("Phi_qT_lam_b", "(Φ_qᵀ λ)_b", "lam t", (X, N), CODED),
    ("gamma_b", "γ_b", "v t", (R, N), FOLLOWS),
)
INERTIA = _operators(
    "inertia",
    ("M", "M", "", (X, X), CODED),
    ("M_a", "M a", "a", (X,), FOLLOWS),
    ("M_a_q", "(M a)_q", "a", (X, X), CODED),
    ("M_a_b", "(M a)_b", "a", (X, N), CODED),
    ("S", "S", "v", (X,), CODED),
    ("S_q", "S_q", "v", (X, X), CODED),
    ("S_v", "S_v", "v", (X, X), CODED),
    ("S_b", "S_b", "v", (X, N), CODED),
    ("M_a_q_xi_q", "((M a)_q ξ)_q", "a xi", (X, X), DERIVED),
    ("S_q_xi_q", "(S_q ξ)_q", "xi v", (X, X), DERIVED),
    ("S_q_xi_v", "(S_q ξ)_v", "xi v", (X, X), DERIVED),
    ("S_v_xi_q", "(S_v ξ)_q", "xi v", (X, X), DERIVED),
    ("S_v_xi_v", "(S_v ξ)_v", "xi v", (X, X), DERIVED),
)
FORCE = _operators(
    "force",
    ("Q", "Q", "v t", (X,), CODED),
    ("Q_q", "Q_q", "v t", (X, X), CODED),
    ("Q_v", "Q_v", "v t", (X, X), CODED),
    ("Q_b", "Q_b", "v t", (X, N), CODED),
    ("Q_q_xi_q", "(Q_q ξ)_q", "xi v t", (X, X), DERIVED),
    ("Q_q_xi_v", "(Q_q ξ)_v", "xi v t", (X, X), DERIVED),
    ("Q_v_xi_q", "(Q_v ξ)_q", "xi v t", (X, X), DERIVED),
    ("Q_v_xi_v", "(Q_v ξ)_v", "xi v t", (X, X), DERIVED),
)
OPERATORS: dict[str, Operator] = {op.name: op for op in (*CONSTRAINT, *INERTIA, *FORCE)}


@dataclass(frozen=True)
class Derivative:
    """Rule of a derived operator: the derivative of another one, contracted with a direction, to q, v or b."""

    of: str
    along: str | None
    by: str


DERIVATIVES: dict[str, Derivative] = {
    "Phi_q": Derivative("Phi", None, "q"),
    "Phi_q_xi_q": Derivative("Phi_q", "xi", "q"),
    "Phi_q_xi_q_eta_q": Derivative("Phi_q_xi_q", "eta", "q"),
    "Phi_qT_lam_q": Derivative("Phi_qT_lam", None, "q"),
    "Phi_qT_lam_q_xi_q": Derivative("Phi_qT_lam_q", "xi", "q"),
    "gamma_q": Derivative("gamma", None, "q"),
    "gamma_v": Derivative("gamma", None, "v"),
    "Phi_t": Derivative("Phi", None, "t"),
    "Phi_tt": Derivative("Phi_t", None, "t"),
    "Phi_q_xi_t": Derivative("Phi_q", "xi", "t"),
    "Phi_t_b": Derivative("Phi_t", None, "b"),
    "Phi_b": Derivative("Phi", None, "b"),
    "Phi_q_xi_b": Derivative("Phi_q", "xi", "b"),
    "Phi_q_xi_q_eta_b": Derivative("Phi_q_xi_q", "eta", "b"),
    "Phi_qT_lam_b": Derivative("Phi_qT_lam", None, "b"),
    "gamma_b": Derivative("gamma", None, "b"),
    "M_a_q": Derivative("M", "a", "q"),
    "M_a_b": Derivative("M", "a", "b"),
    "S_q": Derivative("S", None, "q"),
    "S_v": Derivative("S", None, "v"),
    "S_b": Derivative("S", None, "b"),
    "M_a_q_xi_q": Derivative("M_a_q", "xi", "q"),
    "S_q_xi_q": Derivative("S_q", "xi", "q"),
    "S_q_xi_v": Derivative("S_q", "xi", "v"),
    "S_v_xi_q": Derivative("S_v", "xi", "q"),
    "S_v_xi_v": Derivative("S_v", "xi", "v"),
    "Q_q": Derivative("Q", None, "q"),
    "Q_v": Derivative("Q", None, "v"),
    "Q_b": Derivative("Q", None, "b"),
    "Q_q_xi_q": Derivative("Q_q", "xi", "q"),
    "Q_q_xi_v": Derivative("Q_q", "xi", "v"),
    "Q_v_xi_q": Derivative("Q_v", "xi", "q"),
    "Q_v_xi_v": Derivative("Q_v", "xi", "v"),
}

NONHOLONOMIC = DERIVATIVES | {  # of constraints on velocities, whose Φ_q is no derivative
    "Phi_q": Derivative("Phi_q_xi", None, "xi"),
    "Phi_q_xi_q": Derivative("Phi_q_xi", None, "q"),
    "Phi_q_xi_t": Derivative("Phi_q_xi", None, "t"),
    "Phi_q_xi_b": Derivative("Phi_q_xi", None, "b"),
}
GROUPS: dict[str, tuple[str, ...]] = {
    "kinematic": ("Phi_q", "Phi_qT_lam_q", "Phi_q_xi_q", "gamma_q", "gamma_v"),
    "force": ("Q_q", "Q_v"),
    "inertia": ("M_a_q",),
}
ALIASES: dict[tuple[str, ...], dict[str, str]] = {
    GROUPS["kinematic"]: {"xi": "v"}
}  # (Φ_q v)_q is wanted there
