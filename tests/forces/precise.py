"""Runs with small tolerances, where a closed solution is to be met to many digits."""

from typing import Any

import sarrus as sr


def precise(system: sr.System, **given: Any) -> sr.Trajectory:
    return sr.simulate(system, method=sr.Radau(rtol=1e-10, atol=1e-12), **given)
