"""States at the nodes of a run or between them, and the way of gradients back to the nodes.

Between two nodes states are those of `dynamics.stepping.nodes`: of Radau q is the polynomial of degree five that has
q, v and a there, and λ of degree five, too, through the six nodes about a time. Of methods of order two q is the cubic
that has q and v, v that which has v and a; a and λ are linear. All are linear in the nodes.

Events move the nodes that follow, see `segments`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import accumulate
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import csr_array, eye_array

from ....algebra import Array
from ....outputs.recording import Angles, Key
from ....results import Segments, StepsTaken
from ....results.motion.steps import segments_of
from ....system import System
from ..chain.chain import Nodes
from .reported import Reporter
from .segments import Instants, course_of, nodes_of

# value at s = 0, 1 and slopes, bends there, as coefficients of s⁰ ... s⁵: q₀, h v₀, h² a₀, q₁, h v₁, h² a₁
HERMITE = np.array([
    [1, 0, 0, -10, 15, -6],
    [0, 1, 0, -6, 8, -3],
    [0, 0, 0.5, -1.5, 1.5, -0.5],
    [0, 0, 0, 10, -15, 6],
    [0, 0, 0, -4, 7, -3],
    [0, 0, 0, 0.5, -1, 0.5],
])  # fmt: skip
# the same of a cubic: x₀, h x₀', x₁, h x₁'
CUBIC = np.array([[1, 0, -3, 2], [0, 1, -2, 1], [0, 0, 3, -2], [0, 0, -1, 1]])
KINDS = ("q", "v", "a")
READ = (*KINDS, "lam")
# nodes of a polynomial in time for multipliers: of methods of order two, the same where times move, of Radau
LINEAR, LOW, HIGH = 2, 3, 6
ROUND = 1e-9  # [-] of a step, within which a time is a node's


class Sampling:
    """The states at some times of a run, at all its nodes by default; events move times, and the nodes behind them.

    Each kind of states is computed when it is read.

    Parameters
    ----------
    steps : of the run
    where : the times

    Attributes
    ----------
    moves : whether events move the times
    reported : gives multipliers, where constraints are redundant
    """

    moves = False
    reported: Reporter | None = None

    def __init__(self, steps: StepsTaken | Segments, where: Instants | None = None) -> None:
        self._steps, self._segments, self.moves = steps, segments_of(steps), isinstance(steps, Segments)
        self._every = where is None and not self.moves
        self._t, self.segment, self._part = where or nodes_of(course_of(steps))

    @property
    def t(self) -> Array:
        """The times (nt,). [s]"""
        return self._t

    @cached_property
    def _begins(self) -> list[int]:
        """The place of each segment's first node among all nodes, and the number of nodes."""
        return [0, *accumulate(len(segment.t) for segment in self._segments)]

    @cached_property
    def _places(self) -> Places:
        """The positions of the times."""
        found = Places(np.zeros(len(self.t), dtype=np.int64), *np.zeros((2, len(self.t))))
        for rows, begin, t in self._spans():
            at = _placed(t, self.t[rows])
            for whole, part in zip(found, at._replace(first=at.first + begin), strict=True):
                whole[rows] = part
        return found

    def _spans(self) -> Iterator[tuple[Array, int, Array]]:
        """Of each segment: which times are in it, its first node among all, and the times of its nodes."""
        for p, (segment, begin) in enumerate(zip(self._segments, self._begins, strict=False)):
            yield self.segment == p, begin, segment.t

    @property
    def between_nodes(self) -> Array:
        """Return which times are between nodes, also after a change of event times (nt,)."""
        if self._every:
            return np.zeros(len(self.t), dtype=bool)
        s = self._places.s
        inside = (s != 0.0) & (s != 1.0)
        return np.asarray(inside | self._local.any(axis=1) if self.moves else inside)

    @property
    def _apart(self) -> bool:
        return apart(self._segments[0])

    @property
    def _by_nodes(self) -> tuple[str, ...]:
        """What is interpolated through some nodes, not by both ends of a step."""
        return ("a", "lam") if self._apart else ("lam",)

    @property
    def _width(self) -> int:
        """The nodes of a polynomial in time: so many that its slope is good, too, where times move."""
        return HIGH if not self._apart else LOW if self.moves else LINEAR

    @cached_property
    def _weights(self) -> Weights:
        """Those of q, v, a there, and of their slopes, in q, v, a of both nodes."""
        return interpolation(self._places.s, self._places.h, self._apart)

    @cached_property
    def _stencil(self) -> Stencil:
        """The nodes that λ (and a) at the times are made of."""
        nodes = np.zeros((len(self.t), self._width), dtype=np.int64)
        found, (first, h, s) = np.zeros((3, *nodes.shape)), self._places
        for rows, begin, t in self._spans():
            before = first[rows] - begin
            near = around(before, self._width, len(t))
            ahead = t[near] - (t[before] + s[rows] * h[rows])[:, None]
            nodes[rows, : near.shape[1]] = begin + near
            found[:, rows, : near.shape[1]] = lagrange(ahead)
        return Stencil(nodes, found)

    @cached_property
    def _maps(self) -> dict[tuple[str, int], dict[str, csr_array]]:
        """Those that were needed, see `_map`."""
        return {}

    def _map(self, kind: str, order: int = 0) -> dict[str, csr_array]:
        """What a kind, or a derivative of it by the time, is of each kind at the nodes (nt, nodes)."""
        if (kind, order) not in self._maps:
            self._maps[kind, order] = self._new_map(kind, order)
        return self._maps[kind, order]

    def _new_map(self, kind: str, order: int) -> dict[str, csr_array]:
        count = self._begins[-1]
        if self._every:
            return {kind: eye_array(count, format="csr")}
        if kind in self._by_nodes:
            return {kind: _sparse(self._stencil.nodes, self._stencil.shares[order], count)}
        ends = self._places.first[:, None] + np.arange(2)
        weights = self._weights[order][:, KINDS.index(kind)]
        return {KINDS[place]: _sparse(ends, weights[:, :, place], count) for place in self._sources(kind)}

    def _array(self, name: str) -> Array:
        """A field at all nodes; multipliers as they are reported, at the nodes that count."""
        return self._multipliers if name == "lam" and self.reported else self._of_nodes(name)

    def _of_nodes(self, name: str) -> Array:
        fields = [getattr(segment, name) for segment in self._segments]
        return fields[0] if len(fields) == 1 else np.concatenate(fields)

    @cached_property
    def _multipliers(self) -> Array:
        assert self.reported is not None
        return self.reported.lam(self.nodes_of_multipliers)

    @property
    def nodes_of_multipliers(self) -> Array:
        """The nodes that λ at the times is made of."""
        return np.arange(self._begins[-1]) if self._every else np.unique(self._stencil.nodes)

    @cached_property
    def q(self) -> Array:
        """Coordinates there (nt, nq)."""
        return self._at_times("q")

    @cached_property
    def v(self) -> Array:
        """Velocities there (nt, nq)."""
        return self._at_times("v")

    @cached_property
    def a(self) -> Array:
        """Accelerations there (nt, nq)."""
        return self._at_times("a")

    def lam(self) -> Array:
        """Multipliers there (nt, m)."""
        return self._at_times("lam")

    def _at_times(self, kind: str, order: int = 0, places: Any = slice(None)) -> Array:
        """Coordinates of a kind, or a derivative of them within their steps (nt, places)."""
        if self._every:
            return self._array(kind)
        maps = self._map(kind, order).items()
        return np.asarray(sum(own @ self._array(name)[:, places] for name, own in maps))

    def _sources(self, kind: str) -> Sequence[int]:
        """What a kind of states is interpolated from, by its place among the kinds."""
        return {"q": (0, 1), "v": (1, 2)}[kind] if self._apart else range(len(KINDS))

    @property
    def memory(self) -> dict[int, Array]:
        """State variables of elements at the times (nt,), by index among the parameters."""
        every = np.concatenate([x for own in self._segments for x in (own.memory, own.memory[-1:])])
        return dict(zip(self._segments[0].places.tolist(), every[self._places.first].T, strict=True))

    @cached_property
    def _local(self) -> Array:
        """Return the change of each time within its segment by the events (nt, segments + 1)."""
        found = np.zeros((len(self.t), len(self._segments) + 1))
        rows, held = np.arange(len(self.t)), np.isnan(self._part)
        found[rows, self.segment] -= np.where(held, 1.0, self._part)
        found[rows, self.segment + 1] += np.where(held, 0.0, self._part)
        return found

    @cached_property
    def _global(self) -> Array:
        """Return the change of the times by the events."""
        found, held = self._local.copy(), np.isnan(self._part)
        found[np.arange(len(self.t)), self.segment] += 1.0
        found[held] = 0.0
        return found

    def spread(self, kind: str, places: Array, bar: Array, nodes: Nodes, column: int) -> None:
        """Add the gradients by some coordinates of a kind to those by the nodes, and by the times of the events."""
        for name, own in self._map(kind).items():
            getattr(nodes, name)[:, places, column] += own.T @ bar
        if self.moves:
            nodes.shift[:, column] += self._local.T @ np.sum(bar * self._at_times(kind, 1, places), axis=1)

    def spread_all(self, bars: Mapping[Key, Array], nodes: Nodes, column: int) -> Array:
        """The same of all coordinates; what they add to the gradient by the numbers, (1, 1) if that is nothing."""
        for kind, (places, bar) in by_kind(bars).items():
            self.spread(kind, places, bar, nodes, column)
        return np.zeros((1, 1))

    def spread_along(self, bars: Mapping[Key, Array], dots: Nodes, nodes: Nodes) -> None:
        """Add the changes of gradients, given at the times, by nodes that change as times move in their steps."""
        if not self.moves:
            return
        moved = (self._local @ dots.shift[:, 0])[:, None]
        for kind, (places, bar) in by_kind(bars).items():
            rates_dot = self._at_times(kind, 2, places) * moved
            for name, own in self._map(kind, 1).items():
                getattr(nodes, name)[:, places, 0] += own.T @ (bar * moved)
                rates_dot += own @ getattr(dots, name)[:, places, 0]
            nodes.shift[:, 0] += self._local.T @ np.sum(bar * rates_dot, axis=1)

    def spread_time(self, bar: Array, nodes: Nodes, column: int) -> None:
        """Add the gradient by the times themselves, where they move."""
        nodes.shift[:, column] += self._global.T @ bar

    def gathered_time(self, nodes: Nodes, column: int) -> Array:
        """The change of the times, where they move."""
        return np.asarray(self._global @ nodes.shift[:, column])

    def gathered(self, kind: str, places: Array, nodes: Nodes, column: int) -> Array:
        """The changes of some coordinates of a kind at the times, of those of the nodes: the transpose of `spread`."""
        own = self._map(kind).items()
        found = np.asarray(sum(x @ getattr(nodes, name)[:, places, column] for name, x in own))
        if not self.moves:
            return found
        moved = self._at_times(kind, 1, places) * (self._local @ nodes.shift[:, column])[:, None]
        return np.asarray(found + moved)

    def all_gathered(
        self, keys: Iterable[Key], nodes: Nodes, b: Array, c: Array, column: int
    ) -> dict[Key, Array]:
        """The same of all given coordinates, with the changes of the numbers (len(b), k), and of those of joints."""
        found, wanted = dict[Key, Array](), list(keys)
        for kind in dict.fromkeys(kind for kind, _ in wanted):
            places = [n for own, n in wanted if own == kind]
            moved = self.gathered(kind, np.array(places), nodes, column)
            found |= {(kind, n): moved[:, k] for k, n in enumerate(places)}
        return found


