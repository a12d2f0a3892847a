"""Runs of a method with steps of prescribed lengths, without events, and with other numbers than the system's."""

from typing import Any

import numpy as np

import sarrus as sr
from sarrus.analyses.dynamics.stepping.stepper import RunFailure, Settings
from sarrus.analyses.dynamics.stepping.tolerance import Tolerances
from sarrus.analyses.dynamics.time_loop.outcome import nothing
from sarrus.analyses.dynamics.time_loop.recording import Plan
from sarrus.analyses.dynamics.time_loop.time_loop import TimeLoop


def run_of(
    method: Any,
    system: sr.System,
    start: Any,
    t_eval: np.ndarray,
    *,
    rtol: float,
    atol: float,
    store_steps: bool = False,
    given: np.ndarray | None = None,
    b: np.ndarray | None = None,
) -> sr.Trajectory:
    """A run over the times `t_eval`; `given` are the lengths of its steps, `b` the numbers of the elements."""
    settings = Settings(Tolerances.of(system, rtol, atol), store_steps=store_steps, given=given, b=b)
    none = np.zeros(0)
    try:
        stepper = method.stepper(system, start, settings)
    except RunFailure as error:
        return nothing(system, error.status, error.message)
    plan = Plan(t_eval, float(t_eval[-1]), none, none, stored=store_steps)
    return TimeLoop(system, stepper, plan).go(start)
