"""The integral of slices' areas, and of their derivatives, over their height, refined until halving changes little."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ....algebra import Array
from ....results.maps.workspace_volume import Slice, VolumeRates, WorkspaceRange
from .extremes import distinct
from .slicing import NEARLY, Slicer

LEAST = 0.01  # of the range: critical heights that are nearer to each other cut no piece
FIRST = (
    4  # intervals of theta in a piece; four times as many for derivatives, which do not vanish at its ends
)
KINK = 4.0  # by which halving divides the error at a kink: pieces that converge no faster are cut


@dataclass(eq=False)
class Piece:
    """A range of heights, with the number of intervals of theta: height = middle - half·cos(theta)."""

    low: float
    high: float
    count: int = FIRST

    def heights(self) -> list[float]:
        """Return the heights of the inner slices; those of half as many intervals are among them."""
        middle, half = 0.5 * (self.low + self.high), 0.5 * (self.high - self.low)
        return [middle - half * math.cos(theta) for theta in thetas(self.count)]

    def slopes(self) -> Array:
        """d(height)/d(theta) there."""
        return 0.5 * (self.high - self.low) * np.sin(thetas(self.count))


def thetas(count: int) -> list[float]:
    """Inner points of the rule of Clenshaw and Curtis on 0 ... pi."""
    return [0.5 * math.pi * (1 - math.cos(math.pi * k / count)) for k in range(1, count)]


def weights(count: int) -> Array:
    """Return the weights of Fejér's second rule at these points."""
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
        self.value, self.error = 0.0, np.inf if self.pieces else 0.0
        self.rates = self.missed = np.zeros(0)

    def run(self) -> None:
        """Refine until the error is small enough or there are too many slices."""
        while self._refined() or self._reconciled():
            pass

    def _reconciled(self) -> bool:
        changed = self.slicer.reconcile()
        self.error = np.inf if changed else self.error
        return changed

    def _refined(self) -> bool:
        """Estimate the integral, keep the best estimate, refine the pieces that are worst; whether there are any."""
        if not self.pieces:
            return False
        self.slicer.at(z for piece in self.pieces for z in piece.heights())
        sides = [self._rates(piece) for piece in self.pieces]
        misses = [missed(each[:, 0]) for each in sides]
        errors = np.array([each.sum() for each in misses])
        self._keep(sides, float(errors.sum()) + sum(self._of_slices(piece) for piece in self.pieces))
        wanted, rest = self.rtol * abs(self.value), errors.sum()
        if self.error <= wanted or len(self.slicer.known) >= self.most:
            return False
        for k in np.argsort(-errors).tolist():
            if rest <= 0.5 * wanted:
                break
            self._refine(k, sides[k][:, 0], misses[k])
            rest -= errors[k]
        self.pieces = [piece for piece in self.pieces if piece.count]
        return bool(errors.sum() > 0.5 * wanted)

    def _keep(self, sides: Sequence[Array], error: float) -> None:
        """Keep an estimate if it is better than those before: just after a cut it is not."""
        if error < self.error:
            whole, half = (np.sum([integral(each, n) for each in sides], axis=0) for n in (1, 2))
            self.value, self.error = float(whole[0]), error
            self.rates, self.missed = whole[1:], abs(whole - half)[1:]

    def _refine(self, k: int, sides: Array, misses: Array) -> None:
        """Twice as many slices; a piece that converges slowly, because of a kink, is cut there."""
        piece = self.pieces[k]
        if piece.count == FIRST or KINK * misses.sum() <= missed(sides[1::2]).sum():
            piece.count *= 2
            return
        part = np.cumsum(misses)
        kink = piece.heights()[int(np.searchsorted(part, 0.5 * part[-1]))]  # as much is missed below as above
        self.pieces += [Piece(a, b, piece.count // 2) for a, b in ((piece.low, kink), (kink, piece.high))]
        piece.count = 0

    def _rates(self, piece: Piece) -> Array:
        """dV/d(theta) of a piece at its inner points, and its derivatives (inner points, 1 + numbers)."""
        slices = self.slicer.at(piece.heights())
        every = [one.rates for one in self.slicer.known.values() if one.rates is not None]
        none = np.zeros_like(every[0]) if every else np.zeros(0)  # of slices without any curve
        rows = [np.append(one.area, none if one.rates is None else one.rates) for one in slices]
        return np.array(rows) * piece.slopes()[:, None]

    def derivatives(self, reach: WorkspaceRange) -> VolumeRates:
        """Derivatives of the volume by all numbers; `reach`: those of critical heights."""
        kinked = sum(
            float(
                weights(piece.count)
                @ ([one.kinked for one in self.slicer.at(piece.heights())] * piece.slopes())
            )
            for piece in self.pieces
        )
        return VolumeRates(
            self.rates, self.missed, kinked, tuple(self._jumps(reach)), self.slicer.problem, reach
        )

    def _jumps(self, reach: WorkspaceRange) -> Iterator[tuple[float, float]]:
        """Critical heights at which the area jumps, with the area below less that above."""
        largest = max((one.area for one in self.slicer.known.values()), default=0.0)
        lost: dict[float, float] = {}
        for piece in self.pieces:
            areas = np.array([one.area for one in self.slicer.at(piece.heights())])
            below, above = polynomial(thetas(piece.count), areas, [0.0, math.pi]).tolist()
            lost[piece.low] = lost.get(piece.low, 0.0) - below
            lost[piece.high] = lost.get(piece.high, 0.0) + above
        values = {one.value for one in reach.critical}
        yield from ((z, area) for z, area in lost.items() if z in values and abs(area) > NEARLY * largest)

    def _of_slices(self, piece: Piece) -> float:
        errors = [self._doubt(self.slicer.known[z]) for z in piece.heights()]
        return float(weights(piece.count) @ (errors * piece.slopes()))

    def _doubt(self, one: Slice) -> float:
        """The error of a slice; one that is not complete may be as wrong as it differs from its neighbours."""
        if one.success:
            return one.area_error
        return max((abs(one.area - other.area) for other in self.slicer.around(one.height)), default=np.inf)


def integral(values: Array, every: int) -> Array:
    """The integral of all columns at inner points, by every so many of them."""
    known = values[every - 1 :: every]
    return np.asarray(weights(len(known) + 1) @ known)


def missed(values: Array) -> Array:
    """By how much half as many points miss an integral between them: signs cannot cancel, as at kinks."""
    count = len(values) + 1
    nodes, known = [0.0, *thetas(count // 2), math.pi], np.pad(values[1::2], 1)
    return np.asarray(weights(count) * abs(values - polynomial(nodes, known, thetas(count))))


def polynomial(nodes: Sequence[float], known: Array, at: Sequence[float]) -> Array:
    """The polynomial through known values at nodes evaluated elsewhere."""
    places = [2 / math.pi * np.array(one) - 1 for one in (at, nodes)]
    there, here = (np.polynomial.chebyshev.chebvander(each, len(nodes) - 1) for each in places)
    return np.asarray(there @ np.linalg.solve(here, known))
