"""Which points lie inside of closed polylines."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..algebra import Array

AT_ONCE = 2_000_000  # pairs of points and segments


def inside(lines: Sequence[Array], points: Array) -> Array:
    """Which points (n, 2) are inside of polylines (k, 2) that are closed together, by crossings of a ray (n,)."""
    found = np.zeros(len(points), dtype=bool)
    if not lines:
        return found
    a = np.concatenate([line[:-1] for line in lines])
    b = np.concatenate([line[1:] for line in lines])
    low, high = np.minimum(a, b).min(axis=0), np.maximum(a, b).max(axis=0)
    candidates = np.flatnonzero(np.all((points >= low) & (points <= high), axis=1))
    for some in np.array_split(candidates, len(candidates) * len(a) // AT_ONCE + 1):
        x, y = points[some, 0][:, None], points[some, 1][:, None]
        straddles = (a[:, 1] > y) != (b[:, 1] > y)
        with np.errstate(divide="ignore", invalid="ignore"):
            at = a[:, 0] + (y - a[:, 1]) * (b[:, 0] - a[:, 0]) / (b[:, 1] - a[:, 1])
        found[some] = np.count_nonzero(straddles & (at > x), axis=1) % 2 == 1
    return found
