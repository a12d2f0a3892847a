"""HHT and generalized-α: implicit methods of order 2 with numerical damping, on the index-3 equations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from ..._jit.driver import compiled_function
from ...algebra import Array
from ...results import Assembly, Steps, Trajectory
from ...system import System
from ..independence import Inconsistent, Independence
from ..linear import SingularMatrix
from ..motion import Motion
from ..saddle import SingularSystem
from . import alpha_loop as loop
from .keeping import Keeping
from .newton_matrix import NewtonMatrix
from .outcome import nothing, trajectory_of

CHUNK = 400  # steps for one call of the compiled loop
HISTORY = 100_000  # steps whose history is kept
GROUPS = {
    "RESIDUAL": ("Phi", "Phi_qT_lam"),
    "MOMENTUM": ("M_a", "S"),
    "FORCE": ("Q",),
    "JACOBIAN": ("Phi_q", "Phi_qT_lam_q"),
    "INERTIA": ("M", "M_a_q", "S_q", "S_v"),
    "STIFFNESS": ("Q_q", "Q_v"),
    "VELOCITY": ("Phi_q_xi", "Phi_t"),
}


class _Alpha:
    """What HHT and generalized-α share: everything but the coefficients."""

    def scheme(self) -> loop.Scheme:
        """The coefficients of the method."""
        raise NotImplementedError

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
        keep_steps: bool = False,
        given: Array | None = None,
        b: Array | None = None,
    ) -> Trajectory:
        """Integrate over the times `t_eval`; see `sarrus.simulate`.

        `given` prescribes the lengths of the steps; `b` are other numbers than the system's.
        """
        scheme = self.scheme()
        room = CHUNK if keep_steps else 0
        try:
            run = Run(system, scheme, start, t_eval, rtol, atol, max_step, b)
            return run.go(progress, Keeping(system, room, given))
        except Inconsistent as trouble:
            return nothing(system, "inconsistent", str(trouble))
        except SingularSystem:
            return nothing(
                system, "singular configuration", f"the constraints are dependent at t = {t_eval[0]:g} s"
            )


@dataclass(frozen=True)
class HHT(_Alpha):
    """Hilber, Hughes and Taylor's method, -1/3 <= alpha <= 0: -1/3 damps high frequencies most.

    alpha = 0 does not damp at all; with variable steps the multipliers may then grow: use it with a fixed step.
    """

    alpha: float = -0.1

    def scheme(self) -> loop.Scheme:
        if not -1 / 3 <= self.alpha <= 0:
            raise ValueError(f"alpha of HHT must lie between -1/3 and 0, but is {self.alpha}")
        return _scheme(0.0, -self.alpha)


@dataclass(frozen=True)
class GeneralizedAlpha(_Alpha):
    """Chung and Hulbert's method; rho_inf, its spectral radius at infinite frequency: 1 does not damp, 0 damps most."""

    rho_inf: float = 0.8

    def scheme(self) -> loop.Scheme:
        if not 0 <= self.rho_inf <= 1:
            raise ValueError(f"rho_inf must lie between 0 and 1, but is {self.rho_inf}")
        rho = self.rho_inf
        return _scheme((2 * rho - 1) / (rho + 1), rho / (rho + 1))


def _scheme(alpha_m: float, alpha_f: float) -> loop.Scheme:
    """Second-order accurate coefficients (Chung and Hulbert 1993), and the error h³ ȧ of a step in q."""
    shift = alpha_m - alpha_f
    gamma, beta = 0.5 - shift, 0.25 * (1 - shift) ** 2
    return loop.Scheme(alpha_m, alpha_f, beta, gamma, abs(0.5 * shift + beta - 1 / 6))


