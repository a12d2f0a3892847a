"""Kinematic analysis: the motion of a system whose drivers leave it no freedom."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ...algebra import Array
from ...linalg.threads import one_thread_if_small
from ...model.announcement import announce, reports_warnings
from ...results import State, Trajectory
from ...system import System
from ...system.curves.curve_potentials import curve_potentials
from ..arguments import refuse_for_positions
from ..dynamics.dense_output.sampler import samples_at
from ..equations.length import lever
from ..equations.nullspace import NullSpace
from ..equations.projection.constraint_projection import onto
from ..equations.table_ranges import TableRanges
from ..position.assembly_changes import position_changes, warning
from ..position.initial_state import Given, Start, contradicting, state_of
from ..position.prescribed_angles import prescribed_revolutions
from ..progress import Progress, TimeLimit, monitor
from .branching import branching_time
from .inverse_dynamics import multipliers
from .lockup import fold_time, involved, last_before
from .motion_loop import CROSSED, PAUSED
from .steps import Instant, Path

STEPS = 1000  # intervals by default
OVER_TIME = "positions follow from velocities over time. Call simulate, with the same drivers."


@reports_warnings
@one_thread_if_small
def kinematics(
    system: System,
    times: ArrayLike | None = None,
    q: Start | None = None,
    *,
    until: float | None = None,
    steps: int = STEPS,
    progress: bool | Progress | None = None,
    time_limit: float | None = None,
    strict: bool = False,
) -> Trajectory:
    """Compute the motion that the drivers prescribe, and the forces that it requires.

    Φ(q, t) = 0, Φ_q v = -Φ_t and Φ_q a = γ, Eqs. (2) to (4), each with the exact Jacobian. From one time to the next, q
    is predicted by v and a, and corrected by Newton's method; if it fails, the step is halved. Consistent redundant
    equations are allowed. Inverse dynamics gives `lam`.

    Parameters
    ----------
    system : System
    times : (nt,) output times, increasing [s]
    until, steps : end time [s] and number of equal intervals from 0, instead of `times`
    q : (nq,) the estimate of the position at the first time, or an `Assembly`, a `State` or an
        `Equilibrium`; by default the model's
    progress : True for a bar on standard error, or a function of the time reached
    time_limit : seconds of the clock after which the analysis ends with the status "time limit"
    strict : raise the first warning as a `StrictError`

    Returns
    -------
    Trajectory
        With ``success`` false if the motion ends before the last time: ``status`` is then "lock-up", "not fully
        driven" or "not assembled", and ``message`` contains the time and the equations. Times at which the motion
        passes a singular configuration, where it could branch, are in ``singular``. After `time_limit` and Ctrl-C the
        status is "time limit" or "stopped", and the result has the times before.

    Raises
    ------
    ValueError
        If the times do not increase.
    """
    if (times is None) == (until is None):
        raise TypeError("kinematics: give the times, or until=2.0 for 1001 times from 0 to 2 s.")
    grid = np.atleast_1d(
        np.asarray(np.linspace(0.0, until or 0.0, steps + 1) if times is None else times, float)
    )
    if grid.ndim != 1 or not grid.size or np.any(np.diff(grid) <= 0) or not np.all(np.isfinite(grid)):
        raise ValueError("times must be rising numbers. Give at least one, in s.")
    refuse_for_positions(system, "kinematics", OVER_TIME)
    run = _Run(system, grid, state_of(system, system.q0 if q is None else q))
    with monitor(progress, float(grid[-1]), done="analysed", time_limit=time_limit) as report:
        run.go(report)
    return run.trajectory()


class _Run:
    """State of one kinematic analysis."""

    def __init__(self, system: System, grid: Array, start: Given) -> None:
        self.system, self.grid, self.start = system, grid, start
        self.path = Path(system, start.q)
        self.path.b[:] = start._replace(t=float(grid[0])).parameters(system)
        self.out = samples_at(system, grid)
        self.singular: list[float] = []
        self.status, self.message = "finished", "reached the end"

    @property
    def count(self) -> int:
        """How many times have been reached."""
        return int(self.path.control.next)

    def go(self, progress: Progress) -> None:
        """All times, or as many as can be reached and are allowed."""
        try:
            if self._begin(float(self.grid[0])):
                self._go_on(progress)
        except KeyboardInterrupt:
            self._fail("stopped", f"stopped by the user {self._after()}")
        except TimeLimit as over:
            self._fail("time limit", f"{over} {self._after()}")

    def _after(self) -> str:
        return f"after t = {self.grid[self.count - 1]:.6g} s" if self.count else "at the start"

    def _begin(self, t: float) -> bool:
        """Whether the first state could be found."""
        q, reached = onto(self.system, self.start.q, t, b=self.path.b)
        if reached and t == 0.0 and np.array_equal(self.start.q, self.system.q0):
            announce(warning(self.system, tuple(position_changes(self.system, self.start.q, q))))
        winding = self.path.winding
        winding.begin(q, prescribed_revolutions(self.system, q, t, self.start.revolutions))
        if not reached:
            self._fail("not assembled", self._open(t, q))
            return False
        first = self.path.instant(t, q) if self.path.choose_rows(t, q) else None
        if first is None:
            self._fail("not fully driven", self._free(t, q))
            return False
        if (wrong := contradicting(self.system, first.q, first.v, t)).any():
            rows = ", ".join(self.system.row_names[n] for n in np.flatnonzero(wrong)[:3])
            self._fail(
                "not assembled",
                f"{self.system.name}: at t = {t:.6g} s no velocity satisfies all equations; missed: {rows}. "
                "Remove a driver or joint that contradicts others",
            )
            return False
        self.path.begin(first, self.system.joint_coordinates.revolutions(winding.values, first.q))
        if first.sign == 0:
            self._shortest_multipliers(first, 0)
        return True

    def _shortest_multipliers(self, singular: Instant, n: int) -> None:
        """Of a singular configuration."""
        self.out.lam[n] = multipliers(self.system, *singular[1:4], singular.t, b=self.path.b).lam

    def _go_on(self, progress: Progress) -> None:
        while self.count < len(self.grid):
            outcome = self.path.advance(self.out)
            if outcome == PAUSED:
                progress(float(self.grid[self.count - 1]))
            elif not self.path.renew_rows() and not (self._cross() if outcome == CROSSED else self._bridge()):
                return

    def _open(self, t: float, q: Array) -> str:
        residual = self.system.Phi(q, t)
        worst = np.argsort(-abs(residual))[:3]
        rows = ", ".join(f"{self.system.row_names[n]} by {residual[n]:.3g}" for n in worst)
        return (
            f"{self.system.name} could not be assembled at t = {t:.6g} s; still open: {rows}. "
            "Start from coordinates nearer to the assembled ones"
        )

    def _free(self, t: float, q: Array) -> str:
        J = self.system.Phi_q(q, t)
        Z = NullSpace(J, lever(self.system, q, J)).Z
        most = self.system.coordinate_names[int(np.argmax((Z * Z).sum(axis=1)))]
        count = f"{Z.shape[1]} degree{'s' if Z.shape[1] > 1 else ''} of freedom"
        return (
            f"{self.system.name} keeps {count} at t = {t:.6g} s, {most} among them. Add a driver for each, "
            "or start away from a singular configuration"
        )

    def _cross(self) -> bool:
        """Note where the motion could have branched; or shorten the step, if it was a leap to another branch."""
        before, found = self.path.now, self.path.found
        time = branching_time(self.path, before, found)
        if time is not None:
            self.singular.append(time)
            found = self.path.step(before, found.t) or found  # its factors
        self.path.decide(None if time is None else found)
        return True

    def _bridge(self) -> bool:
        """Whether the motion can go on over a time of the grid on which the configuration is singular."""
        now, target = self.path.now, float(self.grid[self.count])
        found = self.path.bridge(now, target)
        if found is None:
            self._lock(now, float(self.path.control.h), target)
            return False
        self.singular.append(target)
        self.path.decide(found)
        self._shortest_multipliers(found, self.count)
        return True

    def _lock(self, now: Instant, h: float, target: float) -> None:
        near = last_before(self.path, now, h)
        fold = fold_time(self.path, near)
        t = fold if fold is not None and near.t - h <= fold <= target else near.t
        self._fail(
            "lock-up",
            f"{self.system.name} locks at t = {t:.9g} s: its drivers ask for more than it can reach; these equations "
            f"become dependent: {involved(self.path, near)}",
        )

    def _fail(self, status: str, message: str) -> None:
        self.status, self.message = status, message

    def trajectory(self) -> Trajectory:
        """All that was reached."""
        t, q, v, a, lam, violation, energy, _, memory, revolutions = (x[: self.count] for x in self.out)
        TableRanges(self.system).look(self.path.b, t, q, v, memory)
        remembered = dict(zip(self.system.memory_places.tolist(), memory.T, strict=True))
        potential = energy[:, 1] + curve_potentials(self.system.populations, self.path.b, remembered, t, q)
        if self.singular and self.status == "finished":
            times = ", ".join(f"{t:.9g}" for t in self.singular)
            self.message += f"; it could have branched at t = {times} s, where the constraints are dependent"
        return Trajectory(
            self.system.name,
            tuple(self.system.bodies),
            tuple(self.system.coordinate_names),
            *(t, q, v, a, lam),
            violation=violation[:, 0],
            velocity_violation=violation[:, 1],
            kinetic_energy=energy[:, 0],
            potential_energy=potential,
            success=self.status == "finished",
            status=self.status,
            message=self.message,
            nfev=int(self.path.control.iterations),
            nsteps=int(self.path.control.steps),
            joints=self.system.joint_coordinates,
            singular=tuple(self.singular),
            system=self.system,
            memory=memory,
            revolutions=revolutions,
            final=State(float(t[-1]), q[-1], v[-1], a[-1], lam[-1], memory[-1], revolutions[-1])
            if len(t)
            else None,
            analysis="kinematics",
        )
