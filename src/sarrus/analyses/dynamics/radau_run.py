"""One integration by the compiled loop of `radau_loop`: its memory, its matrices, and the calls of the loop."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from ..._jit.driver import compiled_function
from ..._jit.pointer import run
from ...algebra import Array
from ...results import Assembly, Trajectory
from ...system import System
from ..independence import Inconsistent, Independence
from ..linear import SingularMatrix
from ..motion import Motion
from ..saddle import SingularSystem
from . import placed
from . import radau_loop as loop
from .outcome import nothing, trajectory_of
from .placed import LEFT_OUT, UNIT, Numbers, Part, PlacedMatrix

CHUNK = 200  # steps for one call of the compiled loop
HISTORY = 100_000  # steps whose history is kept
GROUPS = {
    "RESIDUAL": ("Phi", "Phi_qT_lam"),
    "MOMENTUM": ("M_a", "S"),
    "FORCE": ("Q",),
    "VELOCITY": ("Phi_q_xi", "Phi_t"),
    "JACOBIAN": ("Phi_q", "Phi_qT_lam_q"),
    "INERTIA": ("M", "M_a_q", "S_q", "S_v"),
    "STIFFNESS": ("Q_q", "Q_v"),
    "TURNING": ("gamma_v",),
    "BENDING": ("Phi_q", "gamma"),
}
CALLS = {  # scalars and arrays that each takes
    "RESIDUAL": (1, 4),
    "MOMENTUM": (0, 5),
    "FORCE": (1, 3),
    "VELOCITY": (1, 4),
    "JACOBIAN": (1, 4),
    "INERTIA": (0, 7),
    "STIFFNESS": (1, 4),
    "TURNING": (1, 3),
    "BENDING": (1, 4),
}
MATRICES = ("Phi_q", "Phi_qT_lam_q", "M", "M_a_q", "S_q", "S_v", "Q_q", "Q_v", "gamma_v")


def newton_parts(nq: int, m: int) -> list[Part]:
    """Where operators stand in the Newton matrix; (Φ_q v + Φ_t)_q is -½ γ_v. `radau_loop.weigh` has their weights."""
    v, lam, mu = nq, 2 * nq, 2 * nq + m
    return [
        Part(UNIT, 0, 0),
        Part(UNIT, 0, v),
        Part("Phi_q", 0, mu, transposed=True),
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


def motion_parts(nq: int, m: int) -> list[Part]:
    """[M Φ_qᵀ; Φ_q 0], with a 1 for every equation left out."""
    below, above = Part("Phi_q", nq, 0), Part("Phi_q", 0, nq, transposed=True)
    return [Part("M", 0, 0), below, above, Part(LEFT_OUT, nq, nq)]


@cache
def _compiled() -> Any:
    """The time loop: the same code for every system; drivers are called by their address."""
    from ..linear import compiled as factors

    known: dict[str, Any] = {name: run(*CALLS[name]) for name in GROUPS}
    known |= {"REFACTOR": factors()["refactor"], "SOLVE": factors()["solve"]}
    known["ASSEMBLE"] = compiled_function(placed.assemble)
    inner = (
        "stages",
        "residual",
        "evaluate",
        "refactor",
        "weigh",
        "factor",
        "backsolve",
        "scaled",
        "unscaled",
        "size",
    )
    outer = ("improve", "newton", "estimate", "lagrange", "predict", "first_guess", "accept")
    for name in (*inner, *outer, "motion", "project", "between", "write", "advance"):
        known[name] = compiled_function(getattr(loop, name), **known)
    return known["advance"]


class Run:
    """One integration."""

    def __init__(
        self,
        system: System,
        scheme: loop.Scheme,
        start: Assembly,
        times: Array,
        rtol: float,
        atol: float,
        max_step: float,
    ) -> None:
        self.system, self.scheme, self.times, self.max_step = system, scheme, times, max_step
        self.rtol, self.atol, self.enough = inner_tolerances(system.nq, rtol, atol)
        self.b = system.b.copy()
        system.remember(start.q, self.b, float(times[0]))
        self.independence = Independence(system, start.q, float(times[0]))
        self.independence.check(start)
        self._loop = _compiled()
        self._index = loop.Indices(*(system.group(*names).entry() for names in GROUPS.values()))
        self._make_matrices()
        self._state = self._start(start)
        nq, m = system.nq, system.m
        wanted = [np.zeros((len(times), width)) for width in (nq, nq, nq, m)]
        self._output = loop.Output._make([times, *wanted, np.zeros((HISTORY, 4))])
        self._control = loop.Control(np.zeros(8), np.zeros(6, dtype=np.int64))
        self._memory = _memory(nq, m)

    @classmethod
    def started(
        cls,
        system: System,
        scheme: loop.Scheme,
        start: Assembly,
        times: Array,
        rtol: float,
        atol: float,
        max_step: float,
        progress: Callable[[float], None] | None,
    ) -> Trajectory:
        """The trajectory, or an empty one that says why there is none."""
        try:
            return cls(system, scheme, start, times, rtol, atol, max_step).go(progress)
        except Inconsistent as trouble:
            return nothing(system, "inconsistent", str(trouble))
        except SingularSystem:
            told = f"the constraints are dependent at t = {times[0]:g} s"
            return nothing(system, "singular configuration", told)

    def _make_matrices(self) -> None:
        system, nq, m = self.system, self.system.nq, self.system.m
        self.numbers = Numbers(system, (*MATRICES, UNIT, LEFT_OUT))
        self.real = PlacedMatrix(self.numbers, 2 * (nq + m), newton_parts(nq, m))
        self.pair = PlacedMatrix(self.numbers, 2 * (nq + m), newton_parts(nq, m), complex)
        self.motion = PlacedMatrix(self.numbers, nq + m, motion_parts(nq, m))
        self._row_of = self.numbers.entries("Phi_q")[0]
        self._keep()

    def _keep(self) -> None:
        left_out = self.numbers.views[LEFT_OUT]
        left_out[:] = 0.0 if self.independence.kept is None else 1.0
        left_out[[] if self.independence.kept is None else self.independence.kept] = 0.0

    def _start(self, start: Assembly) -> loop.State:
        """Consistent accelerations and multipliers at the start."""
        a, lam = Motion(self.system, self.independence.kept).acceleration(
            float(self.times[0]), start.q, start.v
        )
        first = [np.array(x, dtype=float) for x in (start.q, start.v, a)]
        widths = [len(a)] * 3 + [len(lam)] * 2 + [len(a)] * 4
        before = np.repeat(lam[None], 3, axis=0)
        return loop.State._make([*first, *(np.zeros((3, width)) for width in widths), before])

    def go(self, progress: Callable[[float], None] | None) -> Trajectory:
        """Integrate to the last time; whatever happens, what was computed is returned."""
        numbers = self._control.numbers
        numbers[0], numbers[1] = self.times[0], self._first_step()
        status = loop.REPIVOT
        try:
            while status in (loop.RUNNING, loop.REPIVOT):
                if status == loop.REPIVOT:
                    self._renew_equations()
                    self._renew_pivots()
                status = self._advance()
                self.system.remember(self._state.q0, self.b, numbers[0])
                if self.independence.kept is not None and status == loop.RUNNING:
                    status = loop.REPIVOT
                if progress:
                    progress(float(numbers[0]))
        except (SingularMatrix, SingularSystem):
            return self._result("singular configuration", "the constraints become dependent")
        except KeyboardInterrupt:
            return self._result("stopped", "stopped by the user")
        if status == loop.TOO_SMALL:
            told = "Newton's method or the error control asked for ever smaller steps"
            return self._result("step too small", told)
        return self._result("finished", "reached the end")

    def _advance(self) -> int:
        """One chunk of steps; one step where elements remember something."""
        limit = 1 if self.system.has_memory else 20 if self.independence.kept is not None else CHUNK
        status = self._loop(
            self.scheme, self._index, self.b, float(self.times[-1]), limit, self.max_step, self._state, self._memory,
            self._arrays, self._control, self._output, self.rtol, self.atol, self.enough,
        )  # fmt: skip
        return int(status)

    def _renew_equations(self) -> None:
        """Where equations are dependent: another independent choice, if the present one has become poor."""
        state, t = self._state, float(self._control.numbers[0])
        if self.independence.renew(t, state.q0):
            self._keep()
            lam = Motion(self.system, self.independence.kept).acceleration(t, state.q0, state.v0)[1]
            state.lam_before[:] = lam
            self._control.numbers[6] = 0.0

    def _renew_pivots(self) -> None:
        """Pivot orders for the matrices at the present state."""
        system, state, views = self.system, self._state, self.numbers.views
        t, h = float(self._control.numbers[0]), float(self._control.numbers[1])
        operands = {"t": t, "q": state.q0, "v": state.v0, "a": state.a0, "lam": state.lam_before[2]}
        for kind in ("JACOBIAN", "INERTIA", "STIFFNESS", "TURNING"):
            group = system.group(*GROUPS[kind])
            group.run(self.b, *(operands[k] for k in group.operands), *(views[name] for name in group.names))
        views["Phi_q"][views[LEFT_OUT][self._row_of] > 0] = 0.0
        loop.weigh(self.real.weights, self.scheme.gamma / h)
        loop.weigh(self.pair.weights, self.scheme.pair / h)
        self._arrays = loop.Matrices._make([
            self.numbers.values, *(views[name] for name in MATRICES), self._row_of, views[LEFT_OUT],
            self.real.placed(), self.pair.placed(), self.motion.placed(),
        ])  # fmt: skip
        self._control.numbers[2], self._control.numbers[7] = 0.0, 1.0

    def _first_step(self) -> float:
        """A step whose estimated error, of order h⁴, is below the tolerance; a change of slope gives the scale."""
        state, span = self._state, float(self.times[-1] - self.times[0])
        ahead = 1e-5 * span
        q, v = state.q0 + ahead * state.v0, state.v0 + ahead * state.a0
        a, _ = Motion(self.system, self.independence.kept).acceleration(float(self.times[0]) + ahead, q, v)
        jerk = (a - state.a0) / ahead / (self.atol + self.rtol * abs(state.v0))
        size = float(np.sqrt(np.mean(jerk**2)))
        guess = 0.1 * size ** (-1 / 3) if size > 0 else span
        return float(min(max(guess, 1e-7 * span), 0.01 * span, self.max_step))

    def _multipliers(self, rows: int) -> Array:
        """Those given out: the shortest, where equations are dependent."""
        out = self._output
        if self.independence.kept is not None:
            for k in range(rows):
                out.lam[k] = self.independence.shortest(float(self.times[k]), out.q[k], out.lam[k])
        kept: Array = out.lam[:rows]
        return kept

    def _result(self, status: str, message: str) -> Trajectory:
        count, numbers = self._control.counts, self._control.numbers
        rows, out = int(count[4]), self._output
        if status != "finished":
            message = f"{message} near t = {numbers[0]:.6g} s"
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
        )


def inner_tolerances(nq: int, rtol: float, atol: float) -> tuple[float, Array, float]:
    """The tolerances of the error estimate, and what Newton's method may leave of them.

    The estimate is of order 4 in h, the error of order 6: steps are controlled as in Hairer and Wanner's RADAU5, with
    0.1 rtol^(2/3) in the place of rtol.
    """
    inner = 0.1 * rtol ** (2 / 3)
    return inner, np.full(nq, atol * inner / rtol), float(max(1e-14 / inner, min(0.03, inner**0.5)))


def _memory(nq: int, m: int) -> loop.Memory:
    whole, small = 2 * (nq + m), nq + m
    shapes = (m, nq, nq, nq, nq, nq, m, m, m, (3, whole), whole, whole)
    last = (small, small, nq)
    pair = [np.zeros(whole, dtype=complex) for _ in range(2)]
    return loop.Memory._make([*(np.zeros(s) for s in shapes), *pair, *(np.zeros(s) for s in last)])