@cache
def _compiled(drivers: tuple[Any, ...]) -> Any:
    """The time loop over the drivers of a kind of system."""
    from ..linear import compiled as factors

    named = dict(zip(GROUPS, drivers, strict=True))
    solver = {"REFACTOR": factors()["refactor"], "SOLVE": factors()["solve"]}
    residual = compiled_function(loop.residual, **{k: named[k] for k in ("RESIDUAL", "MOMENTUM", "FORCE")})
    matrices = {k: named[k] for k in ("JACOBIAN", "INERTIA", "STIFFNESS")}
    factor = compiled_function(loop.factor, **matrices, REFACTOR=solver["REFACTOR"])
    backsolve = compiled_function(loop.backsolve, SOLVE=solver["SOLVE"])
    size = compiled_function(loop.size)
    update = compiled_function(loop.update)
    correct = compiled_function(loop.correct, backsolve=backsolve, size=size, update=update)
    parts = {"residual": residual, "factor": factor, "correct": correct}
    newton = compiled_function(loop.newton, update=update, **parts)
    polish = compiled_function(loop.polish, **parts)
    constraints = {k: named[k] for k in ("RESIDUAL", "VELOCITY")}
    project = compiled_function(loop.project, **constraints, backsolve=backsolve)
    write = compiled_function(loop.write, project=project)
    velocity = {"VELOCITY": named["VELOCITY"], "factor": factor, "backsolve": backsolve}
    steps = {name: compiled_function(getattr(loop, name)) for name in ("predict", "accept", "keep")}
    steps |= {"newton": newton, "polish": polish, "rescale": compiled_function(loop.rescale, **velocity)}
    return compiled_function(loop.advance, write=write, size=size, **steps)


