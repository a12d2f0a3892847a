"""An event that was found along a motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

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


def event_records(state: Mapping[str, Array]) -> list[EventRecord]:
    """The events of a checkpoint."""
    columns = (state[f"event_{name}"] for name in ("of", "t", "q", "v", "after"))
    rows = zip(*columns, strict=True)
    return [EventRecord(str(state["event_names"][n]), float(t), q, v, after) for n, t, q, v, after in rows]
