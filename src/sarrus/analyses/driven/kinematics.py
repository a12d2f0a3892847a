"""Kinematic analysis: the motion of a system whose drivers leave it no freedom."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import BPoly
from scipy.sparse import block_array, csr_array

from ...algebra import Array
from ...linalg.factors import LUFactors, SingularSystem
from ...linalg.threads import one_thread_if_small
from ...model.announcement import announce, reports_warnings
from ...results import State, Trajectory
from ...system import System
from ...system.curves.curve_potentials import curve_potentials
from ..arguments import refuse_for_positions
from ..dynamics.dense_output.sampler import samples_at
from ..dynamics.inputs.prescribed_motions import refuse_infinite_motions
from ..equations.length import units
from ..equations.nullspace import NullSpace
from ..equations.projection import largest, onto
from ..equations.table_ranges import announce_left_ranges
from ..position.assembly_changes import position_changes, warning
from ..position.initial_state import PartialState, Start, contradicting, state_of
from ..position.prescribed_angles import prescribed_revolutions
from ..progress import Progress, TimeLimit, monitor
from ..redundancy.redundant_constraints import named_rows
from .inverse_dynamics import multipliers
from .motion_loop import CROSSED, PAUSED
from .steps import Instant, Path

STEPS = 1000  # intervals by default
OVER_TIME = "positions follow from velocities over time. Call simulate, with the same drivers."
HALVINGS = 40
ROOT_STEPS = 10  # of Newton's method for a fold or a branching, and the length of the last one
SETTLED = 1e-10
PERTURBATION = 1e-9  # of Φ: what a true branching does not need
FINE = 1e-5  # length of the last step, relative to the first
ROUND_OFF = 1e-14  # of a time: a step so short is none


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
    refuse_infinite_motions(system, float(grid[0]), float(grid[-1]))
    run = _Run(system, grid, state_of(system, system.q0 if q is None else q))
    with monitor(progress, float(grid[-1]), done="analysed", time_limit=time_limit) as report:
        run.go(report)
    return run.trajectory()


class _Run:
    """State of one kinematic analysis."""

    def __init__(self, system: System, grid: Array, start: PartialState) -> None:
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
        self.path.begin(first, self.system.counted_coordinates.revolutions(winding.values, first.q))
        if first.sign == 0:
            self._shortest_multipliers(first, 0)
        return True

    def _shortest_multipliers(self, singular: Instant, n: int) -> None:
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
        Z = NullSpace(J, units(self.system, q, J)).Z
        most = self.system.coordinate_names[int(np.argmax((Z * Z).sum(axis=1)))]
        count = f"{Z.shape[1]} degree{'s' if Z.shape[1] > 1 else ''} of freedom"
        return (
            f"{self.system.name} keeps {count} at t = {t:.6g} s, {most} among them. Add a driver for each, "
            "or start away from a singular configuration"
        )

    def _cross(self) -> bool:
        """Note where the motion could have branched; or shorten the step, if it was a leap to another branch."""
        before, after = self.path.now, self.path.found
        time = branching_time(self.path, before, after)
        if time is not None:
            self.singular.append(time)
            after = self.path.step(before, after.t) or after  # its factors
        self.path.decide(None if time is None else after)
        return True

    def _bridge(self) -> bool:
        """Whether the motion can go on over a time of the grid on which the configuration is singular."""
        now, target = self.path.now, float(self.grid[self.count])
        instant = self.path.bridge(now, target)
        if instant is None:
            self._lock(now, float(self.path.control.h), target)
            return False
        self.singular.append(target)
        self.path.decide(instant)
        self._shortest_multipliers(instant, self.count)
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
        t, q, v, a, lam, violation, energy, _, memory, revolutions = (x[: self.count] for x in self.out)
        announce_left_ranges(self.system, self.path.b, t, q, v, memory)
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


def branching_time(path: Path, before: Instant, after: Instant) -> float | None:
    """The time between two states at which the motion could branch; nothing, if only the step was wrong.

    Bisection along the quintic through both states gives the start for Newton's method; see `_residual`.
    """
    between = BPoly.from_derivatives(
        [before.t, after.t], [[before.q, before.v, before.a], [after.q, after.v, after.a]]
    )
    low, high = before.t, after.t
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _sign(path, middle, between(middle)) == before.sign else (low, middle)
    return _polished(path, low, between(low), after.t - before.t)


def _sign(path: Path, t: float, q: Array) -> float:
    try:
        return path.sign(t, q)
    except SingularSystem:
        return 0.0


def _polished(path: Path, t: float, q: Array, interval: float) -> float | None:
    """Newton's method on the four equations of `_residual`, from the multipliers of the smallest singular value."""
    try:
        u = path.weakest(t, q)[1]
        u, n, near = u / np.linalg.norm(u), len(q), t
        x = np.concatenate([q, u[path.rows], [t, 0.0]])
        for _ in range(ROOT_STEPS):
            step = LUFactors(_matrix(path, x[:n], x[n:-2], x[-2], x[-1])).solve(
                -_residual(path, x[:n], x[n:-2], x[-2], x[-1])
            )
            x = x + step
            if largest(step) <= SETTLED:
                close = abs(x[-2] - near) <= interval and abs(x[-1]) <= PERTURBATION
                return float(x[-2]) if close else None
    except SingularSystem:
        pass
    return None


