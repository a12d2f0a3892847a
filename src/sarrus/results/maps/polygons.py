"""Point-in-polygon test for closed polylines."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ...algebra import Array

AT_ONCE = 2_000_000  # pairs of points and segments


def inside(lines: Sequence[Array], points: Array) -> Array:
    """Which points (n, 2) are inside of polylines (k, 2), by crossings of a ray (n,).

    Each polyline ends exactly where it begins; one that misses its beginning by round-off would let rays through.
    """
    crossed = np.zeros(len(points), dtype=int)
    if not lines:
        return crossed > 0
    a, b = (np.concatenate([line[some] for line in lines]) for some in (slice(-1), slice(1, None)))
    low, high = np.minimum(a[:, 1], b[:, 1]), np.maximum(a[:, 1], b[:, 1])
    for which, k in within(low, high, points[:, 1]):
        x, y = points[which].T
        straddles = (a[k, 1] > y) != (b[k, 1] > y)
        with np.errstate(divide="ignore", invalid="ignore"):
            at = a[k, 0] + (y - a[k, 1]) * (b[k, 0] - a[k, 0]) / (b[k, 1] - a[k, 1])
        crossed += np.bincount(which[straddles & (at > x)], minlength=len(points))
    return np.asarray(crossed % 2 == 1)


def within(low: Array, high: Array, values: Array) -> Iterator[tuple[Array, Array]]:
    """Pairs of values (n,) and closed intervals (k,) that hold them, as arrays of both numbers, in parts."""
    order = np.argsort(values, kind="stable")
    ordered = values[order]
    first, last = np.searchsorted(ordered, low, "left"), np.searchsorted(ordered, high, "right")
    counts = np.maximum(last - first, 0)
    parts = np.searchsorted(np.cumsum(counts), np.arange(AT_ONCE, int(counts.sum()), AT_ONCE))
    for some in np.split(np.arange(len(counts)), np.unique(parts)):
        interval = np.repeat(some, counts[some])
        begins = np.cumsum(counts[some]) - counts[some]
        place = np.arange(len(interval)) - np.repeat(begins, counts[some]) + first[interval]
        yield order[place], interval
