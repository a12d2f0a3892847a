"""Runs with an explicit method of high order, where a closed solution is to be met to many digits."""

from typing import Any

import sarrus as sr


def precise(system: sr.System, **given: Any) -> sr.Trajectory:
    return sr.simulate(system, rtol=1e-9, atol=1e-11, method=sr.ODE(), **given)
