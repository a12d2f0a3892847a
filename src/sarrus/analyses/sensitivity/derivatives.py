"""Derivatives of responses of a run with respect to named numbers: forward (direct) or backward (adjoint)."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np

from ...activity import activity, for_seconds
from ...algebra import Array
from ...linalg.threads import one_thread_if_small
from ...model.announcement import announce, collecting, reports_warnings
from ...outputs import find_output
from ...results import (
    Equilibrium,
    ErrorEstimate,
    Gradient,
    Hessian,
    Modes,
    Pieces,
    Product,
    StateDerivatives,
    StateSpace,
    StepsTaken,
    Trajectory,
)
from ...results.motion.steps import stretches
from ...system import System
from ..arguments import kind
from ..progress import Progress, TimeLimit, monitor
from .accuracy.change_errors import comparable, of_changes, uneven, warnings_of_changes, without_curves
from .accuracy.equivalent_change import LEAST, REST, UNSTABLE, EquivalentChange, moved_along, relative_changes
from .accuracy.estimate import Effects, effects_of, estimated
from .accuracy.growth import FEW, MARGIN, OF_ORDER, Growth, doubtful, growth_of
from .accuracy.round_off import Times, relative_round_off, with_round_off
from .accuracy.small_derivatives import small_derivatives, untouched
from .accuracy.state_errors import of_derivatives, sums, with_sums
from .chain.chain import FIELDS, Gradients, Nodes, by_joints
from .corners import corners
from .events.chains import AnyChain, assembly_of, chain_of
from .hessian import Curvature
from .implicit.results import is_solved, responses_of_result
from .parameters.parameters import Design, Parameters
from .parameters.singular_start import singular_start
from .parameters.undefined import refuse, undefined
from .responses.evaluation import Evaluation, Explicit
from .responses.responses import Final, Integral, Maximum, Minimum, Output, Response
from .responses.undefined import refuse_undefined
from .sampling.over_time import at_all_times, reported_along

Wanted: TypeAlias = "Response | Output | Sequence[Response | Output]"
Method = Literal["adjoint", "direct"]
METHODS = ("adjoint", "direct")
REDUCTIONS = {"final": Final, "max": Maximum, "min": Minimum, "integral": Integral}  # as texts name them
REDUCTION = re.compile(rf"\s*(?P<kind>{'|'.join(REDUCTIONS)})\(\s*(?P<of>.+?)\s*\)\s*")
LOOKED_AT = 3  # responses whose adjoint is looked at where it is not needed: a run is chaotic for all of them


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
    responses : one or several of `Final`, `At`, `Integral`, `Peak`, `Maximum`, `Minimum`, `Misfit`, `AtEvent`; an
        output's name, or a function of `Outputs`, means its final value, ``"max(slider.x)"`` a `Maximum`
    wrt : names of parameters, ``spring.k``, ``pin.point`` (all three), ``rod.inertia.xx``, parameters of the model
        file, design variables; by default all parameters of the model, or all design variables
    method : "adjoint": one sweep backwards, or one solution, for all parameters. "direct": one forwards for each
        parameter, for few parameters and many responses
    design : values of design variables by name
    formula : a function of the design variables that returns parameters of the model by name; differentiated exactly
    progress : True for a bar on standard error, or a function of the stages that are done: responses, sweep
    time_limit : limit in seconds, checked between these stages; a sweep is one compiled call, which cannot be
        interrupted, see `sensitivity_by_checkpoints`
    error : whether errors are estimated, too: of the responses (`Gradient.errors`, see `Trajectory.error`), and of
        their derivatives (`Gradient.relative_errors`), statistically: those are below a third of the truth in about 4 %
        of cases, and always the same for the same run
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
    if is_solved(run):

        def parameters_of(own: System) -> Parameters:
            return Parameters(own, wrt, design=design, formula=formula)

        solved = responses_of_result(run, as_responses(responses), parameters_of)
        refuse_undefined((one.title for one in as_responses(responses)), solved.values)
        return solved.gradient(method)
    system, steps = stored(run)
    assert isinstance(run, Trajectory)
    with _within(run, progress, 2, "differentiated", " stages", time_limit) as report:
        parameters, wanted = _parameters(run, system, steps, wrt, design, formula), as_responses(responses)
        evaluation = Evaluation(system, steps, wanted, parameters)
        report(1)
        found = differentiated(system, steps, wanted, parameters, method, evaluation, error)
        report(2)
    return found


@reports_warnings
@one_thread_if_small
def error_estimates(run: Trajectory, responses: Wanted) -> tuple[ErrorEstimate, ...]:
    """The errors of responses of a run with stored steps; see `Trajectory.error`."""
    with activity(for_seconds("estimating errors")):
        return _estimates(run, responses)


def _estimates(run: Trajectory, responses: Wanted) -> tuple[ErrorEstimate, ...]:
    (system, steps), wanted = stored(run), as_responses(responses)
    parameters = _parameters(run, system, steps, (), None, None)
    evaluation = Evaluation(system, steps, wanted, parameters)
    refuse_undefined((one.title for one in wanted), evaluation.values)
    adjoints = chain_of(system, steps, parameters.restitutions).adjoints(evaluation.gradients()[0])
    return estimated(wanted, evaluation, effects_of(system, steps, adjoints))


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
    steps: StepsTaken | Pieces,
    wrt: Sequence[str] | None,
    design: Any,
    formula: Any,
) -> Parameters:
    """Return the parameters of the derivatives of a run."""
    struck = run.restitutions
    return Parameters(system, wrt, design=design, formula=formula, start=steps.start, restitutions=struck)


def differentiated(
    system: System,
    steps: StepsTaken | Pieces,
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
    chain = chain_of(system, steps, parameters.restitutions)
    missing = undefined(system, steps, parameters)
    announce(singular_start(parameters, steps.start, assembly_of(chain), missing))
    adjoints, given = list[Array](), evaluation.gradients()
    by_states, looked_at = given[0], responses
    if method == "adjoint":
        swept = with_sums(by_states, chain) if error or doubtful(steps) else by_states
        found, of_sums = _adjoint(chain, (swept, given[1]), parameters, adjoints)
    else:
        found, looked_at = (
            _direct(chain, given, parameters, ~missing),
            responses[: None if error else LOOKED_AT],
        )
        by_states, of_sums = _swept(chain, by_states, len(looked_at), adjoints, parameters, error)
    found[:, missing] = 0.0
    derivatives = Derivatives(parameters, looked_at, found[: len(looked_at)], of_sums)
    errors, relative = _warned(chain, looked_at, evaluation, by_states, adjoints, error, derivatives)
    titles = [one.title for one in looked_at]
    changes = _warn_of_changes(chain, titles, parameters, found[: len(titles)], adjoints)
    relative = tuple(map(float, np.hypot(relative, changes))) if error else ()
    found[:, missing] = np.nan
    return Gradient(
        tuple(one.title for one in responses), tuple(parameters.names), evaluation.values, parameters.values, found,
        errors, response_units=tuple(one.unit(system) for one in responses), units=parameters.units,
        relative_errors=relative,
    )  # fmt: skip


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
        chain, last = chain_of(system, steps, parameters.restitutions), Nodes.zeros(steps, 1)
        announce(singular_start(parameters, steps.start, assembly_of(chain)))
        found = chain.along(*changes)
        last.q[-1] = 1.0
        adjoints = list[Array]()
        by_states, of_sums = _swept(chain, last, 1, adjoints, parameters)
        derivatives = Derivatives(parameters, (), np.zeros((0, len(parameters.names))), of_sums)
        _warn(chain, [f"{run.name} at its end"], by_states, adjoints, derivatives)
        _warn_of_changed_states(chain, run.name, parameters, found)
        report(2)
        states = reported_along(system, steps, found, changes[0])
    return StateDerivatives(
        tuple(parameters.names), steps.t, *states, coordinates=run.coordinate_names,
        along=partial(_output_along, system, steps, parameters, found), units=parameters.units,
    )  # fmt: skip


def _output_along(
    system: System, steps: StepsTaken | Pieces, parameters: Parameters, states: Nodes, name: str
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
    response: Response | Output,
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
        curvature, parameters, *_ = _curvature(
            run, response, [*direction] if wrt is None else wrt, design, formula
        )
        report(1)
        found = curvature.times(_direction(direction, parameters.names))
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
    response: Response | Output,
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
    error : whether the error of the value of the response is estimated, too (`Hessian.error`), and that of the
        derivatives (`Hessian.relative_error`)
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
        curvature, parameters, errors, relative = _curvature(run, response, wrt, design, formula, error)
        system = parameters.system
        report(0)
        rows = []
        for number, direction in enumerate(np.eye(len(parameters.names)), start=1):
            rows.append(curvature.times(direction))
            report(number)
        matrix = np.array(rows)
        if relative is not None:
            relative = float(np.hypot(relative, _round_off(run, response, curvature, parameters)))
    bar = errors[0] if errors else None
    one = as_responses(response)[0]
    names, units = tuple(parameters.names), parameters.units
    return Hessian(one.title, names, matrix, bar, relative, response_unit=one.unit(system), units=units)


def _round_off(
    run: Trajectory, response: Response | Output, curvature: Curvature, parameters: Parameters
) -> float:
    """The relative error of second derivatives by round-off at events and corners."""
    _, steps = stored(run)
    if not isinstance(steps, Pieces) or not steps.event_steps:
        return 0.0
    system, wanted = parameters.system, as_responses(response)[:1]

    def products() -> Iterator[Times]:
        for moved in with_round_off(steps):
            chain = chain_of(system, moved, parameters.restitutions)
            yield Curvature(chain, Evaluation(system, moved, wanted, parameters), parameters).times

    return relative_round_off(len(parameters.names), curvature.times, products())


def _curvature(
    run: Trajectory,
    response: Response | Output,
    wrt: Sequence[str],
    design: Any,
    formula: Any,
    error: bool = False,
) -> tuple[Curvature, Parameters, tuple[ErrorEstimate, ...], float | None]:
    system, steps = stored(run)
    parameters = _parameters(run, system, steps, wrt, design, formula)
    refuse(system, steps, parameters)
    announce(corners(system, steps))
    wanted = as_responses(response)[:1]
    evaluation = Evaluation(system, steps, wanted, parameters)
    refuse_undefined((one.title for one in wanted), evaluation.values)
    chain = chain_of(system, steps, parameters.restitutions)
    adjoints, (given, explicit) = list[Array](), evaluation.gradients()
    swept = with_sums(given, chain) if error or doubtful(steps) else given
    found, of_sums = _adjoint(chain, (swept, explicit), parameters, adjoints)
    derivatives = Derivatives(parameters, wanted, found, of_sums)
    errors, relative = _warned(chain, wanted, evaluation, given, adjoints, error, derivatives, order=2)
    changes = _warn_of_changes(chain, [wanted[0].title], parameters, found, adjoints, order=2)
    announce(singular_start(parameters, steps.start, assembly_of(chain)))
    of_both = float(np.hypot(relative[0], changes[0])) if error else None
    return Curvature(chain, evaluation, parameters), parameters, errors, of_both


class Derivatives(NamedTuple):
    """First derivatives by parameters (k, p): of responses, if any, and of sums of states, if they were swept."""

    parameters: Parameters
    responses: Sequence[Response]
    of_responses: Array
    of_sums: Array


def _swept(
    chain: AnyChain, given: Nodes, count: int, adjoints: list[Array], parameters: Parameters, error: bool = False
) -> tuple[Nodes, Array]:  # fmt: skip
    """Gradients of the first responses by states, whose adjoints are swept and stored, for errors those of sums too.

    Return also the derivatives of the sums (s, p).
    """
    first = Nodes(*(getattr(given, name)[..., :count].copy() for name in FIELDS))
    by = chain.gradients(with_sums(first, chain) if error or doubtful(chain.steps) else first, adjoints)
    of_sums = Gradients(*(getattr(by, name)[:, count:] for name in "bqvc"))
    return first, _by_parameters(of_sums, parameters)


def _warned(
    chain: AnyChain, responses: Sequence[Response], evaluation: Evaluation, given: Nodes,
    adjoints: Sequence[Array], error: bool, derivatives: Derivatives | None = None, order: int = 1,
) -> tuple[tuple[ErrorEstimate, ...], tuple[float, ...]]:  # fmt: skip
    """Warn where derivatives have few digits; errors of values and of derivatives, if asked for."""
    checked = _warn(chain, [one.title for one in responses], given, adjoints, derivatives, order)
    if not error or checked is None:
        return (), ()
    effects, relative = checked
    errors = estimated(responses, evaluation, effects)
    return errors, tuple(map(float, relative))


def _warn(
    chain: AnyChain, titles: Sequence[str], given: Nodes, adjoints: Sequence[Array],
    derivatives: Derivatives | None = None, order: int = 1,
) -> tuple[Effects, Array] | None:  # fmt: skip
    """Warn where derivatives have few digits. Return effects of errors of states and relative errors by these.

    They are estimated where sums of states were swept, too, or where adjoints grow enough.
    """
    growth, swept, k = _growth(chain, titles, given, adjoints), adjoints, len(titles)
    if adjoints[0].shape[-1] == k:
        first = stretches(chain.steps)[0]
        if np.all(growth.digits(first.rtol, first.precise) >= FEW + MARGIN):
            return None
        swept = list[Array]()
        by = chain.gradients(sums(chain), swept)
        if derivatives is not None:
            derivatives = derivatives._replace(of_sums=_by_parameters(by, derivatives.parameters))
    effects, factors = effects_of(chain.system, chain.steps, swept), np.ones(k)
    estimates = np.outer(of_derivatives(effects), factors)
    if derivatives is not None:
        parameters, responses, found, of_sums = derivatives
        weights = comparable(parameters, found if responses else of_sums, chain)
        if responses and order == 1:
            own = Nodes(*(getattr(given, name)[..., :k] for name in FIELDS))
            factors = small_derivatives(chain.steps, own, weights, found, of_sums)
        estimates = estimates * factors * OF_ORDER[order]
        grown = float(growth.values().max())
        if grown > UNSTABLE:
            change, moving = _equivalent(chain, derivatives, effects, weights, grown)
            if change and change.rest < REST:
                changes = change.of_derivatives(*_changes(chain, derivatives, change, moving, weights), order)
                others = max(change.rest, UNSTABLE / grown, LEAST) * estimates
                factors = np.where(changes[0] > others[0], 1.0, factors)
                estimates = np.hypot(changes, others)
        if responses and order == 1:
            estimates[:, untouched(found, of_sums, estimates[0])] = 0.0
    announce(growth.warnings_of_errors(titles, (estimates[0], estimates[1]), factors, order))
    return effects, estimates[0]


def _equivalent(
    chain: AnyChain, derivatives: Derivatives, effects: Effects, weights: Array, grown: float
) -> tuple[EquivalentChange | None, Parameters]:
    """A change of parameters that moves the run as its errors do: of those given, or else of all of the model."""
    parameters, of_sums = derivatives.parameters, derivatives.of_sums
    change = EquivalentChange.of(effects, of_sums, without_curves(chain.system, parameters, weights))
    if (change and change.rest < REST) or grown < UNSTABLE / REST:
        return change, parameters
    every = Parameters(chain.system, None, start=chain.steps.start, restitutions=parameters.restitutions)
    by = _by_parameters(chain.gradients(sums(chain)), every)
    by[:, undefined(chain.system, chain.steps, every)] = 0.0
    weights = without_curves(chain.system, every, comparable(every, by, chain))
    return EquivalentChange.of(effects, by, weights), every


def _changes(
    chain: AnyChain, derivatives: Derivatives, change: EquivalentChange, moving: Parameters, weights: Array
) -> tuple[Array, float]:
    """Relative changes of derivatives of responses with a change of the parameters (k,), and of sums of states."""
    parameters, responses, found, of_sums = derivatives
    steps, small = moved_along(chain, moving, change.direction)
    there = chain_of(chain.system, steps, parameters.restitutions)
    if responses:
        with collecting():  # its warnings are those of the run
            given, explicit = Evaluation(chain.system, steps, responses, parameters).gradients()
        moved, moved_sums = _adjoint(there, (with_sums(given, chain), explicit), parameters, [])
    else:
        moved, moved_sums = found, _by_parameters(there.gradients(sums(chain)), parameters)
    within = float(np.median(relative_changes(of_sums, moved_sums, weights))) / small
    return relative_changes(found, moved, weights) / small if responses else np.array([within]), within


def _warn_of_changes(
    chain: AnyChain, titles: Sequence[str], parameters: Parameters, found: Array, adjoints: Sequence[Array],
    order: int = 1,
) -> Array:  # fmt: skip
    """Warn where steps do not suit what parameters change; the relative errors of derivatives by that (k,)."""
    if not uneven(chain.steps):
        return np.zeros(len(titles))
    changes = OF_ORDER[order] * of_changes(chain, parameters, found, adjoints)
    announce(warnings_of_changes(titles, changes, order))
    return changes


def _warn_of_changed_states(chain: AnyChain, name: str, parameters: Parameters, found: Nodes) -> None:
    """Warn where derivatives of all states have few digits, by random sums of the states."""
    if uneven(chain.steps):
        some = sums(chain)
        by_parameters = some.inner(found)
        changes = of_changes(chain, parameters, by_parameters, chain.adjoints(some))
        announce(warnings_of_changes([f"the states of {name}"], np.median(changes, keepdims=True)))


def _growth(chain: AnyChain, titles: Sequence[str], given: Nodes, adjoints: Sequence[Array]) -> Growth:
    return growth_of(chain.steps, given, [one[..., : len(titles)] for one in adjoints])


def _adjoint(
    chain: AnyChain, given: tuple[Nodes, Explicit], parameters: Parameters, adjoints: list[Array]
) -> tuple[Array, Array]:
    """Derivatives of responses (k, p), and of sums of states that are swept with them."""
    nodes, explicit = given
    k, by = explicit.b.shape[1], chain.gradients(nodes, adjoints)
    found = _by_parameters(by, parameters, explicit)
    return found[:k] + own_parts(explicit, parameters), found[k:]


def _by_parameters(by: Gradients, parameters: Parameters, explicit: Explicit | None = None) -> Array:
    """Derivatives by parameters (k, p), with what the first responses depend on by themselves."""
    b, c = by.b.copy(), by_joints(np.zeros((parameters.c_size, by.b.shape[1])), by.c)
    if explicit is not None:
        b[:, : explicit.b.shape[1]] += explicit.b
        c[:, : explicit.c.shape[1]] += explicit.c
    return np.asarray(parameters.gradient(replace(by, b=b), c).T)


def _direct(chain: AnyChain, given: tuple[Nodes, Explicit], parameters: Parameters, chosen: Array) -> Array:
    nodes, explicit = given
    b, q, v, c = parameters.along(np.eye(len(parameters.names))[:, chosen])
    total = own_parts(explicit, parameters)
    if not chosen.any():
        return total
    total[:, chosen] += chain.weighed(nodes, b, q, v, c) + explicit.b.T @ b + explicit.c.T @ c
    return total


def own_parts(explicit: Explicit, parameters: Parameters) -> Array:
    """Return the direct derivatives of responses with respect to parameters (r, p)."""
    return np.array([[own.get(name, 0.0) for name in parameters.names] for own in explicit.named])


def stored(run: Any) -> tuple[System, StepsTaken | Pieces]:
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
    if not run.success:
        raise ValueError(f"derivatives need a run that reached its end, but {run.name}: {run.message}")
    if run.system is None or run.steps is None or not len(run.steps):
        raise ValueError(
            f"{run.name}: derivatives need the steps of the run. Call simulate(..., store_steps=True) with HHT(), "
            "GeneralizedAlpha() or Radau()."
        )
    return run.system, run.steps


def as_responses(given: Wanted) -> list[Response]:
    """Responses of what a user gives for some: ``"slider.x"`` is the final value, ``"max(slider.x)"`` the maximum.

    Raises
    ------
    ValueError
        For none.
    """
    some = given if isinstance(given, Sequence) and not isinstance(given, str) else [given]
    if not some:
        raise ValueError(
            "responses: no response is asked for. Give one or several, such as Final('slider.x')."
        )
    return [one if isinstance(one, Response) else _of_text(one) for one in some]


def _of_text(given: Any) -> Response:
    """The final value of an output, or the reduction that a text names as files do."""
    found = REDUCTION.fullmatch(given) if isinstance(given, str) else None
    return Final(given) if found is None else REDUCTIONS[found["kind"]](found["of"])
