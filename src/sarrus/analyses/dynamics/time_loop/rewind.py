"""Stored states of a method before its last steps, from which steps are repeated."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....model.announcement import announce
from ..step_loop.step_store import StepStore
from ..stepping.nodes import Nodes, joined
from ..stepping.stepper import Stepper

LIMIT = 1000  # steps for one call of a method


class Rewind:
    """A method that can go back.

    Parameters
    ----------
    stepper : the method at work
    free : whether its steps can be taken again
    """

    def __init__(self, stepper: Stepper, free: bool = True) -> None:
        self._stepper = stepper
        self.free, self._warned = free, False
        self._store: StepStore | None = getattr(getattr(stepper, "_inner", stepper), "store", None)

    def warn(self, message: str) -> None:
        """Announce, once, why steps should have been taken again, where they cannot be."""
        announce([] if self._warned else [message])
        self._warned = True

    def mark(self) -> dict[str, Any]:
        """The state of the method, without copies of the steps stored so far; how many chunks of them there are."""
        chunks = {"chunks": len(self._stepper.tally.history)}
        if not self.free:
            return chunks
        state = {name: np.array(array) for name, array in self._without_steps(self._stepper.state).items()}
        found = {"state": state} | chunks
        return found | ({"taken": self._store._taken, "count": self._store.count} if self._store else {})

    def back(self, mark: dict[str, Any]) -> None:
        """Go back to such a state; what was computed since counts."""
        stepper, spent = self._stepper, self._stepper.tally
        history = spent.history
        state = {name: array.copy() for name, array in mark["state"].items()}
        self._without_steps(stepper.resume, state)
        if self._store:
            self._store._taken, self._store.count = mark["taken"], mark["count"]
        for name in ("nfev", "njev", "nlu", "nrejected"):
            setattr(stepper.tally, name, getattr(spent, name))
        stepper.tally.history = history[: mark["chunks"]]

    def since(self, mark: dict[str, Any]) -> dict[str, Any]:
        """The present state, with the steps since a mark, which others may replace."""
        rows = self._store.rows(mark["taken"]) if self._store else {}
        return self.mark() | {"rows": rows, "history": self._stepper.tally.history}

    def forward(self, since: dict[str, Any]) -> None:
        """Go to such a state from a mark before it."""
        self._stepper.tally.history = since["history"]
        self.back(since)
        if self._store:
            self._store.replace(since["rows"])

    def _without_steps(self, function: Any, *given: Any) -> Any:
        """Run a function while no steps are stored."""
        if self._store is None:
            return function(*given)
        wanted, self._store.wanted = self._store.wanted, False
        try:
            return function(*given)
        finally:
            self._store.wanted = wanted

    def until(self, t: float) -> Nodes:
        """Steps up to a time."""
        parts = [self._stepper.advance(t, LIMIT)]
        while self._stepper.t < t:
            parts.append(self._stepper.advance(t, LIMIT))
        return joined(parts)
