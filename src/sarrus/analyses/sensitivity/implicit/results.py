"""The equations of each kind of result, and the derivatives of its responses."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import csr_array

from ....algebra import Array
from ....model import SarrusError
from ....results import Modes, StateSpace, Trajectory
from ....system import System
from ....system.curves.curve_derivatives import CurveDerivatives
from ...equations.length import units
from ...equations.nullspace import NullSpace
from ...position.assembly_derivatives import NoDerivative
from ..parameters.parameters import Parameters
from ..responses.responses import Response
from ..sampling.consistent_states import ConsistentStates, ConsistentSweep
from ..steps.sweep_loop import NodeArrays
from .equilibrium_path import EquilibriumPath
from .linearized_state import linearized_state
from .modal import ModesAbout, equilibrium_of
from .responses import ResponsesOfResult
from .rest import RestingState
from .solved_states import Moves, SolvedStates, states_at

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
        steps, none, still = self.steps, np.zeros(self.steps.q.shape), np.zeros(self.steps.lam.shape)
        record = ConsistentStates(
            b=self.system.b, t=steps.t, q=steps.q, v=steps.v, a=steps.a, lam=steps.lam, q0=steps.q, dq=none, dv=none,
            sigma=still, rho=still, between=np.ones(len(steps.t), dtype=bool),
            defined=~self._singular, left_out=steps.left_out.astype(float), places=steps.places, memory=steps.memory,
        )  # fmt: skip
        return ConsistentSweep(self.system, record.of_independent(self.system), moving=False)

    @cached_property
    def _singular(self) -> Array:
        """Which times are those of singular configurations (nt,)."""
        near = AT * float(np.ptp(self._run.t)) if len(self._run.t) > 1 else AT
        gaps = abs(self.steps.t[:, None] - np.array(self._run.singular)[None])
        return np.asarray((gaps <= near).any(axis=1))

    def along(self, moves: Moves) -> NodeArrays:
        return self._sweep.along({}, moves.b)[0]

    def gradient(self, by: NodeArrays) -> Moves:
        asked = np.any([x.any(axis=(1, 2)) for x in by], axis=0)
        if np.any(asked & self._singular):
            time = self.steps.t[np.argmax(asked & self._singular)]
            message = f"{self.system.name}: the configuration at t = {time:.6g} s is singular"
            raise NoDerivative(f"{message}, and has no derivatives. Take the response at other times.")
        return self.no_moves()._replace(b=self._sweep.back(by).b)


class TimePoint(NamedTuple):
    """Φ_q at one time, and the derivatives of Q + S - M a - Φ_qᵀλ by the parameters (nq, len(b))."""

    space: NullSpace
    by_b: csr_array


class RequiredForces(SolvedStates):
    """The states of `inverse_dynamics` at some of its times: the motion is data, the multipliers follow.

    Raises
    ------
    NoDerivative
        If drivers and joints leave a motion free: other forces would change it.
    """

    def __init__(self, system: System, run: Trajectory, rows: Array) -> None:
        super().__init__(system, *states_at(system, run, rows))

    @cached_property
    def _times(self) -> list[TimePoint]:
        return [self._at(n) for n in range(len(self.states.t))]

    def _at(self, n: int) -> TimePoint:
        system, b, curves = self.system, self.system.b.copy(), CurveDerivatives(self.system)
        t, q, v, a, lam = float(self.steps.t[n]), *(getattr(self.steps, x)[n] for x in ("q", "v", "a", "lam"))
        b[system.memory_places] = self.memory[n]
        J = system.Phi_q(q, t, b=b)
        space = NullSpace(J, units(system, q, J))
        if space.Z.shape[1]:
            message = f"{system.name}: drivers and joints leave a motion free at t = {t:.6g} s"
            raise NoDerivative(f"{message}, which other forces would change. Add a driver.")
        own = system.Q_b(q, v, t, b=b) + system.S_b(q, v, b=b) - system.M_a_b(q, a, b=b)
        own = csr_array(own - system.Phi_qT_lam_b(q, lam, t, b=b))
        own.resize((system.nq, len(b)))
        if curves:
            own = own + curves.matrix("Q", b, t, q=q, v=v) - curves.matrix("Phi_qT_lam", b, t, q=q, lam=lam)
        return TimePoint(space, csr_array(own))

    def along(self, moves: Moves) -> NodeArrays:
        found = self.zeros()
        for n, at in enumerate(self._times):
            found.lam[n, :, 0] = at.space.multipliers((at.by_b @ moves.b)[:, 0])
        return found

    def gradient(self, by: NodeArrays) -> Moves:
        moves = self.no_moves()
        for n in np.flatnonzero(by.lam.any(axis=(1, 2))).tolist():
            at = self._times[n]
            moves.b[:] += at.by_b.T @ at.space.change(by.lam[n])
        return moves


MOTIONS: dict[str, type[DrivenMotion | RequiredForces | EquilibriumPath]] = {
    "kinematics": DrivenMotion,
    "inverse dynamics": RequiredForces,
    "equilibria": EquilibriumPath,
}


def responses_of_result(
    result: Any, responses: Sequence[Response], parameters: Callable[[System], Parameters]
) -> ResponsesOfResult:
    """Responses of a result with their derivatives by the parameters of its system.

    Raises
    ------
    ValueError
        If the analysis failed.
    SarrusError
        For a result without its system.
    """
    if not result.success:
        raise ValueError(f"derivatives need an analysis that succeeded, but {result.name}: {result.message}")
    system = result.system
    if system is None:
        raise SarrusError(
            f"{result.name}: derivatives need the system of this result. Run the analysis again."
        )
    t = result.t if isinstance(result, Trajectory) else np.array([float(result.t)])

    def solved(rows: Array) -> SolvedStates:
        return _states(system, result, rows)

    return ResponsesOfResult(system, result.name, t, solved, responses, parameters(system))


def _states(system: System, result: Any, rows: Array) -> SolvedStates:
    if isinstance(result, Trajectory):
        return MOTIONS[result.analysis](system, result, rows)
    if isinstance(result, StateSpace):
        return linearized_state(system, result)
    if not isinstance(result, Modes):
        return RestingState(system, result)
    state = RestingState(system, equilibrium_of(result))
    state.about = ModesAbout(state, result)
    return state
