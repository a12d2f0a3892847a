"""Steps that are taken again: the state of a method before them, to which it can go back."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..stepping.nodes import Nodes, joined
from ..stepping.stepper import Stepper

LIMIT = 1000  # steps for one call of a method


class Rewind:
    """A method that can go back.

    Parameters
    ----------
    stepper : the method at work
    """

    def __init__(self, stepper: Stepper) -> None:
        self._stepper: Any = stepper
        self._store: Any = getattr(getattr(stepper, "_inner", stepper), "store", None)

    def mark(self) -> dict[str, Any]:
        """The state of the method, without copies of the steps stored so far."""
        state = {name: np.array(array) for name, array in self._without_steps(self._stepper.state).items()}
        found = {"state": state, "history": list(self._stepper.tally.history)}
        return found | ({"taken": self._store._taken, "count": self._store.count} if self._store else {})

    def back(self, mark: dict[str, Any]) -> None:
        """Go back to such a state; what was computed since counts."""
        stepper, spent = self._stepper, self._stepper.tally
        state = {name: array.copy() for name, array in mark["state"].items()}
        self._without_steps(stepper.resume, state)
        if self._store:
            self._store._taken, self._store.count = mark["taken"], mark["count"]
        for name in ("nfev", "njev", "nlu", "nrejected"):
            setattr(stepper.tally, name, getattr(spent, name))
        stepper.tally.history = list(mark["history"])

    def _without_steps(self, function: Any, *given: Any) -> Any:
        """What a function does while no steps are stored."""
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
