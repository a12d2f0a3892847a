"""The record of steps: room for one chunk in the compiled loop, and for derivatives all that has been collected."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...algebra import Array
from ...results import Steps
from ...system import System
from . import alpha_loop as loop
from .stepper import HISTORY, Settings

FIELDS = ("t", "h", "removed", "q", "v", "a", "x", "lam")
NODE = ("t", "q", "v", "a", "lam", "memory")


class Keeping:
    """Room for the steps of one call of the loop; and the chunks collected before, where they are kept.

    Parameters
    ----------
    system : System
    room : steps for one call
    settings : whether steps are kept, and lengths of the steps where they are prescribed
    """

    def __init__(self, system: System, room: int, settings: Settings) -> None:
        nq, m, places = system.nq, system.m, system.memory_places
        shapes = [*[(room,)] * 3, *[(room, nq)] * 4, (room, m), (room, len(places)), (room, 3)]
        given = np.zeros(0) if settings.given is None else np.ascontiguousarray(settings.given, dtype=float)
        self._record = loop.Record._make([*(np.zeros(shape) for shape in shapes), given])
        self._given, self._places, self.wanted = given, places, settings.keep_steps
        self._chunks: list[list[Array]] = []
        self._left_out: list[Array] = []
        self._memory: list[Array] = []
        self.count = 0

    def begin(self, t: float, state: loop.State, left_out: Array) -> None:
        """The state before the first step."""
        self._first = {"t": np.array(t), "left_out": left_out.copy()}
        self._first |= {n: getattr(state, f"{n}0").copy() for n in ("q", "v", "a", "x", "lam")}
        self._out = left_out

    def given(self) -> Array:
        """The lengths that are still to be taken."""
        return self._given[self.count :]

    def record(self) -> loop.Record:
        """What the loop writes into, and the lengths that are still to be taken."""
        return self._record._replace(given=self.given())

    def history(self, taken: int) -> Array:
        """The steps of the last call: end, length, error, iterations, rejected before it."""
        record = self._record
        history: Array = np.column_stack([record.t[:taken], record.h[:taken], record.told[:taken]])
        assert history.shape[1] == HISTORY
        return history

    def collect(self, taken: int, memory: Array) -> list[Array]:
        """The nodes of the last call; `memory` is what elements remembered before its first step."""
        self.count += taken
        record = self._record
        if self.wanted and taken:
            self._chunks.append([getattr(record, name)[:taken].copy() for name in FIELDS])
            self._left_out.append(np.tile(self._out > 0, (taken, 1)))
            self._memory.append(np.concatenate([memory[None], record.memory[: taken - 1]]))
        return [getattr(record, name)[:taken] for name in NODE]

    def steps(self, **told: Any) -> Steps | None:
        """All steps, with the state of the start before them."""
        if not self.wanted:
            return None
        empty = [getattr(self._record, name)[:0] for name in FIELDS]
        columns = (np.concatenate(x) for x in zip(empty, *self._chunks, strict=True))
        whole = dict(zip(FIELDS, columns, strict=True))
        for name in ("t", "q", "v", "a", "x", "lam"):
            whole[name] = np.concatenate([self._first[name][None], whole[name]])
        left_out = np.concatenate([self._first["left_out"][None] > 0, *self._left_out])
        if not np.any(left_out):
            left_out = left_out[:0]
        memory = np.concatenate([np.zeros((0, len(self._places))), *self._memory])
        told |= {**whole, "left_out": left_out, "places": self._places, "memory": memory}
        return Steps(**told)
