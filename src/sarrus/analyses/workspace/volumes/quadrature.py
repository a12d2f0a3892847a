"""The integral of slices' areas over their height, and the heights at which slices change their kind."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ....algebra import Array
from ....results.maps.workspace_range import WorkspaceRange
from ....results.maps.workspace_volume import Slice, VolumeRates
from .extremes import distinct
from .slicing import Slicer

NEAR = 1e-4  # of the whole range: so near to a critical height it is located
AROUND = 5  # times that: an expected height at this distance is taken
SHORT = 30  # times that: the kinds of slices are not looked at in pieces that are shorter
LEAST = 0.01  # of the range: expected heights that are nearer to each other cut no piece
LONG = 0.25  # of the range: pieces that are longer are looked at with more slices first
SCAN = 16  # intervals of theta at which a range is looked at first
FIRST, LAST = 4, 32  # intervals of theta in a piece; a piece that wants more is cut
SLOW = 0.3  # by which what is missed shrinks with twice as many slices: slower pieces are cut
JUMP = 1e-3  # of the largest area: by so much areas jump where a part of the boundary is level
LEFT = 0.4  # of what the last slices were missed by: at inner ends like roots 2^-1.5 of it is left, at kinks 2^-2


@dataclass(eq=False)
class Piece:
    """Heights between two critical ones, with the number of intervals of theta."""

    low: float
    high: float
    count: int = FIRST

    def heights(self, count: int) -> list[float]:
        """Return the heights of the inner slices for a number of intervals; those of half as many are among them."""
        middle, half = 0.5 * (self.low + self.high), 0.5 * (self.high - self.low)
        return [middle - half * math.cos(theta) for theta in thetas(count)]

    def slopes(self, count: int) -> Array:
        """d(height)/d(theta) there."""
        return 0.5 * (self.high - self.low) * np.sin(thetas(count))


def thetas(count: int) -> list[float]:
    """Inner points of the rule of Clenshaw and Curtis on 0 ... pi."""
    return [0.5 * math.pi * (1 - math.cos(math.pi * k / count)) for k in range(1, count)]


def weights(count: int) -> Array:
    """Return the weights of Clenshaw-Curtis quadrature on 0 ... pi at its inner points."""
    k = np.arange(1, count // 2)
    angle = np.pi * np.arange(1, count) / count
    last = np.cos(count * angle) / (count**2 - 1)
    terms = (2 * np.cos(2 * np.outer(angle, k)) / (4 * k**2 - 1)).sum(axis=1)
    return np.asarray(0.5 * np.pi * 2 / count * (1 - terms - last))


def open_weights(count: int) -> Array:
    """Return the weights of Fejér's second rule at the same points, for functions that are not zero at the ends."""
    angle, odd = np.pi * np.arange(1, count) / count, np.arange(1, count, 2)
    sums = (np.sin(np.outer(angle, odd)) / odd).sum(axis=1)
    return np.asarray(0.5 * np.pi * 4 / count * np.sin(angle) * sums)


