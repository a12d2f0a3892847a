"""Kinds of equations of a stage: the operators by which each depends on the stage, and its part of a Lagrangian."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from ...equations.block_matrix import UNIT
from .description import CONSTRAINTS, COORDINATES, HOLONOMIC, NONHOLONOMIC

MULTIPLIERS = ("lam", "mu")  # their operator is Φ_qᵀ


class Kind(NamedTuple):
    """A kind of equation.

    size : of its rows
    by : operators, with signs, by the quantities of the stage; transposed for multipliers; with the rows of constraints
        that they are of, where these are not all
    curves : terms by which numbers of curves enter: operator, its operands by quantities of the stage, sign
    """

    size: str
    by: Mapping[str, tuple[tuple[str, float] | tuple[str, float, str], ...]]
    curves: tuple[tuple[str, Mapping[str, str], float], ...]


REACTION = ("Phi_qT_lam", {"lam": "lam"}, 1.0)
KINDS = {
    "motion": Kind(
        COORDINATES,
        {
            "q": (("M_a_q", 1.0), ("Phi_qT_lam_q", 1.0), ("S_q", -1.0), ("Q_q", -1.0)),
            "v": (("S_v", -1.0), ("Q_v", -1.0)),
            "a": (("M", 1.0),),
            "lam": (("Phi_q", 1.0),),
        },
        (REACTION, ("Q", {"v": "v"}, -1.0)),
    ),
    "impulse": Kind(
        COORDINATES,
        {
            "q": (("M_a_q", 1.0), ("Phi_qT_lam_q", 1.0)),
            "a": (("M", 1.0),),
            "lam": (("Phi_q", 1.0),),
        },
        (REACTION,),
    ),
    "kinematic": Kind(
        COORDINATES,
        {"q": (("Phi_qT_mu_q", 1.0),), "rate": ((UNIT, 1.0),), "mu": (("Phi_q", 1.0),)},
        (("Phi_qT_lam", {"lam": "mu"}, 1.0),),
    ),
    "position": Kind(CONSTRAINTS, {"q": (("Phi_q", 1.0),)}, (("Phi", {}, 1.0),)),
    "velocity": Kind(  # (Φ_q v + Φ_t)_q is -½ γ_v where Φ_q has a Φ
        CONSTRAINTS,
        {
            "q": (("gamma_v", -0.5, HOLONOMIC), ("Phi_q_v_q", 1.0, NONHOLONOMIC)),
            "v": (("Phi_q", 1.0),),
        },
        (("Phi_q_xi", {"xi": "v"}, 1.0), ("Phi_t", {}, 1.0)),
    ),
    "acceleration": Kind(
        CONSTRAINTS,
        {
            "q": (("Phi_q_a_q", 1.0), ("gamma_q", -1.0)),
            "v": (("gamma_v", -1.0),),
            "a": (("Phi_q", 1.0),),
        },
        (("Phi_q_xi", {"xi": "a"}, 1.0), ("gamma", {"v": "v"}, -1.0)),
    ),
}


class Lagrangian(NamedTuple):
    """Equations of a stage whose Lagrangian is recorded together, see `shares`.

    kind : of the share
    xi, nu : the equations whose adjoint variables are ξ, and ν times `sign`
    acceleration, multipliers : quantities of the stage that stand for a (none: zero) and λ
    """

    kind: str
    xi: str
    nu: str
    sign: float
    acceleration: str | None
    multipliers: str


LAGRANGIANS = (
    Lagrangian("motion", "motion", "acceleration", 1.0, "a", "lam"),
    Lagrangian("step", "motion", "position", 1.0, "a", "lam"),
    Lagrangian("impulse", "impulse", "velocity", -1.0, "a", "lam"),
    Lagrangian("place", "", "position", 1.0, None, "lam"),
    Lagrangian("rate", "kinematic", "velocity", -1.0, None, "mu"),
)
NEEDED = {"motion": {"motion", "acceleration"}, "step": {"motion"}, "impulse": {"impulse"}}  # equations


VELOCITY = LAGRANGIANS[-1]  # that of an equation of velocities alone


def lagrangians(kinds: set[str]) -> list[Lagrangian]:
    """Return the Lagrangians that contain the equations of a stage."""
    found, left = [], set(kinds)
    for one in LAGRANGIANS:
        own = {one.xi, one.nu} & left
        if own and NEEDED.get(one.kind, set()) <= left:
            found.append(one)
            left -= own
    return found


OPERATOR = {
    "Phi_qT_mu_q": "Phi_qT_lam_q",
    "Phi_q_a_q": "Phi_q_xi_q",
    "Phi_q_v_q": "Phi_q_xi_q",
    "again": "Phi_q",
}  # other names of operators
# Operators with a row for each constraint
OF_CONSTRAINTS = ("Phi_q", "gamma_q", "gamma_v", "Phi_q_a_q", "Phi_q_v_q")


GROUPS: dict[str, tuple[str, ...]] = {
    "jacobian": ("Phi_q", "Phi_qT_lam_q"),
    "inertia": ("M", "M_a_q", "S_q", "S_v"),
    "stiffness": ("Q_q", "Q_v"),
    "gamma_v": ("gamma_v",),
    "gamma_q_v": ("gamma_q", "gamma_v"),
    "Phi_q_xi_q": ("Phi_q_xi_q",),
}  # operators that one driver evaluates


class Call(NamedTuple):
    """Operators of a stage that one driver evaluates: its group, operands by quantities of the stage, outputs."""

    group: str
    operands: tuple[str, ...]
    outputs: tuple[str, ...]


def calls_for(names: set[str]) -> list[Call]:
    """Return the calls that evaluate some operators of a stage."""
    found = []
    if names & {"Phi_qT_lam_q"} or not names & {"Phi_qT_mu_q"}:
        found.append(Call("jacobian", ("t", "q", "lam"), ("Phi_q", "Phi_qT_lam_q")))
    if "Phi_qT_mu_q" in names:
        again = "again" if found else "Phi_q"
        found.append(Call("jacobian", ("t", "q", "mu"), (again, "Phi_qT_mu_q")))
    if names & {"M", "M_a_q", "S_q", "S_v"}:
        found.append(Call("inertia", ("q", "v", "a"), ("M", "M_a_q", "S_q", "S_v")))
    if names & {"Q_q", "Q_v"}:
        found.append(Call("stiffness", ("t", "q", "v"), ("Q_q", "Q_v")))
    if "gamma_q" in names:
        found.append(Call("gamma_q_v", ("t", "q", "v"), ("gamma_q", "gamma_v")))
    elif "gamma_v" in names:
        found.append(Call("gamma_v", ("t", "q", "v"), ("gamma_v",)))
    if "Phi_q_v_q" in names:
        found.append(Call("Phi_q_xi_q", ("t", "q", "v"), ("Phi_q_v_q",)))
    if "Phi_q_a_q" in names:
        found.append(Call("Phi_q_xi_q", ("t", "q", "a"), ("Phi_q_a_q",)))
    return found
