"""Barriers inside of a workspace of three outputs: lines of neighbouring slices made into sheets."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from ..algebra import Array
from ..results.maps.workspace_volume import Slice

FAR = (
    0.12  # of the size: lines of neighbouring slices that are farther from each other are of different sheets
)


def barrier_sheets(slices: Sequence[Slice]) -> tuple[Array, Array]:
    """Vertices (nv, 3) and triangles (nt, 3) through the barriers of slices by rising height.

    Every line is widened half way to the nearest places of the lines above and below it; where there are none, it ends.
    Sheets are seen from both sides: each has a front and a back, with vertices of their own.
    """
    vertices, triangles, count = [np.zeros((0, 3))], [np.zeros((0, 3), dtype=int)], 0
    for strip in _strips(slices):
        vertices.append(strip.reshape(-1, 3))
        triangles.append(_between(strip.shape[1]) + count)
        count += 2 * strip.shape[1]
    front, faces = np.concatenate(vertices), np.concatenate(triangles)
    return np.concatenate([front, front]), np.concatenate([faces, faces[:, ::-1] + count])


def _strips(slices: Sequence[Slice]) -> Iterator[Array]:
    """Pairs of lines (2, k, 3): a barrier, and where it goes half way to a neighbour."""
    for one, other in pairwise(slices):
        for this, that in ((one, other), (other, one)):
            if that.barriers:
                there = _lifted(np.concatenate(that.barriers), that.height)
                for line in this.barriers:
                    yield from _towards(_lifted(line, this.height), there, _size(slices))


def _towards(line: Array, there: Array, size: float) -> Iterator[Array]:
    """The parts of a line that have neighbours, with the middles between."""
    gaps = np.linalg.norm(line[:, None] - there[None], axis=2)
    nearest = gaps.argmin(axis=1)
    close = gaps[np.arange(len(line)), nearest] < FAR * size
    middle = 0.5 * (line + there[nearest])
    for part in np.split(np.arange(len(line)), np.flatnonzero(np.diff(close)) + 1):
        if close[part[0]] and len(part) > 1:
            yield np.stack([line[part], middle[part]])


def _lifted(line: Array, height: float) -> Array:
    return np.column_stack([line, np.full(len(line), height)])


def _size(slices: Sequence[Slice]) -> float:
    """Of the widest slice, or of their heights."""
    widths = [float(np.ptp(loop.points, axis=0).max()) for one in slices for loop in one.loops]
    return max([slices[-1].height - slices[0].height, *widths])


def _between(count: int) -> Array:
    """Triangles between two lines of so many points."""
    k = np.arange(count - 1)
    low, high = np.column_stack([k, k + 1, k + count]), np.column_stack([k + 1, k + 1 + count, k + count])
    return np.concatenate([low, high])
