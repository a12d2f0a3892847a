"""Derivatives of driven motions, Φ(q, t) = 0, Φ_q v = -Φ_t, Φ_q a = γ, and of the multipliers that they require."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ....algebra import Array
from ....outputs.motion import states_of
from ....outputs.recording import Angles, States
from ....results import Trajectory
from ....system import System
from ...equations.minimum_norm import multipliers_of
from ...position.assembly_derivatives import NoDerivative
from ..sampling.consistent_states import ConsistentStates, ConsistentSweep
from ..steps.sweep_loop import NodeArrays
from .solved_states import Moves, SolvedStates

AT = 1e-9  # of the time between outputs: nearer to a singular configuration is in it


class DrivenMotion(SolvedStates):
    """The states of a kinematic analysis at some of its times; each is determined by the equations at its time.

    Parameters
    ----------
    system, run : of `kinematics`
    rows : of the run's times
    """

    def __init__(self, system: System, run: Trajectory, rows: Array) -> None:
        super().__init__(system, *states_at(system, run, rows))
        self._run = run

    @cached_property
    def _sweep(self) -> ConsistentSweep:
        steps, none = self.steps, np.zeros(self.steps.q.shape)
        lam = steps.lam.copy()
        for row in np.flatnonzero(steps.left_out.any(axis=1)).tolist():
            lam[row] = self._of_choice(row)
        record = ConsistentStates(
            b=self.system.b, t=steps.t, q=steps.q, v=steps.v, a=steps.a, lam=lam, q0=steps.q, dq=none, dv=none,
            sigma=np.zeros(lam.shape), rho=np.zeros(lam.shape), between=np.ones(len(lam), dtype=bool),
            defined=~self._singular, left_out=steps.left_out.astype(float), places=steps.places, memory=steps.memory,
        )  # fmt: skip
        return ConsistentSweep(self.system, record, moving=False)

    @cached_property
    def _singular(self) -> Array:
        """Which times are those of singular configurations (nt,)."""
        near = AT * float(np.ptp(self._run.t)) if len(self._run.t) > 1 else AT
        gaps = abs(self.steps.t[:, None] - np.array(self._run.singular)[None])
        return np.asarray((gaps <= near).any(axis=1))

    def _of_choice(self, row: int) -> Array:
        """The multipliers of independent equations (m,) with the constraint forces of those reported."""
        steps, b = self.steps, self.system.b.copy()
        b[steps.places] = steps.memory[row]
        chosen = np.flatnonzero(~steps.left_out[row])
        return multipliers_of(self.system, chosen, steps.lam[row], steps.q[row], float(steps.t[row]), b)

    def along(self, moves: Moves) -> NodeArrays:
        found = self._sweep.along({}, moves.b)[0]
        self.shorten(found, moves.b)
        return found

    def gradient(self, by: NodeArrays) -> Moves:
        asked = np.any([x.any(axis=(1, 2)) for x in by], axis=0)
        if np.any(asked & self._singular):
            time = self.steps.t[np.argmax(asked & self._singular)]
            message = f"{self.system.name}: the configuration at t = {time:.6g} s is singular"
            raise NoDerivative(f"{message}, and has no derivatives. Take the response at other times.")
        by_b = self.unshorten(by)
        return self.no_moves()._replace(b=self._sweep.back(by).b + by_b)


def states_at(system: System, run: Trajectory, rows: Array) -> tuple[States, Array, Angles]:
    """The states of a run at some of its times, what elements remember there, and its angles."""
    whole, lam = states_of(run), np.asarray(run.lam)[rows]
    t, q, v, a = (x[rows] for x in whole[:4])
    chosen = States(t, q, v, a, lambda: lam)
    counted = len(run.revolutions) == len(run.t)
    angles = Angles(system, whole, revolutions=run.revolutions if counted else None)
    places = len(system.memory_places)
    memory = (
        run.memory[rows]
        if run.memory.shape[1] == places
        else np.tile(system.b[system.memory_places], (len(rows), 1))
    )
    return chosen, memory, angles
