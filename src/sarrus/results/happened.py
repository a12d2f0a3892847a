"""An event that was found along a motion."""

from __future__ import annotations

from dataclasses import dataclass, field

from ..algebra import Array


@dataclass(frozen=True, eq=False)
class Happened:
    """One crossing of one event.

    Attributes
    ----------
    name : of the event
    t : when [s]
    q : (nq,) coordinates
    v : (nq,) velocities before
    after : (nq,) velocities after; the same where nothing was reset
    """

    name: str
    t: float
    q: Array = field(repr=False)
    v: Array = field(repr=False)
    after: Array = field(repr=False)
