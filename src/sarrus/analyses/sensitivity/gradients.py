"""Gradients of responses of a run by parameters: from its steps, by one sweep backward or some forward."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, Literal, TypeAlias

import numpy as np

from ...algebra import Array
from ...model.announcement import Call
from ...results import (
    Assembly,
    Equilibrium,
    ErrorEstimate,
    Gradient,
    Modes,
    Segments,
    StateSpace,
    StepsTaken,
    Trajectory,
    load_run,
)
from ...system import System
from ..arguments import kind
from ..dynamics.error_goal import MISSED
from ..dynamics.stepping.stepper import RunFailure
from ..progress import Progress, TimeLimit, monitor
from .chain.chain import Gradients, Nodes, by_joints
from .combined import Composite, Part
from .error_estimates import effects_of, estimated
from .parameters.contradictions import undefined
from .parameters.parameters import Parameters
from .responses.evaluation import DirectTerms, Evaluation
from .responses.responses import Response
from .responses.undefined import refuse_undefined
from .run_chain import RunChain

Wanted: TypeAlias = "Part | Sequence[Part]"
Method = Literal["adjoint", "direct"]
NOT_FINISHED = "derivatives need a run that reached its end, but"


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
    chain, missing = RunChain(system, steps, parameters.of_run), undefined(system, steps, parameters)
    (nodes, explicit), adjoints = evaluation.gradients(), list[Array]()
    if method == "adjoint":
        matrix = by_parameters(chain.gradients(nodes, adjoints if error else None), parameters, explicit)
    else:
        matrix = along_parameters(chain, nodes, parameters, explicit, ~missing)
        adjoints += chain.adjoints(nodes) if error else []
    errors = estimated(responses, evaluation, effects_of(system, steps, adjoints)) if error else ()
    return gradient_of(responses, parameters, evaluation.values, matrix, missing, errors)


def errors_of(outer: Composite, evaluation: Evaluation, chain: RunChain) -> tuple[ErrorEstimate, ...]:
    """Estimates of the errors of evaluated responses, by a sweep backward for their parts."""
    effects = effects_of(chain.system, chain.steps, chain.adjoints(evaluation.gradients()[0]))
    return tuple(outer.errors(estimated(outer.parts, evaluation, effects)))


def by_parameters(by: Gradients, parameters: Parameters, explicit: DirectTerms) -> Array:
    """Derivatives by parameters (k, p), with what responses depend on by themselves."""
    c = by_joints(np.zeros((parameters.c_size, by.b.shape[1])), by.c) + explicit.c
    total = parameters.gradient(replace(by, b=by.b + explicit.b), c).T
    return np.asarray(total + own_parts(explicit, parameters))


def along_parameters(
    chain: RunChain, nodes: Nodes, parameters: Parameters, explicit: DirectTerms, chosen: Array
) -> Array:
    """Derivatives of responses (k, p) by a sweep forward for each chosen parameter."""
    b, q, v, c = parameters.along(np.eye(len(parameters.names))[:, chosen])
    total = own_parts(explicit, parameters)
    if not chosen.any():
        return total
    total[:, chosen] += chain.weighed(nodes, b, q, v, c) + explicit.b.T @ b + explicit.c.T @ c
    return total


def own_parts(explicit: DirectTerms, parameters: Parameters) -> Array:
    """Return the direct derivatives of responses with respect to parameters (r, p)."""
    found = [own.get(name, 0.0) for own in explicit.named for name in parameters.names]
    return np.reshape(found, (len(explicit.named), len(parameters.names)))


def gradient_of(
    responses: Sequence[Response], parameters: Parameters, values: Array, matrix: Array, missing: Array,
    errors: Sequence[ErrorEstimate] = (),
) -> Gradient:  # fmt: skip
    """The gradient of responses of a run: NaN for the parameters that have no derivative."""
    matrix[:, missing] = np.nan
    system = parameters.system
    return Gradient(
        tuple(one.title for one in responses), tuple(parameters.names), values, parameters.values, matrix,
        tuple(errors), response_units=tuple(one.unit(system) for one in responses), units=parameters.units,
        table_units=parameters.table_units,
    )  # fmt: skip


def is_solved(result: Any) -> bool:
    """Whether this is a result that equations determine, and not a simulated run."""
    if isinstance(result, Trajectory):
        return result.analysis != "simulation"
    return isinstance(result, Equilibrium | Modes | StateSpace)


def refuse_failed(run: Any) -> None:
    """Refuse results that have no derivatives of a run.

    Raises
    ------
    TypeError
        For something else than a run.
    ValueError
        If the run failed.
    """
    if is_solved(run):
        raise ValueError(
            f"{run.name}: only first derivatives of this analysis are known. Use sr.sensitivity."
        )
    if not isinstance(run, Trajectory):
        raise TypeError(
            f"derivatives need a run, got {kind(run)}. Give what simulate(system, ..., store='steps') returns."
        )
    if run.status == "singular configuration":
        t = float(run.steps.t[-1]) if run.steps else float(run.t[-1])
        raise ValueError(
            f"{run.name}: derivatives and estimates of errors need a run that reached its end, but this one ended near "
            f"t = {t:.6g} s in a singular configuration, where derivatives with respect to dimensions do not exist. "
            "Choose `until` before that time."
        )
    if not run.success and run.status != MISSED:
        raise ValueError(f"{NOT_FINISHED} {run.name}: {run.message}")


def stored(run: Any) -> tuple[System, StepsTaken | Segments]:
    """The system and the steps of a run.

    Raises
    ------
    ValueError
        If there are none; see `refuse_failed`, too.
    """
    refuse_failed(run)
    if run.steps_folder:
        raise ValueError(
            f"{run.name}: derivatives need the steps of the run, which are stored in {run.steps_folder}. Open it with "
            f"sarrus.resume({run.steps_folder!r})."
        )
    if run.steps is None and isinstance(run.call, Call) and run.call.analysis is load_run:
        raise ValueError(
            f"{run.name}: derivatives need the steps of the run, which are not in {run.call.arguments['path']}. Repeat "
            "it by simulate(..., store='steps', save=folder), and open it by sarrus.resume(folder)."
        )
    if run.system is None or run.steps is None or not len(run.steps):
        raise ValueError(
            f"{run.name}: derivatives need the steps of the run. Call simulate(..., store='steps') with HHT(), "
            "GeneralizedAlpha() or Radau(), or give sensitivity(..., memory=)."
        )
    return run.system, run.steps


def run_parameters(
    run: Trajectory,
    system: System,
    start: Assembly,
    wrt: Sequence[str] | None,
    design: Any,
    formula: Any,
) -> Parameters:
    """Return the parameters of the derivatives of a run."""
    struck = run.restitutions
    return Parameters(system, wrt, design=design, formula=formula, start=start, restitutions=struck)


@contextmanager
def within(
    name: str,
    progress: bool | Progress | None,
    total: float,
    done: str,
    unit: str,
    time_limit: float | None,
) -> Iterator[Progress]:
    """`monitor` of derivatives, of which there are none where the time limit has passed, or a repeated run fails."""
    try:
        with monitor(progress, total, done=done, unit=unit, time_limit=time_limit) as report:
            yield report
    except TimeLimit as over:
        raise ValueError(f"{name}: {over} before the derivatives were there. Allow more time.") from None
    except RunFailure as failure:
        raise ValueError(f"{NOT_FINISHED} {name}: {failure.message}") from None
    except KeyboardInterrupt:
        raise KeyboardInterrupt(f"{name}: stopped by the user before the derivatives were there") from None
