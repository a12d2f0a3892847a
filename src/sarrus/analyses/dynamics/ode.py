"""SciPy's explicit solvers on the index-1 equations, projected onto the constraints after every step.

For systems that are not stiff, and as an independent check of other methods.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...algebra import Array
from ...results import Assembly, Trajectory
from ...system import System
from ..independence import Inconsistent, Independence
from ..motion import Motion
from ..projection import Projection
from ..saddle import SingularSystem
from .outcome import trajectory_of

TINY = 1e-6  # of the whole time: steps so short are given up on
PATIENCE = 20  # after so many of them in a row
SOLVERS = ("DOP853", "RK45", "RK23")


@dataclass(frozen=True)
class ODE:
    """An explicit Runge-Kutta method of SciPy: "DOP853" (order 8), "RK45" or "RK23"."""

    name: str = "DOP853"

    def __post_init__(self) -> None:
        if self.name not in SOLVERS:
            raise ValueError(f"there is no ODE solver {self.name!r}; choose from {', '.join(SOLVERS)}")

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
        """Integrate over the times `t_eval`; see `sarrus.simulate`."""
        from scipy import integrate

        independence = Independence(system, start.q, t_eval[0])
        motion = Motion(system, independence.kept)
        system.remember(start.q, motion.b, float(t_eval[0]))
        recorder = Recorder(system, t_eval, independence, motion.b)
        y = np.concatenate([start.q, start.v])
        status, message, steps = "finished", "reached the end", 0
        tiny = 0
        try:
            independence.check(start)
            solver = getattr(integrate, self.name)(
                motion.rate, t_eval[0], y, t_eval[-1], rtol=rtol, atol=atol, max_step=max_step
            )
            recorder.record(motion, t_eval[0], lambda t: y, up_to=t_eval[0])
            while solver.status == "running":
                trouble = solver.step()
                if trouble:
                    status, message = "step too small", f"{trouble} at t = {solver.t:.6g} s"
                    break
                steps += 1
                tiny = tiny + 1 if solver.step_size < TINY * (t_eval[-1] - t_eval[0]) else 0
                if tiny >= PATIENCE:
                    status, message = "step too small", _stuck(solver.t)
                    break
                recorder.record(motion, solver.t, solver.dense_output(), up_to=solver.t)
                solver.y = np.concatenate(recorder.projection(solver.t, *np.split(solver.y, 2)))
                if independence.renew(solver.t, solver.y[: system.nq]):
                    motion.keep(independence.kept)
                    recorder.projection.keep(independence.kept)
                system.remember(solver.y[: system.nq], motion.b, solver.t)
                solver.f = motion.rate(solver.t, solver.y)
                if progress:
                    progress(float(solver.t))
        except Inconsistent as contradiction:
            status, message = "inconsistent", str(contradiction)
        except SingularSystem:
            status = "singular configuration"
            message = f"the constraints become dependent near t = {recorder.last:.6g} s; change the start or the model"
        return recorder.trajectory(status, message, motion.evaluations, steps)


def _stuck(t: float) -> str:
    return (
        f"steps become ever shorter near t = {t:.6g} s: a force is very stiff, or the mechanism comes to a singular "
        "position, where motions branch; `singularities` locates such positions along a motion"
    )


class Recorder:
    """Collects states at given times from a solver's interpolants, each projected onto the constraints."""

    def __init__(self, system: System, times: Array, independence: Independence, b: Array) -> None:
        self.system, self.times, self._independence = system, times, independence
        self.projection = Projection(system, b, independence.kept)
        self.last = float(times[0])
        self._rows: list[tuple[Any, ...]] = []

    def record(self, motion: Motion, t: float, interpolant: Callable[[float], Array], up_to: float) -> None:
        """Take all times not yet taken up to `up_to`."""
        while len(self._rows) < len(self.times) and self.times[len(self._rows)] <= up_to * (1 + 1e-15):
            time = float(self.times[len(self._rows)])
            q, v = self.projection(time, *np.split(np.asarray(interpolant(time)), 2))
            a, lam = motion.acceleration(time, q, v)
            lam = self._independence.shortest(time, q, lam)
            self._rows.append((time, q, v, a, lam))
        self.last = float(t)

    def trajectory(self, status: str, message: str, evaluations: int, steps: int) -> Trajectory:
        """All that was recorded."""
        nq, m = self.system.nq, self.system.m
        shapes = ((), (nq,), (nq,), (nq,), (m,))
        columns = zip(*self._rows, strict=True) if self._rows else ([] for _ in shapes)
        t, q, v, a, lam = (
            np.array(list(column)).reshape(-1, *shape) for column, shape in zip(columns, shapes, strict=True)
        )
        told = {"message": message, "nfev": evaluations, "nsteps": steps}
        return trajectory_of(self.system, (t, q, v, a, lam), status=status, **told)
