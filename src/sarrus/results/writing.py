"""A run in memory, written to a folder after its end; `reading` reads it."""

from __future__ import annotations

import json
import os
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..model import ModelError
from .motion.events import records_to_store
from .saving.data_bytes import dumps
from .saving.saved import COUNTS, OVER_TIME, Store

if TYPE_CHECKING:
    from ..system import System
    from .motion.trajectory import Trajectory


def system_data(system: System, folder: str | os.PathLike[str]) -> dict[str, Any]:
    """The model of a system as the text of a model file, or why it has none, and what the system is known by."""
    from ..model.file.plain_data import plain_data
    from ..model.file.text.model_text import json_text

    found: dict[str, Any] = {"coordinates": system.coordinate_names, "equations": system.row_names}
    found["parameters"] = system.b
    try:
        return {**found, "model": json_text(plain_data(system.model, Path(folder)))}
    except ModelError as wrong:
        return {**found, "model": None, "reason": str(wrong).rstrip(".")}


def attributes(system: System, method: str, until: float) -> dict[str, Any]:
    """What the folder of a run is about.

    It has the place and the unit of each first-order state; those that drivers follow are in q, others in v.
    """
    names = {"bodies": list(system.bodies), "coordinates": list(system.coordinate_names)}
    kinds = {"v": system.states, "q": system.followed_states}.items()
    states = {n: [int(one.place), one.unit, kind] for kind, own in kinds for n, one in own.items()}
    own = {"name": system.name, **names, "equations": list(system.row_names), "states": states}
    return {**own, "method": method, "until": until}


def save_finished(run: Trajectory, path: str | os.PathLike[str], *, overwrite: bool = False) -> None:
    """Write the states of a run, its events and its record; see `Trajectory.save`."""
    system: Any = run.system
    samples = SimpleNamespace(
        violation=np.column_stack([run.violation, run.velocity_violation]),
        energy=np.column_stack([run.kinetic_energy, run.potential_energy]),
    )
    for name in OVER_TIME:
        if not hasattr(samples, name):
            setattr(samples, name, np.asarray(getattr(run, name)))
    about, recipe = attributes(system, "", float(run.t[-1])), dumps(system_data(system, path), {})
    with Store.create(path, samples.t, system, about, recipe, overwrite=overwrite) as store:
        store.write(samples, np.asarray(run.history))
        names = list(dict.fromkeys(one.name for one in run.events))
        final = {} if run.final is None else run.final.to_store()
        store.finish(
            {**final, **records_to_store(run.events, names), "told": np.array(json.dumps(_record(run)))}
        )


def _record(run: Trajectory) -> dict[str, Any]:
    """What `load_run` reads besides the arrays."""
    found = {name: getattr(run, name) for name in (*COUNTS, "status", "message", "singular", "warnings")}
    return {**found, "t": float(run.t[-1])}
