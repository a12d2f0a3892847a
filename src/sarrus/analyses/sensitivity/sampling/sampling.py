"""States at the nodes of a run or between them, and the way of gradients back to the nodes.

Between two nodes states are those of `dynamics.stepping.nodes`: of Radau q is the polynomial of degree five that has
q, v and a there, and λ of degree five, too, through the six nodes about a time. Of methods of order two q is the cubic
that has q and v, v that which has v and a; a and λ are linear. All are linear in the nodes.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from itertools import product
from math import perm
from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ....outputs.recording import Key, States
from ....results import StepsTaken
from ..chain.chain import Nodes
from .reported import Reporter

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
LINEAR, HIGH = 2, 6  # nodes of a polynomial in time for multipliers; of Radau
ROUND = 1e-9  # [-] of a step, within which a time is a node's


class NoSample(ValueError):
    """A run that does not have a time or an event at which a response is taken."""


def refuse_outside(times: Iterable[float], begin: float, end: float) -> None:
    """Refuse times [s] that are before the start of a run or after its end.

    Raises
    ------
    NotThere
    """
    round_off = 2e-12 * abs(end)  # steps begin just behind a jump at the start
    wrong = next((t for t in times if not begin - round_off <= t <= end + round_off), None)
    if wrong is not None:
        message = (
            f"times must be between {begin:g} and {end:g} s, the start and the end of the run, but one is"
        )
        raise NoSample(f"{message} {wrong:g} s. Give another time, or another end.")


class Sampling:
    """The states at some times of a run, at all its nodes by default.

    Raises
    ------
    NotThere
        For times outside the run.
    """

    moves = False  # whether events move the times
    reported: Reporter | None = None  # gives multipliers, where constraints are redundant

    def __init__(self, steps: StepsTaken, times: Array | None = None) -> None:
        self._steps = steps
        self._times = times
        refuse_outside(() if times is None else times, steps.t[0], steps.t[-1])

    @property
    def t(self) -> Array:
        """The times (nt,). [s]"""
        return self._steps.t if self._times is None else np.asarray(self._times, dtype=float)

    @cached_property
    def _places(self) -> Places:
        """Return the positions of the times."""
        t = self._steps.t
        return _placed(t, np.searchsorted(t, self.t, side="right") - 1, self.t)

    @property
    def between_nodes(self) -> Array:
        """Return which times are between nodes (nt,)."""
        if self._times is None:
            return np.zeros(len(self.t), dtype=bool)
        s = self._places.s
        return np.asarray((s != 0.0) & (s != 1.0))

    @property
    def _apart(self) -> bool:
        return apart(self._steps)

    @property
    def _by_nodes(self) -> tuple[str, ...]:
        """What is interpolated through some nodes, not by both ends of a step."""
        return ("a", "lam") if self._apart else ("lam",)

    @cached_property
    def _weights(self) -> Weights:
        """Those of q, v, a there, and of their slopes, in q, v, a of both nodes."""
        return interpolation(self._places.s, self._places.h, self._apart)

    @cached_property
    def _near(self) -> Stencil:
        """The nodes that λ (and a) at the times are made of."""
        first, h, s = self._places
        if self._apart:
            return Stencil(np.column_stack([first, first + 1]), np.column_stack([1 - s, s]))
        near = around(first, HIGH, len(self._steps.t))
        ahead = self._steps.t[near] - (self._steps.t[first] + s * h)[:, None]
        return Stencil(near, lagrange(ahead)[0])

    def _array(self, name: str) -> Array:
        """A field at all nodes; multipliers as they are reported, at the nodes that count."""
        return self._multipliers if name == "lam" and self.reported else self._raw(name)

    def _raw(self, name: str) -> Array:
        return np.asarray(getattr(self._steps, name))

    @cached_property
    def _multipliers(self) -> Array:
        assert self.reported is not None
        return self.reported.lam(self.nodes_of_multipliers)

    @property
    def nodes_of_multipliers(self) -> Array:
        """The nodes that λ at the times is made of."""
        return np.arange(len(self._steps.t)) if self._times is None else np.unique(self._near.nodes)

    def _lam(self) -> Array:
        """λ at the times (nt, m)."""
        if self._times is None:
            return self._array("lam")
        near = self._near
        return np.asarray(np.einsum("tw,twm->tm", near.shares, self._array("lam")[near.nodes]))

    @property
    def states(self) -> States:
        """The states there; they are not stored, as their `lam` refers to this object, which holds all steps."""
        return States._make([self.t, *self._motion, self._lam])

    @cached_property
    def _motion(self) -> list[Array]:
        """q, v and a there."""
        if self._times is None:
            return [self._array(name) for name in KINDS]
        found, first, weights = dict[str, Array](), self._places.first, self._weights.values
        ends = [{kind: self._array(kind)[first + end] for kind in KINDS} for end in (0, 1)]
        for row, kind in enumerate(KINDS):
            if kind in self._by_nodes:
                near = self._near
                found[kind] = np.einsum("tw,twm->tm", near.shares, self._array(kind)[near.nodes])
                continue
            terms = [(end, place) for end in (0, 1) for place in self._sources(kind)]
            found[kind] = weights[:, row, terms[0][0], terms[0][1], None] * ends[0][KINDS[terms[0][1]]]
            for end, place in terms[1:]:
                found[kind] += weights[:, row, end, place, None] * ends[end][KINDS[place]]
        return [found[kind] for kind in KINDS]

    def _sources(self, kind: str) -> Sequence[int]:
        """What a kind of states is interpolated from, by its place among the kinds."""
        return {"q": (0, 1), "v": (1, 2)}[kind] if self._apart else range(len(KINDS))

    @property
    def memory(self) -> dict[int, Array]:
        """State variables of elements at the times (nt,), by index among the parameters."""
        rows = self._remembered()[self._places.first]
        return dict(zip(self._steps.places.tolist(), rows.T, strict=True))

    def _remembered(self) -> Array:
        """The same in every step, by its first node."""
        return self._steps.memory

    def spread(self, kind: str, n: int, bar: Array, nodes: Nodes, column: int) -> None:
        """Add the gradient by coordinate n of a kind, given at the times, to those by the nodes."""
        if self._times is None:
            getattr(nodes, kind)[:, n, column] += bar
            return
        if kind in self._by_nodes:
            by = getattr(nodes, kind)[:, n, column]
            np.add.at(by, self._near.nodes, self._near.shares * bar[:, None])
            return
        first, weights, row = self._places.first, self._weights.values, KINDS.index(kind)
        for end, place in product((0, 1), self._sources(kind)):
            by = getattr(nodes, KINDS[place])[:, n, column]
            by += np.bincount(first + end, weights[:, row, end, place] * bar, len(by))

    def spread_all(self, bars: Mapping[Key, Array], nodes: Nodes, column: int) -> Array:
        """The same of all coordinates; what they add to the gradient by the numbers, (1, 1) if that is nothing."""
        for (kind, n), bar in bars.items():
            self.spread(kind, n, bar, nodes, column)
        return np.zeros((1, 1))

    def spread_along(self, bars: Mapping[Key, Array], dots: Nodes, nodes: Nodes) -> None:
        """Add the changes of gradients, given at the times, by nodes that change as times move in their steps."""

    def spread_time(self, bar: Array, nodes: Nodes, column: int) -> None:
        """Add the gradient by the times themselves, where they move."""
        raise NotImplementedError

    def gathered_time(self, nodes: Nodes, column: int) -> Array:
        """The change of the times, where they move."""
        raise NotImplementedError

    def gathered(self, kind: str, n: int, nodes: Nodes, column: int) -> Array:
        """The change of coordinate n of a kind at the times, of that of the nodes: the transpose of `spread`."""
        if self._times is None:
            return np.asarray(getattr(nodes, kind)[:, n, column])
        if kind in self._by_nodes:
            there = getattr(nodes, kind)[:, n, column][self._near.nodes]
            return np.asarray(np.sum(self._near.shares * there, axis=1))
        first, weights = self._places.first, self._weights.values
        row, total = KINDS.index(kind), np.zeros(len(self.t))
        for end, place in product((0, 1), self._sources(kind)):
            total += weights[:, row, end, place] * getattr(nodes, KINDS[place])[first + end, n, column]
        return total

    def all_gathered(self, keys: Iterable[Key], nodes: Nodes, b: Array, column: int) -> dict[Key, Array]:
        """The same of some coordinates, with the change of the numbers (len(b), k)."""
        return {(kind, n): self.gathered(kind, n, nodes, column) for kind, n in keys}


class Stencil(NamedTuple):
    """Nodes about some times (nt, k), and their shares in what is interpolated between them."""

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


def late(most: int) -> int:
    """The last steps before a node about which there are nodes behind it, too."""
    return most - 2 - (most - 2) // 2


def lagrange(t: Array) -> tuple[Array, Array]:
    """Values and slopes at 0 of the polynomials that are 1 at one of some times (nt, k) and 0 at the others."""
    values, slopes, _ = lagrange_with_bends(t)
    return values, slopes


def lagrange_with_bends(t: Array) -> tuple[Array, Array, Array]:
    """Values, slopes and second derivatives at 0 of these polynomials: of products of (x - t_j) / (t_i - t_j)."""
    count = t.shape[1]
    values, slopes, bends = np.ones(t.shape), np.zeros(t.shape), np.zeros(t.shape)
    for i in range(count):
        for j in range(count):
            if j != i:
                slope = 1 / (t[:, i] - t[:, j])
                value = -t[:, j] * slope
                bends[:, i] = bends[:, i] * value + 2 * slopes[:, i] * slope
                slopes[:, i] = slopes[:, i] * value + values[:, i] * slope
                values[:, i] *= value
    return values, slopes, bends


def _placed(t: Array, before: Array, times: Array) -> Places:
    first = np.clip(before, 0, len(t) - 2)
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
    powers = [_powers(s, order, size) for order in range(orders)]
    found = np.stack([p @ basis.T for p in powers], axis=1).reshape(-1, orders, 2, size // 2)
    scale = h[:, None] ** np.arange(max(orders, size // 2))
    return np.asarray(found * scale[:, None, None, : size // 2] / scale[:, :orders, None, None])


def _powers(s: Array, order: int, size: int) -> Array:
    """The derivatives of s⁰ ... of an order (nt, size)."""
    k = np.arange(size)
    return np.asarray(np.array([perm(n, order) for n in k]) * s[:, None] ** np.maximum(k - order, 0))
