"""Switches: corners of forces, at which steps end, and parts of tables over states, over which no step passes.

A step that passes a corner is taken again and ends just before it; the next one begins on the other side. In a calm
motion steps are long, and a force is looked at in few places of each. So a table is divided into parts in which it is
nearly a cubic, and a step that passes over a whole one is taken again and ends within it: before the bump of a road.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ....algebra import Array
from ....elements.operators import OPERATORS
from ....model import Curve
from ....model.announcement import announce
from ....system import System
from ....system.cached import once
from ....system.curves.curve_derivatives import MANY, stored
from ..events.force_corners import TOGETHER, Corner, CornerHit, CornerSearch
from ..inputs.force_arguments import ForceArguments, curves_over_states, force_functions
from ..inputs.laws_of_time import parts_of
from ..step_loop.step_store import StepStore
from ..stepping.nodes import Nodes, joined
from ..stepping.stepper import RunFailure, Stepper

FEW, MOST = 16, 400  # steps that are taken at once
# Of a step that passes over a part of a table, and every eighth of other steps
PLACES = np.linspace(0, 1, 33)[1:]
SEARCHES = 12  # times the last step is taken again
FURTHER = 4.0  # times further back each time that a step ends beyond a corner, whose force holds it there
FIRST = 0.1  # of the time within which a force sets in and ends: the first step after it has set in
LOOKED_AT = 4 * FEW  # steps that are looked at together while they become shorter
NEARER = 1.1  # of the steps up to the earliest corner: those beyond cost less than another look
NEARER_STEPS, REST = 3, 0.25  # before a corner, and how much of the way is left after each
RESOLVED = 2  # steps since the last corner: where there are fewer they are short already
FAR = 1.5  # times what is left: nearer to a corner no such step ends
# Corners at which steps end: so many, and this part of all steps; so many may follow each other ever faster
FREE, SHARE = 200, 0.2
LAST, FASTER = 20, 0.5  # intervals between them, and how much shorter than all: then they do


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
        parts = [self._stepper.advance(t, MOST)]
        while self._stepper.t < t:
            parts.append(self._stepper.advance(t, MOST))
        return joined(parts)


class Table:
    """A table over a state, as laws over the time are examined; two are equal if their numbers are."""

    def __init__(self, curve: Curve) -> None:
        self.curve = curve

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Table) and self.curve == other.curve

    def __hash__(self) -> int:
        return hash(self.curve)

    def __call__(self, x: Array) -> Array:
        """Its values (n,)."""
        return np.asarray(MANY["curve"](self.curve, x))

    def zeros(self, x: Array) -> tuple[Array, Array]:
        """No corners, and its points: between them it is a cubic."""
        return np.zeros(0), np.array(self.curve.knots)

    @cached_property
    def ends(self) -> Array:
        """Rising ends of the parts in which it is nearly a cubic."""
        return parts_of(self, self.curve.knots[0], self.curve.knots[-1]).ends

    def part_of(self, x: Array) -> Array:
        """The number of the part in which an argument is, of the first and the last one also beyond."""
        knots = self.curve.knots
        period = knots[-1] - knots[0]
        periods = np.floor((x - knots[0]) / period) if self.curve.periodic else 0
        return np.searchsorted(self.ends[1:-1], x - periods * period, side="right") + periods * (
            len(self.ends) - 1
        )


class StateTable(NamedTuple):
    """A table, the part of the model that has it, its element's population and index there, which argument it has."""

    table: Table
    owner: str
    population: int
    element: int
    argument: int


@once
def tables_over_states(system: System) -> tuple[StateTable, ...]:
    """Those of all forces that are no single cubic."""
    return tuple(found for number in range(len(system.populations)) for found in _tables(system, number))


def _tables(system: System, number: int) -> Iterator[StateTable]:
    p = system.populations[number]
    if not p.count or OPERATORS["Q"] not in p.kind.family:
        return
    known = force_functions(p.variant)
    for n, place in curves_over_states(p):
        for k in range(p.count):
            law = stored(p, k, place)
            if isinstance(law, Curve) and len(law.cubics) > 1:
                yield StateTable(Table(law), p.owners[k], number, k, len(known.signs) + n)


