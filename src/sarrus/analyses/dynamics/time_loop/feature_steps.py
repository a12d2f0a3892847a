"""Steps that pass over no feature of a law over the state: a bump of a road that a vehicle reaches after a long calm.

In a calm motion steps are long, and a force is looked at in few places of each. So the features of all laws over state
variables are known, see `laws_of_state`; a step over a short part of a law is taken again and ends where the part
begins. The next ones end where parts end, unless the errors already ask for shorter ones.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ....algebra import Array
from ....system import System
from ..inputs.features import features_of
from ..inputs.laws_of_state import StateLaws
from ..stepping.nodes import Nodes
from ..stepping.stepper import Stepper
from .rewind import Rewind

AGAIN = 8  # times that steps are taken again; the time at which a part begins becomes better known
MORE = 1.5  # parts that a step passes over are shorter by this factor than the step
FEW, MOST = 8, 400  # steps that are taken at once
BEFORE = 0.05  # of a part: so far before it steps end, so that a corner is within the next one
REACHED = 0.1  # of a part: so near to its beginning a step is within it
AROUND = 0.25  # of the arguments reached: so much more is examined on both sides


class FeatureSteps:
    """The features of one run.

    Parameters
    ----------
    system : System
    stepper : the method at work
    rewind : takes steps again, if it is free to; else a warning names the first feature that one passes over

    Attributes
    ----------
    portion : how many steps are taken at once: few behind one that has been taken again
    """

    def __init__(self, system: System, stepper: Stepper, rewind: Rewind) -> None:
        self._system, self._stepper, self._rewind = system, stepper, rewind
        self._laws = StateLaws(system)
        count = len(self._laws.all)
        self._reached = np.array([np.full(count, np.inf), np.full(count, -np.inf)])
        self._examined = np.zeros((2, count))
        self.portion = MOST
        self._parts: list[tuple[Array, float]] = [(np.zeros(0), np.inf)] * count

    def __bool__(self) -> bool:
        return bool(self._laws.all)

    def state(self) -> dict[str, Array]:
        """Return the data that a continued run needs, see `Stepper.state`."""
        found = {"reached": self._reached, "examined": self._examined, "portion": np.array(self.portion)}
        return {f"features_{name}": array for name, array in found.items()}

    def resume(self, state: Mapping[str, Array]) -> None:
        """Go on from such a state."""
        self._reached, self._examined = state["features_reached"].copy(), state["features_examined"].copy()
        self.portion = int(state["features_portion"])
        for law in np.flatnonzero(self._examined[0] < self._examined[1]):
            self._examine(int(law))

    def seen(self, mark: dict[str, Any], nodes: Nodes) -> Nodes:
        """The steps since then, up to the first short part of a law that one of them passes over."""
        self.portion = min(MOST, 2 * self.portion)
        for _ in range(AGAIN if self else 0):
            passed = self._passed(mark, nodes)
            if passed is None:
                break
            t, law = passed
            if not self._rewind.free:
                self._rewind.warn(self._message(t, law))
                break
            self.portion = FEW
            self._rewind.back(mark)
            nodes = self._rewind.until(t)
        return nodes

    def _message(self, t: float, law: int) -> str:
        return (
            f"{self._laws.all[law].owner}: its law varies near t = {t:.6g} s within less than a step, so that steps "
            "may pass over it. Take shorter ones, or the default method, whose steps end there."
        )

    def _passed(self, mark: dict[str, Any], nodes: Nodes) -> tuple[float, int] | None:
        """The first time at which a step should have ended, and the law."""
        steps = self._stepper.tally.history[mark["chunks"] :]
        if not steps or len(nodes.t) < 2:
            return None
        ends = np.append(0, np.searchsorted(nodes.t, np.concatenate(steps)[:, 0]))
        arguments = self._laws.arguments(self._stepper.b, Nodes._make(column[ends] for column in nodes))
        self._reach(arguments)
        found = list[tuple[float, int]]()
        for law, x in enumerate(arguments):
            for step, wanted in _passing(x, *self._parts[law]):
                within = nodes.part(slice(ends[step], ends[step + 1] + 1))
                inner = self._laws.arguments(self._stepper.b, within)[law]
                order = np.argsort(inner)
                found.append((float(np.interp(wanted, inner[order], within.t[order])), law))
        return min(found, default=None)

    def _reach(self, arguments: Array) -> None:
        """Examine laws where the motion has gone beyond what has been examined."""
        low, high = self._reached
        np.minimum(low, arguments.min(axis=1), out=low)
        np.maximum(high, arguments.max(axis=1), out=high)
        beyond = (low < self._examined[0]) | (high > self._examined[1])
        for law in np.flatnonzero(beyond & np.isfinite(high - low) & (high > low)):
            size = 2.0 ** np.ceil(np.log2(high[law] - low[law]))
            ends = np.floor(low[law] / size - AROUND), np.ceil(high[law] / size + AROUND)
            self._examined[:, law] = size * np.array(ends)
            self._examine(int(law))

    def _examine(self, law: int) -> None:
        found = features_of(self._laws.all[law].law, *self._examined[:, law].tolist())
        self._parts[law] = np.union1d(found.corners, found.ends), found.longest


def _passing(x: Array, marks: Array, longest: float) -> Iterator[tuple[int, float]]:
    """The first step that passes over a part, if there is one, and the argument at which it should end."""
    gaps = np.concatenate([[np.inf], np.diff(marks), [np.inf]])
    ways, pairs = np.diff(x), np.sort([x[:-1], x[1:]], axis=0)
    low, high = np.searchsorted(marks, pairs[0], "right"), np.searchsorted(marks, pairs[1])
    for step in np.flatnonzero((high > low) | (abs(ways) > MORE * longest)):
        way, inside = ways[step], range(low[step], high[step])
        ahead = [n for n in inside if abs(marks[n] - x[step]) > REACHED * min(gaps[n], gaps[n + 1])]
        if ahead and abs(way) > MORE * min(min(gaps[n], gaps[n + 1]) for n in ahead):
            n = ahead[0 if way > 0 else -1]
            yield int(step), float(marks[n] - np.copysign(BEFORE * min(gaps[n], gaps[n + 1]), way))
            return
        if abs(way) > MORE * longest:
            yield int(step), float(x[step] + np.copysign(longest, way))
            return