def _all(path: Path, u: Array) -> Array:
    lam = np.zeros(path.system.m)
    lam[path.rows] = u
    return lam


def _residual(path: Path, q: Array, u: Array, t: float, e: float) -> Array:
    """Φ + e u = 0, Φ_qᵀ u = 0, uᵀ Φ_t = 0, uᵀu = 1, with e = 0 in the solution: regular where two branches cross."""
    system, b, rows = path.system, path.b, path.rows
    Phi, Phi_t = system.Phi(q, t, b=b)[rows], system.Phi_t(q, t, b=b)[rows]
    force = system.Phi_qT_lam(q, _all(path, u), t, b=b)
    return np.concatenate([Phi + e * u, force, [u @ Phi_t, 0.5 * (u @ u - 1)]])


def _matrix(path: Path, q: Array, u: Array, t: float, e: float) -> csr_array:
    """The exact derivative of `_residual`; Φ_tq is -½ γ_v at rest."""
    system, b, rows = path.system, path.b, path.rows
    J, H = system.Phi_q(q, t, b=b)[rows], system.Phi_qT_lam_q(q, _all(path, u), t, b=b)
    J_t = -0.5 * system.gamma_v(q, np.zeros_like(q), t, b=b)[rows]
    Phi_t, Phi_tt = system.Phi_t(q, t, b=b)[rows], system.Phi_tt(q, t, b=b)[rows]
    turn = csr_array((J_t.T @ u)[:, None])
    by_t, by_e = csr_array(Phi_t[:, None]), csr_array(u[:, None])
    last = csr_array([[u @ Phi_tt]])
    return block_array(
        [
            [J, e * csr_array(np.eye(len(u))), by_t, by_e],
            [H, J.T, turn, None],
            [turn.T, by_t.T, last, None],
            [None, by_e.T, None, csr_array((1, 1))],
        ]
    ).tocsc()


def last_before(path: Path, before: Instant, h: float) -> Instant:
    """The last state that can be reached: steps are halved until nothing is gained, `h` long at first."""
    shortest = max(FINE * h, ROUND_OFF * abs(before.t))
    while h > shortest:
        instant = path.step(before, before.t + h)
        if instant is not None and instant.sign == before.sign:
            before = instant
        else:
            h *= 0.5
    return before


def fold_time(path: Path, near: Instant) -> float | None:
    """The time of reversal, by Newton's method on Φ = 0, Φ_q w = 0, wᵀw₀ = 1.

    With the exact (Φ_q w)_q and (Φ_q w)_t the answer is exact to round-off; nothing, if there is no simple fold nearby.
    """
    try:
        _, _, w0 = path.weakest(near.t, near.q)
        t, q, w = near.t, near.q, w0
        for _ in range(ROOT_STEPS):
            step = LUFactors(_fold_matrix(path, t, q, w, w0)).solve(-_fold_residual(path, t, q, w, w0))
            q, w, t = q + step[: len(q)], w + step[len(q) : -1], t + step[-1]
            if largest(step / np.append(np.tile(path.unit, 2), 1.0)) <= SETTLED:
                return float(t)
    except SingularSystem:
        return None
    return None


def _fold_residual(path: Path, t: float, q: Array, w: Array, w0: Array) -> Array:
    system, b = path.system, path.b
    stretch = system.Phi_q_xi(q, w, t, b=b)[path.rows]
    return np.concatenate([system.Phi(q, t, b=b)[path.rows], stretch, [(w0 / path.unit**2) @ w - 1]])


def _fold_matrix(path: Path, t: float, q: Array, w: Array, w0: Array) -> csr_array:
    system, b, rows = path.system, path.b, path.rows
    J, bend = system.Phi_q(q, t, b=b)[rows], system.Phi_q_xi_q(q, w, t, b=b)[rows]
    Phi_t, J_w_t = system.Phi_t(q, t, b=b)[rows], system.Phi_q_xi_t(q, w, t, b=b)[rows]
    line = csr_array((w0 / path.unit**2)[None, :])
    return block_array(
        [[J, None, csr_array(Phi_t[:, None])], [bend, J, csr_array(J_w_t[:, None])], [None, line, None]]
    ).tocsc()


def involved(path: Path, near: Instant) -> str:
    """The joints whose equations become dependent there, those with the largest shares first, and these equations."""
    rows_of_joints = dict[str, list[str]]()
    for n in named_rows(path.system, abs(path.weakest(near.t, near.q)[1])):
        joint, row = path.system.row_names[n].split(": ", 1)
        rows_of_joints.setdefault(joint, []).append(row)
    return ", ".join(f"{joint} ({', '.join(rows)})" for joint, rows in rows_of_joints.items())
