"""Simulation: one function, whatever the method."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from ...results import Assembly, Trajectory
from ...system import System
from ..assembly import assemble
from .alpha import HHT, GeneralizedAlpha
from .ida import IDA
from .ode import ODE
from .outcome import nothing
from .radau import Radau

Method = HHT | GeneralizedAlpha | Radau | ODE | IDA


def simulate(
    system: System,
    start: Assembly | None = None,
    *,
    until: float,
    t_eval: ArrayLike | None = None,
    method: Method | None = None,
    rtol: float = 1e-6,
    atol: float = 1e-8,
    max_step: float = np.inf,
    keep_steps: bool = False,
    progress: Callable[[float], None] | None = None,
) -> Trajectory:
    """Integrate the equations of motion in time.

    Parameters
    ----------
    system : System
    start : consistent state; by default the model's own, assembled
    until : end time [s]; the start is at 0
    t_eval : times to keep, rising, between 0 and `until`; by default 1001 equidistant ones
    method : `HHT` (the default), `GeneralizedAlpha`, `Radau`, `ODE` or `IDA`
    rtol, atol : tolerances of the local error of q and v
    max_step : longest step [s]
    keep_steps : keep every step in `Trajectory.steps`, converged to round-off, for derivatives (`HHT` and
        `GeneralizedAlpha`)
    progress : called with the time reached after every step

    Returns
    -------
    Trajectory
        With ``success`` false and a sentence in ``message`` where the end was not reached; what was computed is kept.

    Raises
    ------
    ValueError
        For an end time or times that are not positive and rising, and tolerances that are not positive and finite.
    """
    if not (np.isfinite(until) and until > 0):
        raise ValueError(f"until must be a positive time in s, but is {until}")
    _refuse_tolerances(rtol=rtol, atol=atol)
    times = np.linspace(0.0, until, 1001) if t_eval is None else np.asarray(t_eval, dtype=float)
    if times.ndim != 1 or not len(times) or np.any(np.diff(times) <= 0) or times[0] < 0 or times[-1] > until:
        raise ValueError("t_eval must be rising times between 0 and until")
    grid = np.unique(np.concatenate([[0.0], times, [until]]))
    begin = start if start is not None else assemble(system)
    if not begin.success:
        return nothing(system, "inconsistent", begin.message)
    chosen, told = _method(method), {"rtol": rtol, "atol": atol, "max_step": max_step, "progress": progress}
    if isinstance(chosen, ODE | IDA | Radau):
        if keep_steps:
            raise ValueError(f"{type(chosen).__name__}() keeps no steps; choose HHT() or GeneralizedAlpha()")
        return chosen.run(system, begin, grid, **told).at(times)  # type: ignore[arg-type]
    return chosen.run(system, begin, grid, keep_steps=keep_steps, **told).at(times)  # type: ignore[arg-type]


def _refuse_tolerances(**given: float) -> None:
    for name, value in given.items():
        if not (np.isfinite(value) and value > 0):
            raise ValueError(f"{name} must be positive and finite, but is {value}; give one like 1e-6")


def _method(given: Method | None) -> Method:
    if given is None:
        return HHT()
    if not isinstance(given, Method):
        raise TypeError(
            f"method must be HHT(), GeneralizedAlpha(), Radau(), ODE() or IDA(), but is {given!r}; "
            'for a solver of SciPy give ODE("DOP853")'
        )
    return given
