"""What a run was asked for, so that it can be repeated or gone on with from its own file."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ...algebra import Array
from ...model import Model, reports_warnings
from ...results import Assembly, Trajectory
from ...results.saved import Store, recipe_of
from ...system import System
from ..progress import monitor
from .crossing import Crossing
from .march import March, Plan
from .stepper import Settings


@dataclass(frozen=True)
class Recipe:
    """Model, start, method and settings of a run."""

    model: Model
    start: Assembly
    method: Any
    settings: Settings
    plan: Plan

    def as_dict(self) -> dict[str, Any]:
        """What is stored."""
        return {"recipe": self, "system": _SystemOf(self.model)}

    def march(self, system: System, store: Store | None, progress: Callable[[float], None] | None) -> March:
        """The run, at its start."""
        stepper = self.method.stepper(system, self.start, self.settings)
        if not self.settings.keep_steps:
            stepper = Crossing(stepper, system, self.settings)
        return March(system, stepper, replace(self.plan, store=store, progress=progress))

    def store(self, path: str | os.PathLike[str], system: System) -> Store:
        """A folder for the run."""
        about: dict[str, Any] = {"name": system.name, "bodies": list(system.bodies)}
        about |= {"coordinates": list(system.coordinate_names), "method": repr(self.method)}
        about["until"] = self.plan.until
        return Store.create(path, self.plan.times, system, about, self.as_dict())


@dataclass(frozen=True)
class _SystemOf:
    """The system of a stored model, made when it is asked for."""

    model: Model

    def __call__(self) -> System:
        return System(self.model)


@reports_warnings
def resume(
    path: str | os.PathLike[str],
    *,
    progress: bool | Callable[[float], None] | None = None,
    time_limit: float | None = None,
    strict: bool = False,
) -> Trajectory:
    """Go on with a saved run that was cut short: the numbers are, bit by bit, those of a run in one go.

    Of a run that is over, what is saved is opened: as by `load_run`, with the whole motion and the steps, if kept.
    Model and options are read from the folder, which runs code that it holds: trust where it comes from.

    Parameters
    ----------
    path : the folder that was given to ``simulate(..., save=path)``
    progress, time_limit : as for `simulate`
    strict : raise the first warning as a `StrictError`

    Raises
    ------
    FileNotFoundError
        If there is no run.
    ValueError
        If the run was given functions that could not be stored.
    """
    recipe: Recipe = recipe_of(Path(path))["recipe"]
    store, state = Store.reopen(path)
    system = System(recipe.model)
    if _is_over(state):
        return recipe.march(system, store, None).over(state)
    with monitor(progress, recipe.plan.until, time_limit=time_limit) as told:
        return recipe.march(system, store, told).go(recipe.start, state)


@reports_warnings
def repeat(path: str | os.PathLike[str], *, strict: bool = False) -> Trajectory:
    """Do a saved run once more, from its own file, in memory; see `resume` on trust."""
    recipe: Recipe = recipe_of(Path(path))["recipe"]
    return recipe.march(System(recipe.model), None, None).go(recipe.start)


def _is_over(state: dict[str, Array]) -> bool:
    return json.loads(str(state["told"]))["status"] not in ("cut short", "stopped", "time limit")
