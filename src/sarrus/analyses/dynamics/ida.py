"""SUNDIALS IDA (BDF of orders 1 to 5) on the stabilized index-2 equations: an independent check of the other methods.

Multipliers are the derivatives of unknowns Λ and Μ, λ = Λ', μ = Μ', which lowers the index to 1 (Gear 1988):

    q' = v - Φ_qᵀ Μ',    M v' = Q + S - Φ_qᵀ Λ',    Φ = 0,    Φ_q v + Φ_t = 0.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...algebra import Array
from ...results import Assembly, Trajectory
from ...system import System
from ..independence import Inconsistent, Independence
from ..motion import Motion
from ..saddle import SingularSystem
from .ode import Recorder
from .outcome import nothing
from .placed import LEFT_OUT, UNIT, Numbers, PlacedMatrix
from .radau_run import MATRICES, newton_parts

UNMEASURED = 1e100  # tolerance of Λ and Μ, of which only the derivatives mean anything
LIMIT = 1_000_000  # steps between two outputs


@dataclass(frozen=True)
class IDA:
    """Lawrence Livermore's IDA, with exact Jacobians; needs the extra `ida`, which installs scikit-sundae."""

    def run(
        self,
        system: System,
        start: Assembly,
        t_eval: Array,
        *,
        rtol: float,
        atol: float,
        progress: Callable[[float], None] | None = None,
        max_step: float = np.inf,
    ) -> Trajectory:
        """Integrate over the times `t_eval`; see `sarrus.simulate`.

        Raises
        ------
        ImportError
            If scikit-sundae is not installed.
        """
        try:
            equations = Equations(system, start, float(t_eval[0]))
            solver = _solver(equations, rtol, atol, max_step)
            return _followed(equations, solver, start, t_eval, progress)
        except Inconsistent as trouble:
            return nothing(system, "inconsistent", str(trouble))
        except SingularSystem:
            told = f"the constraints are dependent at t = {t_eval[0]:g} s"
            return nothing(system, "singular configuration", told)


def _solver(equations: Equations, rtol: float, atol: float, max_step: float) -> Any:
    try:
        from sksundae.ida import IDA as Solver
    except ImportError:
        raise ImportError("IDA() needs scikit-sundae; install it with: pip install 'sarrus[ida]'") from None
    nq, m = equations.system.nq, equations.system.m
    told = {"rtol": rtol, "atol": np.repeat([atol, UNMEASURED], [2 * nq, 2 * m]), "max_num_steps": LIMIT}
    told["max_step"] = 0.0 if np.isinf(max_step) else max_step
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Custom sparse Jacobian approximation")
        sparse = {"linsolver": "sparse", "sparsity": equations.matrix.pattern()}
        return Solver(equations.residual, jacfn=equations.jacobian, **sparse, **told)


def _followed(
    equations: Equations,
    solver: Any,
    start: Assembly,
    times: Array,
    progress: Callable[[float], None] | None,
) -> Trajectory:
    """The states at the times, each projected onto the constraints."""
    system, independence, motion = equations.system, equations.independence, equations.motion
    recorder = Recorder(system, times, independence, motion.b)
    nq, steps, status, message = system.nq, 0, "finished", "reached the end"
    a, lam = motion.acceleration(times[0], start.q, start.v)
    nothing_yet = np.zeros(2 * system.m)
    y = np.concatenate([start.q, start.v])
    solver.init_step(
        times[0], np.concatenate([y, nothing_yet]), np.concatenate([start.v, a, lam, nothing_yet[system.m :]])
    )
    recorder.record(motion, times[0], lambda t: y, up_to=times[0])
    while recorder.last < times[-1]:
        step = solver.step(times[-1], method="onestep", tstop=times[-1])
        if not step.success:
            status, message = "step too small", f"IDA gave up at t = {step.t:.6g} s: {step.message}"
            break
        steps += 1
        recorder.record(motion, step.t, lambda t: solver.step(t).y[: 2 * nq], up_to=step.t)
        system.remember(step.y[:nq].copy(), motion.b, float(step.t))
        if progress:
            progress(float(step.t))
    return recorder.trajectory(status, message, equations.evaluations, steps)


class Equations:
    """F(t, y, y') = 0 for y = [q; v; Λ; Μ], and F_y + c F_y'."""

    def __init__(self, system: System, start: Assembly, t: float) -> None:
        self.system, self.evaluations = system, 0
        self.independence = Independence(system, start.q, t)
        self.independence.check(start)
        self.motion = Motion(system, self.independence.kept)
        system.remember(start.q, self.motion.b, t)
        self._numbers = Numbers(system, (*MATRICES, UNIT, LEFT_OUT))
        nq, m = system.nq, system.m
        self.matrix = PlacedMatrix(self._numbers, 2 * (nq + m), newton_parts(nq, m))
        self._left_out = self._numbers.views[LEFT_OUT]
        if self.independence.kept is not None:
            self._left_out[:] = 1.0
            self._left_out[self.independence.kept] = 0.0
        self._row_of = self._numbers.entries("Phi_q")[0]
        self._cut = np.cumsum([nq, nq, m])

    def residual(self, t: float, y: Array, rate: Array, out: Array) -> None:
        """[q' - v + Φ_qᵀ Μ'; M v' + Φ_qᵀ Λ' - Q - S; Φ; Φ_q v + Φ_t]; Λ' and Μ' of equations left out are 0."""
        self.evaluations += 1
        system, b, kept = self.system, self.motion.b, 1.0 - self._left_out
        q, v, _, _ = np.split(y, self._cut)
        qd, a, lam, mu = (part.copy() for part in np.split(rate, self._cut))
        q, v = q.copy(), v.copy()
        first = qd - v + system.Phi_qT_lam(q, mu, t, b=b)
        second = system.M_a(q, a, b=b) + system.Phi_qT_lam(q, lam, t, b=b)
        second -= system.Q(q, v, t, b=b) + system.S(q, v, b=b)
        third = np.where(kept > 0, system.Phi(q, t, b=b), lam)
        fourth = np.where(kept > 0, system.Phi_q_xi(q, v, t, b=b) + system.Phi_t(q, t, b=b), mu)
        out[:] = np.concatenate([first, second, third, fourth])

    def jacobian(self, t: float, y: Array, rate: Array, _: Array, c: float, out: Array) -> None:
        """The numbers of F_y + c F_y' by columns; (Φ_qᵀ Μ')_q is left out, Μ' being 0 on the solution."""
        q, v = (part.copy() for part in np.split(y, self._cut)[:2])
        _, a, lam, _ = (part.copy() for part in np.split(rate, self._cut))
        views, operands = self._numbers.views, {"t": t, "q": q, "v": v, "a": a, "lam": lam}
        groups = (("Phi_q", "Phi_qT_lam_q"), ("M", "M_a_q", "S_q", "S_v"), ("Q_q", "Q_v"), ("gamma_v",))
        for names in groups:
            group = self.system.group(*names)
            group.run(self.motion.b, *(operands[k] for k in group.operands), *(views[name] for name in names))
        views["Phi_q"][self._left_out[self._row_of] > 0] = 0.0
        self.matrix.weights[:] = [c, -1, c, c, 1, 1, -1, -1, c, -1, -1, 1, 1, -0.5, c, c]
        out[:] = self.matrix.assembled()
