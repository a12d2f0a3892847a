"""The record of steps: room for one chunk in the compiled loop, and for derivatives all that has been collected."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from ...algebra import Array
from ...results import StepsTaken
from ...system import System
from .stepper import HISTORY, Settings

NODE = ("t", "q", "v", "a", "lam", "memory")


class Keeping:
    """Room for the steps of one call of the loop; and the chunks collected before, where they are kept.

    Parameters
    ----------
    system : System
    record : of the method's loop, with room for the steps of one call; `given` is put in place here
    kind : of the steps that are kept; what the record has of its fields is collected
    settings : whether steps are kept, and lengths of the steps where they are prescribed
    """

    def __init__(self, system: System, record: Any, kind: type[StepsTaken], settings: Settings) -> None:
        self._given = (
            np.zeros(0) if settings.given is None else np.ascontiguousarray(settings.given, dtype=float)
        )
        self._record, self._kind, self._places = record, kind, system.memory_places
        own = {field.name for field in fields(kind)} - {"memory"}
        self._names = [name for name in record._fields if name in own]
        self.wanted = settings.keep_steps
        self._chunks: list[list[Array]] = []
        self._left_out: list[Array] = []
        self._memory: list[Array] = []
        self.count = 0

    def begin(self, left_out: Array, **first: Any) -> None:
        """The state before the first step; what was collected before is forgotten. `left_out` is looked at later."""
        for collected in (self._chunks, self._left_out, self._memory):
            collected.clear()
        self._first = {name: np.array(value, dtype=float) for name, value in first.items()}
        self._first_out, self._out = left_out > 0, left_out

    def forget(self, **first: Any) -> None:
        """Nothing is kept of the past; the next step is the first one."""
        self._chunks, self._left_out, self._memory = [], [], []
        self.begin(self._out, **first)

    def given(self) -> Array:
        """The lengths that are still to be taken."""
        return self._given[self.count :]

    def record(self) -> Any:
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
            self._chunks.append([getattr(record, name)[:taken].copy() for name in self._names])
            self._left_out.append(np.tile(self._out > 0, (taken, 1)))
            self._memory.append(np.concatenate([memory[None], record.memory[: taken - 1]]))
        return [getattr(record, name)[:taken] for name in NODE]

    def state(self) -> dict[str, Array]:
        """All that has been collected, for `resume`; nothing where steps are not kept."""
        if not self.wanted:
            return {}
        found = {f"first_{name}": value for name, value in self._first.items()}
        found |= dict(zip(self._names, self._joined(), strict=True))
        found |= {"left_out": np.concatenate([self._first_out[None], *self._left_out])}
        found |= {"memory": np.concatenate([np.zeros((0, len(self._places))), *self._memory])}
        return {f"kept_{name}": array for name, array in found.items()}

    def resume(self, state: Mapping[str, Array], left_out: Array) -> None:
        """Go on from such a state; `left_out` as for `begin`."""
        self._out = left_out
        if not self.wanted:
            return
        names = [name[11:] for name in state if name.startswith("kept_first_")]
        self._first = {name: state[f"kept_first_{name}"] for name in names}
        self._chunks = [[state[f"kept_{name}"] for name in self._names]]
        self._first_out, self._left_out = state["kept_left_out"][0], [state["kept_left_out"][1:]]
        self._memory, self.count = [state["kept_memory"]], len(state["kept_memory"])

    def _joined(self) -> list[Array]:
        """The columns of all chunks."""
        empty = [getattr(self._record, name)[:0] for name in self._names]
        return [np.concatenate(x) for x in zip(empty, *self._chunks, strict=True)]

    def steps(self, **told: Any) -> StepsTaken | None:
        """All steps, with the state of the start before them."""
        if not self.wanted:
            return None
        whole = dict(zip(self._names, self._joined(), strict=True))
        for name, value in self._first.items():
            whole[name] = np.concatenate([value[None], whole[name]])
        left_out = np.concatenate([self._first_out[None], *self._left_out])
        if not np.any(left_out):
            left_out = left_out[:0]
        memory = np.concatenate([np.zeros((0, len(self._places))), *self._memory])
        told |= {**whole, "left_out": left_out, "places": self._places, "memory": memory}
        return self._kind(**told)
