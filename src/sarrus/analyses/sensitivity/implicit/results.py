"""The equations of each kind of result, and the derivatives of its responses."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ....algebra import Array
from ....model import SarrusError
from ....results import Equilibrium, Modes, StateSpace, Trajectory
from ....system import System
from ..parameters.parameters import Parameters
from ..responses.responses import Response
from .driven_motion import DrivenMotion
from .linearized_state import linearized_state
from .modal import ModesAbout, equilibrium_of
from .required_forces import RequiredForces
from .responses import ResponsesOfResult
from .rest import RestingState
from .solved_states import SolvedStates

MOTIONS = {"kinematics": DrivenMotion, "inverse dynamics": RequiredForces}


def is_solved(result: Any) -> bool:
    """Whether this is a result that equations determine, and not a simulated run."""
    return isinstance(result, Equilibrium | Modes | StateSpace) or getattr(result, "analysis", "") in MOTIONS


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
