"""Simulation: one function, whatever the method."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from inspect import unwrap
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from ...linalg.threads import one_thread_if_small
from ...model.announcement import Call, reports_warnings
from ...results import Trajectory, load_run
from ...system import System
from ..arguments import refuse_other_system
from ..position.initial_state import Start, start_of
from ..progress import monitor
from .error_goal import simulated_to
from .former_options import accepts_former_options
from .integrators.differentiable import Method, method_with_options
from .recipe import Recipe, recipe_in, repeat, resume
from .run_options import Events, Limits, Save, Stored, limits_of, listed_events, save_of
from .sampled.control import Control, controlled
from .sampled.controllers import Controller, controllers_of
from .stepping.stepper import RunFailure
from .time_loop.outcome import nothing


@accepts_former_options
@reports_warnings
@one_thread_if_small
def simulate(
    system: System,
    start: Start | None = None,
    *,
    until: float,
    t_eval: ArrayLike | None = None,
    method: Method | None = None,
    events: Events = (),
    inputs: Mapping[str, Any] | None = None,
    controllers: Controller | Sequence[Controller] = (),
    store: Stored = "samples",
    save: Save | str | os.PathLike[str] | None = None,
    progress: bool | Callable[[float], None] | None = None,
    limits: Limits | None = None,
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
    method : `Radau` (the default), `HHT`, `GeneralizedAlpha`, `ODE`, or the `Description` of another method,
        with its tolerances and step lengths, ``sr.Radau(rtol=1e-8, max_step=0.01)``: see `StepControl`
    events : an `Event` to be located, which may end the run or change velocities; a breakpoint, the number of a time
        [s] at which forces or motions are discontinuous, in addition to those of the model's tables; or a list of
        both, ``[0.3, sr.Event("ball.z")]``. A step ends exactly at a breakpoint, and methods that go on from
        accelerations are initialized again
    inputs : values of inputs by name for this run, numbers or laws as of `Input`
    controllers : one sampled `Controller`, or several, whose inputs are first-order states of `Trajectory.system`; a
        value that is not finite ends the run with the status "controller". The run cannot be saved; with stored steps
        the functions are recorded for derivatives
    store : "samples", the states at `t_eval`; "dense", also the interpolation of all steps: `Trajectory.sol` returns
        the state at any time; "steps", also every step in `Trajectory.steps` for derivatives (`HHT`,
        `GeneralizedAlpha`, `Radau` and descriptions). The motion is the same within its tolerances: shorter steps come
        before switches of forces, for derivatives
    save : a folder, such as "run.sarrus", to which the run is written during the computation, or
        ``sr.Save(folder, overwrite=True)``, which replaces a run. Results survive a crash, and memory does not grow,
        unless `store` is "dense" or "steps". `load_run` opens the folder, `resume` continues the run
    progress : true for a bar on the terminal, or a function that is called with the time reached
    limits : of time, of steps, and of the errors of responses, see `Limits`

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
    controllers, limits, folder = controllers_of(controllers), limits_of(limits), save_of(save)
    chosen, events = method_with_options(method), listed_events(events)
    if inputs:
        refuse_other_system(system, "simulate", unset=True)
        system = system.with_inputs(inputs)
    if limits.errors is not None:
        _refuse_save(folder, "an error goal are not saved, as they are repeated")
        again = partial(
            simulate, system, start, until=until, t_eval=t_eval, events=events, store="steps", progress=progress,
            controllers=controllers,
        )  # fmt: skip
        return simulated_to(again, system, chosen, limits)
    control: Control | None = None
    try:
        with monitor(progress, until, time_limit=limits.time) as message:
            if controllers:
                _refuse_save(folder, "controllers are not saved, as they cannot be continued")
                refuse_other_system(system, "simulate", unset=True)
                system, start, control = controlled(system, start, controllers, until, store == "steps")
            begin = start_of(system, start)
            if not begin.success:
                return nothing(system, "inconsistent", begin.message)
            given = {
                "until": until, "t_eval": t_eval, "method": chosen, "events": events, "store": store,
                "limits": Limits(steps=limits.steps),
            }  # fmt: skip
            recipe = Recipe.of(system, begin, given, control)
            if folder is None:
                return recipe.done(message)
            return recipe.saved(folder.folder, message, overwrite=folder.overwrite)
    except RunFailure as failure:
        return nothing(system, failure.status, failure.message)


def _refuse_save(folder: Save | None, reason: str) -> None:
    if folder is not None:
        raise ValueError(f"save: runs with {reason}. Remove save=.")


def arguments_of(run: Trajectory) -> Mapping[str, Any] | None:
    """The arguments of `simulate` by which a run is computed again, from its call or its folder; None if unknown."""
    call = run.call
    if not isinstance(call, Call):
        return None
    if unwrap(call.analysis) is unwrap(simulate):
        return call.arguments
    if call.analysis not in (load_run, resume, repeat):
        return None
    again = {name: call.arguments.get(name) for name in ("events", "method")}
    recipe = recipe_in(Path(call.arguments["path"]), run.system, **again)
    return recipe.arguments | {"system": recipe.system, "start": recipe.start}