class Run:
    """One integration: its memory, and the calls of the compiled loop."""

    def __init__(
        self,
        system: System,
        scheme: loop.Scheme,
        start: Assembly,
        times: Array,
        rtol: float,
        atol: float,
        max_step: float,
        b: Array | None = None,
    ) -> None:
        self.system, self.scheme, self.times, self.begin = system, scheme, times, start
        self.b, self.rtol, self.atol = (system.b if b is None else b).copy(), rtol, np.full(system.nq, atol)
        self.max_step = max_step
        self._numbers = self.b.copy()
        system.remember(start.q, self.b, float(times[0]))
        self.independence = Independence(system, start.q, float(times[0]))
        self.independence.check(start)
        self.matrix = NewtonMatrix(system, self.independence.kept)
        bundles = [system.group(*names).bundle() for names in GROUPS.values()]
        self._loop = _compiled(tuple(function for function, _ in bundles))
        self._index = loop.Indices(*(indices for _, indices in bundles))
        self._state = self._start(start)
        nq, m = system.nq, system.m
        rows = (m, nq, nq, nq, nq, m, m, nq + m, nq + m, nq)
        self._memory = loop.Memory(*(np.zeros(length) for length in rows))
        wanted = [np.zeros((len(times), width)) for width in (nq, nq, nq, m)]
        self._output = loop.Output._make([times, *wanted, np.zeros((HISTORY, 4))])
        self._control = loop.Control(np.zeros(8), np.zeros(6, dtype=np.int64))
        self._control.numbers[7] = 1.0

    def _start(self, start: Assembly) -> loop.State:
        """Consistent accelerations and multipliers at the start."""
        a, lam = self._motion().acceleration(float(self.times[0]), start.q, start.v)
        first = [np.array(x, dtype=float) for x in (start.q, start.v, a, a, lam)]
        return loop.State._make([*first, *(x.copy() for x in first), np.zeros(len(a)), np.zeros(len(lam))])

    def _motion(self) -> Motion:
        motion = Motion(self.system, self.independence.kept)
        motion.b[:] = self.b
        return motion

    def go(self, progress: Callable[[float], None] | None, keeping: Keeping) -> Trajectory:
        """Integrate to the last time; whatever happens, what was computed is returned."""
        numbers, state = self._control.numbers, self._state
        self._keeping = keeping
        self._first = {"t": self.times[0], "left_out": self.matrix.left_out.copy()}
        self._first |= {n: getattr(state, f"{n}0").copy() for n in ("q", "v", "a", "x", "lam")}
        given = keeping.record().given
        numbers[0], numbers[1] = self.times[0], given[0] if len(given) else self._first_step()
        numbers[4] = numbers[1]
        status = loop.REPIVOT
        try:
            while status in (loop.RUNNING, loop.REPIVOT):
                if status == loop.REPIVOT:
                    self._renew_equations()
                    self._renew_pivots()
                status = self._advance()
                keeping.collect(int(self._control.counts[0]), self.matrix.left_out, self.b)
                self.system.remember(self._state.q0, self.b, numbers[0])
                if self.independence.kept is not None and status == loop.RUNNING:
                    status = loop.REPIVOT
                if progress:
                    progress(float(numbers[0]))
        except SingularMatrix:
            return self._result("singular configuration", "the constraints become dependent")
        except KeyboardInterrupt:
            return self._result("stopped", "stopped by the user")
        if status == loop.TOO_SMALL:
            return self._result(
                "step too small", "Newton's method or the error control asked for ever smaller steps"
            )
        return self._result("finished", "reached the end")

    def _advance(self) -> int:
        """One chunk of steps; one step where elements remember something."""
        limit = 1 if self.system.has_memory else 20 if self.independence.kept is not None else CHUNK
        status = self._loop(
            self.scheme, self._index, self.b, float(self.times[-1]), limit, self.max_step, self._state, self._memory,
            self._arrays, self._control, self._output, self._keeping.record(), self.rtol, self.atol,
        )  # fmt: skip
        return int(status)

    def _renew_equations(self) -> None:
        """Where equations are dependent: another independent choice, if the present one has become poor."""
        state, t = self._state, float(self._control.numbers[0])
        if self.independence.renew(t, state.q0):
            self.matrix.keep(self.independence.kept)
            motion = self._motion()
            state.lam0[:] = motion.acceleration(t, state.q0, state.v0)[1]
            state.lam_change[:] = 0.0

    def _renew_pivots(self) -> None:
        """A pivot order for the matrix at the present state."""
        system, state, views = self.system, self._state, self.matrix.views
        t, h, scheme = self._control.numbers[0], self._control.numbers[1], self.scheme
        kappa = (1 - scheme.alpha_f) / (1 - scheme.alpha_m)
        operands = {"t": t, "q": state.q0, "v": state.v0, "a": state.a0, "lam": state.lam0}
        for kind in ("JACOBIAN", "INERTIA", "STIFFNESS"):
            group = system.group(*GROUPS[kind])
            group.run(self.b, *(operands[k] for k in group.operands), *(views[name] for name in group.names))
        self.matrix.weigh(scheme.beta * h * h * kappa, scheme.gamma * h * kappa)
        self.matrix.choose_pivots()
        self._control.numbers[2] = 0.0
        lu, matrix = self.matrix.lu, self.matrix
        self._arrays = loop.Matrix._make([
            matrix.values, matrix.segments, matrix.places, matrix.weights, matrix.data,
            *(views[name] for name in ("Phi_q", "Phi_qT_lam_q", "M", "M_a_q", "S_q", "S_v", "Q_q", "Q_v")),
            matrix.row_of, matrix.left_out,
            lu.indptr, lu.indices, lu.pointers, lu.rows, lu.diagonal, lu.factors, lu.work, lu.row_place,
            lu.column_order,
        ])  # fmt: skip

    def _first_step(self) -> float:
        """A step whose error h³ ȧ is well below the tolerance, ȧ by a difference along the motion."""
        state, span = self._state, float(self.times[-1] - self.times[0])
        ahead = 1e-5 * span
        q, v = state.q0 + ahead * state.v0, state.v0 + ahead * state.a0
        a, _ = self._motion().acceleration(float(self.times[0]) + ahead, q, v)
        jerk = self.scheme.error * (a - state.a0) / ahead / (self.atol + self.rtol * abs(state.q0))
        size = float(np.sqrt(np.mean(jerk**2)))
        guess = 0.4 * size ** (-1 / 3) if size > 0 else span
        return float(min(max(guess, 1e-7 * span), 0.01 * span, self.max_step))

    def _multipliers(self, rows: int) -> Array:
        """Those given out: the shortest, where equations are dependent."""
        out = self._output
        if self.independence.kept is not None:
            for k in range(rows):
                out.lam[k] = self.independence.shortest(float(self.times[k]), out.q[k], out.lam[k])
        kept: Array = out.lam[:rows]
        return kept

    def _steps(self) -> Steps | None:
        told = {"scheme": self.scheme, "start": self.begin, "b": self._numbers, "rtol": self.rtol}
        first = {name: np.array(value) for name, value in self._first.items()}
        return self._keeping.steps(first, atol=float(self.atol[0]), **told)

    def _result(self, status: str, message: str) -> Trajectory:
        count, numbers = self._control.counts, self._control.numbers
        rows = int(count[4])
        if status != "finished":
            message = f"{message} near t = {numbers[0]:.6g} s"
        out = self._output
        return trajectory_of(
            self.system,
            (self.times[:rows], out.q[:rows], out.v[:rows], out.a[:rows], self._multipliers(rows)),
            status=status,
            message=message,
            nfev=int(count[2]),
            njev=int(count[3]),
            nsteps=int(count[0]),
            nrejected=int(count[1]),
            history=out.history[: min(int(count[0]), len(out.history))].copy(),
            steps=self._steps(),
        )
