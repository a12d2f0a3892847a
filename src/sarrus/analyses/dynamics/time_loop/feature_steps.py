"""Steps that pass over no feature of a law over the state: a bump of a road that a vehicle reaches after a long calm.

In a calm motion steps are long, and a force is looked at in few places of each. So the features of all laws over state
variables are known, see `laws_of_state`; a step over a short part of a law is taken again and ends where the part
begins. The next ones end where parts end, unless the errors already ask for shorter ones.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from ....algebra import Array
from ....system import System
from ..inputs.features import LEAST, Law, features_of
from ..inputs.laws_of_state import StateLaws, Table
from ..stepping.nodes import Nodes
from ..stepping.stepper import Stepper
from .rewind import Rewind

# Least part of the time since the begin by which so many steps that are taken again must advance
ADVANCING, ADVANCE = 32, 1e-3
AGAIN = 8  # times that steps are taken again; the time at which a part begins becomes better known
MORE = 1.5  # parts that a step passes over are shorter by this factor than the step
FEW, MOST = 8, 400  # steps that are taken at once
BEFORE = 0.05  # of a part: so far before it steps end, so that a corner is within the next one
REACHED = 0.1  # of a part: so near to its beginning a step is within it
AROUND = 0.25  # of the arguments reached: so much more is examined on both sides
NEARER = 0.5 ** np.arange(10.0, -1, -1)  # parts of that, from the arguments reached outwards
COMPARABLE = 4.0  # times the largest value of a law: so large it may be around the arguments reached
SAMPLES = 513  # places where that value is looked for
QUARTERS = np.array([0.25, 0.5, 0.75, 1.0])  # of a step: whether an argument reverses within it
UNEVEN = 0.02  # of the change of an argument in a step: how far it may be from a parabola
PLACES = np.linspace(0, 1, 33)  # within a step, where its extreme value is looked for
REFINED = 3  # how often, each time more closely


class Extreme(NamedTuple):
    """An extreme value of an argument within a step, and its place, in steps."""

    place: float
    x: float


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
        self._ends = list[float]()
        self._begin: float | None = None
        self._parts: list[tuple[Array, float]] = [(np.zeros(0), np.inf)] * count

    def __bool__(self) -> bool:
        return bool(self._laws.all)

    def state(self) -> dict[str, Array]:
        """Return the data that a continued run needs, see `Stepper.state`."""
        found = {"reached": self._reached, "examined": self._examined, "portion": np.array(self.portion)}
        found |= {
            "ends": np.array(self._ends),
            "begin": np.array([] if self._begin is None else [self._begin]),
        }
        return {f"features_{name}": array for name, array in found.items()}

    def resume(self, state: Mapping[str, Array]) -> None:
        """Go on from such a state."""
        self._reached, self._examined = state["features_reached"].copy(), state["features_examined"].copy()
        self.portion = int(state["features_portion"])
        self._ends = state.get("features_ends", np.zeros(0)).tolist()  # which runs of 0.2 did not save
        self._begin = next(iter(state.get("features_begin", np.zeros(0)).tolist()), None)
        for law in np.flatnonzero(self._examined[0] < self._examined[1]):
            self._examine(int(law))

    def seen(self, mark: dict[str, Any], nodes: Nodes) -> Nodes:
        """The steps since then, up to the first short part of a law that one of them passes over."""
        self.portion = min(MOST, 2 * self.portion)
        if self._begin is None:
            self._begin = float(nodes.t[0])
        for _ in range(AGAIN if self else 0):
            passed = self._passed(mark, nodes)
            if passed is None:
                break
            t, law = passed
            if self._crawls(t, self._begin):
                break
            if not self._rewind.free:
                self._rewind.warn(self._message(t, law))
                break
            self.portion = FEW
            self._rewind.back(mark)
            nodes = self._rewind.until(t)
        return nodes

    def _crawls(self, t: float, begin: float) -> bool:
        """Whether steps that are taken again no longer advance, as where a law grows beyond all bounds."""
        self._ends = [*self._ends[-ADVANCING:], t]
        return len(self._ends) > ADVANCING and t - self._ends[0] < ADVANCE * (t - begin)

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
        at = Nodes._make(column[ends] for column in nodes)
        arguments = self._arguments(at, QUARTERS)
        extremes = [self._extremes(law, at, x) for law, x in enumerate(arguments)]
        self._reach(
            [np.append(x, [one.x for one in own]) for x, own in zip(arguments, extremes, strict=True)]
        )
        found = list[tuple[float, int]]()
        for law, (x, own) in enumerate(zip(arguments, extremes, strict=True)):
            places = np.append(np.arange(len(at.t)), [one.place for one in own])
            order = np.argsort(places, kind="stable")
            places, path = places[order], np.append(x[::4], [one.x for one in own])[order]
            found += [
                (self._time(law, at, places[n : n + 2], wanted), law)
                for n, wanted in _passing(path, *self._parts[law])
            ]
        return min(found, default=None)

    def _arguments(self, at: Nodes, parts: Array) -> Array:
        return self._laws.arguments(self._stepper.b, at, parts, self._stepper.apart)

    def _extremes(self, law: int, at: Nodes, x: Array) -> list[Extreme]:
        """Where an argument reverses within steps that are long beside the parts of the law, or reach new arguments."""
        marks, longest = self._parts[law]
        extreme, reverses, uneven = _parabolas(x)
        size = np.ptp([x[:-1:4], x[2::4], x[4::4], extreme], axis=0)
        new = (extreme < self._reached[0, law]) | (extreme > self._reached[1, law])
        long = size > MORE * min(np.diff(marks).min(initial=np.inf), longest)
        wanted = np.flatnonzero((reverses & (new | long) | uneven) & (size > LEAST * abs(extreme)))
        return [extreme for step in wanted for extreme in self._within(law, at, int(step))]

    def _within(self, law: int, at: Nodes, step: int) -> Iterator[Extreme]:
        """The least and the largest value of an argument within a step, unless they are at its ends."""
        pair = at.part(slice(step, step + 2))
        for side in (1.0, -1.0):
            low, high = 0.0, 1.0
            for _ in range(REFINED):
                parts = low + (high - low) * PLACES
                x = self._arguments(pair, parts)[law, 1:]
                n = int(np.argmin(side * x))
                low, high = parts[max(n - 1, 0)], parts[min(n + 1, len(parts) - 1)]
            if 0.0 < parts[n] < 1.0:
                yield Extreme(step + float(parts[n]), float(x[n]))

    def _time(self, law: int, at: Nodes, places: Array, wanted: float) -> float:
        """The time at which an argument has a value, between two places of a step."""
        step = min(int(places[0]), len(at.t) - 2)
        parts = places[0] - step + (places[1] - places[0]) * PLACES
        x = self._arguments(at.part(slice(step, step + 2)), parts)[law, 1:]
        order = np.argsort(x)
        t = at.t[step] + (at.t[step + 1] - at.t[step]) * parts
        return float(np.interp(wanted, x[order], t[order]))

    def _reach(self, arguments: list[Array]) -> None:
        """Examine laws where the motion has gone beyond what has been examined."""
        low, high = self._reached
        np.minimum(low, [x.min() for x in arguments], out=low)
        np.maximum(high, [x.max() for x in arguments], out=high)
        beyond = (low < self._examined[0]) | (high > self._examined[1])
        moved = high - low > LEAST * np.maximum(abs(low), abs(high))  # by more than round-off
        for law in np.flatnonzero(beyond & np.isfinite(high - low) & moved):
            self._examined[:, law] = _around(self._laws.all[law].law, low[law], high[law])
            self._examine(int(law))

    def _examine(self, law: int) -> None:
        low, high = self._examined[:, law].tolist()
        found = features_of(self._laws.all[law].law, low, high)
        marks = np.union1d(found.corners, found.ends)
        # Others are one corner, but for round-off
        apart = np.diff(marks, prepend=-np.inf) > LEAST * (high - low)
        self._parts[law] = marks[apart], found.longest


def _around(law: Law | Table, low: float, high: float) -> Array:
    """More than the arguments reached, so that growing motions are examined seldom: as far as a law is not much larger.

    Where exp(x) or 1/(d - x)² is much larger than it has been, what it has been would be nearly a cubic.
    """
    size = 2.0 ** np.ceil(np.log2(high - low))
    ends = size * np.array([np.floor(low / size - AROUND), np.ceil(high / size + AROUND)])
    reached = np.array([low, high])
    candidates = reached + (ends - reached) * NEARER[:, None]
    largest = COMPARABLE * np.nanmax(abs(law(np.linspace(low, high, SAMPLES))), initial=0.0)
    fits = np.isfinite(candidates) & (abs(law(candidates.ravel()).reshape(candidates.shape)) <= largest)
    near = np.logical_and.accumulate(fits, axis=0).sum(axis=0)
    return np.where(near > 0, candidates[np.maximum(near - 1, 0), [0, 1]], reached)


def _parabolas(x: Array) -> tuple[Array, Array, Array]:
    """The parabolas through an argument at the ends and in the middle of steps, of its values (1 + 4 steps,).

    Returns
    -------
    extreme : their vertices in each step; the argument at its end if they are outside
    reverses : whether they are within
    uneven : whether the argument is not as the parabola at a quarter and three quarters of the step
    """
    first, before, middle, behind, last = x[:-1:4], x[1::4], x[2::4], x[3::4], x[4::4]
    change, bend = last - first, first - 2 * middle + last
    reverses = abs(change) < 2 * abs(bend)
    extreme = np.where(reverses, middle - change**2 / (8 * np.where(reverses, bend, 1.0)), last)
    quarters = middle + bend / 8
    off = np.maximum(abs(before - quarters + change / 4), abs(behind - quarters - change / 4))
    return extreme, reverses, off > UNEVEN * np.maximum(abs(change), abs(bend))


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
