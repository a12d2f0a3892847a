"""The integral of slices' areas, and of their derivatives, over their height, refined until halving changes little."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.polynomial import Chebyshev

from ....algebra import Array
from ....results.maps.workspace_volume import VolumeRates, WorkspaceRange
from .extremes import distinct
from .slicing import NEARLY, Slicer

LEAST = 0.01  # of the range: critical heights that are nearer to each other cut no piece
FIRST = (
    4  # intervals of theta in a piece; four times as many for derivatives, which do not vanish at its ends
)
KINK = 4.0  # by which halving divides the error at a kink: pieces that converge no faster are cut


class Piece(NamedTuple):
    """A range of heights, with intervals of theta: height = middle - half·cos(theta)."""

    low: float
    high: float
    intervals: int

    @property
    def heights(self) -> list[float]:
        """The heights of the inner slices; those of half as many intervals are among them."""
        turned: list[float] = np.cos(thetas(self.intervals)[1:-1]).tolist()
        return [0.5 * (self.low + self.high) - 0.5 * (self.high - self.low) * x for x in turned]

    @property
    def slopes(self) -> Array:
        """d(height)/d(theta) there."""
        return np.asarray(0.5 * (self.high - self.low) * np.sin(thetas(self.intervals)[1:-1]))

    def refined(self, areas: Array, misses: Array) -> list[Piece]:
        """Twice as many slices; two pieces with half of what is missed, if it converges as slowly as at a kink."""
        if self.intervals == FIRST or KINK * misses.sum() <= missed(areas[1::2]).sum():
            return [self._replace(intervals=2 * self.intervals)]
        part = np.cumsum(misses)
        cut = self.heights[int(np.searchsorted(part, 0.5 * part[-1]))]
        return [Piece(self.low, cut, self.intervals // 2), Piece(cut, self.high, self.intervals // 2)]


def thetas(count: int) -> Array:
    """Points of the rule of Clenshaw and Curtis on 0 ... pi, with its ends."""
    return np.asarray(0.5 * np.pi * (1 - np.cos(np.pi * np.arange(count + 1) / count)))


def weights(count: int) -> Array:
    """Return the weights of Fejér's second rule at the inner points."""
    angle, odd = np.pi * np.arange(1, count) / count, np.arange(1, count, 2)
    sums = (np.sin(np.outer(angle, odd)) / odd).sum(axis=1)
    return np.asarray(0.5 * np.pi * 4 / count * np.sin(angle) * sums)


class Integral:
    """The volume with its derivatives, piece by piece.

    Parameters
    ----------
    slicer : makes slices
    ranges : of the height
    critical : heights at which the third output is stationary
    rtol : relative error that is wanted
    most : slices
    first : intervals of theta in a piece

    Attributes
    ----------
    critical : those that separate pieces
    value, error : of the volume, so far
    kinked : area of the boundary where derivatives have two sides
    rates, missed : derivatives by all numbers, if slices have any, and by how much half as many slices miss them
    """

    def __init__(
        self,
        slicer: Slicer,
        ranges: Sequence[tuple[float, float]],
        critical: Sequence[float],
        rtol: float,
        most: int,
        first: int = FIRST,
    ) -> None:
        self.slicer, self.rtol, self.most = slicer, rtol, most
        least = LEAST * max((high - low for low, high in ranges), default=0.0)
        cuts = [
            [low, *distinct([z for z in critical if low + least < z < high - least], least), high]
            for low, high in ranges
        ]
        self.critical = [z for some in cuts for z in some[1:-1]]
        self.pieces = [Piece(a, b, first) for some in cuts for a, b in pairwise(some)]
        self.value, self.error, self.kinked = 0.0, np.inf if self.pieces else 0.0, 0.0
        self.rates = self.missed = np.zeros(0)

    def run(self) -> None:
        """Refine until the error is small enough or there are too many slices."""
        while self.pieces and (self._refined() or self._reconciled()):
            pass

    def _reconciled(self) -> bool:
        changed = self.slicer.reconcile()
        self.error = np.inf if changed else self.error
        return changed

    def _refined(self) -> bool:
        """Estimate the integral, keep the best estimate, refine the worst pieces; whether there are any."""
        self.slicer.at(z for piece in self.pieces for z in piece.heights)
        columns = [self._columns(piece) for piece in self.pieces]
        misses = [missed(each[:, 0]) for each in columns]
        errors = np.array([each.sum() for each in misses])
        whole, half = (np.sum([integral(each, n) for each in columns], axis=0) for n in (1, 2))
        wanted, rest = self.rtol * abs(float(whole[0])), float(errors.sum())
        if rest + whole[1] < self.error:  # just after a cut it is not
            self.value, self.error = float(whole[0]), rest + float(whole[1])
            self.kinked, self.rates, self.missed = float(whole[2]), whole[3:], abs(whole[3:] - half[3:])
        if self.error <= wanted or rest <= 0.5 * wanted or len(self.slicer.known) >= self.most:
            return False
        pieces = {k: [piece] for k, piece in enumerate(self.pieces)}
        for k in np.argsort(-errors).tolist():
            if rest > 0.5 * wanted:
                pieces[k] = self.pieces[k].refined(columns[k][:, 0], misses[k])
            rest -= errors[k]
        self.pieces = [part for parts in pieces.values() for part in parts]
        return True

    def _columns(self, piece: Piece) -> Array:
        """Area, its error, kinked length and derivatives, by theta (inner points, 3 + numbers)."""
        known = [one.rates for one in self.slicer.known.values() if one.rates is not None]
        none = np.zeros_like(known[0]) if known else np.zeros(0)  # of slices without any curve
        rows = []
        for one in self.slicer.at(piece.heights):
            error = one.area_error if one.success else np.inf
            rows.append([one.area, error, one.kinked, *(none if one.rates is None else one.rates)])
        return np.array(rows) * piece.slopes[:, None]

    def derivatives(self, reach: WorkspaceRange) -> VolumeRates:
        """Derivatives of the volume by all numbers; `reach`: those of critical heights."""
        jumps = tuple(self._jumps({one.value for one in reach.critical}))
        return VolumeRates(self.rates, self.missed, self.kinked, jumps, self.slicer.problem, reach)

    def _jumps(self, critical: Iterable[float]) -> Iterator[tuple[float, float]]:
        """Critical heights at which the area jumps, with the area below less that above."""
        largest = max((one.area for one in self.slicer.known.values()), default=0.0)
        lost = Counter[float]()
        for piece in self.pieces:
            areas = np.array([one.area for one in self.slicer.at(piece.heights)])
            above, below = polynomial(thetas(piece.intervals)[1:-1], areas)(np.array([0.0, np.pi]))
            lost[piece.low] -= above
            lost[piece.high] += below
        yield from ((z, lost[z]) for z in critical if abs(lost[z]) > NEARLY * largest)


def integral(values: Array, every: int) -> Array:
    """The integral of all columns at inner points, by every so many of them."""
    known = values[every - 1 :: every]
    return np.asarray(weights(len(known) + 1) @ known)


def missed(values: Array) -> Array:
    """By how much half as many points miss an integral between them: signs cannot cancel, as at kinks."""
    count = len(values) + 1
    half = polynomial(thetas(count // 2), np.pad(values[1::2], 1))
    return np.asarray(weights(count) * abs(values - half(thetas(count)[1:-1])))


def polynomial(nodes: Array, values: Array) -> Chebyshev:
    """The polynomial on 0 ... pi through values at nodes."""
    return Chebyshev.fit(nodes, values, len(nodes) - 1, domain=[0.0, np.pi])
