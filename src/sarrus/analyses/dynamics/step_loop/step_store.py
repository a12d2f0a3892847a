"""The record of steps: buffers for one chunk in the compiled loop, and for derivatives all that has been collected."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from ....algebra import Array
from ....results import StepsTaken
from ....system import System
from ..stepping.stepper import HISTORY, Settings
from .records import Record

MEMORY, LEFT_OUT = "memory", "left_out"
NODE = ("t", "q", "v", "node_a", "lam", "memory")


class StepStore:
    """Buffers for the steps of one call of the loop; stored steps are written behind those before.

    Parameters
    ----------
    system : System
    record : of the loop, with buffers for the steps of one call; `given` is put in place here
    settings : whether steps are stored, and lengths of the steps where they are prescribed
    """

    def __init__(self, system: System, record: Record, settings: Settings) -> None:
        self._given = (
            np.zeros(0) if settings.given is None else np.ascontiguousarray(settings.given, dtype=float)
        )
        self._record, self._places = record, system.memory_places
        own = {field.name for field in fields(StepsTaken)} - {MEMORY}
        self._names = [name for name in record._fields if name in own]
        self.wanted = settings.store_steps
        self._now, self._taken = record, 0
        self.count, self._rows = 0, dict[str, Array]()

    def begin(self, left_out: Array, **first: Any) -> None:
        """The state before the first step; what was stored before is forgotten. `left_out` is looked at later."""
        self._out, self._taken, self._first = left_out, 0, tuple(first)
        self._rows = {}
        if self.wanted:
            self._reserve(0)
            for name, value in first.items():
                self._rows[name][0] = value
            self._rows[LEFT_OUT][0] = left_out > 0

    def forget(self, **first: Any) -> None:
        """Forget the past; the next step is the first one."""
        self.begin(self._out, **first)

    def _reserve(self, count: int) -> None:
        """Buffers for one call behind so many steps; they are doubled, so that each step is copied about once."""
        wanted, have = count + len(self._record.t) + 1, len(self._rows[LEFT_OUT]) if self._rows else 0
        if wanted <= have:
            return
        like = {name: getattr(self._record, name) for name in (*self._names, MEMORY)}
        like[LEFT_OUT] = np.zeros((0, len(self._out)), dtype=bool)
        for name, one in like.items():
            rows = np.empty((max(wanted, 2 * have), *one.shape[1:]), one.dtype)
            before = self._rows.get(name, rows)[: min(count + 1, have)]
            rows[: len(before)] = before
            self._rows[name] = rows

    def _stored(self, name: str) -> Array:
        """The rows of all steps, with that of the first state where there is one."""
        return self._rows[name][: self._taken + (name in self._first or name == LEFT_OUT)]

    def given(self) -> Array:
        """The lengths that are still to be taken."""
        return self._given[self.count :]

    def record(self) -> Record:
        """What the loop writes into, and the lengths that are still to be taken."""
        found = {"given": self.given()}
        if self.wanted:
            self._reserve(self._taken)
            for name in self._names:
                at = self._taken + (name in self._first)
                found[name] = self._rows[name][at : at + len(self._record.t)]
        self._now = self._record._replace(**found)
        return self._now

    def history(self, taken: int) -> Array:
        """The steps of the last call: end, length, error, iterations, rejected before it."""
        record = self._now
        columns = (record.t, record.h, record.error, record.iterations, record.rejected)
        history: Array = np.column_stack([column[:taken] for column in columns])
        assert history.shape[1] == HISTORY
        return history

    def collect(self, taken: int, memory: Array) -> list[Array]:
        """The nodes of the last call; `memory` is what elements remembered before its first step."""
        record, at = self._now, self._taken
        self.count += taken
        if self.wanted and taken:
            self._taken += taken
            self._rows[LEFT_OUT][at + 1 : self._taken + 1] = self._out > 0
            self._rows[MEMORY][at] = memory
            self._rows[MEMORY][at + 1 : self._taken] = record.memory[: taken - 1]
        return [getattr(record, name)[:taken] for name in NODE]

    def state(self) -> dict[str, Array]:
        """All stored steps, for `resume`; nothing where steps are not stored."""
        if not self.wanted:
            return {}
        found = {f"first_{name}": self._rows[name][0] for name in self._first}
        found |= {name: self._rows[name][name in self._first :][: self._taken] for name in self._names}
        found |= {LEFT_OUT: self._stored(LEFT_OUT), MEMORY: self._stored(MEMORY)}
        return {f"kept_{name}": np.array(array) for name, array in found.items()}

    def resume(self, state: Mapping[str, Array], left_out: Array) -> None:
        """Go on from such a state; `left_out` as for `begin`."""
        self._out = left_out
        if not self.wanted:
            return
        names = [name[11:] for name in state if name.startswith("kept_first_")]
        self.begin(left_out, **{name: state[f"kept_first_{name}"] for name in names})
        self._taken = self.count = len(state[f"kept_{MEMORY}"])
        self._reserve(self._taken)
        for name in self._names:
            self._stored(name)[name in self._first :] = state[f"kept_{name}"]
        for name in (LEFT_OUT, MEMORY):
            self._stored(name)[:] = state[f"kept_{name}"]

    def steps(self, **message: Any) -> StepsTaken | None:
        """All steps, with the state of the start before them; None if none are stored, or before it begins."""
        if not (self.wanted and self._rows):
            return None
        message |= {name: self._stored(name) for name in (*self._names, MEMORY)}
        left_out = self._stored(LEFT_OUT)
        message |= {LEFT_OUT: left_out if np.any(left_out) else left_out[:0], "places": self._places}
        return StepsTaken(**message)