class TableSteps:
    """The tables over states of one run.

    Parameters
    ----------
    system : System
    stepper : the method at work
    rewind : takes steps again, if it is free to; else a warning names the first table of which one passes over a part
    """

    def __init__(self, system: System, stepper: Stepper, rewind: Rewind) -> None:
        self._stepper, self._rewind, self._tables = stepper, rewind, tables_over_states(system)
        self._arguments = ForceArguments(system, sorted({one.population for one in self._tables}))
        self._columns = [self._arguments.column(*one[2:]) for one in self._tables]

    def __bool__(self) -> bool:
        return bool(self._tables)

    def seen(self, mark: dict[str, Any], nodes: Nodes) -> Nodes:
        """The steps since then, up to the first part of a table that one of them passes over."""
        while self and (passed := self._passed(mark, nodes)) and nodes.t[0] < passed[0] < nodes.t[-1]:
            t, owner = passed
            if not self._rewind.free:
                self._rewind.warn(
                    f"{owner}: its table varies near t = {t:.6g} s within less than a step, so that steps may pass "
                    "over it. Take shorter ones, or the default method, whose steps end there."
                )
                break
            self._rewind.back(mark)
            nodes = self._rewind.until(t)
        return nodes

    def _passed(self, mark: dict[str, Any], nodes: Nodes) -> tuple[float, str] | None:
        """The first time at which a step should have ended, and whose table it is."""
        steps = self._stepper.tally.history[mark["chunks"] :]
        if not steps or len(nodes.t) < 2:
            return None
        ends = np.append(0, np.searchsorted(nodes.t, np.concatenate(steps)[:, 0]))
        at = Nodes._make(column[ends] for column in nodes)
        parts = self._parts(at, PLACES[7::8])
        each = np.concatenate([parts[:, :-1:4, None], parts[:, 1:].reshape(len(parts), -1, 4)], axis=2)
        passing = np.ptp(each, axis=2) > 1
        if not passing.any():
            return None
        step = int(np.argmax(passing.any(axis=0)))
        pair = at.part(slice(step, step + 2))
        places = [_end(own) for own in self._parts(pair, PLACES)[passing[:, step]]]
        owners = [one.owner for one, wanted in zip(self._tables, passing[:, step], strict=True) if wanted]
        place, owner = min(zip(places, owners, strict=True))
        return float(pair.t[0] + place * (pair.t[1] - pair.t[0])), owner

    def _parts(self, at: Nodes, places: Array) -> Array:
        """The parts in which arguments are (tables, 1 + steps * places), at the first node, then within every step."""
        x = self._arguments(at, self._stepper.b, places, self._stepper.apart)[:, self._columns]
        return np.array([one.table.part_of(own) for one, own in zip(self._tables, x.T, strict=True)])


def _end(parts: Array) -> float:
    """The place in a step where it should end: in the middle of its way through the second part of a table."""
    places = np.append(0.0, PLACES)
    passed = np.maximum.accumulate(parts) - np.minimum.accumulate(parts)
    second, third = (int(np.argmax(passed > n)) for n in (0, 1))
    return float(places[second - 1] + places[third]) / 2


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


