"""Closed curves of quintic pieces as polygons, which hold points."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...algebra import Array

DENSE = 8  # points per piece of a polyline that is drawn
POWERS = np.arange(6)


def sampled(pieces: Array, count: int = DENSE) -> Array:
    """Points along a curve (pieces, 6, 2), so many for each piece, and the last (n, 2)."""
    tau = (np.arange(count) / count)[:, None] ** POWERS
    inner = np.einsum("tp,kpd->ktd", tau, pieces).reshape(-1, 2)
    return np.concatenate([inner, pieces[-1].sum(axis=0)[None]])


def finely(pieces: Array, off: float) -> Array:
    """Points along a curve between which chords are nowhere farther from it than `off`."""
    bends = np.linalg.norm(np.einsum("kpd,p->kd", abs(pieces), POWERS * (POWERS - 1.0)), axis=1)
    return sampled(pieces, max(DENSE, int(np.ceil(np.sqrt(bends.max() / (8 * off))))))


def polygon(line: Array, holes: Sequence[Array] = ()) -> Any:
    """Return the polygon inside of a closed line, without those inside of others."""
    import shapely  # not with `import sarrus`

    found = shapely.Polygon(line, holes)
    shapely.prepare(found)
    return found


def inside(lines: Sequence[Array], points: Array) -> Array:
    """Return which points (n, 2) are inside of an odd number of closed lines (n,)."""
    import shapely

    found = np.zeros(len(points), dtype=bool)
    for line in lines:
        found ^= shapely.contains_xy(polygon(line), points)
    return found


def beyond(lines: Sequence[Array], points: Array, distance: float) -> Array:
    """Return which points (n, 2) are farther than a distance from all lines (n,)."""
    import shapely

    every = shapely.MultiLineString(lines)
    shapely.prepare(every)
    return np.asarray(~shapely.dwithin(every, shapely.points(points), distance))
