"""Simulations with the steps of another one: what derivatives of discrete runs are compared with."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from tests.prescribed_steps import run_of

import sarrus as sr
from sarrus.analyses.dynamics.integrators.differentiable import differentiable
from sarrus.analyses.sensitivity.parameters.parameters import Parameters
from sarrus.analyses.sensitivity.responses.evaluation import Evaluation
from sarrus.model.written import with_numbers
from sarrus.results import StepsTaken


def again(
    system: sr.System,
    steps: StepsTaken,
    method: object,
    numbers: Mapping[str, float],
    rates: Mapping[str, float] | None = None,
    guess: Sequence[np.ndarray | None] = (None, None),
) -> tuple[sr.System, StepsTaken]:
    """The run with other numbers of the model and the same step sizes; perhaps from given rates, or a guess (q, v)."""
    changed = sr.System(with_numbers(system.model, numbers))
    ends = np.array([steps.t[0], steps.t[-1]])
    settings = {"rtol": steps.rtol, "atol": steps.atol, "store_steps": True, "given": steps.h}
    start = sr.assemble(changed, *guess, rates=rates or {})
    run = run_of(differentiable(method), changed, start, ends, **settings)
    assert run.success, run.message
    if steps.correction.shape[1]:
        assert np.array_equal(run.steps.removed != 0, steps.removed != 0)
    return changed, run.steps


def solved(run: sr.Trajectory, method: object) -> sr.Trajectory:
    """The run with its steps solved to round-off, as those taken again are."""
    return replace(run, steps=again(run.system, run.steps, method, {})[1])


def values(system: sr.System, steps: StepsTaken, responses: Sequence[object]) -> np.ndarray:
    """Responses of a run."""
    return Evaluation(system, steps, responses, Parameters(system, [])).values


def differenced(
    run: sr.Trajectory, responses: Sequence[object], name: str, size: float, method: object
) -> np.ndarray:
    """Richardson's extrapolation of central differences of whole simulations (r,)."""
    at = Parameters(run.system, [name]).values[0]

    def slope(e: float) -> np.ndarray:
        ends = [values(*again(run.system, run.steps, method, {name: at + d}), responses) for d in (e, -e)]
        return (ends[0] - ends[1]) / (2 * e)

    return (4 * slope(size / 2) - slope(size)) / 3
