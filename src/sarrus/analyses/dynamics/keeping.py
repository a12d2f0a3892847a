"""Keeping the steps of a run: room for one chunk in the compiled loop, and what has been collected so far."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...algebra import Array
from ...results import Steps
from ...system import System
from . import alpha_loop as loop

FIELDS = ("t", "h", "removed", "q", "v", "a", "x", "lam")


class Keeping:
    """Room for the steps of one call of the loop, and the chunks collected before.

    Parameters
    ----------
    system : System
    room : steps for one call; 0 keeps nothing
    given : lengths of the steps where they are prescribed, else None
    """

    def __init__(self, system: System, room: int, given: Array | None = None) -> None:
        widths = (system.nq, system.nq, system.nq, system.nq, system.m)
        self._arrays = [*(np.zeros(room) for _ in range(3)), *(np.zeros((room, width)) for width in widths)]
        self._given = np.zeros(0) if given is None else np.ascontiguousarray(given, dtype=float)
        self._places = system.memory_places
        self._chunks: list[list[Array]] = []
        self._left_out: list[Array] = []
        self._memory: list[Array] = []
        self.wanted, self.count = room > 0, 0

    def record(self) -> loop.Record:
        """What the loop writes into, and the lengths that are still to be taken."""
        return loop.Record._make([*self._arrays, self._given[self.count :]])

    def collect(self, total: int, left_out: Array, b: Array) -> None:
        """Take over what the last call wrote; `total` steps have been taken since the start."""
        taken = total - self.count
        self.count = total
        if self.wanted and taken:
            self._chunks.append([array[:taken].copy() for array in self._arrays])
            self._left_out.append(np.tile(left_out > 0, (taken, 1)))
            self._memory.append(np.tile(b[self._places], (taken, 1)))

    def steps(self, first: dict[str, Array], **told: Any) -> Steps | None:
        """All steps, with the state of the start before them."""
        if not self.wanted:
            return None
        empty = [array[:0] for array in self._arrays]
        whole = dict(
            zip(FIELDS, (np.concatenate(x) for x in zip(empty, *self._chunks, strict=True)), strict=True)
        )
        for name in ("t", "q", "v", "a", "x", "lam"):
            whole[name] = np.concatenate([first[name][None], whole[name]])
        left_out = np.concatenate([first["left_out"][None] > 0, *self._left_out])
        if not np.any(left_out):
            left_out = left_out[:0]
        memory = np.concatenate([np.zeros((0, len(self._places))), *self._memory])
        told |= {**whole, "left_out": left_out, "places": self._places, "memory": memory}
        return Steps(**told)
