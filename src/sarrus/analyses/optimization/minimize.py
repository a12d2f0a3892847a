"""The best design: solvers of nonlinear programs with exact gradients of simulations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from typing import Any

from ...linalg.threads import one_thread_if_small
from ...model.announcement import announce, reports_warnings
from ...results import Optimum
from ...system import System
from ..arguments import refuse_other_system
from ..position.initial_state import Start
from ..sensitivity.combined import Part
from ..sensitivity.parameters.design_start import DesignStart
from .constraint import Within, constraints_of
from .problem import Analysis, Problem, refuse_unknown
from .search import Bounds, Progress, Variables, reporting
from .solvers import solver_of
from .starts import optimum_from_many
from .task import Task


@reports_warnings
@one_thread_if_small
def optimize(
    system: System,
    objective: Part | Sequence[Part],
    wrt: Sequence[str] | None = None,
    *,
    until: float | None = None,
    analysis: Analysis | None = None,
    start: Start | DesignStart | None = None,
    bounds: Bounds | None = None,
    constraints: Within | Sequence[Within] = (),
    scale: Mapping[str, float] | None = None,
    design: Mapping[str, float] | None = None,
    formula: Any = None,
    solver: str | None = None,
    second_order: bool = False,
    iterations: int = 100,
    tolerance: float = 1e-8,
    starts: int = 1,
    seed: int = 0,
    executor: Executor | None = None,
    progress: Progress | None = None,
    total_time_limit: float | None = None,
    **settings: Any,
) -> Optimum:
    """Minimize a response over parameters or design variables, with exact gradients: of a motion or another analysis.

    Every design is assembled and simulated, and its gradient computed by one adjoint sweep. For a design that cannot be
    simulated, the solver receives a large value and steps back; the message is stored.

    Parameters
    ----------
    system : with the design at the start
    objective : the response to be minimized, see `sensitivity`, or `Combined`; of several responses, their sum
    wrt : names of the design variables, see `sensitivity`
    until : end time of the simulation [s]
    analysis : another analysis instead of a simulation, such as `Statics` or `Vibration`, see `Problem`
    start : of every simulation, see `Problem`; by default the model's own state, assembled for every design
    bounds : limits by name, ``{"spring.k": (1, 100), "spring.c": (0, None)}``, or texts with units,
        ``("1 N/m", "2 kN/m")``; a name is one of a variable, or of a part or vector as in `wrt`, whose variables have
        the same limits
    constraints : responses that must stay within limits
    scale : typical sizes of the variables by name, by which they are divided; by default their values at the start
    design, formula : named design variables, and the function that computes parameters of the model from them
    solver : "L-BFGS-B" (the default), "SLSQP" (the default with constraints), "trust-constr", or "IPOPT" (the extra
        `ipopt`)
    second_order : exact second derivatives of objective and constraints: for "trust-constr" products with vectors, for
        "IPOPT" the Hessian of the Lagrangian, one product for each variable and response (for few variables; by
        default it is approximated from gradients)
    iterations, tolerance : limits of the solver; it is started again at the best design until the optimality
        conditions hold to 1e-4, or until this makes no progress
    starts : number of starts: the system's own design, and random designs between the bounds. A random design that
        cannot be simulated is replaced by another one; `Optimum.start_reports` lists the outcome of every start
    seed : of the random designs
    executor : of ``concurrent.futures``, which runs the starts in parallel
    total_time_limit : seconds after which the search ends with the best design so far; `time_limit` in `settings`
        is the limit of each simulation
    progress : called with the number of the simulation and the objective; True for lines on standard error,
        False for no output; by default a line on a terminal and in a notebook
    settings : ``method``, ``events``, ``controllers``, ``memory`` and ``time_limit``, see `Problem`

    Returns
    -------
    Optimum
        ``success`` means that the constraints and the optimality conditions hold, independent of the solver's report:
        ``optimality``, the relative distance from the optimum predicted from gradients, is at most 0.01. The best
        design is returned, also after Ctrl-C.

    Raises
    ------
    ValueError
        If bounds have unknown names, or the solver is unknown.
    SarrusError
        If the first design cannot be simulated.
    """
    refuse_unknown(optimize, settings)
    refuse_other_system(system, "optimize", unset=bool(settings.get("controllers")))
    within = constraints_of(constraints)
    solver_of(solver, bool(within))
    if not tolerance > 0 or iterations < 1:
        raise ValueError(
            f"tolerance and iterations must be greater than 0, but are {tolerance:g} and {iterations}. "
            "Give positive numbers."
        )
    several = isinstance(objective, Sequence) and not isinstance(objective, str)
    objectives: Any = objective if several else [objective]
    responses = [*objectives, *(constraint.response for constraint in within)]
    settings |= {"analysis": analysis, "start": start, "design": design, "formula": formula}
    problem = Problem(system, responses, wrt, until=until, **settings)
    problem.end_after(total_time_limit)
    task = Task(within, solver, iterations, tolerance, second_order)
    variables = Variables(problem.names, problem.x0, bounds, scale, problem.units)
    if starts < 1:
        raise ValueError(f"starts must be 1 at least, but is {starts}. Give a whole number.")
    with reporting(progress) as report:
        if starts == 1:
            best = task.solved(problem, variables, report)
        else:
            best = optimum_from_many(task, problem, variables, starts, seed, executor, report)
    announce(best.warnings)
    return best
