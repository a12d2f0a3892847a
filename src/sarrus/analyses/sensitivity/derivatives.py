"""Derivatives of responses of a run with respect to named numbers: forward (direct) or backward (adjoint)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from ...activity import activity, for_seconds
from ...algebra import Array
from ...linalg.threads import one_thread_if_small
from ...model.announcement import collecting, reports_warnings
from ...outputs import find_output
from ...results import (
    Equilibrium,
    ErrorEstimate,
    Gradient,
    Modes,
    Segments,
    StateDerivatives,
    StateSpace,
    StepsTaken,
    Trajectory,
)
from ...system import System
from ..dynamics import simulate
from ..dynamics.former_options import accepts_former_options
from ..dynamics.integrators.differentiable import Differentiable
from ..dynamics.run_options import Events
from ..position.initial_state import Start
from ..progress import Progress
from .chain.chain import Nodes
from .checkpoints import repeated_gradient
from .combined import Composite
from .gradients import (
    Method,
    Wanted,
    differentiated,
    errors_of,
    is_solved,
    refuse_failed,
    run_parameters,
    stored,
    within,
)
from .implicit.results import responses_of_result
from .long_run import repeated_recipe
from .parameters.contradictions import refuse
from .parameters.parameters import Design, Parameters
from .responses.evaluation import Evaluation
from .responses.responses import Final
from .responses.undefined import refuse_undefined
from .run_chain import RunChain
from .sampling.consistent import ConsistentSampling
from .sampling.reported import Reporter
from .sampling.sampling import Sampling, apart
from .sampling.segments import Instants, course_of, nodes_of
from .steps.sweep_loop import NodeArrays

METHODS = ("adjoint", "direct")


def at_all_times(steps: StepsTaken | Segments) -> Instants:
    """The ends of all steps, and both sides of every event, as times that stay where they are.

    Only the end of a run moves with the event that ended it, as in a response at that time.
    """
    where = nodes_of(course_of(steps))
    where.part[:-1] = np.nan
    return where


def reported_along(system: System, steps: StepsTaken | Segments, nodes: Nodes, b: Array) -> NodeArrays:
    """The changes of q, v, a and λ there (n, nq or m, k), with those of all nodes and of the numbers (len(b), k)."""
    if not isinstance(steps, Segments) and not apart(steps):
        reported = Reporter(system, steps)
        return NodeArrays(nodes.q, nodes.v, nodes.a, reported.along(nodes, b, reported.times(nodes.shift)))
    consistent = ConsistentSampling(system, steps, Sampling(steps, at_all_times(steps)))
    columns = [consistent.along(nodes, b[:, k : k + 1], k).found for k in range(b.shape[1])]
    return NodeArrays._make(np.concatenate(x, axis=2) for x in zip(*columns, strict=True))


@reports_warnings
@one_thread_if_small
def sensitivity(
    run: Trajectory | Equilibrium | Modes | StateSpace,
    responses: Wanted,
    wrt: Sequence[str] | None = None,
    *,
    method: Method = "adjoint",
    design: Mapping[str, float] | None = None,
    formula: Design | None = None,
    memory: float | str | None = None,
    progress: bool | Progress | None = None,
    time_limit: float | None = None,
    error: bool = False,
) -> Gradient:
    """Compute the derivatives of responses of a result with respect to parameters.

    Those of a simulated run are exact for the computed steps. Those of other analyses follow from their equations by
    the implicit function theorem.

    Parameters
    ----------
    run : from ``simulate(..., store="steps")``, or from `simulate` with `memory`; from `kinematics`,
        `inverse_dynamics`, `equilibrium`, `modes` or `linearize`
    responses : one or several of `Final`, `At`, `Integral`, `Maximum`, `Minimum`, `Misfit`, `AtEvent`,
        `Combined`; formulas such as ``"max(slider.x) - min(slider.x)"``, in which an output without a reduction is its
        final value; or functions of `Outputs`, of final values
    wrt : names of parameters, ``spring.k``, ``pin.point`` (all three), ``rod.inertia.xx``, parameters of the model
        file, design variables; by default all parameters of the model, or all design variables
    method : "adjoint": one sweep backwards, or one solution, for all parameters. "direct": one forwards for each
        parameter, for few parameters and many responses
    design : values of design variables by name
    formula : a function of the design variables that returns parameters of the model by name; differentiated exactly
    memory : for a run that stored no steps, which is repeated: the limit for checkpoints, events, and the steps between
        two checkpoints [bytes], ``"500 MB"``; the steps are then computed twice. By the adjoint method only,
        and without `error`
    progress : True for a bar on standard error, or a function of the stages that are done: responses, sweep; with
        `memory` of the simulated time, forwards and backwards: it goes to twice the end
    time_limit : limit in seconds, checked between these stages; a sweep is one compiled call, which cannot be
        interrupted. With `memory` it is checked after every few steps
    error : whether the errors of the responses are estimated, too (`Gradient.errors`, see `Trajectory.error`)

    Returns
    -------
    Gradient
        NaN for parameters whose change alone makes the constraints contradict each other (`Gradient.undefined`)

    Raises
    ------
    ValueError
        If the run stored no steps, or failed, for a response that is not a number or whose derivative is infinite,
        where the time limit has passed, and where the memory is too small.
    SarrusError
        For names that the model does not have.
    """
    if method not in METHODS:
        raise ValueError(
            f"method must be {' or '.join(map(repr, METHODS))}, but is {method!r}. Choose one of them."
        )
    outer = Composite(responses)
    if is_solved(run):

        def parameters_of(own: System) -> Parameters:
            return Parameters(own, wrt, design=design, formula=formula)

        solved = responses_of_result(run, outer.parts, parameters_of)
        refuse_undefined((one.title for one in outer.parts), solved.values)
        return outer.gradient(solved.gradient(method), solved.system)
    if memory is not None and isinstance(run, Trajectory) and not run.steps:
        return _of_repeated(
            run, outer, method, float(memory), progress, time_limit, error, wrt, design, formula
        )
    system, steps = stored(run)
    assert isinstance(run, Trajectory)
    with within(run.name, progress, 2, "differentiated", " stages", time_limit) as report:
        parameters = run_parameters(run, system, steps.start, wrt, design, formula)
        evaluation = Evaluation(system, steps, outer.parts, parameters)
        report(1)
        found = differentiated(system, steps, outer.parts, parameters, method, evaluation, error)
        report(2)
    return outer.gradient(found, system)


def _of_repeated(
    run: Trajectory, outer: Composite, method: Method, memory: float, progress: bool | Progress | None,
    time_limit: float | None, error: bool, *asked: Any,
) -> Gradient:  # fmt: skip
    """The gradient of a run that stored no steps."""
    refuse_failed(run)
    if method != "adjoint" or error:
        raise ValueError(
            f'{run.name}: memory= needs method="adjoint", and error=False. Leave out both, or store the steps.'
        )
    with within(run.name, progress, 2 * float(run.t[-1]), "differentiated", " s", time_limit) as report:
        with collecting():  # its warnings are those of the run
            recipe = repeated_recipe(run)
        parameters = run_parameters(run, recipe.system, recipe.start, *asked)
        found = repeated_gradient(recipe, outer.parts, parameters, memory, progress=report)
    return outer.gradient(found, recipe.system)


@reports_warnings
@one_thread_if_small
def error_estimates(run: Trajectory, responses: Wanted) -> tuple[ErrorEstimate, ...]:
    """The errors of responses of a run with stored steps; see `Trajectory.error`."""
    with activity(for_seconds("estimating errors")):
        (system, steps), outer = stored(run), Composite(responses)
        parameters = run_parameters(run, system, steps.start, (), None, None)
        evaluation = Evaluation(system, steps, outer.parts, parameters)
        refuse_undefined((one.title for one in outer.parts), evaluation.values)
        return errors_of(outer, evaluation, RunChain(system, steps, parameters.of_run))


def response_values(run: Trajectory, responses: Wanted) -> Array:
    """The values of responses of a run with stored steps (r,), without derivatives."""
    (system, steps), outer = stored(run), Composite(responses)
    parameters = run_parameters(run, system, steps.start, (), None, None)
    return outer.values(Evaluation(system, steps, outer.parts, parameters).values)


@reports_warnings
@one_thread_if_small
def state_derivatives(
    run: Trajectory,
    wrt: Sequence[str],
    *,
    design: Mapping[str, float] | None = None,
    formula: Design | None = None,
    time_limit: float | None = None,
) -> StateDerivatives:
    """Compute the derivatives of all states, and of any output, at the ends of the steps (direct method).

    The derivatives are those of the states that the run reports, at constant times. An event, and a corner of a force
    that ends a step, has two entries in `t`, because derivatives are discontinuous there: those of the motion before
    and after it. The end of a run changes with the event that ended it, as in `Final`.

    Parameters
    ----------
    run, wrt, design, formula : as for `sensitivity`
    time_limit : limit in seconds, checked before and after the sweep, which is one compiled call
    """
    system, steps = stored(run)
    if not wrt:
        raise ValueError("wrt names no number by which the states are differentiated. Name at least one.")
    with within(run.name, None, 2, "differentiated", " stages", time_limit) as report:
        parameters = run_parameters(run, system, steps.start, wrt, design, formula)
        refuse(system, steps, parameters)
        report(1)
        changes = parameters.along(np.eye(len(parameters.names)))
        chain = RunChain(system, steps, parameters.of_run)
        found = chain.along(*changes)
        report(2)
        states = reported_along(system, steps, found, changes[0])
    return StateDerivatives(
        tuple(parameters.names), steps.t, *states, coordinates=run.coordinate_names,
        along=partial(_output_along, system, steps, parameters, found), units=parameters.units,
    )  # fmt: skip


def _output_along(
    system: System, steps: StepsTaken | Segments, parameters: Parameters, states: Nodes, name: str
) -> Array:
    """Derivatives of an output along a run by all parameters (n, p), with those of its nodes."""
    whole = np.eye(len(parameters.names))
    b, _, _, c = parameters.along(whole)
    response, named = Final(find_output(system, name).name), dict(zip(parameters.names, whole, strict=True))
    evaluation = Evaluation(system, steps, [response], parameters, where=[at_all_times(steps)])
    (found,) = evaluation.signals_along(states, b, c, named)
    return found


@accepts_former_options
def simulated_gradient(
    system: System, responses: Wanted, wrt: Sequence[str] | None = None, *, until: float, start: Start | None = None,
    method: Differentiable | None = None, events: Events = (), memory: float = 100e6, **options: Any,
) -> Gradient:  # fmt: skip
    """Simulate and compute a gradient with limited memory: the former way to `sensitivity` of a run with `memory`.

    `system`, `start`, `until`, `method` and `events` are those of `simulate`; `responses`, `wrt`, `memory` and
    `options` those of `sensitivity`.
    """
    run = simulate(system, start, until=until, t_eval=[until], method=method, events=events)
    return sensitivity(run, responses, wrt, memory=memory, **options)
