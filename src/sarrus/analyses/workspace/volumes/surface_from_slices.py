"""A closed surface of triangles through the boundaries of slices, by surface nets on a grid that has them as planes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ....results.maps.workspace import inside
from ....results.maps.workspace_volume import Slice

GRID = 48  # cells across all slices
PLANES = 2 * GRID  # slices of a range that are used, at most
LEVEL = "level"  # the cause of a triangle that closes the surface at one height


class Surface(NamedTuple):
    """Vertices (nv, 3), triangles (nt, 3) seen counter-clockwise from outside, causes, and one for each triangle."""

    vertices: Array
    triangles: Array
    causes: tuple[str, ...]
    of: Array


def surface(slices: Sequence[Slice], ranges: Sequence[tuple[float, float]]) -> Surface:
    """The surface through slices, which is closed at the ends of the ranges of heights."""
    vertices, triangles, causes = np.zeros((0, 3)), np.zeros((0, 3), dtype=int), list[str]()
    for low, high in ranges:
        some = [one for one in slices if low < one.height < high and one.loops]
        if some:
            some = some[:: -(-len(some) // PLANES)]
            points, faces, level = _nets(*_field(some, low, high))
            causes += _causes(some, points[faces].mean(axis=1), level)
            triangles = np.concatenate([triangles, faces + len(vertices)])
            vertices = np.concatenate([vertices, points])
    names = (LEVEL, *sorted({*causes} - {LEVEL}))
    return Surface(vertices, triangles, names, np.array([names.index(one) for one in causes], dtype=int))


def _field(slices: Sequence[Slice], low: float, high: float) -> tuple[Array, tuple[Array, Array, Array]]:
    """Distances from the boundaries, positive inside, on a grid (nx, ny, slices + 2), and the grid's axes.

    They are free of units, and needed on both sides of the boundary only; elsewhere their signs will do.
    """
    import shapely  # only surfaces pay for these imports
    from scipy.ndimage import binary_dilation, binary_erosion

    size = np.ptp(np.concatenate([loop.points for one in slices for loop in one.loops]), axis=0)
    scaled = [[loop.points / size for loop in one.loops] for one in slices]
    x, y = (
        np.arange(line.min() - 1 / GRID, line.max() + 2 / GRID, 1 / GRID)
        for line in np.concatenate([line for lines in scaled for line in lines]).T
    )
    places = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
    none = np.zeros((places[..., 0].size, 1), dtype=bool)
    columns = [inside(lines, places.reshape(-1, 2))[:, None] for lines in scaled]
    within = np.concatenate([none, *columns, none], axis=1).reshape(len(x), len(y), -1)
    near = binary_dilation(within) ^ binary_erosion(within)
    field = np.where(within, 1.0, -1e-9)
    for k, lines in enumerate(scaled, 1):
        at = near[:, :, k]
        away = shapely.distance(shapely.MultiLineString(lines), shapely.points(places[at]))
        field[at, k] = np.where(within[at, k], away, -away)
    return field, (x * size[0], y * size[1], np.array([low, *(one.height for one in slices), high]))


def _nets(field: Array, axes: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
    """Vertices, triangles, and which of these close it at an end: one vertex for each cell with a change of sign.

    It is the mean of the places on the cell's edges where the field is zero. Around each such edge are four cells,
    whose vertices make two triangles.
    """
    shape = np.array(field.shape) + 1
    sums, counts = np.zeros((shape.prod(), 3)), np.zeros(shape.prod())
    quads, level = list[Array](), list[Array]()
    for axis in range(3):
        step, one, other = np.roll(np.eye(3, dtype=int), -axis, axis=0)
        at = np.argwhere(np.diff((field > 0).astype(int), axis=axis))
        first, last = field[tuple(at.T)], field[tuple((at + step).T)]
        places = np.stack([line[k] for line, k in zip(axes, at.T, strict=True)], axis=1)
        places[:, axis] += first / (first - last) * np.diff(axes[axis])[at[:, axis]]
        around = at[:, None] + step + np.array([0 * one, one, one + other, other])
        cells = np.ravel_multi_index(tuple(np.moveaxis(around, -1, 0)), tuple(shape))
        np.add.at(sums, cells, places[:, None])
        np.add.at(counts, cells, 1)
        quads.append(np.where((first > 0)[:, None], cells, cells[:, ::-1]))
        level.append((axis == 2) & ((at[:, 2] == 0) | (at[:, 2] == field.shape[2] - 2)))
    used = np.flatnonzero(counts)
    numbers = np.searchsorted(used, np.concatenate(quads))
    triangles = np.concatenate([numbers[:, [0, 1, 2]], numbers[:, [0, 2, 3]]])
    return sums[used] / counts[used, None], triangles, np.tile(np.concatenate(level), 2)


def _causes(slices: Sequence[Slice], places: Array, level: Array) -> list[str]:
    """The cause of each triangle, by its middle: that of the nearest point of the slice at its height."""
    from scipy.spatial import cKDTree

    heights = np.array([one.height for one in slices])
    nearest = np.searchsorted(0.5 * (heights[1:] + heights[:-1]), places[:, 2])
    found = np.full(len(places), LEVEL, dtype=object)
    for k in np.unique(nearest[~level]):
        loops, mine = slices[k].loops, (nearest == k) & ~level
        causes = np.array([cause for loop in loops for cause in loop.cause_along()], dtype=object)
        tree = cKDTree(np.concatenate([loop.points for loop in loops]))
        found[mine] = causes[tree.query(places[mine, :2])[1]]
    return list(found)
