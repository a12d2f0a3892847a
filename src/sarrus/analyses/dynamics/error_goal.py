"""Runs whose responses meet a goal: repeated with smaller tolerances until the estimated errors are small enough."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, TypeVar, cast

import numpy as np

from ...deferred import estimator
from ...model import ModelError
from ...model.expression import parse
from ...model.expression.quantity import quantity
from ...model.show import show
from ...outputs import find_output
from ...outputs.reductions import REDUCTIONS, is_reduction
from ...results import ErrorEstimate, Segments, Trajectory
from ...system import System
from ..progress import duration
from .run_options import Limits
from .stepping.step_control import StepControl

MISSED = "error goal missed"  # status of the last run, which reached its end
REPEATS = 6  # runs at most, after which the goal is given up
SAFETY = 0.5  # [-] of the goal, at which the next run aims
LEAST, MOST = 1e-6, 0.3  # [-] factors of tolerances from one run to the next
POWER, POWER_OF_ORDER_TWO = 1.0, 1.5  # tolerances fall with the error to this power
MANY = "Smaller tolerances need too many steps. Choose a larger error or a larger limit of steps"
POWER_OF_STEP = 0.5  # of a given step of methods of order two

Method = TypeVar("Method", bound=StepControl)


def simulated_to(
    run_with: Callable[..., Trajectory], system: System, method: StepControl, limits: Limits
) -> Trajectory:
    """The first run whose responses meet their goals, or the last one, without success.

    Parameters
    ----------
    run_with : gives a run with stored steps for a method and limits
    limits : with the largest errors by responses, numbers in SI units or texts with a unit

    Raises
    ------
    ValueError
        For a goal that is not positive, or in another unit.
    TypeError
        If goals are no mapping.
    """
    goals, time_limit = limits.errors, limits.time
    if not isinstance(goals, Mapping):
        raise TypeError(
            f'errors must be a mapping of responses, got {show(goals)}. Give one such as {{"slider.x": "1 um"}}.'
        )
    wanted = np.array([goal_in_si(system, response, goal) for response, goal in goals.items()])
    end, before = np.inf if time_limit is None else time.monotonic() + time_limit, np.inf
    run = run_with(method=method, limits=replace(limits, errors=None))
    for left in range(REPEATS - 1, -1, -1):
        if not run.success:
            return run
        found = estimator()(run, [*goals])
        ratio = max(one.error / goal for one, goal in zip(found, wanted, strict=True))
        if ratio <= 1.0:
            return run
        hopeless = any(one.round_off > goal for one, goal in zip(found, wanted, strict=True))
        same = ratio == before  # tolerances were the smallest of the method already
        if hopeless or same or not left or not np.isfinite(ratio):
            return _missed(run, found, wanted)
        before, method = ratio, _smaller(method, ratio / SAFETY, _precise(run))
        if (seconds := end - time.monotonic()) <= 0:
            return _missed(run, found, wanted, _late(time_limit))
        left_time = None if time_limit is None else seconds
        again = run_with(method=method, limits=replace(limits, time=left_time, errors=None))
        if again.status in ("time limit", "too many steps"):
            return _missed(run, found, wanted, _late(time_limit) if again.status == "time limit" else MANY)
        run = again
    raise AssertionError


def goal_in_si(system: System, response: Any, goal: float | str) -> float:
    """A goal as a number; the unit of a text must be that of the output."""
    found: Any = goal
    if isinstance(goal, str):
        formula = isinstance(response, str) and any(
            map(is_reduction, parse(response, functions=REDUCTIONS).nodes())
        )
        unit = find_output(system, response).unit if isinstance(response, str) and not formula else None
        try:
            found = quantity(goal, unit)
        except ModelError as wrong:
            raise ValueError(f"error of {response} {wrong.message}") from None
    if (
        isinstance(found, bool)
        or not isinstance(found, int | float)
        or not (np.isfinite(found) and found > 0)
    ):
        raise ValueError(f'error of {response} must be positive, got {goal!r}. Give a number or "1 um".')
    return float(found)


def _precise(run: Trajectory) -> bool:
    steps = run.steps.segments[0] if isinstance(run.steps, Segments) else run.steps
    return steps is not None and steps.precise


def _smaller(method: StepControl, ratio: float, precise: bool) -> StepControl:
    """The method for an error that is smaller by a ratio."""
    if getattr(method, "step", None):
        return finer(method, 1 / ratio)
    return finer(method, min(max(float(ratio) ** -(POWER if precise else POWER_OF_ORDER_TWO), LEAST), MOST))


def finer(method: Method, factor: float) -> Method:
    """The method with all tolerances times a factor; a given step is multiplied by its square root."""
    given: Any = method
    if getattr(method, "step", None):
        return cast(Method, replace(given, step=given.step * factor**POWER_OF_STEP))
    return replace(method, rtol=_scaled(method.rtol, factor), atol=_scaled(method.atol, factor))


def _scaled(tolerance: Any, factor: float) -> Any:
    """A tolerance as a user gives it, times a factor."""
    if tolerance is None:
        return None
    if isinstance(tolerance, Mapping):
        return {kind: _scaled(own, factor) for kind, own in tolerance.items()}
    return f"{factor!r}*({tolerance})" if isinstance(tolerance, str) else np.asarray(tolerance) * factor


def _late(time_limit: float | None) -> str:
    return f"The time limit of {duration(time_limit or 0.0)} has passed. Choose a larger error or a longer time limit"


def _missed(
    run: Trajectory, found: tuple[ErrorEstimate, ...], wanted: Any, limit: str | None = None
) -> Trajectory:
    """The run, with a message about the goal that it does not meet, and the limit that ended the next run."""
    ratios = [one.error / goal for one, goal in zip(found, wanted, strict=True)]
    worst = int(np.argmax(ratios))
    reason = limit or (
        "round-off alone is more. Choose a larger error or a shorter run"
        if found[worst].round_off > wanted[worst]
        else "Choose a larger error, or a method of higher order such as Radau()"
    )
    message = (
        f"the estimated error of {found[worst].response} is {found[worst].error:.2g}, not {wanted[worst]:.2g}. "
        f"{reason[0].upper()}{reason[1:]}."
    )
    return replace(run, success=False, status=MISSED, message=message)
