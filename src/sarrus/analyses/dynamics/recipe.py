"""A run that is prepared: stored with its model and its options, so that it can be repeated or continued."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NoReturn, TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike

from ...algebra import Array
from ...linalg.threads import one_thread_if_small
from ...model.announcement import announce, reports_warnings
from ...model.show import quote
from ...results import Assembly, AssemblyRequest, Trajectory, load_run
from ...results.reading import system_of
from ...results.saving.checked_file import NOT_SAVED, NotSavedError, SavedDataError
from ...results.saving.data_bytes import dumps, loads
from ...results.saving.saved import (
    RECIPE,
    UNFINISHED,
    Store,
    arrays_of,
    awaits_checkpoint,
    other_versions,
    recipe_of,
)
from ...results.writing import attributes, system_data
from ...system import System
from ..progress import monitor
from .events.events import Event, Impact
from .events.singular_passage import SingularPassage
from .inputs.force_arguments import that_jump
from .inputs.laws_of_time import stops_of
from .integrators.alpha import HHT, GeneralizedAlpha
from .integrators.described import DescribedMethod, Radau, StepMethod
from .integrators.differentiable import Method, method_with_options
from .integrators.ode import ODE
from .run_options import Events, Limits, events_of, limits_of, listed_events, refuse_store
from .sampled.control import Control
from .stepping.step_budget import StepBudget
from .stepping.stepper import RunFailure, Settings, Stepper
from .stepping.tolerance import Tolerances
from .time_loop.outcome import nothing
from .time_loop.recording import Plan
from .time_loop.time_loop import TimeLoop

LATEST = 1e12  # [s] 30,000 years: first steps are parts of the whole time
SHORTEST = 1e-100  # s: squares of shorter runs vanish
STORED = {
    one.__name__: one
    for one in (
        Assembly, AssemblyRequest, Event, Impact, Limits, HHT, GeneralizedAlpha, Radau, DescribedMethod, ODE
    )
}  # fmt: skip
Progress: TypeAlias = Callable[[float], None] | None


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


@dataclass(frozen=True)
class Recipe:
    """System, start, method, settings and plan of a run.

    Attributes
    ----------
    arguments : of `simulate`, from which the others follow
    """

    system: System
    start: Assembly
    method: StepMethod | ODE
    settings: Settings
    plan: Plan
    arguments: dict[str, Any]

    @classmethod
    def of(
        cls, system: System, start: Assembly, given: dict[str, Any], control: Control | None = None
    ) -> Recipe:
        """Prepare a run.

        Parameters
        ----------
        start : on the constraints
        given : arguments of `simulate`
        control : of sampled controllers

        Raises
        ------
        ValueError
            If they are wrong.
        """
        method, until, store = given["method"], given["until"], given["store"]
        refuse_end(until, start.t)
        refuse_store(store)
        times = _times(given["t_eval"], start.t, until)
        events, breakpoints = events_of(given["events"])
        if control is not None:
            breakpoints = np.concatenate([breakpoints, control.times()])
        step: float | None = getattr(method, "step", None)
        stops = stops_of(system, breakpoints, until, start.t, step=step)
        max_step, store_steps, dense = method.max_step, store == "steps", store != "samples"
        announce(_passed_over(system, step))
        if max_step < np.spacing(until):
            message = f"max_step is {max_step:.3g} s, less than the rounding of the time {until:g} s."
            raise ValueError(f"{message} Give a longer one.")
        settings = Settings(
            Tolerances.of(system, method.rtol, method.atol), min(max_step, stops.longest),
            min(method.first_step or 0.0, until - start.t), store_steps, times=times, dense=dense or bool(events),
        )  # fmt: skip
        plan = Plan(
            times, until, stops.all, stops.kinks, events, dense,
            free=step is None,
            budget=StepBudget(limits_of(given["limits"]).steps, min(max_step, step or np.inf), method),
            stored=store_steps,
            aside=stops.aside, behind=stops.behind, control=control,
        )  # fmt: skip
        return cls(system, start, method, settings, plan, given)

    def loop(self, store: Store | None = None, progress: Progress = None) -> TimeLoop:
        """The run, at its start."""
        stepper = self.method.stepper(self.system, self.start, self.settings)
        if not self.settings.store_steps:
            stepper = cast(Stepper, SingularPassage(stepper, self.system, self.settings))
        return TimeLoop(self.system, stepper, replace(self.plan, store=store, progress=progress))

    def done(
        self, progress: Progress = None, store: Store | None = None, state: Mapping[str, Array] | None = None
    ) -> Trajectory:
        """The run from its start or a saved state on; warnings about its energy are saved with it."""
        loop = self.loop(store, progress)
        run = loop.go(self.start, state)
        found = announce(loop.recording.energies.warnings(run, self.settings.tolerances))
        if store is not None and found:
            store.warn(found)
        return run

    def saved(
        self, path: str | os.PathLike[str], progress: Progress = None, *, overwrite: bool = False
    ) -> Trajectory:
        """The run from its start, written to a folder."""
        about = attributes(self.system, repr(self.method), self.plan.until)
        own = self.plan.times, self.system, about, self._as_bytes(path)
        try:
            with Store.create(path, *own, overwrite=overwrite) as store:
                return self.done(progress, store)
        except (NotSavedError, RunFailure) as error:
            return nothing(self.system, getattr(error, "status", NOT_SAVED), str(error))

    def _as_bytes(self, path: str | os.PathLike[str]) -> bytes:
        """The stored data, each argument by itself, so that one can be given again."""
        own = {**self.arguments, "start": replace(self.start, call=None)}
        own["t_eval"] = own["t_eval"] if own["t_eval"] is None else np.asarray(own["t_eval"], dtype=float)
        parts = {name: np.frombuffer(dumps(value, STORED), dtype=np.uint8) for name, value in own.items()}
        return dumps({**system_data(self.system, path), "arguments": parts}, {})


@reports_warnings
@one_thread_if_small
def resume(
    path: str | os.PathLike[str],
    *,
    system: System | None = None,
    events: Events | None = None,
    method: Method | None = None,
    progress: bool | Callable[[float], None] | None = None,
    time_limit: float | None = None,
) -> Trajectory:
    """Continue an interrupted saved run; the result has the same bits as an uninterrupted run.

    A complete run is opened as by `load_run`, with the whole motion and the steps, if stored. A run that was stopped
    before its first checkpoint starts again. All data are verified first. If the folder cannot be written, the status
    is "not saved", and the result contains the motion up to there.

    The model and the options are read from the folder as data. What they cannot contain is passed again: events with
    Python functions, a method of your own, and a system whose model a model file cannot describe.

    Parameters
    ----------
    path : the folder of ``simulate(..., save=path)``
    system, events, method : those of the run, where the folder does not contain them
    progress, time_limit : as for `simulate`

    Raises
    ------
    SarrusError
        If there is no run (also a FileNotFoundError), if it is damaged, of another version, or needs what was not
        passed again (also a ValueError), or if another process writes it (also a FileExistsError).
    """
    folder = Path(path)
    recipe = recipe_in(folder, system, events=events, method=method)
    if awaits_checkpoint(folder):
        with monitor(progress, recipe.plan.until, time_limit=time_limit) as message:
            return recipe.saved(folder, message)
    about, _, state = arrays_of(folder)
    if "record._written" not in state:
        remedy = "Open it with sarrus.load_run, or simulate anew."
        raise SavedDataError(
            f"{folder}: its checkpoint was written by an earlier version of Sarrus. {remedy}"
        )
    if json.loads(str(state["told"]))["status"] not in UNFINISHED:
        return recipe.loop().recording.over(state, folder)
    announce(other_versions(about))
    try:
        store, state = Store.reopen(folder)
    except NotSavedError as wrong:
        return replace(load_run(folder, recipe.system), success=False, status=NOT_SAVED, message=str(wrong))
    with store, monitor(progress, recipe.plan.until, time_limit=time_limit) as message:
        return recipe.done(message, store, state)


@reports_warnings
@one_thread_if_small
def repeat(
    path: str | os.PathLike[str],
    *,
    system: System | None = None,
    events: Events | None = None,
    method: Method | None = None,
) -> Trajectory:
    """Repeat a saved run in memory, with its stored model and options.

    Parameters
    ----------
    path : the folder that the run was saved in
    system, events, method : see `resume`
    """
    return recipe_in(Path(path), system, events=events, method=method).done()


def recipe_in(folder: Path, system: System | None = None, **again: Any) -> Recipe:
    """The run in a folder, prepared again; arguments that the folder does not contain are given.

    Raises
    ------
    SavedDataError
        If it was not saved while it was computed, or if an argument is missing or another one.
    """
    stored = recipe_of(folder)
    if "arguments" not in stored:
        message = f"{folder}: was saved after the run, by run.save, without its options and its steps."
        raise SavedDataError(f"{message} Simulate with save= for a folder by which the run can be repeated.")
    parts = {name: part.tobytes() for name, part in stored["arguments"].items()}
    found = {name: _argument(folder, name, part, again.get(name)) for name, part in parts.items()}
    return Recipe.of(system_of(folder, stored, system), found.pop("start"), found)


def _argument(folder: Path, name: str, stored: bytes, again: Any) -> Any:
    """A stored argument of `simulate`, or the same one given again."""

    def refuse(function: str) -> NoReturn:
        message = f"{folder}: does not contain {function} of its {name}, since no code is saved."
        raise SavedDataError(f"{message} Pass {name}= again, as to simulate.")

    if again is None:
        return loads(folder / RECIPE, stored, STORED, refuse)
    again = listed_events(again) if name == "events" else method_with_options(again)
    if dumps(again, STORED) != stored:
        raise SavedDataError(f"{folder}: was computed with other {name}. Pass those of the run.")
    return again


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


def _passed_over(system: System, step: float | None) -> Iterator[str]:
    """Steps of a given length that pass over jumps."""
    if step is not None and (owners := that_jump(system)):
        yield (
            f"{system.name}: a law of {quote(owners[0])} jumps, and steps of a given length do not end there, which "
            "may be a large error. Take a method without a given step, or a law that changes within a width."
        )
