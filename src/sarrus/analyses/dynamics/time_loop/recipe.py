"""Options of a run, stored so that it can be repeated or continued from its own file."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ....algebra import Array
from ....linalg.threads import one_thread_if_small
from ....model import Model
from ....model.announcement import announce, reports_warnings
from ....results import Assembly, Trajectory, load_run
from ....results.saving.checked_file import NOT_SAVED, NotSavedError, SavedDataError
from ....results.saving.saved import (
    UNFINISHED,
    Store,
    arrays_of,
    awaits_checkpoint,
    other_versions,
    recipe_of,
)
from ....results.writing import SystemOf, state_names
from ....system import System
from ...progress import monitor
from ..events.crossing import Crossing
from ..stepping.stepper import IntegrationMethod, RunFailure, Settings
from .energy_check import energy_change
from .outcome import nothing
from .time_loop import Plan, TimeLoop


@dataclass(frozen=True)
class Recipe:
    """Model, start, method and settings of a run.

    Attributes
    ----------
    options : of `simulate`, as the user gave them, which the settings and the plan do not have
    """

    model: Model
    start: Assembly
    method: IntegrationMethod
    settings: Settings
    plan: Plan
    options: Mapping[str, Any] = field(default_factory=dict)

    def arguments(self) -> dict[str, Any]:
        """The arguments of `simulate` for the same run."""
        own = {"system": System(self.model), "start": self.start, "method": self.method}
        plan, stored = self.plan, self.settings.store_steps
        own |= {"until": plan.until, "t_eval": plan.times, "events": plan.events, "dense_output": plan.dense}
        return {**own, "store_steps": stored, **self.options}

    def as_dict(self) -> dict[str, Any]:
        """Return the stored data."""
        return {"recipe": self, "system": SystemOf(self.model)}

    def loop(self, system: System, store: Store | None, progress: Callable[[float], None] | None) -> TimeLoop:
        """The run, at its start."""
        stepper = self.method.stepper(system, self.start, self.settings)
        if not self.settings.store_steps:
            stepper = Crossing(stepper, system, self.settings)
        return TimeLoop(system, stepper, replace(self.plan, store=store, progress=progress))

    def done(
        self,
        system: System,
        store: Store | None,
        progress: Callable[[float], None] | None,
        state: Mapping[str, Array] | None = None,
    ) -> Trajectory:
        """The run from its start or a saved state on; warnings about its energy are saved with it."""
        run = self.loop(system, store, progress).go(self.start, state)
        found = announce(energy_change(system, run, self.settings.tolerances))
        if store is not None and found:
            store.warn(found)
        return run

    def store(self, path: str | os.PathLike[str], system: System, *, overwrite: bool = False) -> Store:
        """A folder for the run, see `Store.create`."""
        about: dict[str, Any] = {"name": system.name, "bodies": list(system.bodies)}
        about |= {"coordinates": list(system.coordinate_names), "equations": list(system.row_names)}
        about["method"], about["states"] = repr(self.method), state_names(system)
        about["until"] = self.plan.until
        return Store.create(path, self.plan.times, system, about, self.as_dict(), overwrite=overwrite)

    def saved(
        self,
        path: str | os.PathLike[str],
        system: System,
        progress: Callable[[float], None] | None,
        *,
        overwrite: bool = False,
    ) -> Trajectory:
        """The run from its start, written to a folder."""
        try:
            store = self.store(path, system, overwrite=overwrite)
            with store:
                return self.done(system, store, progress)
        except NotSavedError as wrong:
            return nothing(system, NOT_SAVED, str(wrong))
        except RunFailure as error:
            return nothing(system, error.status, error.message)


@reports_warnings
@one_thread_if_small
def resume(
    path: str | os.PathLike[str],
    *,
    progress: bool | Callable[[float], None] | None = None,
    time_limit: float | None = None,
    strict: bool = False,
    trusted: bool = False,
) -> Trajectory:
    """Continue an interrupted saved run; the result has the same bits as an uninterrupted run.

    A complete run is opened as by `load_run`, with the whole motion and the steps, if stored. A run that was stopped
    before its first checkpoint starts again. All data are verified first. If the folder cannot be written, the status
    is "not saved", and the result contains the motion up to there.

    The model and the options are read from the folder. If they contain functions or classes of the user, such as events
    or forces in Python, loading them can run any code, and `trusted` is needed.

    Parameters
    ----------
    path : the folder of ``simulate(..., save=path)``
    progress, time_limit : as for `simulate`
    strict : raise the first warning as a `StrictError`
    trusted : whether the folder may name functions and classes of other modules than Sarrus's

    Raises
    ------
    SarrusError
        If there is no run (also a FileNotFoundError), if it is damaged, of another version, or its functions could not
        be stored (also a ValueError), or if another process writes it (also a FileExistsError).
    """
    folder = Path(path)
    recipe = options_of(folder, trusted)
    system = System(recipe.model)
    if awaits_checkpoint(folder):
        with monitor(progress, recipe.plan.until, time_limit=time_limit) as message:
            return recipe.saved(folder, system, message)
    about, _, state = arrays_of(folder)
    if _is_over(state):
        return recipe.loop(system, None, None).over(state, folder)
    announce(other_versions(about))
    try:
        store, state = Store.reopen(folder)
    except NotSavedError as wrong:
        return replace(load_run(folder, system), success=False, status=NOT_SAVED, message=str(wrong))
    with store, monitor(progress, recipe.plan.until, time_limit=time_limit) as message:
        return recipe.done(system, store, message, state)


@reports_warnings
@one_thread_if_small
def repeat(path: str | os.PathLike[str], *, strict: bool = False, trusted: bool = False) -> Trajectory:
    """Repeat a saved run in memory, with its stored model and options.

    Parameters
    ----------
    path : the folder that the run was saved in
    strict : raise the first warning as a `StrictError`
    trusted : see `resume`
    """
    recipe = options_of(Path(path), trusted)
    return recipe.done(System(recipe.model), None, None)


def options_of(folder: Path, trusted: bool) -> Recipe:
    """The stored options, which a run has that was saved while it was computed."""
    stored = recipe_of(folder, trusted)
    if "recipe" not in stored:
        message = f"{folder}: was saved after the run, by run.save, without its options and its steps."
        raise SavedDataError(f"{message} Open it with sarrus.load_run, or simulate with save=.")
    found: Recipe = stored["recipe"]
    return replace(found, plan=replace(found.plan, trusted=trusted))


def _is_over(state: dict[str, Array]) -> bool:
    return json.loads(str(state["told"]))["status"] not in UNFINISHED
