"""Steps that end at corners of forces: a step that passes a corner is repeated so that it ends just before it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np

from ....algebra import Array
from ....system import System
from ..events.corner_search import TOGETHER, CornerSearch, Located
from ..events.force_corners import Corner
from ..stepping.nodes import Nodes, joined
from ..stepping.stepper import RunFailure, Stepper
from .rewind import Rewind

SEARCHES = 12  # times the last step is taken again
FURTHER = 4.0  # times further back each time that a step ends beyond a corner, whose force holds it there
FIRST = 0.1  # of the time within which a force sets in and ends: the first step after it has set in
FEW, MOST = 16, 400  # steps that are taken at once
LOOKED_AT = 4 * FEW  # steps that are looked at together while they become shorter
NEARER = 1.1  # of the steps up to the earliest corner: those beyond cost less than another look
NEARER_STEPS, REST = 3, 0.25  # before a corner, and how much of the way is left after each
RESOLVED = 2  # steps since the last corner: where there are fewer they are short already
FAR = 1.5  # times what is left: nearer to a corner no such step ends
FREE, SHARE = 200, 0.2  # corners at which steps end: so many, and this part of all steps
MEETINGS = 200  # zeros of lengths from which on they may accumulate
JUMPS = 100  # the same of corners in runs that are not stored
LAST, FASTER = 20, 0.5  # intervals between them, and how much shorter than all: then they do
LANDED, SHARE_LANDED = 20, 0.02  # steps that end at a corner and are taken again in halves: the same


class Cut(NamedTuple):
    """Steps up to a corner.

    Attributes
    ----------
    left, wide : how long after their end the corner is, and how long after it the next one begins [s]
    longest : the next one at most, so that it does not pass over what follows [s]
    """

    nodes: Nodes
    corner: Corner
    left: float
    wide: float
    longest: float

    def beyond(self, acceleration: Callable[[float, Array, Array], Array]) -> Nodes:
        """Return the state behind the corner; accelerations may jump there.

        Parameters
        ----------
        acceleration : at t, q and v
        """
        last = self.nodes.part(slice(-1, None))
        t, at_corner = last.t + self.left + self.wide, last.v + self.left * last.a
        q = last.q + self.left * (last.v + at_corner) / 2 + self.wide * at_corner
        a = acceleration(float(t[0]), q[0], (at_corner + self.wide * last.a)[0])[None]
        return last._replace(t=t, q=q + self.wide**2 / 2 * a, v=at_corner + self.wide * a, a=a)


class CornerSteps:
    """The corners of one run.

    Parameters
    ----------
    system : System
    stepper : the method at work
    rewind : takes steps again, if it is free to; else a warning names the first force that a step passes over
    every : whether steps also end at all corners. In every run those are taken again that pass one and pass back, as
        where a wheel touches the ground within a step, and shortly before it
    stored : whether all steps are stored for derivatives; otherwise they pass all corners once these accumulate

    Attributes
    ----------
    portion : how many steps are taken at once: few where a corner may be near
    """

    def __init__(
        self, system: System, stepper: Stepper, rewind: Rewind, every: bool, stored: bool = True
    ) -> None:
        self._search, self._stepper, self._every = CornerSearch(system, stepper, every), stepper, every
        self._passes = CornerSearch(system, stepper, False) if every else self._search
        self._stored, self._system, self._meetings = stored, system, np.zeros(0)
        self._rewind, self.portion = rewind, FEW if every else MOST
        # Corners that were passed and at which steps end; steps before the last one; steps taken again in halves
        self._passed = self._ends = self._earlier = self._landings = 0

    def __bool__(self) -> bool:
        return bool(self._search.corners)

    def state(self) -> dict[str, Array]:
        """Return the data that a continued run needs, see `Stepper.state`."""
        counts = np.array([self._passed, self._ends, self.portion, self._earlier, self._landings])
        return {"corners": counts, "meetings": self._meetings}

    def resume(self, state: Mapping[str, Array]) -> None:
        """Go on from such a state."""
        counts = (int(x) for x in state["corners"])
        self._passed, self._ends, self.portion, self._earlier, self._landings = counts
        self._meetings = state.get("meetings", np.zeros(0))
        self._search = CornerSearch(self._system, self._stepper, self._every and not self._accumulate)

    @property
    def _accumulate(self) -> bool:
        """Whether zeros of lengths, or jumps, follow each other ever faster, as a damped motion comes to rest there."""
        intervals = np.diff(self._meetings)
        least = MEETINGS if self._stored else JUMPS
        return len(intervals) >= least and bool(np.mean(intervals[-LAST:]) < FASTER * np.mean(intervals))

    def _meet(self, t: float, corner: Corner) -> None:
        """Count a zero of a length, or a jump; once they accumulate, they are no corners any more."""
        self._meetings = np.append(self._meetings, t)
        if not self._accumulate:
            return
        self._search = CornerSearch(self._system, self._stepper, False)
        near = f"ever more often near t = {t:.6g} s, so that steps pass these points from there on"
        if corner.length:
            found = (
                f"its ends meet {near}, and derivatives may be inaccurate",
                "the force go to zero with the length",
            )
        else:
            found = f"its force changes its law {near}, with larger errors", "the law change within a width"
        self._rewind.warn(f"{corner.owner}: {found[0]}. End the run earlier, or let {found[1]}.")

    def may_reverse(self, nodes: Nodes) -> bool:
        """Whether the last steps are so short that a force may reverse soon, as a length vanishes.

        Those before it are then taken again with the step that passes this corner, and are looked at together with it.
        """
        h = np.diff(nodes.t)
        looks = self._search.lengths and self._rewind.free
        return looks and 0 < len(h) <= LOOKED_AT and bool(h[-1] < TOGETHER * h.max())

    def seen(self, mark: dict[str, Any], nodes: Nodes, stop: float) -> tuple[Nodes, Cut | None]:
        """The steps since a state, and up to the first corner at which one ends; they are taken again.

        `stop`: a time at which a step ends in any case.
        """
        self.portion = min(MOST, 2 * self.portion)
        if len(nodes.t) < 2 or (self._every and not self._stored and self._accumulate):
            return nodes, None
        nodes = self._resolved(mark, nodes, stop)
        if not self._every or self._ends > self._most or len(nodes.t) < 2:
            return nodes, None
        found, ahead = self._search.look(nodes)
        if not found:
            self.portion = int(np.clip(NEARER * ahead / (nodes.t[-1] - nodes.t[-2]), FEW, self.portion))
            return nodes, None
        self.portion, self._ends, resolved = FEW, self._ends + 1, self._rewind.since(mark)
        corner, cut = self._search.corners.all[found.number], self._ended(mark, nodes, found)
        if not self._stored or (cut and corner.length):
            self._meet(found.t, corner)
        if cut:
            return cut.nodes, cut
        self._rewind.forward(resolved)  # where no step can end there they pass it
        return nodes, None

    @property
    def _most(self) -> float:
        """The number of corners after which none are looked for."""
        return FREE + SHARE * self._stepper.tally.nsteps

    def _resolved(self, mark: dict[str, Any], nodes: Nodes, stop: float) -> Nodes:
        """The steps since a state up to the first of them that passes a corner and passes back."""
        if self._passed > self._most:
            return nodes
        few = self._landings <= LANDED + SHARE_LANDED * self._stepper.tally.nsteps
        ends = (
            self._every and self._ends <= self._most
        )  # a step that lands is then taken again to end at the corner
        landings = self._rewind.free and few and not ends
        found = self._passes.look(nodes, self._steps(mark, nodes), landings)[0]
        if found and not found.before and found.t == stop:  # not for the corner
            return nodes
        if found and self._rewind.free:
            self.portion, self._passed = FEW, self._passed + 1
            self._landings += found.before == 0
            return self._before(mark, nodes, found)
        if found:
            self._rewind.warn(self._message(found))
        return nodes

    def _steps(self, mark: dict[str, Any], nodes: Nodes) -> Array:
        """The step that ends at each node, or behind it, counted from 0."""
        ends = np.concatenate(
            [np.zeros(0), *(part[:, 0] for part in self._stepper.tally.history[mark["chunks"] :])]
        )
        return np.searchsorted(ends, nodes.t[1:])

    def _message(self, found: Located) -> str:
        owner = self._passes.corners.all[found.number].owner
        return (
            f"{owner}: its force sets in and ends, or the reverse, within one step near t = {found.t:.6g} s, so that "
            "steps may pass over it. Take shorter ones, or the default method, whose steps end there."
        )

    def _before(self, mark: dict[str, Any], nodes: Nodes, found: Located) -> Nodes:
        """The steps up to shortly before a force sets in; the next one is short, so that it is not passed over again.

        Steps that were held by a force end where it does not act: those taken instead are looked at again, and are
        halved until none is.
        """
        begin, end = (float(t) for t in nodes.t[found.step : found.step + 2])
        first = FIRST * (found.wide or end - found.t)
        t = max(found.t - first, begin)
        for _ in range(SEARCHES):
            self._rewind.back(mark)
            nodes = self._rewind.until(t)
            again = self._passes.look(nodes, self._steps(mark, nodes))[0] if len(nodes.t) > 1 else None
            if not again:
                break
            first = (float(nodes.t[again.step + 1]) - float(nodes.t[again.step])) / 2
            t = float(nodes.t[again.step]) + first
        self._stepper.shorten(first)
        return nodes

    def _ended(self, mark: dict[str, Any], nodes: Nodes, found: Located) -> Cut | None:
        """The steps up to a corner, if one can end there: shorter ones before it, unless it is not where it seemed."""
        for nearer in (True, False):
            with suppress(RunFailure):
                cut = self._taken_again(mark, nodes, found, nearer)
                if cut and not self._passes.look(cut.nodes, self._steps(mark, cut.nodes), landings=False)[0]:
                    return cut
        return None

    def _taken_again(self, mark: dict[str, Any], nodes: Nodes, found: Located, nearer: bool) -> Cut | None:
        """The steps up to a corner, whose last one ends just before it; `nearer`: with ever shorter ones."""
        self._rewind.back(mark)
        step, end = self._search.natural(found, nodes)
        parts = [self._rewind.until(float(nodes.t[step]))] if step else []
        begin, natural = float(nodes.t[step]), REST**NEARER_STEPS * (end - found.t)
        if nearer and self._stepper.tally.nsteps - self._earlier >= RESOLVED:
            parts += self._nearer(begin, end, found.t)
        begin = float(parts[-1].t[-1]) if parts else begin
        own, t, beyond, longest = self._rewind.mark(), found.t, 1.0, FIRST * found.wide or np.inf
        for _ in range(SEARCHES):
            self._rewind.back(own)
            taken = self._rewind.until(t)
            margins = self._search.margins(found.number, t, float(taken.t[-1] - taken.t[-2]), natural)
            value, slope = self._search.at_end(found.number, taken)
            left = found.before * value / abs(slope or found.rate)  # so long before the corner
            if margins.least < left < 4 * margins.wide:
                end_left = self._search.end(found.number, taken, left)
                if end_left is None:
                    return None
                every, self._earlier = joined([*parts, taken]), self._stepper.tally.nsteps
                return Cut(every, self._search.corners.all[found.number], end_left, margins.wide, longest)
            if left > -margins.together:
                beyond = 1.0
            else:  # of two corners near to each other the other one may be the first
                beyond, found = FURTHER * beyond, self._search.look(taken)[0] or found
                left = min(found.t - t, beyond * left)
            t += left - 2 * margins.wide
            if not begin < t < 2 * end - begin:
                return None
        return None

    def _nearer(self, begin: float, end: float, corner: float) -> Iterator[Nodes]:
        """Ever shorter steps towards a corner, in the place of one that passes it, unless it is near to its begin.

        The time of a corner depends on parameters, and the error of the last step on where in it the corner is: in one
        long step derivatives have far fewer digits than states. Laws such as δ^1.5 need short steps there, too.
        """
        rest = end - begin
        for _ in range(NEARER_STEPS):
            rest *= REST
            if corner - begin > FAR * rest:
                yield self._rewind.until(corner - rest)
