"""A surface of triangles through the boundaries of slices: neighbouring loops are joined, single ones closed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...algebra import Array
from ...results.workspace_volume import Slice

AROUND = 96  # points of every loop


def loft(slices: Sequence[Slice]) -> tuple[Array, Array]:
    """Vertices (nv, 3) and triangles (nt, 3), the region on the inner side, from slices by rising height."""
    rings: list[list[Array]] = [
        [_ring(loop, one.height, hole > 0) for part in one.components for hole, loop in enumerate(part)]
        for one in slices
    ]
    vertices = [ring for level in rings for ring in level]
    first = {id(ring): AROUND * n for n, ring in enumerate(vertices)}
    triangles: list[Array] = []
    for below, above in zip([[], *rings], [*rings, []], strict=True):
        pairs = _pairs(below, above)
        triangles += [_band(first[id(a)], first[id(b)], _shift(a, b)) for a, b in pairs]
        joined = {id(ring) for pair in pairs for ring in pair}
        triangles += [_cap(ring, first[id(ring)], up=True) for ring in below if id(ring) not in joined]
        triangles += [_cap(ring, first[id(ring)], up=False) for ring in above if id(ring) not in joined]
    none = np.zeros((0, 3))
    return (
        np.concatenate(vertices) if vertices else none,
        np.concatenate(triangles) if triangles else none.astype(int),
    )


def _ring(loop: Array, height: float, hole: bool) -> Array:
    """Points at equal distances, counter-clockwise, of holes clockwise."""
    closed = loop if np.allclose(loop[0], loop[-1]) else np.concatenate([loop, loop[:1]])
    x, y = closed.T
    if (float(x[:-1] @ y[1:] - x[1:] @ y[:-1]) > 0) == hole:
        closed = closed[::-1]
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))])
    at = np.linspace(0.0, along[-1], AROUND, endpoint=False)
    plane = [np.interp(at, along, column) for column in closed.T]
    return np.stack([*plane, np.full(AROUND, height)], axis=1)


def _signed(ring: Array) -> float:
    x, y = ring[:, 0], ring[:, 1]
    return float(0.5 * (x @ np.roll(y, -1) - np.roll(x, -1) @ y))


def _pairs(below: list[Array], above: list[Array]) -> list[tuple[Array, Array]]:
    """Rings of the same kind, outer or hole, that are near and alike, each used once."""
    found = []
    costs = sorted(
        (_unlike(a, b), m, n)
        for m, a in enumerate(below)
        for n, b in enumerate(above)
        if _signed(a) * _signed(b) > 0
    )
    free_below, free_above = set(range(len(below))), set(range(len(above)))
    for _, m, n in costs:
        if m in free_below and n in free_above:
            free_below.discard(m)
            free_above.discard(n)
            found.append((below[m], above[n]))
    return found


def _unlike(a: Array, b: Array) -> float:
    size = float(abs(np.sqrt(abs(_signed(a))) - np.sqrt(abs(_signed(b)))))
    return float(np.linalg.norm(a[:, :2].mean(axis=0) - b[:, :2].mean(axis=0))) + size


def _shift(a: Array, b: Array) -> int:
    """How far b's points are to be turned to lie opposite to a's."""
    costs = [float(np.sum((a[:, :2] - np.roll(b[:, :2], -k, axis=0)) ** 2)) for k in range(AROUND)]
    return int(np.argmin(costs))


def _band(first: int, other: int, shift: int) -> Array:
    k = np.arange(AROUND)
    a, b = first + k, first + (k + 1) % AROUND
    c, d = other + (k + shift) % AROUND, other + (k + 1 + shift) % AROUND
    return np.concatenate([np.stack([a, b, d], axis=1), np.stack([a, d, c], axis=1)])


def _cap(ring: Array, first: int, *, up: bool) -> Array:
    """The inside of a ring as a fan; right for rings that are seen from their first point."""
    k = np.arange(1, AROUND - 1)
    a, b, c = np.full(len(k), first), first + k, first + k + 1
    return np.stack([a, b, c] if up else [a, c, b], axis=1)
