"""Steps that end at the corners of forces: the step that passes one is taken again, so that it ends just before it."""

from __future__ import annotations

from typing import Any, NamedTuple

from ....algebra import Array
from ....system import System
from ..events.force_corners import Corner, ForceCorners, Located, width
from ..stepping.nodes import Nodes, joined
from ..stepping.stepper import RunFailure
from .rewind import Rewind

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
        self._rewind = Rewind(stepper)
        self.count = 0

    def __bool__(self) -> bool:
        return bool(self._corners)

    def mark(self) -> dict[str, Any]:
        """The method before steps that are taken next."""
        return self._rewind.mark()

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
            self._rewind.back(mark)
            self._rewind.until(end)
            return None
        self.count += 1
        return cut

    def _taken_again(self, mark: dict[str, Any], nodes: Nodes, found: Located) -> Cut | None:
        """The steps up to a corner, whose last one ends just before it."""
        self._rewind.back(mark)
        parts = [self._rewind.until(float(nodes.t[found.step]))] if found.step else []
        own, t, rate = self._rewind.mark(), found.t, found.rate
        begin = float(nodes.t[found.step])
        for _ in range(SEARCHES):
            self._rewind.back(own)
            taken = self._rewind.until(t)
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


def ahead_of(nodes: Nodes, ahead: float) -> tuple[Array, Array]:
    """q and v a little after the last node."""
    return nodes.q[-1] + ahead * nodes.v[-1], nodes.v[-1] + ahead * nodes.a[-1]
