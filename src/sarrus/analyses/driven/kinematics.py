"""Kinematic analysis: the motion of a system whose drivers leave it no freedom."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ...algebra import Array
from ...linalg.threads import one_thread_if_small
from ...model.announcement import reports_warnings
from ...results import State, Trajectory
from ...system import System
from ..arguments import refuse_for_positions
from ..dynamics.dense_output.winding import Winding
from ..dynamics.stepping.nodes import Nodes
from ..equations.constraint_projection import onto
from ..equations.length import lever
from ..equations.nullspace import NullSpace
from ..equations.recorded_state import RecordedState, histories, recorded_state
from ..position.initial_state import Given, Start, state_of
from ..position.prescribed_angles import prescribed_revolutions
from ..progress import Progress, TimeLimit, monitor
from .branching import branching_time
from .inverse_dynamics import multipliers
from .lockup import fold_time, involved, last_before
from .steps import Instant, Path

OUTPUTS = 1001  # times by default
SHORTEST = 1e-6  # of a grid interval: steps are halved down to this before a lock-up is looked for
OVER_TIME = "positions follow from velocities over time. Call simulate, with the same drivers."


@reports_warnings
@one_thread_if_small
def kinematics(
    system: System,
    times: ArrayLike | None = None,
    q: Start | None = None,
    *,
    until: float | None = None,
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
    until : end time of 1001 times from 0, instead of `times` [s]
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
        np.asarray(np.linspace(0.0, until or 0.0, OUTPUTS) if times is None else times, float)
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
        self.system, self.grid, self.guess = system, grid, start.q
        self.path = Path(system, start.q)
        self.path.b[:] = start._replace(t=float(grid[0])).parameters(system)
        self.winding = Winding(system)
        self.last: Instant | None = None
        self.winding.begin(start.q, start.revolutions)
        self._rows: list[tuple[Instant, Array, RecordedState, Array, Array]] = []
        self.singular: list[float] = []
        self.status, self.message, self.steps = "finished", "reached the end", 0

    def go(self, progress: Progress) -> None:
        """All times, or as many as can be reached and are allowed."""
        try:
            self._go(progress)
        except KeyboardInterrupt:
            self._fail("stopped", f"stopped by the user {self._after()}")
        except TimeLimit as over:
            self._fail("time limit", f"{over} {self._after()}")

    def _after(self) -> str:
        return f"after t = {self._rows[-1][0].t:.6g} s" if self._rows else "at the start"

    def _go(self, progress: Progress) -> None:
        now = self._start(float(self.grid[0]))
        for target in self.grid[1:]:
            if now is None:
                return
            now = self._advance(now, float(target))
            if now is not None:
                progress(now.t)

    def _start(self, t: float) -> Instant | None:
        q, reached = onto(self.system, self.guess, t, b=self.path.b)
        self.winding.begin(q, prescribed_revolutions(self.system, q, t, self.winding.first))
        now = self.path.instant(t, q) if reached and self._determined(t, q) else None
        if now is not None:
            return self._keep(now)
        if not reached:
            self._fail("not assembled", self._open(t, q))
        else:
            self._fail("not fully driven", self._free(t, q))
        return None

    def _determined(self, t: float, q: Array) -> bool:
        return self.path.choose_rows(t, q) == self.system.nq

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

    def _advance(self, now: Instant, target: float) -> Instant | None:
        interval = h = target - now.t
        while now.t < target:
            t = target if h >= 0.999 * (target - now.t) else now.t + h
            found = self.path.step(now, t)
            if found is not None and found.sign * now.sign >= 0:
                now, h = self._accept(found), 2 * h
            elif found is not None and (crossed := self._cross(now, found)):
                now, h = crossed, 2 * h
            elif h > SHORTEST * interval:
                h *= 0.5
            else:
                bridged = self._bridge(now, target)
                if bridged is None:
                    self._lock(now, h, target)
                    return None
                now, h = bridged, interval
        return self._keep(now)

    def _accept(self, now: Instant) -> Instant:
        self.system.remember(now.q, self.path.b, now.t)
        self._count_revolutions(now)
        self.steps += 1
        return now

    def _count_revolutions(self, now: Instant) -> None:
        """Count revolutions from the last state to this one."""
        pair = [self.last or now, now]
        t, q, v = (np.array([getattr(one, name) for one in pair]) for name in ("t", "q", "v"))
        none = np.zeros((2, 0))
        self.winding.take(Nodes(t, q, v, none, none, none), t[:0], q[:0], v[:0])
        self.last = now

    def _cross(self, now: Instant, found: Instant) -> Instant | None:
        """Note where the motion could have branched; nothing, if the step was a leap to another branch."""
        time = branching_time(self.path, now, found)
        if time is None:
            return None
        self.singular.append(time)
        return self._accept(found)

    def _bridge(self, now: Instant, target: float) -> Instant | None:
        """Over a time of the grid on which the configuration is singular."""
        found = self.path.bridge(now, target)
        if found is not None:
            self.singular.append(target)
            self._accept(found)
        return found

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

    def _keep(self, now: Instant) -> Instant:
        lam = self._multipliers(now)
        if self.last is None:
            self._count_revolutions(now)
        recorded = recorded_state(self.system, now.t, now.q, now.v, self.path.b)
        memory = self.path.b[self.system.memory_places]
        revolutions = self.system.joint_coordinates.revolutions(self.winding.values, now.q)
        self._rows.append((now, lam, recorded, memory, revolutions))
        return now

    def _multipliers(self, now: Instant) -> Array:
        """Return the multipliers of the motion; with redundant equations, those of minimum norm."""
        system, b, factors = self.system, self.path.b, now.factors
        if factors is None or now.sign == 0 or not factors.is_whole:
            return multipliers(system, now.q, now.v, now.a, now.t, b=b).lam
        force = system.Q(now.q, now.v, now.t, b=b) + system.S(now.q, now.v, b=b)
        return factors.transposed(force - system.M_a(now.q, now.a, b=b))

    def trajectory(self) -> Trajectory:
        """All that was reached."""
        nq, m = self.system.nq, self.system.m
        places, joints = len(self.system.memory_places), self.system.joint_coordinates.m
        shapes = ((), (nq,), (nq,), (nq,), (m,), (places,), (joints,))
        rows = [(*now[:4], lam, memory, revolutions) for now, lam, _, memory, revolutions in self._rows]
        columns = list(zip(*rows, strict=True)) if rows else [()] * len(shapes)
        t, q, v, a, lam, memory, revolutions = (
            np.array(c, dtype=float).reshape(len(c), *s) for c, s in zip(columns, shapes, strict=True)
        )
        if self.singular and self.status == "finished":
            times = ", ".join(f"{t:.9g}" for t in self.singular)
            self.message += f"; it could have branched at t = {times} s, where the constraints are dependent"
        return Trajectory(
            self.system.name,
            tuple(self.system.bodies),
            tuple(self.system.coordinate_names),
            *(t, q, v, a, lam),
            **histories([state for _, _, state, *_ in self._rows]),
            success=self.status == "finished",
            status=self.status,
            message=self.message,
            nfev=self.path.iterations,
            nsteps=self.steps,
            joints=self.system.joint_coordinates,
            singular=tuple(self.singular),
            system=self.system,
            memory=memory,
            revolutions=revolutions,
            final=State(float(t[-1]), q[-1], v[-1], a[-1], lam[-1], memory[-1], revolutions[-1])
            if len(t)
            else None,
        )