class Integral:
    """The volume below and above critical heights, piece by piece.

    Parameters
    ----------
    slicer : makes slices
    ranges : of the height
    expected : heights at which something may change
    rtol : relative error that is wanted
    most : slices

    Attributes
    ----------
    critical : heights at which slices change their kind
    value, error : so far
    """

    def __init__(
        self,
        slicer: Slicer,
        ranges: Sequence[tuple[float, float]],
        expected: Sequence[float],
        rtol: float,
        most: int,
    ) -> None:
        self.slicer, self.ranges, self.rtol, self.most = slicer, ranges, rtol, most
        self._span = max((high - low for low, high in ranges), default=0.0)
        self._near = NEAR * self._span
        self.expected = distinct(expected, AROUND * self._near)
        self.pieces = [piece for low, high in ranges for piece in self._first(low, high)]
        self.critical: list[float] = []
        self.value, self.error = 0.0, np.inf

    def _first(self, low: float, high: float) -> Iterator[Piece]:
        """Pieces between expected heights, also of features that are too small to be met by chance."""
        least = LEAST * self._span
        inner = distinct(self._expected(low + least, high - least), least)
        for a, b in pairwise([low, *inner, high]):
            yield Piece(a, b, SCAN if b - a > LONG * self._span else 2 * FIRST)

    def _at_expected(self) -> list[float]:
        """Expected heights at which slices change their kind."""
        inner = [piece.low for piece in self.pieces if piece.low not in {low for low, _ in self.ranges}]
        below = self.slicer.at(z - self._near for z in inner)
        above = self.slicer.at(z + self._near for z in inner)
        return [z for z, a, b in zip(inner, below, above, strict=True) if a.kind != b.kind]

    def run(self) -> None:
        """Cut and refine until the error is small enough or there are too many slices."""
        waiting = list(self.pieces)
        self.slicer.at(z for piece in waiting for z in piece.heights(piece.count))
        self.critical = self._at_expected()
        while waiting:
            self.slicer.at(z for piece in waiting for z in piece.heights(piece.count))
            waiting = self._cut_where_kinds_change(waiting)
            if not waiting:
                waiting = self._refined()
        self._estimate()
        self.slicer.at(z for low, high in self.ranges for z in _inside(low, high))

    def coarse(self) -> tuple[float, float]:
        """Value and error by the trapezoidal rule in theta over the slices so far; nan without slices.

        The error is the integral of the distances of slices from the line through their neighbours, without signs.
        """
        value = error = 0.0
        for low, high in self.ranges:
            slices = [one for one in self._between(low, high) if one.success]
            half = 0.5 * (high - low)
            theta = np.arccos([(0.5 * (low + high) - one.height) / half for one in slices])
            nodes = np.array([0.0, *theta, np.pi])
            rates = np.array([0.0, *(half * np.sin(theta) * [one.area for one in slices]), 0.0])
            gaps, slopes = np.diff(nodes), np.diff(rates) / np.diff(nodes)
            value += float(np.trapezoid(rates, nodes))
            error += 0.5 * float(gaps[:-1] @ (gaps[1:] * abs(np.diff(slopes))))
        return (value, error) if value > 0.0 else (np.nan, np.nan)

    def rates(self, reach: WorkspaceRange) -> VolumeRates | None:
        """Derivatives of the volume by all parameters, if a slice has any; `reach`: those of critical heights."""
        if all(one.rates is None for one in self.slicer.known.values()):
            return None
        total, half = (np.sum([self._by_numbers(piece, n) for piece in self.pieces], axis=0) for n in (1, 2))
        kinked = sum(
            float(open_weights(piece.count) @ (self._of(piece, "kinked") * piece.slopes(piece.count)))
            for piece in self.pieces
        )
        return VolumeRates(total, total - half, kinked, tuple(self._jumps(reach)), self.slicer.problem, reach)

    def _of(self, piece: Piece, what: str) -> Array:
        """A property of the slices of a piece."""
        found = [getattr(one, what) for one in self.slicer.at(piece.heights(piece.count))]
        known = [getattr(one, what) for one in self.slicer.known.values()]
        size = max(np.size(one) for one in known if one is not None)
        return np.array([np.zeros(size) if one is None else one for one in found])

    def _by_numbers(self, piece: Piece, every: int) -> Array:
        """The integral of a piece's rates, with every slice or every other one."""
        count = piece.count // every
        rates = self._of(piece, "rates")[every - 1 :: every]
        return np.asarray((open_weights(count) * piece.slopes(count)) @ rates)

    def _jumps(self, reach: WorkspaceRange) -> Iterator[tuple[float, float]]:
        """Critical heights at which the area jumps, with the area below less that above."""
        largest = max((one.area for one in self.slicer.known.values()), default=0.0)
        lost: dict[float, float] = {}
        for piece in self.pieces:
            below, above = self._end_areas(piece)
            lost[piece.low] = lost.get(piece.low, 0.0) - below
            lost[piece.high] = lost.get(piece.high, 0.0) + above
        for z, area in lost.items():
            nearest = min((one.value for one in reach.critical), key=lambda value: abs(value - z))
            if abs(area) > JUMP * largest and abs(nearest - z) <= 2 * self._near:
                yield nearest, area

    def _end_areas(self, piece: Piece) -> tuple[float, float]:
        """Areas at the lower and upper end of a piece, by the polynomial in theta through its slices."""
        areas = _polynomial(np.array(thetas(piece.count)), self._of(piece, "area"), np.array([0.0, np.pi]))
        return float(areas[0]), float(areas[1])

    def groups(self) -> list[list[list[Slice]]]:
        """For every range, for every piece between critical heights, its slices by rising height."""
        cuts = sorted(self.critical)
        return [
            [self._between(a, b) for a, b in pairwise([low, *(z for z in cuts if low < z < high), high])]
            for low, high in self.ranges
        ]

    def _between(self, low: float, high: float) -> list[Slice]:
        return [self.slicer.known[z] for z in sorted(self.slicer.known) if low < z < high]

    def _spare(self) -> int:
        return self.most - len(self.slicer.known)

    def _estimate(self) -> dict[Piece, float]:
        """Value and error of the whole; the error of every piece."""
        errors = {piece: self._error(piece) for piece in self.pieces}
        self.value = sum(
            float(weights(piece.count) @ self._rates(piece, piece.count)) for piece in self.pieces
        )
        self.error = sum(errors.values()) + sum(self._of_slices(piece) for piece in self.pieces)
        return errors

    def _rates(self, piece: Piece, count: int) -> Array:
        """dV/d(theta) of a piece at its inner points."""
        areas = [one.area for one in self.slicer.at(piece.heights(count))]
        return np.asarray(areas * piece.slopes(count))

    def _of_slices(self, piece: Piece) -> float:
        errors = [self._doubt(one) for one in self.slicer.at(piece.heights(piece.count))]
        return float(weights(piece.count) @ (errors * piece.slopes(piece.count)))

    def _doubt(self, one: Slice) -> float:
        """The error of a slice; one that is not complete may be as wrong as it differs from its neighbours."""
        if one.success:
            return one.area_error
        return max((abs(one.area - other.area) for other in self.slicer.around(one.height)), default=np.inf)

    def _missed(self, piece: Piece, count: int) -> Array:
        """Return the interpolation error of half as many slices, relative to the integral."""
        rates = self._rates(piece, count)
        return np.asarray(weights(count) * abs(rates - _interpolated(rates[1::2], count)))

    def _error(self, piece: Piece) -> float:
        """By how much the last slices were missed, signs cannot cancel in it; part of it where that shrinks.

        It is not extrapolated by the rate at which it shrank: where a kink shows only now, that rate is another one.
        """
        last = float(self._missed(piece, piece.count).sum())
        if piece.count == FIRST:
            return last
        before = float(self._missed(piece, piece.count // 2).sum())
        return last * (LEFT if last < LEFT * before else 1.0)

    def _refined(self) -> list[Piece]:
        """Pieces with more slices where the error is too large; none where all is well."""
        errors = self._estimate()
        wanted = self.rtol * abs(self.value)
        if self.error <= wanted or self._spare() <= 0:
            return []
        share = 0.5 * wanted / len(self.pieces)
        worst = [
            piece for piece in self.pieces if errors[piece] > share and piece.high - piece.low > self._near
        ]
        return [new for piece in worst for new in self._finer(piece)]

    def _finer(self, piece: Piece) -> list[Piece]:
        """Twice as many slices; where that helps little, because of a kink, the piece is cut there."""
        missed = self._missed(piece, piece.count)
        slow = piece.count > 2 * FIRST and missed.sum() > SLOW * self._missed(piece, piece.count // 2).sum()
        if piece.count < LAST and not slow:
            piece.count *= 2
            return [piece]
        kink = piece.heights(piece.count)[int(np.argmax(missed))]
        return self._replace(piece, [piece.low, kink, piece.high], FIRST)

    def _replace(self, piece: Piece, ends: Sequence[float], count: int) -> list[Piece]:
        new = [Piece(a, b, count) for a, b in pairwise(ends)]
        self.pieces.remove(piece)
        self.pieces += new
        return new

    def _cut_where_kinds_change(self, pieces: Iterable[Piece]) -> list[Piece]:
        """New pieces, where the slices of a piece are of different kinds."""
        long = [piece for piece in pieces if piece.high - piece.low > SHORT * self._near]
        found: set[float] = set()
        while brackets := [pair for piece in long for pair in self._unexplained(piece, found)]:
            if not self.slicer.agree(brackets):
                found |= set(self._located(brackets))
        self.critical = sorted({*self.critical, *found})
        new: list[Piece] = []
        for piece in list(self.pieces):
            inner = sorted(z for z in found if piece.low < z < piece.high)
            if inner:
                new += self._replace(piece, [piece.low, *inner, piece.high], FIRST)
        return new

    def _unexplained(self, piece: Piece, found: Iterable[float]) -> list[tuple[float, float]]:
        """Neighbouring slices of different kinds without a critical height at them."""
        near = 2 * AROUND * self._near
        changes = self._changes(self._between(piece.low + self._near, piece.high - self._near))
        return [(a, b) for a, b in changes if not any(a - near < z < b + near for z in found)]

    def _changes(self, slices: Sequence[Slice]) -> list[tuple[float, float]]:
        return [(a.height, b.height) for a, b in pairwise(slices) if a.kind != b.kind]

    def _differ(self, low: float, high: float) -> bool:
        return self.slicer.known[low].kind != self.slicer.known[high].kind

    def _located(self, brackets: list[tuple[float, float]]) -> list[float]:
        """Where slices change their kind, by bisection; expected heights are tried first."""
        near = self._near
        found: list[float] = []
        while brackets:
            wide = [pair for pair in brackets if pair[1] - pair[0] > 2.5 * near and self._spare() > 0]
            narrow = [pair for pair in brackets if pair not in wide]
            self.slicer.agree(narrow)
            found += [self._place(*pair) for pair in narrow if self._differ(*pair)]
            probes = {pair: self._probes(*pair, near) for pair in wide}
            self.slicer.at(z for some in probes.values() for z in some)
            brackets = [
                change
                for (low, high), some in probes.items()
                for change in self._changes([self.slicer.known[z] for z in (low, *some, high)])
            ]
        return sorted(set(found))

    def _probes(self, low: float, high: float, near: float) -> list[float]:
        expected = self._expected(low + near, high - near)
        if not expected:
            return [0.5 * (low + high)]
        z = expected[len(expected) // 2]
        return [z - near, z + near]

    def _expected(self, low: float, high: float) -> list[float]:
        return [z for z in self.expected if low < z < high]

    def _place(self, low: float, high: float) -> float:
        """A height in a narrow bracket; an expected one near it, around which small curves may have been missed."""
        middle = 0.5 * (low + high)
        expected = self._expected(low - AROUND * self._near, high + AROUND * self._near)
        return min(expected, key=lambda z: abs(z - middle), default=middle)


def _inside(low: float, high: float) -> tuple[float, float]:
    """Heights close to the ends of a range."""
    return low + NEAR * (high - low), high - NEAR * (high - low)


def _interpolated(values: Array, count: int) -> Array:
    """The polynomial in theta through every other inner point and zero at the ends, at all inner points."""
    nodes = np.array([0.0, *thetas(count // 2), np.pi])
    known = np.concatenate([[0.0], values, [0.0]])
    return _polynomial(nodes, known, np.array(thetas(count)))


def _polynomial(nodes: Array, known: Array, at: Array) -> Array:
    """The polynomial through known values at nodes, evaluated elsewhere."""
    from scipy.interpolate import BarycentricInterpolator  # 0.4 s to import: only volumes pay

    return np.asarray(BarycentricInterpolator(nodes, known)(at))
