"""Corners of force laws along a run: functions whose sign changes a law, found in the recorded formulas of elements.

A contact that touches or leaves, the ends of a rounding, an absolute value and a maximum in a user's formula; a length
whose ends pass through each other, so that its force reverses. A step ends at each of them, so that the law is smooth
within every step. The first one that a step passes is located by signs and rates of these functions.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...._jit.formulas.expression import Expression, Graph
from ...._jit.formulas.replay import needed, replay
from ....algebra import Array
from ....model.tape import Tracer
from ....outputs.recording import TRACED, Recording
from ....system import System
from ....system.curves.curve_derivatives import MANY, formula_graph, stored
from ..inputs.force_arguments import (
    END,
    ForceArguments,
    Length,
    force_functions,
    forces,
    has_corners,
    has_kinks,
    law_signs,
)
from ..inputs.laws_of_time import ASIDE
from ..stepping.nodes import Nodes
from ..stepping.stepper import Stepper

SHIFT = 1e-6  # of the states, at random: the change of a function shows the size of its terms
SHIFTS = 3  # how often
MEETS = 1e-8  # of tan² between a length and its rate at the end of a step: its ends meet
ROUND_OFF = 1e-12  # of that size: what integration leaves of a function that decays to zero
NEAR = 1e-10  # of a step: so long before a corner a step ends, and so long behind it the next one begins
NEAR_ZERO = 1e-5  # the same of a length that vanishes: its derivatives have the round-off of the ends over powers of it
LEAST = 0.5  # of the distance before a length that vanishes: nearer steps are taken again
TOGETHER = 0.1  # of a step, which the reversal of a force has made short: corners that are one
ROUNDS, POINTS = 2, 33  # of the search within a step; the steps themselves do the rest
DEPTH = 6  # rounds of the search for the least distance from a corner
GRAZES = 1e-2  # of what a function changes within a step: slower crossings only graze
PLACES = np.linspace(0, 1, 5)  # parts of a step at which signs are compared
AHEAD_OF = 1e-6  # of a step: between two states that give the rate of a function
LOOKS = np.sort([*PLACES[1:], *(PLACES[:-1] + AHEAD_OF), 1 - AHEAD_OF])  # where functions are evaluated
# Of the step's begin and these: places, and rates'
OWN, AHEAD = np.array([0, 2, 4, 6, 9]), np.array([1, 3, 5, 7, 8])


@dataclass(frozen=True, eq=False)
class Corner:
    """A function of one element whose sign changes its force: one of the force, or of a formula or length in it.

    Attributes
    ----------
    owner : the part of the model
    population, element : index among the system's populations, and the element in it
    sign : index of the function
    curve : index of the formula among those of the force; negative for the force itself
    length : whether the index is that of a length, and the function the rate of its square
    """

    owner: str
    population: int
    element: int
    sign: int
    curve: int = -1
    length: bool = False

    def record(self, recording: Recording) -> Tracer:
        """Its value along a recorded motion, which can be differentiated."""
        p = recording.system.populations[self.population]
        known = force_functions(p.variant)
        if self.length:
            return recording.replayed(p, self.element, known.graph, [known.lengths[self.sign].rate])[0]
        if self.curve < 0:
            return recording.replayed(p, self.element, known.graph, [known.signs[self.sign]])[0]
        place, x = known.curves[self.curve]
        law = stored(p, self.element, place)
        argument = recording.replayed(p, self.element, known.graph, [x])[0]
        graph, signs = formula_graph(law)[0], law_signs(law)
        found: Tracer = replay(graph, [signs[self.sign]], {("x",): argument}, TRACED)[0]
        return found


class ForceCorners:
    """The corners of all forces of a system; `lengths`: those of lengths that vanish, too."""

    def __init__(self, system: System, lengths: bool = True) -> None:
        own = forces(system, has_corners if lengths else has_kinks)
        self._arguments, self._system = ForceArguments(system, own), system
        self.all, self._columns, self._forces = list[Corner](), list[int](), list[int]()
        self._laws: dict[int, tuple[Graph, list[Expression], list[int]]] = {}
        self._lengths: dict[int, list[int]] = {}  # columns of each length
        for n in own:
            for k in range(system.populations[n].count):
                self._add_element(n, k)
                if lengths:
                    self._add_lengths(n, k)

    def _add_element(self, n: int, k: int) -> None:
        p = self._system.populations[n]
        known = force_functions(p.variant)
        for sign in range(len(known.signs)):
            self._add(Corner(p.owners[k], n, k, sign), sign)
        first = len(known.signs)
        for curve, (place, _) in enumerate(known.curves):
            for sign, found in enumerate(law_signs(stored(p, k, place))):
                self._laws[len(self.all)] = found.graph, [found], needed(found.graph, [found])
                self._add(Corner(p.owners[k], n, k, sign, curve), first + curve)

    def _add_lengths(self, n: int, k: int) -> None:
        p = self._system.populations[n]
        known = force_functions(p.variant)
        first, width = len(known.arguments), len(Length._fields)
        for length, at in enumerate(range(first - width * len(known.lengths), first, width)):
            self._lengths[len(self.all)] = [self._arguments.column(n, k, at + i) for i in range(width)]
            self._add(Corner(p.owners[k], n, k, length, length=True), at)

    def _add(self, corner: Corner, argument: int) -> None:
        at = corner.population, corner.element
        self.all.append(corner)
        self._columns.append(self._arguments.column(*at, argument))
        self._forces.append(self._arguments.column(*at, -1))

    def __bool__(self) -> bool:
        return bool(self.all)

    def all_at(self, nodes: Nodes, b: Array, parts: Array, apart: bool) -> tuple[Array, Array]:
        """The functions of all corners, and whether their forces act (corners, 1 + steps * parts).

        At the first node, then at parts of every step.
        """
        found = self._arguments(nodes, b, parts, apart)
        values, acts = found[:, self._columns].T.copy(), found[:, self._forces].T != 0
        for number in self._laws:
            values[number] = self._of(number, found)
        steps = np.repeat(np.diff(nodes.t), len(parts))
        for number in self._lengths:
            acts[number] &= self._length(number, found).meets(np.concatenate([steps[:1], steps]))
            if not acts[number].any():
                values[number] = 1.0  # a length that does not come to zero has no corner near
        return values, acts

    def are_far(self, nodes: Nodes, b: Array) -> bool:
        """Whether there are no corners but lengths, which come near to zero nowhere between nodes, by these alone."""
        if len(self._lengths) < len(self.all):
            return False
        found, h = self._arguments(nodes, b, END), np.diff(nodes.t)
        each = (self._length(number, found) for number in self._lengths)
        return all((own.is_far(np.append(h[0], h)) & own.is_far(np.append(h, h[-1]))).all() for own in each)

    def one_at(self, number: int, pair: Nodes, b: Array, parts: Array, apart: bool) -> tuple[Array, Array]:
        """The function of one corner at parts of a step, and whether its force acts (parts,)."""
        found = self._arguments(pair, b, parts, apart)[1:]
        return self._of(number, found), found[:, self._forces[number]] != 0

    def meets(self, number: int, pair: Nodes, b: Array) -> bool:
        """Whether the ends of a length meet after a step, but for round-off."""
        found = self._length(number, self._arguments(pair, b, END))
        return bool(found.meets(pair.t[1] - pair.t[0], MEETS)[-1])

    def round_off(self, number: int, pair: Nodes, b: Array) -> float:
        """Below which a function at the end of a step is round-off of its terms; velocities have that of q/h, too."""
        own, rng = self.one_at(number, pair, b, END, False)[0], np.random.default_rng(0)
        sizes = abs(pair.q), abs(pair.v) + abs(pair.q) / (pair.t[1] - pair.t[0])
        changes = []
        for _ in range(SHIFTS):
            q, v = (SHIFT * size * rng.standard_normal(size.shape[1]) for size in sizes)
            shifted = pair._replace(q=pair.q + q, v=pair.v + v)
            changes.append(abs(self.one_at(number, shifted, b, END, False)[0] - own))
        return ROUND_OFF / SHIFT * float(np.max(changes))

    def _length(self, number: int, found: Array) -> Length:
        return Length(*found.T[self._lengths[number]])

    def _of(self, number: int, found: Array) -> Array:
        """The function of one corner (nt,), of the arguments (nt, size)."""
        x: Array = found[:, self._columns[number]]
        if number not in self._laws:
            return x
        graph, wanted, order = self._laws[number]
        value = replay(graph, wanted, {("x",): x}, MANY, order)[0]
        return np.broadcast_to(np.asarray(value, dtype=float), x.shape)


@dataclass(frozen=True)
class CornerHit:
    """A corner that a step passes.

    Attributes
    ----------
    number : of the corner
    step : between the node of this number and the next one
    t : time [s]
    before : sign of its function before it
    rate : of its function [1/s]
    wide : how long after it the function has its sign again, where it has within the step; at least [s]
    """

    number: int
    step: int
    t: float
    before: float
    rate: float
    wide: float


class Margins(NamedTuple):
    """How long before a corner a step ends, and at least; and how long after it others are that reverse with it [s]."""

    wide: float
    least: float
    together: float


class CornerSearch:
    """The search for corners of forces along the steps of a method.

    Parameters
    ----------
    system : System
    stepper : the method at work
    lengths : whether lengths that vanish are corners, too

    Attributes
    ----------
    lengths : whether there are any
    """

    def __init__(self, system: System, stepper: Stepper, lengths: bool = True) -> None:
        self.corners, self._stepper = ForceCorners(system, lengths), stepper
        self.lengths = any(one.length for one in self.corners.all)

    def _at(self, number: int, pair: Nodes, parts: Array) -> tuple[Array, Array]:
        return self.corners.one_at(number, pair, self._stepper.b, parts, self._stepper.apart)

    def at_end(self, number: int, nodes: Nodes) -> tuple[float, float]:
        """The function of one corner at the last node, and its rate there."""
        last = nodes.part(slice(-2, None))
        before, end = self._at(number, last, np.array([1 - AHEAD_OF, 1.0]))[0]
        return float(end), float((end - before) / (AHEAD_OF * (last.t[1] - last.t[0])))

    def end(self, number: int, nodes: Nodes, left: float) -> float | None:
        """How long after the last node a corner is [s], from a first approximation; None where steps cannot end there.

        They cannot where the ends of a length pass beside each other. |d|² / 2 is no parabola over the time before
        d = 0 if the ends accelerate: one more step of Newton's method.
        """
        if not self.corners.all[number].length:
            return left
        last = nodes.part(slice(-2, None))
        if not self.corners.meets(number, last, self._stepper.b):
            return None
        h = float(last.t[1] - last.t[0])
        value, ahead = self._at(number, last, np.array([1.0, 1.0 + left / h]))[0]
        return float(left * value / (value - ahead))

    def margins(self, number: int, t: float, h: float, natural: float) -> Margins:
        """Those of a step of length h that ends at a corner; a force that reverses makes steps short."""
        if not self.corners.all[number].length:
            return Margins(width(t, h), 0.0, 0.0)
        wide = NEAR_ZERO * max(h, natural)
        return Margins(wide, LEAST * wide, wide)

    def natural(self, found: CornerHit, nodes: Nodes) -> tuple[int, float]:
        """The step from which steps up to a corner are taken again, and the end of the one that passed it.

        A force that reverses has made the steps before it ever shorter: they are taken again, too.
        """
        if not self.corners.all[found.number].length:
            return found.step, float(nodes.t[found.step + 1])
        longest = float(np.max(np.diff(nodes.t[: found.step + 2])))
        return max(int(np.searchsorted(nodes.t, found.t - longest)) - 1, 0), found.t + longest

    def look(self, nodes: Nodes, steps: Array | None = None) -> tuple[CornerHit | None, float]:
        """The first corner that is passed between nodes, if there is one; how long behind them one may be at least [s].

        Where the `steps` are given to which nodes belong (n - 1,): the first that one of them passes and passes back.
        """
        if not self.corners or self.corners.are_far(nodes, self._stepper.b):
            return None, np.inf
        values, acts = self.corners.all_at(nodes, self._stepper.b, LOOKS, self._stepper.apart)
        looks = Looks.of(values, acts)
        looks = looks if steps is None else looks.back(steps)
        for step in np.flatnonzero(np.any(looks.passed | looks.dips, axis=(0, 2))).tolist():
            pair = nodes.part(slice(step, step + 2))
            known = [one for one in self._in_step(looks, step, pair) if one and not self._is_greatest(one)]
            if known:
                return self._first(known, pair), 0.0
        return None, _ahead(nodes, values)

    def _is_greatest(self, found: CornerHit) -> bool:
        """Whether a length has its greatest value there, not zero: the rate of its square changes to negative."""
        return self.corners.all[found.number].length and found.before > 0

    def _first(self, known: list[CornerHit], pair: Nodes) -> CornerHit:
        """The first corner; a length that vanishes before others, which reverse with it."""
        first = min(one.t for one in known) + TOGETHER * float(pair.t[1] - pair.t[0])
        return min(known, key=lambda one: (one.t > first, not self.corners.all[one.number].length, one.t))

    def _is_round_off(self, number: int, pair: Nodes, *sides: Array) -> bool:
        """Whether a function is zero but for round-off on one side of a corner: u - a, once a has come to u."""
        least = self.corners.round_off(number, pair, self._stepper.b)
        return any(np.max(abs(side)) < least for side in sides)

    def _in_step(self, looks: Looks, step: int, pair: Nodes) -> Iterator[CornerHit | None]:
        """The corners in one step."""
        for n, k in np.argwhere(looks.dips[:, step]).tolist():
            found = self._beyond(n, pair, *PLACES[k : k + 2].tolist())
            if found is not None:
                beyond, wide = found
                yield self._located(n, step, pair, (PLACES[k], beyond), looks.values[n, step], wide)
        for n, k in np.argwhere(looks.passed[:, step]).tolist():
            own = looks.values[n, step]
            if not self._is_round_off(n, pair, own[: k + 1], own[k + 1 :]):
                yield self._located(n, step, pair, (PLACES[k], PLACES[k + 1]), own)

    def _beyond(self, number: int, pair: Nodes, low: float, high: float) -> tuple[float, float] | None:
        """The part of a step at which a function that comes near to zero is beyond it, if any, and about how long."""
        for _ in range(DEPTH):
            parts = np.linspace(low, high, POINTS)
            values, acts = self._at(number, pair, parts)
            beyond = acts & (values * values[0] < 0)
            if beyond.any():
                return float(parts[np.argmax(beyond)]), float(np.sum(beyond) * (parts[1] - parts[0]))
            least = int(np.argmin(abs(values)))
            low, high = float(parts[max(least - 1, 0)]), float(parts[min(least + 1, POINTS - 1)])
        return None

    def _located(
        self, number: int, step: int, pair: Nodes, between: tuple[float, float], own: Array, wide: float = 0.0
    ) -> CornerHit | None:
        """Locate one sign change within a step; None at its ends, and where the function grazes."""
        h, (low, high), before, t = float(pair.t[1] - pair.t[0]), between, 0.0, 0.0
        for _ in range(ROUNDS):
            parts = np.linspace(low, high, POINTS)
            values = self._at(number, pair, parts)[0]
            before = before or float(np.sign(values[0]))
            first = int(np.argmax(values[1:] * before <= 0)) + 1
            low, high = parts[first - 1 : first + 1].tolist()
            change = float(values[first] - values[first - 1]) / (high - low)
            t = float(pair.t[0] + (low - values[first - 1] / change) * h)
        if min(t - pair.t[0], pair.t[1] - t) < 10 * width(t, h) or abs(change) < GRAZES * np.ptp(own):
            return None
        wide = wide or self._back(number, pair, high, before)
        return CornerHit(number, step, t, before, abs(change) / h, wide * h)

    def _back(self, number: int, pair: Nodes, behind: float, before: float) -> float:
        """The part of a step that a function is beyond zero for, from there on; 0 if it stays there."""
        parts = np.linspace(behind, 1, POINTS)
        back = self._at(number, pair, parts)[0] * before > 0
        return float(parts[max(int(np.argmax(back)), 1)] - behind) if back.any() else 0.0


def width(t: float, h: float) -> float:
    """Return the distance from a corner at which a step ends [s]."""
    return max(NEAR * h, ASIDE * abs(t))


def _ahead(nodes: Nodes, values: Array) -> float:
    """Return the extrapolated time from the last node to the first zero of the functions [s]."""
    last, before = values[:, -1], values[:, -2]
    with np.errstate(all="ignore"):
        parts = np.where(abs(last) < abs(before), last / (before - last), np.inf)
    return float(np.nanmin(parts, initial=np.inf) * AHEAD_OF * (nodes.t[-1] - nodes.t[-2]))


class Looks(NamedTuple):
    """Functions at five places of every step (corners, steps, 5), and between which of them (corners, steps, 4) signs
    change of forces that act, or functions reverse where they come near to zero; where functions return to zero at the
    end of a step, and where their force acts, or does not, in the middle only (corners, steps).
    """

    values: Array
    passed: Array
    dips: Array
    returns: Array
    inside: Array

    def back(self, steps: Array) -> Looks:
        """Return the signs without those that change once in their step and do not return at its end.

        A step from a flight into a hard contact can end in it with the speed of its end already reversed. The force of
        a damped contact sets in by the depth, and ends by its rate.
        """
        counts = np.zeros((len(self.passed), int(steps.max(initial=0)) + 1), np.int64)
        np.add.at(counts.T, steps, self.passed.sum(axis=2).T)
        again = (counts[:, steps] > 1) | self.returns | self.inside
        return self._replace(passed=self.passed & again[:, :, None])

    @classmethod
    def of(cls, values: Array, acts: Array) -> Looks:
        """Create it from the functions and the activity of forces at the first node and at `LOOKS` of every step."""
        every, acting = _with_begin(values), _with_begin(acts)[:, :, OWN]
        own = every[:, :, OWN]
        slopes = (every[:, :, AHEAD] - own) / (np.append(0, LOOKS)[AHEAD] - PLACES)
        x, y, down, up = own[:, :, :-1], own[:, :, 1:], slopes[:, :, :-1], slopes[:, :, 1:]
        passed = (x * y < 0) & (acting[:, :, 1:] | acting[:, :, :-1])
        with np.errstate(all="ignore"):
            least = x + down * (y - x - up * np.diff(PLACES)) / (down - up)  # where tangents meet
        dips = (x * y > 0) & (x * down < 0) & (y * up > 0) & ~(x * least > 0)
        first, middle, last = acting[:, :, 0], acting[:, :, 1:-1], acting[:, :, -1]
        inside = (first == last) & np.any(middle != first[:, :, None], axis=2)
        return cls(own, passed, dips, own[:, :, -1] * slopes[:, :, -1] < 0, inside)


def _with_begin(at: Array) -> Array:
    """Values at the first node and at `LOOKS` of every step (n, 1 + 9 steps) as (n, steps, 10), from each begin on."""
    inner = at[:, 1:].reshape(len(at), -1, len(LOOKS))
    begin = np.concatenate([at[:, :1], inner[:, :-1, -1]], axis=1)[:, :, None]
    return np.concatenate([begin, inner], axis=2)
