"""A run in memory, written to a folder after its end; `reading` reads it."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..model import Model
from .motion.events import EventRecord
from .saving.saved import COUNTS, OVER_TIME, Store

if TYPE_CHECKING:
    from ..system import System
    from .motion.trajectory import Trajectory


@dataclass(frozen=True)
class SystemOf:
    """The system of a stored model, built when it is called."""

    model: Model

    def __call__(self) -> System:
        from ..system import System

        return System(self.model)


def state_names(system: System) -> dict[str, list[Any]]:
    """The place and the unit of each first-order state, by name; those that drivers follow are in q, others in v."""
    found = {"v": system.states, "q": system.followed_states}
    return {
        name: [int(one.place), one.unit, kind] for kind, own in found.items() for name, one in own.items()
    }


def save_finished(run: Trajectory, path: str | os.PathLike[str], *, overwrite: bool = False) -> None:
    """Write the states of a run, its events and its record; see `Trajectory.save`."""
    system: Any = run.system
    about: dict[str, Any] = {
        "name": run.name,
        "bodies": list(run.bodies),
        "coordinates": list(run.coordinate_names),
    }
    about |= {"equations": list(system.row_names), "method": "", "until": float(run.t[-1])}
    about["states"] = state_names(system)
    samples = SimpleNamespace(
        violation=np.column_stack([run.violation, run.velocity_violation]),
        energy=np.column_stack([run.kinetic_energy, run.potential_energy]),
    )
    for name in OVER_TIME:
        if not hasattr(samples, name):
            setattr(samples, name, np.asarray(getattr(run, name)))
    model = {"system": SystemOf(system.model)}
    with Store.create(path, samples.t, system, about, model, overwrite=overwrite) as store:
        store.write(samples, np.asarray(run.history))
        final = {} if run.final is None else run.final.to_store()
        store.finish({**final, **_events(run.events), "told": np.array(json.dumps(_record(run)))})


def _record(run: Trajectory) -> dict[str, Any]:
    """What `load_run` reads besides the arrays."""
    found = {name: getattr(run, name) for name in (*COUNTS, "status", "message", "singular", "warnings")}
    return {**found, "t": float(run.t[-1])}


def _events(records: tuple[EventRecord, ...]) -> dict[str, Any]:
    """The events as arrays, see `event_records`."""
    names = list(dict.fromkeys(one.name for one in records))
    found = {"event_of": np.array([names.index(one.name) for one in records], dtype=np.int64)}
    found["event_names"] = np.array(names, dtype="U")
    return found | {
        f"event_{n}": np.array([getattr(one, n) for one in records]) for n in ("t", "q", "v", "after")
    }
