"""Derivatives of responses of a run with respect to named numbers: forward (direct) or backward (adjoint)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache, partial
from typing import Any, Literal, TypeAlias

import numpy as np

from ...activity import activity, for_seconds
from ...algebra import Array
from ...linalg.threads import one_thread_if_small
from ...model.announcement import announce, reports_warnings
from ...outputs import find_output
from ...results import (
    Equilibrium,
    ErrorEstimate,
    Gradient,
    Hessian,
    Modes,
    Product,
    Segments,
    StateDerivatives,
    StateSpace,
    StepsTaken,
    Trajectory,
)
from ...system import System
from ..arguments import kind
from ..dynamics.error_goal import MISSED
from ..progress import Progress, TimeLimit, monitor
from .accuracy.estimate import effects_of, estimated
from .chain.chain import Nodes
from .combined import Composite, Part
from .corners import corners, leaving_corners
from .gradients import adjoint, direct, gradient_of
from .hessian import Curvature
from .implicit.results import is_solved, responses_of_result
from .parameters.parameters import Design, Parameters
from .parameters.singular_start import refuse, singular_start, undefined
from .responses.evaluation import Evaluation
from .responses.responses import Final, Response
from .responses.undefined import refuse_undefined
from .run_chain import RunChain
from .sampling.consistent import ConsistentSampling
from .sampling.reported import Reporter
from .sampling.sampling import Sampling, apart
from .sampling.segments import Instants, SegmentSampling, course_of
from .steps.sweep_loop import NodeArrays

Times: TypeAlias = Callable[[Array], Array]
Wanted: TypeAlias = "Part | Sequence[Part]"
Method = Literal["adjoint", "direct"]
METHODS = ("adjoint", "direct")


def at_all_times(steps: StepsTaken | Segments) -> Sampling:
    """The states at the ends of all steps, and on both sides of every event, at times that stay where they are.

    Only the end of a run moves with the event that ended it, as in a response at that time.
    """
    if not isinstance(steps, Segments):
        return Sampling(steps)
    course = course_of(steps)
    part = np.full(len(course.times), np.nan)
    part[-1] = 1.0
    segment = np.repeat(np.arange(len(course.t)), [len(t) for t in course.t])
    return SegmentSampling(steps, Instants(course.times, segment, part))


def reported_along(system: System, steps: StepsTaken | Segments, nodes: Nodes, b: Array) -> NodeArrays:
    """The changes of q, v, a and λ there (n, nq or m, k), with those of all nodes and of the numbers (len(b), k)."""
    if not isinstance(steps, Segments) and not apart(steps):
        reported = Reporter(system, steps)
        found = reported.along(nodes, b) if reported.redundant else nodes
        return NodeArrays(found.q, found.v, found.a, found.lam)
    consistent = ConsistentSampling(system, steps, at_all_times(steps))
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
    progress: bool | Progress | None = None,
    time_limit: float | None = None,
    error: bool = False,
    strict: bool = False,
) -> Gradient:
    """Compute the derivatives of responses of a result with respect to parameters.

    Those of a simulated run are exact for the computed steps. Those of other analyses follow from their equations by
    the implicit function theorem.

    Parameters
    ----------
    run : from ``simulate(..., store_steps=True)``, `kinematics`, `inverse_dynamics`, `equilibrium`,
        `modes` or `linearize`
    responses : one or several of `Final`, `At`, `Integral`, `Peak`, `Maximum`, `Minimum`, `Misfit`, `AtEvent`,
        `Combined`; formulas such as ``"max(slider.x) - min(slider.x)"``, in which an output without a reduction is its
        final value; or functions of `Outputs`, of final values
    wrt : names of parameters, ``spring.k``, ``pin.point`` (all three), ``rod.inertia.xx``, parameters of the model
        file, design variables; by default all parameters of the model, or all design variables
    method : "adjoint": one sweep backwards, or one solution, for all parameters. "direct": one forwards for each
        parameter, for few parameters and many responses
    design : values of design variables by name
    formula : a function of the design variables that returns parameters of the model by name; differentiated exactly
    progress : True for a bar on standard error, or a function of the stages that are done: responses, sweep
    time_limit : limit in seconds, checked between these stages; a sweep is one compiled call, which cannot be
        interrupted, see `sensitivity_by_checkpoints`
    error : whether the errors of the responses are estimated, too (`Gradient.errors`, see `Trajectory.error`)
    strict : raise the first warning as a `StrictError`

    Returns
    -------
    Gradient
        NaN for parameters whose change alone makes the constraints contradict each other (`Gradient.undefined`)

    Raises
    ------
    ValueError
        If the run stored no steps, or failed, for a response that is not a number or whose derivative is infinite, and
        where the time limit has passed.
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
    system, steps = stored(run)
    assert isinstance(run, Trajectory)
    with _within(run, progress, 2, "differentiated", " stages", time_limit) as report:
        parameters = _parameters(run, system, steps, wrt, design, formula)
        evaluation = Evaluation(system, steps, outer.parts, parameters)
        report(1)
        found = differentiated(system, steps, outer.parts, parameters, method, evaluation, error)
        report(2)
    return outer.gradient(found, system)


