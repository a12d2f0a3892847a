"""Motion through a position where constraints become dependent, along the smooth continuation of the motion before.

At such a position the matrix of the accelerations is singular, and the mechanism could go on in several ways. Close to
it the steps of methods that solve or evaluate the equations there become ever shorter, although the motion is smooth.
So one step is taken from a state before the position to a time as far behind it, as an Adams method takes it:
accelerations are one polynomial in time through those of earlier states and of the state behind, which is found by
iteration. Nothing is evaluated close to the position. The error is what the projection onto the constraints changes,
and what one state less in the polynomial does: another way than the smooth one is not taken.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike

from ....algebra import Array
from ....linalg.factors import SingularSystem
from ....linalg.rank import rank_of
from ....model.announcement import announce
from ....system import System
from ...equations.motion import EquationsOfMotion
from ...equations.projection import Projection
from ..stepping.nodes import Nodes
from ..stepping.stepper import RunFailure, RunPart, Settings, Stepper

RECORD_SIZE = 120  # stored states, each THIN times as far from the last one as the next
THIN = 1.1
NUMBERS = 1_000_000  # of those states together, as far as more than a few do not fit
CLOSE, AWAY = (
    0.3,
    1e-4,
)  # of the smallest singular value at the start: from so far before a position it is gone over
SHORT, RECENT = 1e-2, 24  # of the longest among recent steps: one that may be on the way to a position
# Each state from which the step is tried is so many times as far from the last as the one before
FURTHER = 1.5
POINTS, SPACING = (
    8,
    0.4,
)  # accelerations of the polynomial at most; between two, of the distance to the position
ROUNDS = 12  # iterations for the state behind the position
ENOUGH = 10.0  # times the tolerance of other steps is allowed for this one, if it cannot be more exact
SETTLED = 0.03  # of the tolerance, where they end
PARTS = 8  # pieces of the step between which there are nodes
BRANCHES = (
    "a singular configuration is passed between t = {:.6g} and {:.6g} s, where the motion could branch. The run "
    "follows the smooth continuation. Change the start or the dimensions if another branch is meant."
)


class Track(NamedTuple):
    """States on the way: rising times (n,), coordinates and velocities (n, nq)."""

    t: Array
    q: Array
    v: Array


class Landing(NamedTuple):
    """A state behind the position, the nodes of the way there, and the error over the tolerance."""

    nodes: Nodes
    error: float
    iterations: int


class SingularPassage(RunPart):
    """A stepper that also passes singular configurations; see `Stepper`."""

    VARIABLES = "_inner", "_past", "_until", "_shortest"

    def __init__(self, stepper: Stepper, system: System, settings: Settings) -> None:
        self._inner, self._system, self._settings = stepper, system, settings
        self._until, self._shortest, self._length = 0.0, np.inf, stepper.independence.length
        self._past = Track(np.zeros(0), np.zeros((0, system.nq)), np.zeros((0, system.nq)))

    @property
    def t(self) -> float:
        """The time reached."""
        return self._inner.t

    @t.setter
    def t(self, t: float) -> None:
        self._inner.t = t

    def __getattr__(self, name: str) -> Any:
        """All else is the method's own."""
        return getattr(self._inner, name)

    def restart(self, t: float, q: Array, v: Array, until: float) -> None:
        """Begin at a consistent state, see `Stepper`."""
        self._until, self._shortest, self._past = until, np.inf, Track(*(x[:0] for x in self._past))
        self._inner.restart(t, q, v, until)

    def advance(self, stop: float, limit: int) -> Nodes:
        """Steps towards a time, and over a singular configuration where they become ever shorter; see `Stepper`."""
        with np.errstate(all="ignore"):  # multipliers grow without bounds
            nodes = self._next(stop, limit)
        self._bear_in_mind(nodes)
        return nodes

    def _next(self, stop: float, limit: int) -> Nodes:
        """The method's own steps, or the one over a position."""
        landing = self._landing(stop) if self._is_shortening() else None
        if landing is None:
            try:
                return self._inner.advance(stop, limit)
            except RunFailure:
                landing = self._landing(stop)
                if landing is None:
                    raise
        return self._land(landing)

    def _is_shortening(self) -> bool:
        """Whether the last step is so much shorter than the longest before it, and than when this was last so."""
        if len(self._past.t) < 2:
            return False
        h = np.diff(self._past.t[-RECENT:])
        if h[-1] > SHORT * h.max():
            self._shortest = np.inf
        if h[-1] > SHORT * min(h.max(), self._shortest):
            return False
        self._shortest = float(h[-1])
        return True

    def _bear_in_mind(self, nodes: Nodes) -> None:
        """Keep states, ever fewer the further they are from the last one."""
        fresh = slice(1 if len(self._past.t) else 0, None)
        t = np.concatenate([self._past.t, nodes.t[fresh]])
        rows, row = list[int](), len(t) - 1
        while row >= 0:
            rows.append(row)
            row = int(np.searchsorted(t[:row], t[-1] - THIN * (t[-1] - t[row]), side="right")) - 1
        capacity = min(RECORD_SIZE, max(2 * POINTS, NUMBERS // (2 * self._system.nq)))
        chosen = rows[capacity::-1]
        q, v = (
            np.concatenate(x)[chosen]
            for x in ((self._past.q, nodes.q[fresh]), (self._past.v, nodes.v[fresh]))
        )
        self._past = Track(t[chosen], q, v)

    def _landing(self, stop: float) -> Landing | None:
        """The way over the position, from the nearest state from where it is exact enough, or the most exact one."""
        found: list[Landing] = []
        for row, ahead in self._before_the_position():
            end = float(self._past.t[row]) + 2 * ahead
            if self._past.t[-1] < end <= stop:
                found += self._over(row, end)
                if found and found[-1].error <= 1.0:
                    return found[-1]
        best = min(found, key=lambda landing: landing.error, default=None)
        return best if best is not None and best.error <= ENOUGH else None

    def _before_the_position(self) -> Iterator[tuple[int, float]]:
        """States before it, the nearest first, and how far it is, in time: so falls the smallest singular value."""
        past, known = self._past, self.independence
        near: tuple[float, float] | None = None
        for row in range(len(past.t) - 1, -1, -1):
            t = float(past.t[row])
            if near is not None and past.t[-1] - t < FURTHER * (past.t[-1] - near[0]):
                continue
            rank = rank_of(known.scaled_Phi_q(past.q[row], t))
            value = rank.smallest if rank.null.shape[1] == known.known else 0.0
            if value > CLOSE * known.smallest:
                return
            if near is not None and value > max(near[1], AWAY * known.smallest):
                yield row, (near[0] - t) * value / (value - near[1])
            near = t, value

    def _over(self, row: int, end: float) -> list[Landing]:
        """Take one step from a state to a time; None if this fails."""
        rows = _spaced(self._past.t, row, 0.5 * SPACING * (end - self._past.t[row]))
        try:
            return [self._step(rows, end)] if len(rows) > 1 else []
        except SingularSystem:
            return []

    def _step(self, rows: list[int], end: float) -> Landing:
        """The same, from the last of some states."""
        stored, (times, qs, vs) = self.independence.rows, (x[rows] for x in self._past)
        motion = EquationsOfMotion(self._system, stored)
        motion.b[:] = self.b
        project = Projection(self._system, motion.b, stored)
        states = [(t, *project(t, q, v)) for t, q, v in zip(times.tolist(), qs, vs, strict=True)]
        known, begin = [motion.acceleration(*state)[0] for state in states], StepStart(*states[-1])
        way, moved, iterations = InterpolatedMotion(begin, times, np.array(known)), np.inf, 0
        while moved >= SETTLED and iterations < ROUNDS:
            q, v, _ = way.at(end)
            a, lam = motion.acceleration(end, *project(end, q, v))
            way, before = InterpolatedMotion(begin, np.append(times, end), np.array([*known, a])), way
            moved, iterations = self._size(way.at(end), before.at(end)), iterations + 1
        poorer = InterpolatedMotion(begin, np.append(times[1:], end), np.array([*known[1:], a]))
        q, v, _ = way.at(end)
        there = project(end, q, v)
        error = max(moved, self._size((q, v), there), self._size((q, v), poorer.at(end)))
        return Landing(self._nodes(way, end, there, a, lam), error, iterations)

    def _nodes(
        self, way: InterpolatedMotion, end: float, there: tuple[Array, Array], a: Array, lam: Array
    ) -> Nodes:
        """From where the method has come on; multipliers on the way, which may be without bounds, are not guessed."""
        since, places = self.t, self._system.memory_places
        t = np.array([since, *(since + np.arange(1, PARTS) / PARTS * (end - since)), end])
        q, v, acc = (np.array(x) for x in zip(*(way.at(time) for time in t), strict=True))
        q[0], v[0] = self._past.q[-1], self._past.v[-1]
        (q[-1], v[-1]), acc[-1] = there, a
        multipliers = np.zeros((len(t), len(lam)))
        multipliers[-1] = lam
        return Nodes(t, q, v, acc, multipliers, np.tile(self.b[places], (len(t), 1)))

    def _size(self, one: Sequence[Array], other: Sequence[Array]) -> float:
        """Root mean square of the differences of q and of v over their tolerances, the greater."""
        allowed = self._settings.tolerances.of_state(other[0], other[1], self._length)
        in_q, in_v = (_root_mean_square((x - y) / z) for x, y, z in zip(one, other, allowed, strict=False))
        return float(np.nan_to_num(np.max([in_q, in_v]), nan=np.inf))

    def _land(self, landing: Landing) -> Nodes:
        """Let the method begin anew behind the position."""
        nodes, tally = landing.nodes, self.tally
        self._system.remember(nodes.q[-1], self.b, nodes.t[-1])
        self._inner.restart(float(nodes.t[-1]), nodes.q[-1], nodes.v[-1], self._until)
        tally.nsteps += 1
        announce([f"{self._system.name}: {BRANCHES.format(nodes.t[0], nodes.t[-1])}"])
        taken = nodes.t[-1] - nodes.t[0]
        tally.history.append(np.array([[nodes.t[-1], taken, landing.error, landing.iterations, 0]]))
        return nodes


class StepStart(NamedTuple):
    """The state that a step goes out from."""

    t: float
    q: Array
    v: Array


class InterpolatedMotion:
    """A motion whose accelerations are the polynomial through some of them (k, nq), at rising times (k,)."""

    def __init__(self, begin: StepStart, times: Array, a: Array) -> None:
        self._begin, self._first, self._half = begin, times[0], 0.5 * (times[-1] - times[0])
        self._a = np.linalg.solve(chebyshev.chebvander(self._x(times), len(times) - 1), a)
        message = {"lbnd": self._x(begin.t), "scl": self._half}
        self._v, self._q = (chebyshev.chebint(self._a, m, **message) for m in (1, 2))

    def _x(self, t: ArrayLike) -> Any:
        """-1 at the first of the times, 1 at the last."""
        return (np.asarray(t) - self._first) / self._half - 1

    def at(self, t: float) -> tuple[Array, Array, Array]:
        """q, v and a."""
        begin, x = self._begin, self._x(t)
        q, v, a = (np.asarray(chebyshev.chebval(x, c)) for c in (self._q, self._v, self._a))
        return begin.q + (t - begin.t) * begin.v + q, begin.v + v, a


def _root_mean_square(x: Array) -> float:
    return float(np.sqrt(np.mean(x**2)))


def _spaced(t: Array, last: int, apart: float) -> list[int]:
    """Places of rising times up to the last one, so far apart at least, as many as make a polynomial with one more."""
    rows = [last]
    for row in range(last - 1, -1, -1):
        if t[rows[-1]] - t[row] >= apart and len(rows) < POINTS - 1:
            rows.append(row)
    return rows[::-1]
