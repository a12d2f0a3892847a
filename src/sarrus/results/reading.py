"""A saved run as a trajectory whose arrays are read on demand."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from ..model import SarrusError
from ..model.announcement import Call, collecting
from ..model.checks.arguments import checked
from ..model.read_only import read_only
from .motion.events import event_records
from .motion.solution import State
from .motion.trajectory import Trajectory
from .saving.checked_file import SavedDataError
from .saving.saved import COUNTS, STORED_STEPS, arrays_of, recipe_of

if TYPE_CHECKING:
    from ..system import System


@checked
def load_run(path: str | os.PathLike[str], system: Any = None) -> Trajectory:
    """Open a run saved by ``simulate(..., save=path)``, also one that was interrupted or is still running.

    All data are verified by the checksums with which they were written.

    Parameters
    ----------
    path : the folder
    system : the system that moved, for reactions and joints; by default that of the model in the folder, if it can be
        read

    Returns
    -------
    Trajectory
        ``t`` and other small arrays are in memory; of ``q``, ``v``, ``a``, ``lam`` and ``history``, the indexed parts
        are read from disk; ``np.asarray(run.q)`` reads everything. Stored steps are opened by `resume` only.

    Raises
    ------
    SarrusError
        If there is no run (also a FileNotFoundError), or if it is damaged, in another format or of another system (also
        a ValueError); states that are damaged are refused where they are indexed.
    """
    folder = Path(path)
    about, arrays, state = arrays_of(folder)
    record = json.loads(str(state["told"]))
    if system is not None:
        _refuse_other(folder, about, system)
    else:
        with suppress(SarrusError), collecting():
            system = system_of(folder, recipe_of(folder))
    violation, energy = (np.asarray(arrays[name]) for name in ("violation", "energy"))
    names = ("q", "v", "a", "lam", "history", "memory", "revolutions")
    states: dict[str, Any] = {name: arrays[name] for name in names}
    counts: dict[str, Any] = {name: record[name] for name in COUNTS}
    run = Trajectory(
        name=about["name"],
        bodies=tuple(about["bodies"]),
        coordinate_names=tuple(about["coordinates"]),
        states={name: _place(*one) for name, one in about.get("states", {}).items()},
        t=np.asarray(arrays["t"]),
        violation=violation[:, 0],
        velocity_violation=violation[:, 1],
        kinetic_energy=energy[:, 0],
        potential_energy=energy[:, 1],
        success=record["status"] in ("finished", "event"),
        status=record["status"],
        message=record["message"],
        events=tuple(event_records(state)),
        singular=tuple(record.get("singular", ())),
        warnings=tuple(record.get("warnings", ())),
        final=State.stored(state),
        joints=None if system is None else system.joint_coordinates,
        system=system,
        call=Call(load_run, (), {"path": folder}),
        steps_folder=str(folder) if "recipe" in about and STORED_STEPS in state else "",
        **states,
        **counts,
    )
    return cast(Trajectory, read_only(run))


def _place(place: Any, unit: Any, kind: str = "v") -> tuple[int, str, str]:
    """The place of a state, its unit, and in which array it is; older files have no others than velocities."""
    return int(place), str(unit), kind


def system_of(folder: Path, recipe: Mapping[str, Any], given: Any = None) -> System:
    """The system of a saved run, of the model in its folder, or given again.

    Raises
    ------
    SavedDataError
        If there is no model in the folder, or if the system is another one.
    """
    from ..model.file.load import loaded, parsed
    from ..system import System

    if given is None and recipe["model"] is None:
        message = f"{folder}: does not contain its model ({recipe['reason']})."
        raise SavedDataError(f"{message} Pass the same system, as in sarrus.resume(folder, system=system).")
    system: System = given or System(loaded(parsed(recipe["model"], folder / "model.json")))
    _refuse_other(folder, recipe, system)
    return system


def _refuse_other(folder: Path, about: Mapping[str, Any], system: System) -> None:
    """Coordinates and multipliers of a run are those of its own system, in its order of equations."""
    own: dict[str, Any] = {"coordinates": system.coordinate_names, "equations": system.row_names}
    own |= {"parameters": system.b} if "parameters" in about else {}
    other = next(
        (kind for kind, found in own.items() if [*map(repr, about[kind])] != [*map(repr, found)]), ""
    )
    if other:
        raise SavedDataError(
            f"{folder}: is a run of another system than {system.name}, whose {other} differ or are in another order. "
            "Give the system that moved, or leave it out."
        )
