"""The integral of slices' areas over their height: coarse first, refined where halving shows the largest error."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ....algebra import Array
from ....results.maps.workspace_volume import Slice, VolumeRates, WorkspaceRange
from .extremes import distinct
from .slicing import Slicer

LEAST = 0.01  # of the range: critical heights that are nearer to each other cut no piece
FIRST, LAST = 4, 32  # intervals of theta in a piece; a piece that wants more is cut
OF_RATES = (
    16  # the first number for derivatives, which do not vanish at the ends of pieces as dV/d(theta) does
)
KINK = 4.0  # by which halving divides the error at a kink: pieces that converge no faster are cut
JUMP = 1e-3  # of the largest area: by so much areas jump where a part of the boundary is level


@dataclass(eq=False)
class Piece:
    """A range of heights, with the number of intervals of theta: height = middle - half·cos(theta)."""

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
    """The volume, piece by piece.

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
    value, error : so far
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
        self.slicer, self.ranges, self.rtol, self.most = slicer, ranges, rtol, most
        least = LEAST * max((high - low for low, high in ranges), default=0.0)
        cuts = [
            [low, *distinct([z for z in critical if low + least < z < high - least], least), high]
            for low, high in ranges
        ]
        self.critical = [z for some in cuts for z in some[1:-1]]
        self.pieces = [Piece(a, b, first) for some in cuts for a, b in pairwise(some)]
        self.value, self.error = 0.0, np.inf

    def run(self) -> None:
        """Refine until the error is small enough or there are too many slices."""
        changed = True
        while changed:
            self.slicer.at(z for piece in self.pieces for z in piece.heights(piece.count))
            changed = self._refined() or self.slicer.reconcile()

    def coarse(self) -> tuple[float, float]:
        """Value and error of the slices so far; before the first estimate, by the trapezoidal rule in theta.

        The error of that is the integral of the distances of slices from the line through their neighbours.
        """
        if np.isfinite(self.error):
            return self.value, self.error
        value = error = 0.0
        for low, high in self.ranges:
            known = self.slicer.known
            slices = [known[z] for z in sorted(known) if low < z < high and known[z].success]
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
        values = {one.value for one in reach.critical}
        yield from ((z, area) for z, area in lost.items() if z in values and abs(area) > JUMP * largest)

    def _end_areas(self, piece: Piece) -> tuple[float, float]:
        """Areas at the lower and upper end of a piece, by the polynomial in theta through its slices."""
        areas = _polynomial(np.array(thetas(piece.count)), self._of(piece, "area"), np.array([0.0, np.pi]))
        return float(areas[0]), float(areas[1])

    def _refined(self) -> bool:
        """Estimate value and error, and refine the pieces that are worst; whether there are any."""
        errors = {piece: float(self._missed(piece, piece.count).sum()) for piece in self.pieces}
        self.value = sum(
            float(weights(piece.count) @ self._rates(piece, piece.count)) for piece in self.pieces
        )
        self.error = sum(errors.values()) + sum(self._of_slices(piece) for piece in self.pieces)
        wanted = self.rtol * abs(self.value)
        if self.error <= wanted or len(self.slicer.known) >= self.most:
            return False
        rest = sum(errors.values())
        for piece in sorted(errors, key=errors.__getitem__, reverse=True):
            if rest <= 0.5 * wanted:
                break
            self._refine(piece)
            rest -= errors[piece]
        return sum(errors.values()) > 0.5 * wanted

    def _refine(self, piece: Piece) -> None:
        """Twice as many slices; a piece that converges slowly, because of a kink, is cut there."""
        missed = self._missed(piece, piece.count)
        slow = piece.count > FIRST and KINK * missed.sum() > self._missed(piece, piece.count // 2).sum()
        if piece.count < LAST and not slow:
            piece.count *= 2
            return
        half = int(np.searchsorted(np.cumsum(missed), 0.5 * missed.sum()))  # as much is missed below as above
        kink = piece.heights(piece.count)[half]
        self.pieces.remove(piece)
        self.pieces += [Piece(piece.low, kink), Piece(kink, piece.high)]

    def _missed(self, piece: Piece, count: int) -> Array:
        """By how much half as many slices miss the integral between them: signs cannot cancel, as at kinks."""
        rates = self._rates(piece, count)
        nodes = np.array([0.0, *thetas(count // 2), np.pi])
        known = np.concatenate([[0.0], rates[1::2], [0.0]])
        return np.asarray(weights(count) * abs(rates - _polynomial(nodes, known, np.array(thetas(count)))))

    def _rates(self, piece: Piece, count: int) -> Array:
        """dV/d(theta) of a piece at its inner points."""
        return np.asarray([one.area for one in self.slicer.at(piece.heights(count))] * piece.slopes(count))

    def _of_slices(self, piece: Piece) -> float:
        errors = [self._doubt(self.slicer.known[z]) for z in piece.heights(piece.count)]
        return float(weights(piece.count) @ (errors * piece.slopes(piece.count)))

    def _doubt(self, one: Slice) -> float:
        """The error of a slice; one that is not complete may be as wrong as it differs from its neighbours."""
        if one.success:
            return one.area_error
        return max((abs(one.area - other.area) for other in self.slicer.around(one.height)), default=np.inf)


def _polynomial(nodes: Array, known: Array, at: Array) -> Array:
    """The polynomial through known values at nodes, evaluated elsewhere."""
    from scipy.interpolate import BarycentricInterpolator  # 0.4 s to import: only volumes pay

    return np.asarray(BarycentricInterpolator(nodes, known)(at))
