"""The operators of the equations of motion: what each takes and what shape its result has.

    M a + Phi_qᵀ lam = Q + S,    Phi = 0,    Phi_q a = gamma

A suffix differentiates all before it, `T` transposes: ``Phi_qT_lam_q`` is (Φ_qᵀλ)_q.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Axis(Enum):
    """What a row or column of an operator stands for."""

    ROWS = "constraint equations"
    COORDINATES = "coordinates"
    NUMBERS = "design numbers"


@dataclass(frozen=True)
class Operator:
    """One operator: its name, equation, operands, the axes of its result (one for vectors, two for matrices)."""

    name: str
    formula: str
    family: str
    operands: tuple[str, ...]
    axes: tuple[Axis, ...]
    follows: bool = False

    @property
    def sums(self) -> bool:
        """Whether entries of different elements add (they do, where the rows are coordinates)."""
        return self.axes[0] is Axis.COORDINATES and Axis.NUMBERS not in self.axes

    @property
    def is_vector(self) -> bool:
        return len(self.axes) == 1


R, X, N = Axis.ROWS, Axis.COORDINATES, Axis.NUMBERS


def _operators(family: str, *table: tuple[str, str, str, tuple[Axis, ...], bool]) -> list[Operator]:
    return [
        Operator(name, formula, family, tuple(ops.split()), axes, f) for name, formula, ops, axes, f in table
    ]


CODED, FOLLOWS = False, True

CONSTRAINT = _operators(
    "constraint",
    ("Phi", "Φ", "", (R,), CODED),
    ("Phi_q", "Φ_q", "", (R, X), CODED),
    ("Phi_q_xi", "Φ_q ξ", "xi", (R,), FOLLOWS),
    ("Phi_q_xi_q", "(Φ_q ξ)_q", "xi", (R, X), CODED),
    ("Phi_q_xi_q_eta_q", "((Φ_q ξ)_q η)_q", "xi eta", (R, X), CODED),
    ("Phi_qT_lam", "Φ_qᵀ λ", "lam", (X,), FOLLOWS),
    ("Phi_qT_lam_q", "(Φ_qᵀ λ)_q", "lam", (X, X), CODED),
    ("Phi_qT_lam_q_xi_q", "((Φ_qᵀ λ)_q ξ)_q", "lam xi", (X, X), CODED),
    ("gamma", "γ = -(Φ_q v)_q v", "v", (R,), FOLLOWS),
    ("gamma_q", "γ_q = -((Φ_q v)_q v)_q", "v", (R, X), FOLLOWS),
    ("gamma_v", "γ_v = -2 (Φ_q v)_q", "v", (R, X), FOLLOWS),
    ("Phi_b", "Φ_b", "", (R, N), CODED),
    ("Phi_q_xi_b", "(Φ_q ξ)_b", "xi", (R, N), CODED),
    ("Phi_q_xi_q_eta_b", "((Φ_q ξ)_q η)_b", "xi eta", (R, N), CODED),
    ("Phi_qT_lam_b", "(Φ_qᵀ λ)_b", "lam", (X, N), CODED),
    ("gamma_b", "γ_b = -((Φ_q v)_q v)_b", "v", (R, N), FOLLOWS),
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
)
FORCE = _operators(
    "force",
    ("Q", "Q", "v t", (X,), CODED),
    ("Q_q", "Q_q", "v t", (X, X), CODED),
    ("Q_v", "Q_v", "v t", (X, X), CODED),
    ("Q_b", "Q_b", "v t", (X, N), CODED),
)
OPERATORS: dict[str, Operator] = {op.name: op for op in (*CONSTRAINT, *INERTIA, *FORCE)}


@dataclass(frozen=True)
class Derivative:
    """That an operator is the derivative of another one, contracted with a direction, to q, v or b."""

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
    "Q_q": Derivative("Q", None, "q"),
    "Q_v": Derivative("Q", None, "v"),
    "Q_b": Derivative("Q", None, "b"),
}

GROUPS: dict[str, tuple[str, ...]] = {
    "kinematic": ("Phi_q", "Phi_qT_lam_q", "Phi_q_xi_q", "gamma_q", "gamma_v"),
    "force": ("Q_q", "Q_v"),
    "inertia": ("M_a_q",),
}
