"""Point-in-region test for closed curves of quintic pieces: by their polylines, corrected between chord and curve."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ...algebra import Array
from .polygons import inside, within

DENSE = 8  # points per piece of a polyline
POWERS = np.arange(6)
NEWTON = 6  # steps from the chord to the curve; a chord is an eighth of a step, so that three suffice
STRAIGHT = 1e-9  # of the longest chord: pieces that are shorter have no direction


def sampled(pieces: Array) -> Array:
    """Points along a curve (count, 6, 2), `DENSE` for each piece and the last (n, 2)."""
    tau = (np.arange(DENSE) / DENSE)[:, None] ** POWERS
    inner = np.einsum("tp,kpd->ktd", tau, pieces).reshape(-1, 2)
    return np.concatenate([inner, pieces[-1].sum(axis=0)[None]])


def inside_curves(
    lines: Sequence[Array], curves: Sequence[Array], points: Array, tolerance: float = 0.0
) -> Array:
    """Which points (n, 2) are inside closed curves, or within a tolerance of them (n,).

    A point is inside the curves if it is inside their polylines, except between a chord and its part of the curve.

    Parameters
    ----------
    lines : closed polylines of the curves
    curves : coefficients (count, 6, 2) of their pieces, polynomials of the parameter 0 ... 1
    points : (n, 2)
    tolerance : distance from a curve that counts as inside
    """
    found = inside(lines, points)
    if not len(curves):
        return found
    chords = _Chords(np.concatenate(curves))
    touched = np.zeros(len(points), dtype=bool)
    for which, chord in chords.near(points, tolerance):
        between, away = chords.compared(points[which], chord)
        found ^= np.bincount(which[between], minlength=len(points)) % 2 == 1
        touched[which[away <= tolerance]] = tolerance > 0
    return np.asarray(found | touched)


class _Chords:
    """The chords of a curve's polyline with the parts of the curve that they replace."""

    def __init__(self, pieces: Array) -> None:
        tau = (np.arange(DENSE + 1) / DENSE)[:, None] ** POWERS
        at = np.einsum("tp,kpd->ktd", tau, pieces)
        start, end = at[:, :-1].reshape(-1, 2), at[:, 1:].reshape(-1, 2)
        length = np.linalg.norm(end - start, axis=1)
        long = np.flatnonzero(length > STRAIGHT * length.max(initial=0.0))
        self.start, self.length = start[long], length[long]
        self.along = (end - start)[long] / self.length[:, None]
        self.pieces = pieces[long // DENSE]
        self.first = (long % DENSE) / DENSE
        middles = np.stack([self._local(np.arange(len(long)), share)[1] for share in (0.25, 0.5, 0.75)])
        self.sagitta = 1.5 * abs(middles).max(axis=0)

    def _local(self, chord: Array, share: Array | float) -> tuple[Array, Array]:
        """Distance along the chord and to its left, of the curve at a share of its parameter."""
        tau = (self.first[chord] + share / DENSE)[:, None] ** POWERS
        return self._turned(chord, np.einsum("kp,kpd->kd", tau, self.pieces[chord]))

    def _turned(self, chord: Array, points: Array) -> tuple[Array, Array]:
        d, t = points - self.start[chord], self.along[chord]
        return np.einsum("kd,kd->k", d, t), t[:, 0] * d[:, 1] - t[:, 1] * d[:, 0]

    def near(self, points: Array, tolerance: float) -> Iterator[tuple[Array, Array]]:
        """Pairs of points and chords that are as near as the curve may be."""
        reach = self.sagitta + tolerance
        y = np.stack([self.start[:, 1], self.start[:, 1] + self.along[:, 1] * self.length])
        for which, chord in within(y.min(axis=0) - reach, y.max(axis=0) + reach, points[:, 1]):
            along, left = self._turned(chord, points[which])
            slack = reach[chord]
            near = (abs(left) <= slack) & (along >= -slack) & (along <= self.length[chord] + slack)
            yield which[near], chord[near]

    def compared(self, points: Array, chord: Array) -> tuple[Array, Array]:
        """Whether points lie between chord and curve; how far they are from the curve across the chord."""
        along, left = self._turned(chord, points)
        share = np.clip(along / self.length[chord], 0.0, 1.0)
        for _ in range(NEWTON):
            at, _ = self._local(chord, share)
            share = np.clip(share + (along - at) / self.length[chord], 0.0, 1.0)
        at, bulge = self._local(chord, share)
        within = (along >= 0) & (along < self.length[chord])
        between = within & (((left > 0) & (left < bulge)) | ((left <= 0) & (left > bulge)))
        return between, np.hypot(left - bulge, along - at)