@reports_warnings
@one_thread_if_small
def error_estimates(run: Trajectory, responses: Wanted) -> tuple[ErrorEstimate, ...]:
    """The errors of responses of a run with stored steps; see `Trajectory.error`."""
    with activity(for_seconds("estimating errors")):
        return _estimates(run, responses)


def _estimates(run: Trajectory, responses: Wanted) -> tuple[ErrorEstimate, ...]:
    (system, steps), outer = stored(run), Composite(responses)
    wanted = outer.parts
    parameters = _parameters(run, system, steps, (), None, None)
    evaluation = Evaluation(system, steps, wanted, parameters)
    refuse_undefined((one.title for one in wanted), evaluation.values)
    adjoints = RunChain(system, steps, parameters.of_run).adjoints(evaluation.gradients()[0])
    return tuple(outer.errors(estimated(wanted, evaluation, effects_of(system, steps, adjoints))))


@contextmanager
def _within(
    run: Trajectory,
    progress: bool | Progress | None,
    total: float,
    done: str,
    unit: str,
    time_limit: float | None,
) -> Iterator[Progress]:
    """`monitor` of derivatives, of which there are none where the time limit has passed."""
    try:
        with monitor(progress, total, done=done, unit=unit, time_limit=time_limit) as report:
            yield report
    except TimeLimit as over:
        raise ValueError(f"{run.name}: {over} before the derivatives were there. Allow more time.") from None
    except KeyboardInterrupt:
        raise KeyboardInterrupt(
            f"{run.name}: stopped by the user before the derivatives were there"
        ) from None


def _parameters(
    run: Trajectory,
    system: System,
    steps: StepsTaken | Segments,
    wrt: Sequence[str] | None,
    design: Any,
    formula: Any,
) -> Parameters:
    """Return the parameters of the derivatives of a run."""
    struck = run.restitutions
    return Parameters(system, wrt, design=design, formula=formula, start=steps.start, restitutions=struck)


def differentiated(
    system: System,
    steps: StepsTaken | Segments,
    responses: Sequence[Response],
    parameters: Parameters,
    method: Method = "adjoint",
    evaluation: Evaluation | None = None,
    error: bool = False,
) -> Gradient:
    """Derivatives of responses of stored steps, which may have been evaluated; see `sensitivity`."""
    evaluation = evaluation or Evaluation(system, steps, responses, parameters)
    refuse_undefined((one.title for one in responses), evaluation.values)
    announce(corners(system, steps))
    chain = RunChain(system, steps, parameters.of_run)
    missing = undefined(system, steps, parameters)
    adjoints, given = list[Array](), evaluation.gradients()
    if method == "adjoint":
        found = adjoint(chain, given, parameters, adjoints if error else None)
    else:
        found = direct(chain, given, parameters, ~missing)
        adjoints += chain.adjoints(given[0]) if error else []
    errors = estimated(responses, evaluation, effects_of(system, steps, adjoints)) if error else ()
    return gradient_of(
        responses, parameters, steps.start, chain.assembly, evaluation.values, found, missing, errors
    )