def by_kind(bars: Mapping[Key, Array]) -> dict[str, tuple[Array, Array]]:
    """The coordinates of each kind, and their gradients (nt, coordinates)."""
    found = dict[str, tuple[Array, Array]]()
    for kind in dict.fromkeys(kind for kind, _ in bars):
        places = [n for own, n in bars if own == kind]
        found[kind] = np.array(places), np.column_stack([bars[kind, n] for n in places])
    return found


def _sparse(nodes: Array, shares: Array, count: int) -> csr_array:
    """The matrix that makes something at some times of nodes (nt, count); zeros do not count."""
    begin = np.arange(len(nodes) + 1) * nodes.shape[1]
    found = csr_array((shares.ravel(), nodes.ravel(), begin), shape=(len(nodes), count), copy=True)
    found.eliminate_zeros()
    return found


class Stencil(NamedTuple):
    """Nodes about some times (nt, k), and their shares in a polynomial through them, its slope and bend (3, nt, k)."""

    nodes: Array
    shares: Array


class Weights(NamedTuple):
    """Weights of q, v, a at both nodes in q, v, a between them, and in their derivatives (nt, 3, 2, 3)."""

    values: Array
    slopes: Array
    bends: Array


class Places(NamedTuple):
    """Nodes before some times, lengths of the steps, and relative positions in them (nt,)."""

    first: Array
    h: Array
    s: Array


