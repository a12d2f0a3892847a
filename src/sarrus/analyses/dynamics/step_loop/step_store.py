"""The record of steps: buffers for one chunk in the compiled loop, and for derivatives all that has been collected."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any

import numpy as np

from ....algebra import Array
from ....results import StepsTaken
from ....system import System
from ..stepping.stepper import HISTORY, Settings
from .records import Record

MEMORY, LEFT_OUT = "memory", "left_out"
FIRST = ("t", "q", "v", "a", "lam", LEFT_OUT)  # what is stored of the state before the first step, too
NODE = ("t", "q", "v", "node_a", "lam", "memory")


class StepStore:
    """Buffers for the steps of one call of the loop; stored steps are written behind those before.

    Parameters
    ----------
    system : System
    record : of the loop, with buffers for the steps of one call; `given` is put in place here
    settings : whether steps are stored, and lengths of the steps where they are prescribed
    left_out : 1 for equations that are left out; looked at after each call
    """

    def __init__(self, system: System, record: Record, settings: Settings, left_out: Array) -> None:
        self._given = (
            np.zeros(0) if settings.given is None else np.ascontiguousarray(settings.given, dtype=float)
        )
        self._record, self._places = record, system.memory_places
        own = {field.name for field in fields(StepsTaken)} - {MEMORY}
        self._names = [name for name in record._fields if name in own]
        self.wanted = settings.store_steps
        self._now, self._taken, self._out = record, 0, left_out
        self.count, self._rows = 0, dict[str, Array]()

    def begin(self, **first: Any) -> None:
        """The state before the first step, with the values of `FIRST`; what was stored before is forgotten."""
        self._taken, self._rows = 0, {}
        if self.wanted:
            self._reserve(0)
            for name, value in (first | {LEFT_OUT: self._out > 0}).items():
                self._rows[name][0] = value

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
        return self._rows[name][: self._taken + (name in FIRST)]

    def given(self) -> Array:
        """The lengths that are still to be taken."""
        return self._given[self.count :]

    def record(self) -> Record:
        """What the loop writes into, and the lengths that are still to be taken."""
        found = {"given": self.given()}
        if self.wanted:
            self._reserve(self._taken)
            for name in self._names:
                at = self._taken + (name in FIRST)
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
        return {name: self._stored(name).copy() for name in self._rows}

    def resume(self, state: Mapping[str, Array]) -> None:
        """Go on from such a state."""
        if self.wanted:
            self._rows, self._taken = {}, len(state[MEMORY])
            self.count = self._taken
            self._reserve(self._taken)
            for name in self._rows:
                self._stored(name)[:] = state[name]

    def steps(self, **message: Any) -> StepsTaken | None:
        """All steps, with the state of the start before them; None if none are stored, or before it begins."""
        if not (self.wanted and self._rows):
            return None
        message |= {name: self._stored(name) for name in (*self._names, MEMORY)}
        left_out = self._stored(LEFT_OUT)
        message |= {LEFT_OUT: left_out if np.any(left_out) else left_out[:0], "places": self._places}
        return StepsTaken(**message)


def writable(steps: StepsTaken) -> StepsTaken:
    """The steps with arrays that can be written, as compiled code takes no others, although it only reads them."""
    values = {one.name: getattr(steps, one.name) for one in fields(steps)}
    arrays: dict[str, Any] = {n: _writable(x) for n, x in values.items() if isinstance(x, np.ndarray)}
    return replace(steps, **arrays)


def _writable(array: Array) -> Array:
    found = array.view()
    try:
        found.setflags(write=True)
    except ValueError:  # the memory is that of a pickled run
        return array.copy()
    return found
