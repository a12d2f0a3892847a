"""Steps that end at the corners of forces: the step that passes one is taken again, so that it ends just before it."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ....algebra import Array
from ....system import System
from ..events.force_corners import Corner, ForceCorners, Located, width
from ..stepping.nodes import Nodes, joined
from ..stepping.stepper import RunFailure

SEARCHES = 8  # times the last step is taken again
FREE, SHARE = 200, 0.2  # corners at which steps end: so many, and this part of all steps


class Cut(NamedTuple):
    """Steps up to a corner, and how long after their end the next one begins [s]."""

    nodes: Nodes
    corner: Corner
    ahead: float


class CornerSteps:
    """The corners of one run.

    Parameters
    ----------
    system : System
    stepper : the method at work

    Attributes
    ----------
    count : corners at which steps have ended
    """

    def __init__(self, system: System, stepper: Any) -> None:
        self._corners, self._stepper = ForceCorners(system), stepper
        self._store: Any = getattr(stepper, "_inner", stepper).store if self._corners else None
        self.count = 0

    def __bool__(self) -> bool:
        return bool(self._corners)

    def mark(self) -> dict[str, Any]:
        """The state of the method, without copies of the steps stored so far."""
        store, tally = self._store, self._stepper.tally
        wanted, store.wanted = store.wanted, False
        try:
            state = {name: np.array(array) for name, array in self._stepper.state().items()}
        finally:
            store.wanted = wanted
        return {"state": state, "taken": store._taken, "count": store.count, "history": list(tally.history)}

    def rewind(self, mark: dict[str, Any]) -> None:
        """Go back to such a state; what was computed since counts."""
        store, stepper, counts = self._store, self._stepper, self._stepper.tally
        wanted, store.wanted = store.wanted, False
        try:
            stepper.resume({name: array.copy() for name, array in mark["state"].items()})
        finally:
            store.wanted = wanted
        store._taken, store.count = mark["taken"], mark["count"]
        taken, before = stepper.tally.nsteps, stepper.tally
        before.nfev, before.njev, before.nlu, before.nrejected = (
            counts.nfev,
            counts.njev,
            counts.nlu,
            counts.nrejected,
        )
        before.nsteps, before.history = taken, list(mark["history"])

    def cut(self, mark: dict[str, Any], nodes: Nodes) -> Cut | None:
        """The steps since a state up to the first corner that they pass; they are taken again."""
        if self.count > FREE + SHARE * self._stepper.tally.nsteps:
            return None
        found = self._corners.first(nodes, self._stepper.b, self._stepper.apart)
        if found is None:
            return None
        end = float(nodes.t[-1])
        try:
            cut = self._taken_again(mark, nodes, found)
        except RunFailure:
            cut = None
        if cut is None:
            self.rewind(mark)
            self._until(end)
            return None
        self.count += 1
        return cut

    def _taken_again(self, mark: dict[str, Any], nodes: Nodes, found: Located) -> Cut | None:
        """The steps up to a corner, whose last one ends just before it."""
        self.rewind(mark)
        parts = [self._until(float(nodes.t[found.step]))] if found.step else []
        own, t, rate = self.mark(), found.t, found.rate
        begin = float(nodes.t[found.step])
        for _ in range(SEARCHES):
            self.rewind(own)
            taken = self._until(t)
            wide = width(t, t - begin)
            last = taken.part(slice(-1, None))
            value = float(self._corners.value(found.corner, self._stepper.b, last)[0])
            rate = self._corners.rate(found.corner, last, self._stepper.b, 1e-6 * (t - begin)) or rate
            left = found.before * value / abs(rate)  # so long before the corner
            if 0 < left < 4 * wide:
                every = joined([*parts, taken])
                return Cut(every, self._corners.all[found.corner], left + wide)
            t += left - 2 * wide
            if not begin < t < nodes.t[found.step + 1] + (nodes.t[found.step + 1] - begin):
                return None
        return None

    def _until(self, t: float) -> Nodes:
        """Steps up to a time."""
        parts = [self._stepper.advance(t, 1000)]
        while self._stepper.t < t:
            parts.append(self._stepper.advance(t, 1000))
        return joined(parts)


def ahead_of(nodes: Nodes, ahead: float) -> tuple[Array, Array]:
    """q and v a little after the last node."""
    return nodes.q[-1] + ahead * nodes.v[-1], nodes.v[-1] + ahead * nodes.a[-1]