def around(before: Array, most: int, count: int) -> Array:
    """The nodes about times after given ones, of so many at most and of all that there are (nt, k)."""
    width = min(most, count)
    begin = np.clip(before - (width - 2) // 2, 0, count - width)
    return np.asarray(begin[:, None] + np.arange(width))


def lagrange(t: Array) -> tuple[Array, Array, Array]:
    """Values, slopes and bends at 0 of the polynomials that are 1 at one of some times (nt, k) and 0 at the others."""
    values, slopes, bends = np.ones(t.shape), np.zeros(t.shape), np.zeros(t.shape)
    for j in range(t.shape[1]):
        ahead = t - t[:, j : j + 1]
        ahead[:, j] = np.inf
        slope = 1 / ahead
        value = -t[:, j : j + 1] * slope
        value[:, j] = 1.0
        bends = bends * value + 2 * slopes * slope
        slopes = slopes * value + values * slope
        values = values * value
    return values, slopes, bends


def _placed(t: Array, times: Array) -> Places:
    first = np.clip(np.searchsorted(t, times, side="right") - 1, 0, len(t) - 2)
    h = np.diff(t)[first]
    s = (times - t[first]) / h
    return Places(first, h, np.where(abs(s) < ROUND, 0.0, np.where(abs(s - 1) < ROUND, 1.0, s)))


def apart(steps: StepsTaken) -> bool:
    """Whether q and v are interpolated apart between nodes, as those of order two are."""
    return not steps.precise


def interpolation(s: Array, h: Array, separate: bool) -> Weights:
    """Weights of q, v, a, or of q and v apart (`separate`), at parts s of steps of length h."""
    if not separate:
        orders = _polynomial(HERMITE, s, h, 5)
        return Weights(orders[:, :3], orders[:, 1:4], orders[:, 2:])
    found = Weights(*np.zeros((3, len(s), 3, 2, 3)))
    orders = _polynomial(CUBIC, s, h, 3)
    for of, whole in enumerate(found):
        for k in (0, 1):
            whole[:, k, :, k : k + 2] = orders[:, of]
    return found


def _polynomial(basis: Array, s: Array, h: Array, orders: int) -> Array:
    """Weights (nt, orders, 2, k) of derivatives 0, 1 ... of what has k given derivatives at both ends."""
    size = len(basis)
    powers, factors = np.vander(s, size, increasing=True), np.arange(size)
    derived = [basis]
    for _ in range(orders - 1):
        derived.append(np.roll(derived[-1] * factors, -1, axis=1))
    found = np.stack([powers @ own.T for own in derived], axis=1).reshape(-1, orders, 2, size // 2)
    scale = np.vander(h, max(orders, size // 2), increasing=True)
    return np.asarray(found * scale[:, None, None, : size // 2] / scale[:, :orders, None, None])


def angles_of(system: System, steps: StepsTaken | Segments) -> Angles:
    """The joints' coordinates and rotations of bodies along a run, with the revolutions that it started with."""
    counted, start = system.counted_coordinates, steps.start
    first = counted.with_revolutions(counted.Phi(start.q), start.revolutions)
    return Angles(system, Sampling(steps), lambda: first)
