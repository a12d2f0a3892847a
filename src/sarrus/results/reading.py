"""A saved run as a trajectory whose arrays are read on demand."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np

from ..model.announcement import Call
from ..model.checks.arguments import checked
from .motion.events import event_records
from .motion.solution import State
from .motion.trajectory import Trajectory
from .saving.checked_file import SavedDataError
from .saving.saved import COUNTS, arrays_of, recipe_of


@checked
def load_run(path: str | os.PathLike[str], system: Any = None, *, trusted: bool = False) -> Trajectory:
    """Open a run saved by ``simulate(..., save=path)``, also one that was interrupted or is still running.

    All data are verified by the checksums with which they were written.

    Parameters
    ----------
    path : the folder
    system : the system that moved, for reactions and joints
    trusted : whether to create the system from the model in the folder, which executes code in the folder

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
    if system is None and trusted:
        system = recipe_of(folder, trusted)["system"]()
    if system is not None:
        _refuse_other(folder, about, system)
    violation, energy = (np.asarray(arrays[name]) for name in ("violation", "energy"))
    names = ("q", "v", "a", "lam", "history", "memory", "revolutions")
    states: dict[str, Any] = {name: arrays[name] for name in names}
    counts: dict[str, Any] = {name: record[name] for name in COUNTS}
    return Trajectory(
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
        steps_folder=str(folder) if "recipe" in about and "kept_t" in state else "",
        **states,
        **counts,
    )


def _place(place: Any, unit: Any, kind: str = "v") -> tuple[int, str, str]:
    """The place of a state, its unit, and in which array it is; older files have no others than velocities."""
    return int(place), str(unit), kind


def _refuse_other(folder: Path, about: dict[str, Any], system: Any) -> None:
    """Coordinates and multipliers of a run are those of its own system, in its order of equations."""
    own = {"coordinates": system.coordinate_names, "equations": system.row_names}
    other = next((kind for kind, names in own.items() if about[kind] != list(names)), None)
    if other is not None:
        raise SavedDataError(
            f"{folder}: is a run of another system than {system.name}, whose {other} differ or are in another order. "
            "Give the system that moved, or leave it out."
        )
