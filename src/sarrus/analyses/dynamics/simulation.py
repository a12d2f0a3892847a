"""Simulation: one function, whatever the method."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...algebra import Array
from ...defaults import ATOL, RTOL, RTOL_OF_ORDER_2
from ...linalg.threads import one_thread_if_small
from ...model.announcement import announce, reports_warnings
from ...model.show import quote
from ...results import Trajectory
from ...system import System
from ..arguments import refuse_other_system
from ..integration_methods import method_of
from ..position.initial_state import Start, start_of
from ..progress import monitor
from .error_goal import Goals, simulated_to
from .events.events import Event
from .inputs.force_arguments import that_jumps
from .inputs.laws_of_time import Stops, stops_of
from .integrators.alpha import HHT, GeneralizedAlpha
from .integrators.described import Described
from .integrators.differentiable import Differentiable as Differentiable
from .integrators.differentiable import differentiable as differentiable
from .integrators.ida import IDA
from .integrators.ode import ODE
from .sampled.control import Control, controlled
from .sampled.controllers import Controller, controllers_of
from .stepping.step_budget import StepBudget
from .stepping.stepper import RunFailure, Settings
from .stepping.tolerance import Absolute, Given, Tolerances
from .time_loop.outcome import nothing
from .time_loop.prescribed import Prescribed
from .time_loop.recipe import Recipe
from .time_loop.time_loop import Plan

LATEST = 1e12  # [s] 30,000 years: first steps are parts of the whole time
SHORTEST = 1e-100  # s: squares of shorter runs vanish
Method = Differentiable | ODE | IDA


def refuse_end(until: float, begin: float = 0.0) -> None:
    """Refuse an end time that is none, or that no step leads to from the start.

    Raises
    ------
    ValueError
    """
    after = "a positive time in s" if begin == 0.0 else f"a time in s after the start at {begin:g}"
    if not (np.isfinite(until) and until - begin > max(SHORTEST, 4 * np.spacing(abs(begin)))):
        raise ValueError(f"until must be {after}, but is {until}. Give the time of the end in s.")
    if until > LATEST:
        raise ValueError(f"until must be at most {LATEST:g} s, but is {until:g}. Check its unit.")


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
    time_limit : seconds after which the run ends with the status "time limit"; with `error`, of all its runs
    max_steps : number of steps after which the run ends with the status "too many steps"; by default it ends if
        60,000 steps were so short that five million more would follow
    error : largest errors of responses, ``{"slider.x": "1 um", sr.Peak("pin.force.x"): 0.5}``: the run is repeated with
        smaller tolerances or steps until the estimates of `Trajectory.error` are smaller; its steps are stored
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
    chosen, watched = method_with_options(method), _events(events)
    options |= {"rtol": rtol, "atol": atol, "corners": corners}
    control: Control | None = None
    if controllers and save is not None:
        raise ValueError(
            "save: runs with controllers are not saved, as they cannot be continued. Remove save=."
        )
    try:
        with monitor(progress, until, time_limit=time_limit) as message:
            if controllers:
                refuse_other_system(system, "simulate", unset=True)
                system, start, control = controlled(system, start, controllers, until, store_steps)
                breakpoints = np.concatenate([np.asarray(breakpoints, dtype=float), control.times()])
            begin = start_of(system, start)
            if not begin.success:
                return nothing(system, "inconsistent", begin.message)
            refuse_end(until, begin.t)
            times = _times(t_eval, begin.t, until)
            step: float | None = getattr(chosen, "step", None)
            stops = stops_of(system, np.asarray(breakpoints, dtype=float), until, begin.t, step=step)
            announce(_passed_over(system, stops, step))
            tolerances = Tolerances.of(system, rtol_of(chosen, rtol), atol)
            settings = Settings(
                tolerances, _longest(max_step, stops.longest, until), _first(first_step, until - begin.t), store_steps,
                times=times, dense=dense_output or bool(watched),
            )  # fmt: skip
            budget = _budget(max_steps, max_step, chosen)
            free = step is None and not isinstance(chosen, IDA)
            if corners and not free:
                raise ValueError(
                    "corners: steps of a given length and those of IDA do not end at corners. Remove the step of the "
                    "method, choose another method, or remove corners=True."
                )
            every = free and (store_steps or that_jumps(system)) if corners is None else corners
            plan = Plan(
                times, until, stops.all, stops.kinks, watched, dense_output, budget=budget, corners=bool(every) or None,
                free=free, aside=stops.aside, behind=stops.behind, stored=store_steps, control=control,
            )  # fmt: skip
            recipe = Recipe(system.model, begin, chosen, settings, plan, options)
            if save is not None:
                return recipe.saved(save, system, message, overwrite=overwrite)
            return recipe.done(system, None, message)
    except RunFailure as failure:
        return nothing(system, failure.status, failure.message)


def rtol_of(method: Prescribed | ODE | IDA, given: Given | None) -> Given:
    """The relative tolerance, by default that of the method."""
    if given is not None:
        return given
    return RTOL_OF_ORDER_2 if isinstance(method, HHT | GeneralizedAlpha | Described) else RTOL


def _times(given: ArrayLike | None, begin: float, until: float) -> Array:
    """The times of the states wanted."""
    times = np.linspace(begin, until, 1001) if given is None else np.array(given, dtype=float)
    rising = times.ndim == 1 and len(times) and np.all(np.isfinite(times)) and np.all(np.diff(times) > 0)
    if not rising or times[0] < begin or times[-1] > until:
        raise ValueError(
            f"t_eval must be rising times between the start at {begin:g} s and until = {until:g} s. "
            f"Give a list of them, such as numpy.linspace({begin:g}, {until:g}, 101)."
        )
    return times


def _events(given: Event | Sequence[Event]) -> list[Event]:
    found: Sequence[object] = [given] if isinstance(given, Event) else given
    if not isinstance(found, list | tuple) or not all(isinstance(one, Event) for one in found):
        raise TypeError(
            f"events must be a sarrus.Event, or a list of them, got {type(given).__name__}. Pass sr.Event(...)."
        )
    return [*found]


def _passed_over(system: System, stops: Stops, step: float | None) -> Iterator[str]:
    """Steps of a given length that are too long for what loads do, or pass over jumps."""
    if len(stops.quick):
        yield (
            f"{system.name}: a load or a motion varies at t = {stops.quick[0]:.6g} s within less than half a step of "
            f"{step} s, so that steps may pass over it. Take shorter ones, or a method without a given step."
        )
    if step is not None and (owner := that_jumps(system)):
        yield (
            f"{system.name}: a law of {quote(owner)} jumps, and steps of a given length do not end there, which may be "
            "a large error. Take a method without a given step, or a law that changes within a width."
        )


def _longest(given: float, found: float, until: float) -> float:
    """The longest step: a user's, but not over parts in which loads vary; a wrong one is refused with the settings."""
    if 0 < given < np.spacing(until):
        message = f"max_step is {given:.3g} s, which is less than the rounding of the time {until:g} s."
        raise ValueError(f"{message} Give a longer one.")
    return min(given, found) if given > 0 else given


def _first(step: float | None, span: float) -> float:
    if step is not None and not (np.isfinite(step) and step > 0):
        raise ValueError(f"first_step must be a positive time in s, but is {step}. Give one, or None.")
    return min(step or 0.0, span)


def _budget(max_steps: int | None, max_step: float, method: object) -> StepBudget:
    if max_steps is not None and not max_steps >= 1:
        raise ValueError(f"max_steps must be 1 at least, but is {max_steps}. Leave it out for the default.")
    return StepBudget(max_steps, min(max_step, getattr(method, "step", None) or np.inf), method)


def method_with_options(given: Method | None) -> Prescribed | ODE | IDA:
    """The method of an option of `simulate`, by default Radau."""
    given = method_of(given)
    if isinstance(given, ODE | IDA):
        return given
    return differentiable(given, ", ODE(), IDA()", 'For a solver of SciPy give ODE("DOP853").')