@reports_warnings
@one_thread_if_small
def state_derivatives(
    run: Trajectory,
    wrt: Sequence[str],
    *,
    design: Mapping[str, float] | None = None,
    formula: Design | None = None,
    time_limit: float | None = None,
    strict: bool = False,
) -> StateDerivatives:
    """Compute the derivatives of all states, and of any output, at the ends of the steps (direct method).

    The derivatives are those of the states that the run reports, at constant times. An event, and a corner of a force
    that ends a step, has two entries in `t`, because derivatives are discontinuous there: those of the motion before
    and after it. The end of a run changes with the event that ended it, as in `Final`.

    Parameters
    ----------
    run, wrt, design, formula : as for `sensitivity`
    time_limit : limit in seconds, checked before and after the sweep, which is one compiled call
    strict : raise the first warning as a `StrictError`
    """
    system, steps = stored(run)
    if not wrt:
        raise ValueError("wrt names no number by which the states are differentiated. Name at least one.")
    with _within(run, None, 2, "differentiated", " stages", time_limit) as report:
        parameters = _parameters(run, system, steps, wrt, design, formula)
        refuse(system, steps, parameters)
        announce(corners(system, steps))
        report(1)
        changes = parameters.along(np.eye(len(parameters.names)))
        chain = RunChain(system, steps, parameters.of_run)
        announce(singular_start(parameters, steps.start, chain.assembly))
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
    response, there = Final(find_output(system, name).name), at_all_times(steps)
    named = dict(zip(parameters.names, whole, strict=True))
    (found,) = Evaluation(system, steps, [response], parameters, samplings=[there]).signals_along(
        states, b, c, named
    )
    return found


@reports_warnings
@one_thread_if_small
def hessian_product(
    run: Trajectory,
    response: Part,
    direction: Mapping[str, float | Sequence[float]],
    wrt: Sequence[str] | None = None,
    *,
    design: Mapping[str, float] | None = None,
    formula: Design | None = None,
    time_limit: float | None = None,
    strict: bool = False,
) -> Product:
    """Compute the product of the Hessian of a response with a direction, in about two sweeps.

    Parameters
    ----------
    run, response, design, formula : as for `sensitivity`
    direction : changes by name, three for a vector; others are zero
    wrt : names of the parameters; by default those of the direction
    time_limit : limit in seconds, checked before the sweeps, which are compiled calls
    strict : raise the first warning as a `StrictError`

    Returns
    -------
    ndarray (p,)
        in the order of `wrt`, with three entries for each vector, and with ``warnings``
    """
    with _within(run, None, 2, "differentiated twice", " stages", time_limit) as report:
        times, parameters, _ = _curvature(
            run, Composite(response), [*direction] if wrt is None else wrt, design, formula
        )
        report(1)
        found = times(_direction(direction, parameters.names))
        report(2)
    return Product.of(found)


def _direction(given: Mapping[str, Any], names: Sequence[str]) -> Array:
    """Changes by name in the order of the numbers (p,)."""
    found = np.zeros(len(names))
    for name, value in given.items():
        places = [k for k, own in enumerate(names) if own == name or own.startswith(f"{name}.")]
        if not places:
            raise ValueError(
                f"direction: {name!r} is not among the parameters. Add it to wrt, or leave it out."
            )
        if np.size(value) != len(places) or not np.isfinite(value).all():
            raise ValueError(
                f"the direction of {name} must be {len(places)} finite numbers, but is {value}. Give them as a list."
            )
        found[places] = np.ravel(value)
    return found


@reports_warnings
@one_thread_if_small
def hessian(
    run: Trajectory,
    response: Part,
    wrt: Sequence[str],
    *,
    design: Mapping[str, float] | None = None,
    formula: Design | None = None,
    progress: bool | Progress | None = None,
    time_limit: float | None = None,
    error: bool = False,
    strict: bool = False,
) -> Hessian:
    """Compute the second derivatives of a response with respect to parameters, exact for the computed steps.

    Parameters
    ----------
    run, response, design, formula : as for `sensitivity`
    wrt : names of the parameters; each costs the two sweeps of a `hessian_product`
    progress : True for a bar on standard error, or a function of the number of completed products
    time_limit : limit in seconds, checked after each product, whose sweeps are compiled calls
    error : whether the error of the value of the response is estimated, too (`Hessian.error`)
    strict : raise the first warning as a `StrictError`

    Raises
    ------
    ValueError
        As `sensitivity`, and where `wrt` names nothing.
    """
    if not wrt:
        raise ValueError(
            "wrt names no number by which the response is differentiated twice. Name at least one."
        )
    with _within(run, progress, len(wrt), "differentiated twice by", " parameters", time_limit) as report:
        outer = Composite(response)
        times, parameters, errors = _curvature(run, outer, wrt, design, formula, error)
        system = parameters.system
        report(0)
        rows = []
        for number, direction in enumerate(np.eye(len(parameters.names)), start=1):
            rows.append(times(direction))
            report(number)
        matrix = np.array(rows)
    bar = errors[0] if errors else None
    names, units = tuple(parameters.names), parameters.units
    unit = outer.units(system)[0]
    return Hessian(outer.titles[0], names, matrix, bar, response_unit=unit, units=units)


