"""The start of a run differentiated: accelerations and multipliers that belong to the assembled state.

M a + Φ_qᵀλ = Q + S,    Φ_q a = γ
"""

from __future__ import annotations

from functools import partial

import numpy as np
from scipy.sparse import csr_array

from ...algebra import Array
from ...results import StepsTaken
from ...system import System
from ...system.curve_derivatives import CurveDerivatives
from ..saddle import Saddle


class Start:
    """Derivatives of a and λ at the first node, with equations that others imply left out.

    Parameters
    ----------
    system : System
    steps : whose first node it is
    curves : of the system, perhaps with the time, which make the numbers complete
    """

    def __init__(self, system: System, steps: StepsTaken, curves: CurveDerivatives) -> None:
        self._nq, self._m = system.nq, system.m
        q, v, a, lam, t = steps.q[0], steps.v[0], steps.a[0], steps.lam[0], float(steps.t[0])
        b = steps.b.copy()
        if len(steps):
            b[steps.places] = steps.memory[0]
        kept = np.flatnonzero(~steps.left_out[0]) if len(steps.left_out) else None
        self._saddle = Saddle(system, "M", kept)
        self._saddle.factor(system.M(q, b=b).data, system.Phi_q(q, t, b=b).data)
        forces = system.Q_q(q, v, t, b=b) + system.S_q(q, v, b=b)
        self._f_q = csr_array(system.M_a_q(q, a, b=b) + system.Phi_qT_lam_q(q, lam, t, b=b) - forces)
        self._f_v = csr_array(-system.Q_v(q, v, t, b=b) - system.S_v(q, v, b=b))
        self._g_q = csr_array(system.Phi_q_xi_q(q, a, t, b=b) - system.gamma_q(q, v, t, b=b))
        self._g_v = csr_array(-system.gamma_v(q, v, t, b=b))
        loads = (-system.Q_b(q, v, t, b=b), -system.S_b(q, v, b=b))
        self._f_b = _sum((system.M_a_b(q, a, b=b), system.Phi_qT_lam_b(q, lam, t, b=b), *loads), curves.width)
        self._g_b = _sum((system.Phi_q_xi_b(q, a, t, b=b), -system.gamma_b(q, v, t, b=b)), curves.width)
        if curves:
            now = partial(curves.matrix, b=b, t=t, q=q)
            self._f_b = csr_array(self._f_b + now("Phi_qT_lam", lam=lam) - now("Q", v=v))
            self._g_b = csr_array(self._g_b + now("Phi_q_xi", xi=a) - now("gamma", v=v))

    def along(self, q_dot: Array, v_dot: Array, b_dot: Array) -> tuple[Array, Array]:
        """The changes of a (nq, k) and λ (m, k) with those of q, v and the numbers."""
        f = -(self._f_q @ q_dot + self._f_v @ v_dot + self._f_b @ b_dot)
        g = -(self._g_q @ q_dot + self._g_v @ v_dot + self._g_b @ b_dot)
        return self._solve(f, g)

    def transposed(self, a_bar: Array, lam_bar: Array) -> tuple[Array, Array, Array]:
        """Gradients by q (nq, k), v and the numbers of what has the gradients given by a and λ."""
        y, z = self.adjoint(a_bar, lam_bar)
        return (
            -(self._f_q.T @ y + self._g_q.T @ z),
            -(self._f_v.T @ y + self._g_v.T @ z),
            -(self._f_b.T @ y + self._g_b.T @ z),
        )

    def adjoint(self, a_bar: Array, lam_bar: Array) -> tuple[Array, Array]:
        """The adjoint variables of the equations of motion (nq, k) and of the constraints (m, k)."""
        return self._solve(a_bar, lam_bar)

    def _solve(self, f: Array, g: Array) -> tuple[Array, Array]:
        found = [self._saddle.solve(*pair) for pair in zip(f.T, g.T, strict=True)]
        x = np.array([pair[0] for pair in found]).reshape(-1, self._nq).T
        return x, np.array([pair[1] for pair in found]).reshape(-1, self._m).T


def _sum(parts: tuple[csr_array, ...], width: int) -> csr_array:
    """The sum of operators by b, as wide as all numbers with the curves."""
    total = csr_array(sum(parts[1:], parts[0]))
    total.resize((total.shape[0], width))
    return csr_array(total)
