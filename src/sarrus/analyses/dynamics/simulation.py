"""Simulation: one function, whatever the method."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...defaults import ATOL
from ...linalg.threads import one_thread_if_small
from ...model.announcement import Call, reports_warnings
from ...results import Trajectory, load_run
from ...system import System
from ..arguments import refuse_other_system
from ..position.initial_state import Start, start_of
from ..progress import monitor
from .error_goal import Goals, simulated_to
from .events.events import Event
from .recipe import Method, Recipe, events_of, method_with_options, recipe_in, repeat, resume, rtol_of
from .sampled.control import Control, controlled
from .sampled.controllers import Controller, controllers_of
from .stepping.stepper import RunFailure
from .stepping.tolerance import Absolute, Given
from .time_loop.outcome import nothing


@reports_warnings
@one_thread_if_small
def simulate(
    system: System,
    start: Start | None = None,
    *,
    until: float,
    t_eval: ArrayLike | None = None,
    method: Method | None = None,
    rtol: Given | None = None,
    atol: Absolute = ATOL,
    max_step: float = np.inf,
    first_step: float | None = None,
    events: Event | Sequence[Event] = (),
    breakpoints: ArrayLike = (),
    dense_output: bool = False,
    store_steps: bool = False,
    corners: bool | None = None,
    save: str | os.PathLike[str] | None = None,
    overwrite: bool = False,
    progress: bool | Callable[[float], None] | None = None,
    time_limit: float | None = None,
    max_steps: int | None = None,
    error: Goals | None = None,
    inputs: Mapping[str, Any] | None = None,
    controllers: Controller | Sequence[Controller] = (),
    strict: bool = False,
) -> Trajectory:
    """Integrate the equations of motion in time.

    Parameters
    ----------
    system : System
    start : an `Assembly`; a `State` such as ``run.final`` or ``run.state(t)``, with its time and revolutions;
        an `Equilibrium`, whose derivatives are included in those of the run; coordinates (nq,), which are assembled; a
        mapping as in files; or a function of the system that returns one of these. By default the model's state
    until : end time [s], not the duration; the initial time is that of `start`, by default 0
    t_eval : output times, increasing, between the start and `until`; by default 1001 equidistant ones. The
        state at which a run ends earlier, by an event or otherwise, is its last output, too
    method : `Radau` (the default), `HHT`, `GeneralizedAlpha`, `ODE`, `IDA`, or the `Description` of another method
    rtol : relative tolerance of the local error, 1e-9 by default, 1e-6 for HHT, generalized-α and descriptions. Without
        `atol` it is relative to the size of the motion of each body so far, independent of units, and decreases with
        the fourth root of the number of periods, and in very long runs by more (not for methods of order 2),
        because errors accumulate
    atol : absolute tolerances, which replace those that follow the motion; `rtol` is then relative to the
        coordinates. Both are a number, an array for all coordinates, or by kind, e.g.
        ``{"position": 1e-6, "orientation": 1e-8}``, and "velocity" and "rotation" (rates of Euler parameters), which
        are controlled by HHT and generalized-α only if they are given [m, 1, m/s, 1/s]; `atol` by kind takes texts
        with units, too: ``{"position": "1 um", "orientation": "0.01 deg", "velocity": "1 mm/s"}``
    max_step, first_step : the longest step, and the first one, by default automatic [s]
    events : events to be located, which may end the run or change velocities; see `Event`
    breakpoints : times at which forces or motions are discontinuous, in addition to those of the model's tables [s]; a
        step ends exactly there, and methods that go on from accelerations are initialized again
    dense_output : store the interpolation of all steps: `Trajectory.sol` returns the state at any time
    store_steps : store every step in `Trajectory.steps` for derivatives (`HHT`, `GeneralizedAlpha`, `Radau` and
        descriptions). The motion is that of a run without, except that steps end at `corners`
    corners : whether steps end at the corners of forces (first touch, lift-off, kinks of formulas), so that derivatives
        converge there. By default with `store_steps`, and where a law jumps, as by `sign`, unless steps have a given
        length. In every run a step that contains two corners of one force is repeated
    save : a folder, such as "run.sarrus", to which the run is written during the computation. Results survive a crash,
        and memory does not grow, except by `dense_output` and `store_steps`. `load_run` opens the folder, `resume`
        continues the run. The folder must be new or empty, or contain a run and `overwrite` be true
    overwrite : whether an existing saved run is replaced
    progress : true for a bar on the terminal, or a function that is called with the time reached
    time_limit : seconds after which the run ends with the status "time limit"; with `error`, of all its runs. Outputs
        that are computed when they are first used do not count
    max_steps : number of steps after which the run ends with the status "too many steps"; by default it ends if
        60,000 steps were so short that five million more would follow
    error : largest errors of responses, ``{"slider.x": "1 um", sr.Maximum("pin.force.x"): 0.5}``: the run is repeated
        with smaller tolerances or steps until the estimates of `Trajectory.error` are smaller; its steps are stored
    inputs : values of inputs by name for this run, numbers or laws as of `Input`
    controllers : one sampled `Controller`, or several, whose inputs are first-order states of `Trajectory.system`; a
        value that is not finite ends the run with the status "controller". The run cannot be saved; with `store_steps`
        the functions are recorded for derivatives
    strict : raise the first warning as a `StrictError`

    Returns
    -------
    Trajectory
        With ``success`` false, a `status` and a ``message`` if the end was not reached; the result up to there is
        returned, also after Ctrl-C.

    Raises
    ------
    ValueError
        If times are not increasing, if tolerances are not positive and finite, or if the method cannot store steps.
    """
    controllers = controllers_of(controllers)
    options: dict[str, Any] = {"max_step": max_step, "first_step": first_step, "breakpoints": breakpoints}
    if inputs:
        refuse_other_system(system, "simulate", unset=True)
        system = system.with_inputs(inputs)
    if error is not None:
        if save is not None:
            raise ValueError(
                "save: runs with an error goal are not saved, as they are repeated. Remove save=."
            )
        again = partial(
            simulate, system, start, until=until, t_eval=t_eval, events=events, dense_output=dense_output,
            store_steps=True, progress=progress, max_steps=max_steps, controllers=controllers, **options,
        )  # fmt: skip
        relative = rtol_of(method_with_options(method), rtol)
        return simulated_to(again, system, error, time_limit, method=method, rtol=relative, atol=atol)
    chosen, watched = method_with_options(method), events_of(events)
    if controllers and save is not None:
        raise ValueError(
            "save: runs with controllers are not saved, as they cannot be continued. Remove save=."
        )
    control: Control | None = None
    try:
        with monitor(progress, until, time_limit=time_limit) as message:
            if controllers:
                refuse_other_system(system, "simulate", unset=True)
                system, start, control = controlled(system, start, controllers, until, store_steps)
                own = np.asarray(breakpoints, dtype=float)
                options["breakpoints"] = np.concatenate([own, control.times()])
            begin = start_of(system, start)
            if not begin.success:
                return nothing(system, "inconsistent", begin.message)
            given: dict[str, Any] = {
                "until": until, "t_eval": t_eval, "method": chosen, "rtol": rtol, "atol": atol, "events": watched,
                "dense_output": dense_output, "store_steps": store_steps, "corners": corners,
                "max_steps": max_steps, **options,
            }  # fmt: skip
            recipe = Recipe.of(system, begin, given, control)
            return recipe.done(message) if save is None else recipe.saved(save, message, overwrite=overwrite)
    except RunFailure as failure:
        return nothing(system, failure.status, failure.message)


def arguments_of(run: Trajectory) -> Mapping[str, Any] | None:
    """The arguments of `simulate` by which a run is computed again, from its call or its folder; None if unknown."""
    call = run.call
    if not isinstance(call, Call):
        return None
    if call.analysis is simulate:
        return call.arguments
    if call.analysis not in (load_run, resume, repeat):
        return None
    again = {name: call.arguments.get(name) for name in ("events", "method")}
    recipe = recipe_in(Path(call.arguments["path"]), run.system, **again)
    return recipe.arguments | {"system": recipe.system, "start": recipe.start}