def _products(outer: Composite, chain: RunChain, evaluation: Evaluation, parameters: Parameters) -> Times:
    """The Hessian of a response in products, of the values and the gradients of its parts."""
    wanted = outer.parts
    every = (
        [evaluation]
        if len(wanted) == 1
        else [Evaluation(parameters.system, chain.steps, [one], parameters) for one in wanted]
    )
    curvatures = [Curvature.of(chain, own, one, parameters) for own, one in zip(every, wanted, strict=True)]

    def of_part(place: int, direction: Array) -> Array:
        return curvatures[place].times(direction)

    def gradients() -> Array:
        return adjoint(chain, evaluation.gradients(), parameters)

    return partial(outer.curved, 0, evaluation.values, cache(gradients), of_part)


def _curvature(
    run: Trajectory,
    outer: Composite,
    wrt: Sequence[str],
    design: Any,
    formula: Any,
    error: bool = False,
) -> tuple[Times, Parameters, Sequence[ErrorEstimate]]:
    system, steps = stored(run)
    parameters = _parameters(run, system, steps, wrt, design, formula)
    refuse(system, steps, parameters)
    announce(corners(system, steps))
    wanted = outer.parts
    evaluation = Evaluation(system, steps, wanted, parameters)
    refuse_undefined((one.title for one in wanted), evaluation.values)
    chain = RunChain(system, steps, parameters.of_run)
    errors: Sequence[ErrorEstimate] = ()
    if error:
        adjoints = chain.adjoints(evaluation.gradients()[0])
        errors = outer.errors(estimated(wanted, evaluation, effects_of(system, steps, adjoints)))
    announce(singular_start(parameters, steps.start, chain.assembly))
    announce(leaving_corners(chain, parameters) if chain.event_steps else [])
    return _products(outer, chain, evaluation, parameters), parameters, errors


def stored(run: Any) -> tuple[System, StepsTaken | Segments]:
    """The system and the steps of a run.

    Raises
    ------
    TypeError
        For something else than a run.
    ValueError
        If there are none, or if the run failed.
    """
    if is_solved(run):
        raise ValueError(
            f"{run.name}: only first derivatives of this analysis are known. Use sr.sensitivity."
        )
    if not isinstance(run, Trajectory):
        raise TypeError(
            f"derivatives need a run, got {kind(run)}. Give what simulate(system, ..., store_steps=True) returns."
        )
    if run.status == "singular configuration":
        t = float(run.steps.t[-1]) if run.steps else float(run.t[-1])
        raise ValueError(
            f"{run.name}: derivatives and estimates of errors need a run that reached its end, but this one ended near "
            f"t = {t:.6g} s in a singular configuration, where derivatives with respect to dimensions do not exist. "
            "Choose `until` before that time."
        )
    if not run.success and run.status != MISSED:
        raise ValueError(f"derivatives need a run that reached its end, but {run.name}: {run.message}")
    if run.steps_folder:
        raise ValueError(
            f"{run.name}: derivatives need the steps of the run, which are stored in {run.steps_folder}. Open it with "
            f"sarrus.resume({run.steps_folder!r})."
        )
    if run.system is None or run.steps is None or not len(run.steps):
        raise ValueError(
            f"{run.name}: derivatives need the steps of the run. Call simulate(..., store_steps=True) with HHT(), "
            "GeneralizedAlpha() or Radau()."
        )
    return run.system, run.steps
