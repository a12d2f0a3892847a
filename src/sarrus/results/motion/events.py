"""An event that was found along a motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ...algebra import Array


@dataclass(frozen=True, eq=False)
class EventRecord:
    """One occurrence of an event: its name, time and state.

    Attributes
    ----------
    name : of the event
    t : time [s]
    q : (nq,) coordinates
    v : (nq,) velocities before the event
    after : (nq,) velocities after the event; equal to v without a reset
    """

    name: str
    t: float
    q: Array = field(repr=False)
    v: Array = field(repr=False)
    after: Array = field(repr=False)


def records_to_store(records: Sequence[EventRecord], names: Sequence[str]) -> dict[str, Array]:
    """The events in a checkpoint, with the names of all that are looked for."""
    found = {"event_of": np.array([names.index(one.name) for one in records], dtype=np.int64)}
    found["event_names"] = np.array(names, dtype="U")
    columns = ("t", "q", "v", "after")
    return found | {f"event_{n}": np.array([getattr(one, n) for one in records]) for n in columns}


def event_records(state: Mapping[str, Array]) -> list[EventRecord]:
    """The events of a checkpoint."""
    columns = (state[f"event_{name}"] for name in ("of", "t", "q", "v", "after"))
    rows = zip(*columns, strict=True)
    return [EventRecord(str(state["event_names"][n]), float(t), q, v, after) for n, t, q, v, after in rows]
