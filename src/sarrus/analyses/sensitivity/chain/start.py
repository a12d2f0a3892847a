"""The start of a run differentiated: accelerations and multipliers that belong to the assembled state.

M a + Φ_qᵀλ = Q + S,    Φ_q a = γ
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from ....algebra import Array
from ....linalg.factors import LUFactors, SingularSystem
from ....results import StepsTaken
from ....system import System
from ....system.curves.curve_derivatives import CurveDerivatives
from ...dynamics.methods.equations import GROUPS
from ...equations.block_matrix import LEFT_OUT, Numbers, Part, PlacedMatrix
from ...equations.joined_operators import CurveTerms, TwoSidedMatrix
from ...equations.length import extent
from ...equations.motion import motion_parts

BY_NUMBERS = ("M_a_b", "Phi_qT_lam_b", "Q_b", "S_b", "Phi_q_xi_b", "gamma_b")
ALONE = ("Phi_q_xi_q", "gamma_q", "gamma_v", *BY_NUMBERS)  # operators that no group has


class Start:
    """Derivatives of a and λ at the first node, with equations that others imply left out.

    Parameters
    ----------
    system : System
    steps : whose first node it is
    curves : of the system, perhaps with the time, which make the numbers complete

    Attributes
    ----------
    width : number of parameters, including those of curves
    """

    def __init__(self, system: System, steps: StepsTaken, curves: CurveDerivatives) -> None:
        self._nq, self._m = nq, m = system.nq, system.m
        self._at, self.width = (system, steps.q[0]), curves.width
        b = steps.b.copy()
        if len(steps):
            b[steps.places] = steps.memory[0]
        at = {"t": float(steps.t[0])} | {name: getattr(steps, name)[0] for name in ("q", "v", "a", "lam")}
        at["xi"] = at["a"]
        together = [GROUPS[kind] for kind in ("jacobian", "inertia", "stiffness")]
        names = (*(name for group in together for name in group), LEFT_OUT, *ALONE)
        numbers = Numbers(system, names)
        numbers.left_out[:] = steps.left_out[0] if len(steps.left_out) else 0.0
        for group in (*together, *((name,) for name in ALONE)):
            numbers.evaluate(group, b, at)
        self._stored = 1.0 - numbers.left_out[:, None]
        self._motion = LUFactors(PlacedMatrix(numbers, nq + m, motion_parts(nq)).matrix())
        bent = curved_equations(curves, b, at, nq, m) if curves else []
        self._equations = TwoSidedMatrix(numbers, _signs(nq), nq + m, 2 * nq, 2 * nq + curves.width, bent)

    @property
    def freedom(self) -> int:
        """The number of independent accelerations."""
        return self._nq - int(self._stored.sum())

    @cached_property
    def units(self) -> Array:
        """Changes of coordinates (nq, 1) that are as large as the system."""
        return self._at[0].layout.scales(extent(*self._at))[:, None]

    def along(self, q_dot: Array, v_dot: Array, b_dot: Array) -> tuple[Array, Array]:
        """The changes of a (nq, k) and λ (m, k) with those of q, v and the numbers."""
        right = -(self._equations @ np.concatenate([q_dot, v_dot, b_dot]))
        return self._solve(right[: self._nq], right[self._nq :])

    def transposed(self, y: Array, z: Array) -> tuple[Array, Array, Array]:
        """Gradients by q (nq, k), v and the numbers, with the adjoint variables of both equations."""
        found = -self._equations.transposed(np.concatenate([y, z]))
        q, v, b = np.split(found, [self._nq, 2 * self._nq])
        return q, v, b

    def adjoint(self, a_bar: Array, lam_bar: Array) -> tuple[Array, Array]:
        """The adjoint variables of the equations of motion (nq, k) and of the constraints (m, k).

        Of what has the gradients given by a and λ.
        """
        return self._solve(a_bar, lam_bar)

    def _solve(self, f: Array, g: Array) -> tuple[Array, Array]:
        found = self._motion.solve(np.concatenate([f, self._stored * g]))
        if not np.all(np.isfinite(found)):
            raise SingularSystem("the matrix of the equations of motion is singular at the start")
        return found[: self._nq], found[self._nq :]


def _signs(nq: int) -> dict[Part, float]:
    """The changes of both equations with q, v and the numbers."""
    motion = {"M_a": 1.0, "Phi_qT_lam": 1.0, "Q": -1.0, "S": -1.0}
    found = {Part(f"{name}_q", 0, 0): sign for name, sign in motion.items()}
    found |= {Part(f"{name}_v", 0, nq): -1.0 for name in ("Q", "S")}
    found |= {Part("Phi_q_xi_q", nq, 0): 1.0, Part("gamma_q", nq, 0): -1.0, Part("gamma_v", nq, nq): -1.0}
    found |= {Part(f"{name}_b", 0, 2 * nq): sign for name, sign in motion.items()}
    return found | {Part("Phi_q_xi_b", nq, 2 * nq): 1.0, Part("gamma_b", nq, 2 * nq): -1.0}


def curved_equations(
    curves: CurveDerivatives, b: Array, at: dict[str, Any], nq: int, m: int
) -> list[CurveTerms]:
    """The changes of both equations with the numbers of curves, at a state: t, q, v, lam, and xi = a."""

    def part(sign: float, name: str, row: int, height: int, operand: str) -> CurveTerms:
        now = {"t": np.array([at["t"]]), "q": at["q"][None], operand: at[operand][None]}
        return CurveTerms(sign, curves(name, b, {}, **now), row, height)

    motion = [part(1.0, "Phi_qT_lam", 0, nq, "lam"), part(-1.0, "Q", 0, nq, "v")]
    return [*motion, part(1.0, "Phi_q_xi", nq, m, "xi"), part(-1.0, "gamma", nq, m, "v")]