class Switches:
    """The switches of one run.

    Parameters
    ----------
    system : System
    stepper : the method at work
    free : whether its steps can be taken again; else a warning names the first switch that one passes over
    every : whether steps end at all corners. In every run those are taken again that pass one and pass back, as where a
        wheel touches the ground within a step, and shortly before it. None: steps are not looked at
    stored : whether all steps are stored for derivatives; otherwise they pass all corners once these accumulate

    Attributes
    ----------
    failure : why the method stopped behind the last steps, if it did
    """

    def __init__(
        self, system: System, stepper: Stepper, free: bool, every: bool | None, stored: bool
    ) -> None:
        self._rewind = Rewind(stepper, free)
        self.failure: RunFailure | None = None
        self._tables = TableSteps(system, stepper, self._rewind)
        self._search, self._stepper, self._every = CornerSearch(system, stepper, bool(every)), stepper, every
        self._passes = CornerSearch(system, stepper, False) if every else self._search
        self._stored, self._system, self._meetings = stored, system, np.zeros(0)
        self._portion = FEW if every else MOST  # steps that are taken at once: few where a corner may be near
        # Corners passed, and at which steps end; steps before the last
        self._passed = self._ends = self._earlier = 0

    def state(self) -> dict[str, Array]:
        """Return the data that a continued run needs, see `Stepper.state`."""
        counts = np.array([self._passed, self._ends, self._portion, self._earlier])
        return {"corners": counts, "meetings": self._meetings}

    def resume(self, state: Mapping[str, Array]) -> None:
        """Go on from such a state."""
        counts = (int(x) for x in state.get("corners", self.state()["corners"]))
        self._passed, self._ends, self._portion, self._earlier = counts
        self._meetings = state.get("meetings", np.zeros(0))
        self._search = CornerSearch(self._system, self._stepper, bool(self._every) and not self._accumulate)

    def advance(self, stop: float, most: int) -> tuple[Nodes, Cut | None]:
        """Some steps, over no part of a table, and up to the first corner at which one ends."""
        if self._every is None or not (self._search.corners or self._tables):
            return self._stepper.advance(stop, most), None
        mark, portion = self._rewind.mark(), min(most, self._portion)
        self._portion = min(MOST, 2 * self._portion)
        nodes = self._some(mark, stop, portion)
        while self._may_reverse(nodes) and self._stepper.t < stop:
            try:
                nodes = joined([nodes, self._some(self._rewind.mark(), stop, FEW)])
            except RunFailure as failure:
                self.failure = failure  # once the steps before it are taken
                break
        return self._up_to_corner(mark, nodes)

    def _some(self, mark: dict[str, Any], stop: float, portion: int) -> Nodes:
        taken = self._stepper.advance(stop, portion)
        nodes = self._tables.seen(mark, taken)
        if nodes is not taken:
            self._portion = FEW
        return nodes

    @property
    def _accumulate(self) -> bool:
        """Whether zeros of lengths, or jumps, follow each other ever faster, as a damped motion comes to rest there."""
        intervals = np.diff(self._meetings)
        return len(intervals) >= FREE and bool(np.mean(intervals[-LAST:]) < FASTER * np.mean(intervals))

    def _meet(self, t: float, corner: Corner) -> None:
        """Count a zero of a length, or a jump; once they accumulate, they are no corners any more."""
        self._meetings = np.append(self._meetings, t)
        if self._accumulate:
            self._search = CornerSearch(self._system, self._stepper, False)
            self._rewind.warn(
                f"{corner.owner}: switches of its force crowd at t = {t:.6g} s, so that steps pass them from there on, "
                "with larger errors. End the run earlier, or let the force change within a width."
            )

    def _may_reverse(self, nodes: Nodes) -> bool:
        """Whether the last steps are so short that a force may reverse soon, as a length vanishes.

        Those before it are then taken again with the step that passes this corner, and are looked at together with it.
        """
        h = np.diff(nodes.t)
        looks = self._search.lengths and self._rewind.free
        return looks and 0 < len(h) <= LOOKED_AT and bool(h[-1] < TOGETHER * h.max())

    def _up_to_corner(self, mark: dict[str, Any], nodes: Nodes) -> tuple[Nodes, Cut | None]:
        """The steps since a state, and up to the first corner at which one ends; they are taken again."""
        if (
            len(nodes.t) < 2
            or not self._search.corners
            or (self._every and not self._stored and self._accumulate)
        ):
            return nodes, None
        nodes = self._resolved(mark, nodes)
        if not self._every or self._ends > self._most or len(nodes.t) < 2:
            return nodes, None
        found, ahead = self._search.look(nodes)
        if not found:
            self._portion = int(np.clip(NEARER * ahead / (nodes.t[-1] - nodes.t[-2]), FEW, self._portion))
            return nodes, None
        self._portion, self._ends, end = FEW, self._ends + 1, float(nodes.t[-1])
        corner, cut = self._search.corners.all[found.number], self._ended(mark, nodes, found)
        if not self._stored or (cut and corner.length):
            self._meet(found.t, corner)
        if cut:
            return cut.nodes, cut
        self._rewind.back(mark)  # where no step can end there they pass it
        return self._rewind.until(end), None

    @property
    def _most(self) -> float:
        """The number of corners after which none are looked for."""
        return FREE + SHARE * self._stepper.tally.nsteps

    def _resolved(self, mark: dict[str, Any], nodes: Nodes) -> Nodes:
        """The steps since a state up to the first of them that passes a corner and passes back."""
        if self._passed > self._most:
            return nodes
        found = self._passes.look(nodes, self._steps(mark, nodes))[0]
        if found and self._rewind.free:
            self._portion, self._passed = FEW, self._passed + 1
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

    def _message(self, found: CornerHit) -> str:
        owner = self._passes.corners.all[found.number].owner
        return (
            f"{owner}: its force sets in and ends, or the reverse, within one step near t = {found.t:.6g} s, so that "
            "steps may pass over it. Take shorter ones, or the default method, whose steps end there."
        )

    def _before(self, mark: dict[str, Any], nodes: Nodes, found: CornerHit) -> Nodes:
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

    def _ended(self, mark: dict[str, Any], nodes: Nodes, found: CornerHit) -> Cut | None:
        """The steps up to a corner, if one can end there: shorter ones before it, unless it is not where it seemed."""
        for nearer in (True, False):
            with suppress(RunFailure):
                cut = self._taken_again(mark, nodes, found, nearer)
                if cut and not self._passes.look(cut.nodes, self._steps(mark, cut.nodes))[0]:
                    return cut
        return None

    def _taken_again(self, mark: dict[str, Any], nodes: Nodes, found: CornerHit, nearer: bool) -> Cut | None:
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
