"""SciPy's explicit solvers on the index-1 equations, projected onto the constraints after every step.

For systems that are not stiff, and as an independent check of other methods.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...._jit.linking.link import link
from ....algebra import Array
from ....linalg.factors import SingularSystem
from ....results import Assembly
from ....system import System
from ...equations.motion import EquationsOfMotion
from ...equations.projection import Projection
from ..events.switching_functions import no_switching
from ..step_loop.crossing import LANDED, NONE, Crossing, Step, Switching, first_after, shorter
from ..stepping.failures import failure_of, singular
from ..stepping.motion_scale import follow_motion
from ..stepping.nodes import Nodes
from ..stepping.step_control import StepControl
from ..stepping.stepper import RunFailure, RunPart, Settings, Tally, below, independence_at, remember_start
from ..stepping.tolerance import FIRST, FOLLOWED, begin_motion, first_step

TINY = 1e-10  # of the whole time: steps so short are given up on; a light part may turn within 1e-6 of it
PATIENCE = 20  # after so many of them in a row
PARTS = 8  # pieces of a step between which there are nodes, if states are wanted at any time
SOLVERS = ("DOP853", "RK45", "RK23")


@dataclass(frozen=True)
class ODE(StepControl):
    """Explicit Runge-Kutta method of SciPy: "DOP853" (order 8), "RK45" or "RK23"; further options: `StepControl`."""

    name: str = "DOP853"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.name not in SOLVERS:
            raise ValueError(f"there is no ODE solver {self.name!r}. Choose from {', '.join(SOLVERS)}")

    def stepper(self, system: System, start: Assembly, settings: Settings) -> ODEStepper:
        """The method at work, see `Stepper`."""
        if settings.store_steps:
            raise ValueError(
                "method: ODE() stores no steps. Choose HHT(), GeneralizedAlpha(), Radau() or a description."
            )
        return ODEStepper(system, self.name, start, settings)


class ODEStepper(RunPart):
    """An explicit solver at work on one system, see `Stepper`."""

    VARIABLES = (
        "independence", "t", "_span", "_tiny", "b", "tally", "_crossing", *FOLLOWED, "_solver.h_abs", "_solver.y",
        "_solver.f",
    )  # fmt: skip
    apart = passes_kinks = has_history = False
    host = None  # it keeps no matrix of the equations of motion for others

    def __init__(self, system: System, name: str, start: Assembly, settings: Settings) -> None:
        self.system, self._name, self._settings = system, name, settings
        self.t, self.tally, self._tiny = start.t, Tally(), 0
        self.independence = independence_at(system, start)
        self.motion = EquationsOfMotion(system, self.independence.rows)
        self.b = self.motion.b
        remember_start(system, start, self.b)
        self._projection = Projection(system, self.b, self.independence.rows)
        self._tolerance = settings.tolerances.for_loop()
        self._switching = no_switching(system.nq)
        self._crossing: Any = Crossing.zeros()

    def end_at(self, switching: Switching) -> None:
        """See `Stepper`."""
        self._switching = switching

    @property
    def switched(self) -> Crossing | None:
        """See `Stepper`."""
        crossing = self._crossing
        landed = crossing.stage == LANDED and self._switching.returns[crossing.number]
        return crossing if landed else None

    def restart(self, t: float, q: Array, v: Array, until: float) -> None:
        """Begin anew; SciPy's solver chooses its first step."""
        from scipy import integrate

        self.t, self._span, self._tiny = t, until - t, 0
        tolerances, settings = self._settings.tolerances, self._settings
        first = settings.first_step or None
        if tolerances.follow:
            begin_motion(self._tolerance, self.system, t, q, until)
            first = first or self._first_step(t, q, v)
        message: dict[str, Any] = {"max_step": settings.max_step, "first_step": first}
        message["rtol"] = float(min(tolerances.rtol_q.min(), tolerances.rtol_v.min()))
        message["atol"] = np.concatenate([self._tolerance.atol_q, self._tolerance.atol_v])
        try:
            self._solver = getattr(integrate, self._name)(
                self._rate, t, np.concatenate([q, v]), until, **message
            )
        except ValueError:  # SciPy's choice of a first step meets what is not finite
            raise self._explained(q, v) from None
        self._count()
        if not np.all(np.isfinite(self._solver.f)):
            raise self._explained(q, v)

    def shorten(self, longest: float) -> None:
        """See `Stepper`."""
        self._solver.h_abs = min(self._solver.h_abs, longest)

    def _first_step(self, t: float, q: Array, v: Array) -> float:
        try:
            a = self.motion.acceleration(t, q, v)[0]
        except SingularSystem:
            raise self._explained(q, v) from None
        return first_step(
            self.motion, self._tolerance, FIRST, t, q, v, a, min(0.01 * self._span, self._settings.max_step)
        )

    def advance(self, stop: float, limit: int) -> Nodes:
        """Steps towards a time, see `Stepper`."""
        self._renew(self.t, self._solver.y[: self.system.nq])
        rows = [self._node(self.t, *np.split(self._solver.y, 2))]
        try:
            self._solver.t_bound, self._solver.status = float(stop), "running"
            for _ in range(min(limit, PATIENCE) if self.independence.rows is None else 1):
                rows += self._step()
                if self.t == stop or self.switched:
                    break
        except SingularSystem:
            if len(rows) == 1:
                raise self._stuck_at() from None
        except RunFailure as error:
            if len(rows) == 1:
                raise self._stuck_at(error) from None
        finally:
            self._count()
        return Nodes._make(np.array(column) for column in zip(*rows, strict=True))

    def _count(self) -> None:
        """Each evaluation of the motion factors its matrix."""
        self.tally.nfev = self.tally.nlu = self.motion.evaluations

    def _step(self) -> list[tuple[Any, ...]]:
        """Take one step, and store its nodes: some of the solver's interpolant, then the projected end."""
        solver, before = self._solver, self.t
        self._crossing.stage = NONE
        self._switching.ignored[:] = 0.0
        if self._settings.tolerances.follow:
            q, v = np.split(solver.y, 2)
            link(follow_motion)(self._tolerance, solver.h_abs, q, v, v, False)
            solver.rtol, solver.atol = 0.0, np.concatenate([self._tolerance.atol_q, self._tolerance.atol_v])
        y, f = solver.y, solver.f
        while length := self._take(before, y):
            solver.t, solver.y, solver.f, solver.h_abs, solver.status = before, y, f, length, "running"
        self._crossing.since += 1
        if self._crossing.stage == LANDED:
            solver.h_abs, self._crossing.since = min(solver.h_abs, first_after(self._crossing)), 0
        self._tiny = self._tiny + 1 if solver.step_size < TINY * self._span else 0
        if self._tiny >= PATIENCE:
            raise RunFailure("step too small", f"steps become ever shorter near t = {solver.t:.6g} s: {WHY}")
        interpolant, h = solver.dense_output(), solver.t - before
        nodes = [
            self._node(t, *self._projection(t, *np.split(interpolant(t), 2))) for t in self._inner(before, h)
        ]
        q, v = self._projection(solver.t, *np.split(solver.y, 2))
        self.system.remember(q, self.b, solver.t)
        solver.y = np.concatenate([q, v])
        solver.f = self._rate(solver.t, solver.y)
        self.t, self.tally.nsteps = float(solver.t), self.tally.nsteps + 1
        self.tally.history.append(np.array([[solver.t, h, np.nan, 0, 0]]))
        return [*nodes, self._node(self.t, q, v)]

    def _take(self, before: float, y: Array) -> float:
        """Let the solver take a step; the length of one in its place towards a switch, or 0.

        Raises
        ------
        RunFailure
            If there is none.
        """
        solver = self._solver
        message = solver.step()
        if message:
            raise RunFailure("step too small", f"{message} at t = {solver.t:.6g} s: {WHY}")
        if not len(self._switching.columns):
            return 0.0
        rates = self._rate(before, y), self._rate(solver.t, solver.y)
        first, last = (np.split(np.concatenate(x), 4) for x in zip((y, solver.y), rates, strict=True))
        (q0, v0, _, a0), (q1, v1, _, a1) = first, last
        step = Step(self.b, before, float(solver.t - before), q0, v0, a0, q1, v1, a1, False)
        return float(link(shorter)(self._switching, step, self._crossing))

    def _inner(self, before: float, h: float) -> list[float]:
        """Times within a step at which there are nodes: those wanted, and some between."""
        settings = self._settings
        inner = settings.times[(settings.times > before) & (settings.times < before + h)]
        if settings.dense:
            inner = np.union1d(inner, before + np.arange(1, PARTS) / PARTS * h)
        return [float(t) for t in inner]

    def _node(self, t: float, q: Array, v: Array) -> tuple[Any, ...]:
        a, lam = self.motion.acceleration(t, q, v)
        return t, q.copy(), v.copy(), a, lam, self.b[self.system.memory_places]

    def _renew(self, t: float, q: Array) -> None:
        if self.independence.renew(t, q):
            self._keep()

    def _keep(self) -> None:
        """Solve only the independent equations."""
        self.motion.keep(self.independence.rows)
        self._projection.keep(self.independence.rows)

    def _explained(self, q: Array, v: Array, otherwise: RunFailure | None = None) -> RunFailure:
        """Why there are no further steps."""
        message = otherwise or singular(self.t, [])
        return failure_of(self.system, self.b, self.t, q, v, self.independence, self._span, message)

    def _rate(self, t: float, y: Array) -> Array:
        """The rate of [q; v]; not a number where there is none, so that the solver tries a shorter step."""
        try:
            return self.motion.rate(t, y)
        except SingularSystem:
            return np.full(len(y), np.nan)

    def _stuck_at(self, otherwise: RunFailure | None = None) -> RunFailure:
        q, v = np.split(self._solver.y, 2)
        return self._explained(q, v, otherwise)

    def resume(self, state: Mapping[str, Array]) -> None:
        """See `RunPart`; a solver of SciPy that begins there takes over the variables of the one before."""
        self.independence.resume(below("independence", state))
        self._keep()
        self.b[:], t = state["b"], float(state["t"])
        q, v = np.split(state["_solver.y"], 2)
        self.restart(t, q, v, t + float(state["_span"]))
        super().resume(state)
        self.motion.evaluations = self.tally.nfev

    def steps(self) -> None:
        """No steps are stored."""


WHY = (
    "a force is very stiff, or the mechanism reaches a singular configuration, where motions branch; `singularities` "
    "locates such positions along a motion, and Radau() takes stiff forces."
)
