"""The look of a body without a given shape: a bar, a rod, a plate, a frame of rods, or a block."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ...algebra import Array
from ..meshes.mesh import POINT, Mesh, joined
from ..meshes.solids import ball, bar, box, hull, plate, rod
from .part import LOOK


class Outline(NamedTuple):
    """Geometry of a body: its points [m], the axis of the hinge at each or None, mass properties in body axes.

    ``guide`` are the axes of a guide in which the body slides, with the place of the guide.
    """

    points: list[Array]
    hinges: list[Array | None]
    mass: float
    inertia: Array
    center: Array
    guide: tuple[Array, Array] | None


class Drawing(NamedTuple):
    """A mesh in body axes and its opacity."""

    mesh: Mesh
    opacity: float = 1.0


def body_meshes(known: Outline, unit: float, size: float) -> Iterator[Drawing]:
    """Yield the meshes of a body; ``unit`` is the thickness of a rod, ``size`` that of the whole drawing [m]."""
    points, hinges = _distinct(known, POINT * size)
    if known.guide is not None:
        place, axes = known.guide
        yield Drawing(box((2.4 * unit * 1.6, 2.4 * unit * 1.6, 6.0 * unit)).moved(place, axes))
    if not points:
        yield Drawing(_block(known, unit, size))
    elif len(points) == 1:
        yield from _single(points[0], known, unit, size)
    elif len(points) == 2:
        yield from _link(points, hinges, known, unit)
    else:
        yield from _frame(np.array(points), unit)


def _distinct(known: Outline, near: float) -> tuple[list[Array], list[Array | None]]:
    points: list[Array] = []
    hinges: list[Array | None] = []
    for point, axis in zip(known.points, known.hinges, strict=True):
        if all(np.linalg.norm(point - other) > near for other in points):
            points.append(point)
            hinges.append(axis)
    return points, hinges


def _block(known: Outline, unit: float, size: float) -> Mesh:
    """The uniform box that has the body's inertia, no larger than the drawing can bear."""
    moments, axes = np.linalg.eigh(known.inertia)
    squares = np.maximum(6 * (moments.sum() - 2 * moments) / (known.mass or np.inf), 0.0)
    edges = np.clip(np.sqrt(squares), 2.5 * unit, 2 * LOOK.block * size if size > 4 * unit else np.inf)
    if np.linalg.det(axes) < 0:
        axes = axes * [1.0, 1.0, -1.0]
    return box(edges).moved(known.center, axes)


def _single(point: Array, known: Outline, unit: float, size: float) -> Iterator[Drawing]:
    """A rod from the only point to the centre of mass with a bob there, or a block about the point."""
    if np.linalg.norm(point - known.center) > 2 * unit:
        yield Drawing(joined([rod(point, known.center, 0.5 * unit), ball(1.5 * unit, known.center)]))
    elif known.guide is None:
        yield Drawing(_block(known, unit, size))


def _link(points: list[Array], hinges: list[Array | None], known: Outline, unit: float) -> Iterator[Drawing]:
    """A bar between two parallel hinges, otherwise a rod; a thinner one to a centre of mass that lies elsewhere."""
    start, end = points
    way = (end - start) / np.linalg.norm(end - start)
    first, second = hinges
    if (
        first is not None
        and second is not None
        and abs(first @ second) > LOOK.parallel
        and abs(first @ way) < 0.05
    ):
        h = first - (first @ way) * way
        h = h / np.linalg.norm(h)
        axes = np.column_stack([way, np.cross(h, way), h])
        length = float(np.linalg.norm(end - start))
        yield Drawing(bar(length, 1.25 * unit, 0.9 * unit).moved(start, axes))
    else:
        yield Drawing(joined([rod(start, end, 0.6 * unit), ball(0.6 * unit, start), ball(0.6 * unit, end)]))
    along_it = np.clip((known.center - start) @ way, 0.0, np.linalg.norm(end - start))
    foot = start + along_it * way
    if np.linalg.norm(known.center - foot) > LOOK.off * unit:
        yield Drawing(joined([rod(foot, known.center, 0.35 * unit), ball(0.9 * unit, known.center)]))


def _frame(points: Array, unit: float) -> Iterator[Drawing]:
    """Points in one plane as a plate with a rim of rods, others as a glass hull with rods along its edges."""
    middle = points.mean(axis=0)
    _, spread, axes = np.linalg.svd(points - middle, full_matrices=True)
    spread = np.concatenate([spread, np.zeros(3)])[:3]
    if spread[1] < 0.02 * spread[0]:
        order = np.argsort((points - middle) @ axes[0])
        yield Drawing(joined([rod(points[order[0]], points[order[-1]], 0.6 * unit)]))
    elif spread[2] < 0.02 * spread[0]:
        yield from _flat(points, middle, axes, unit)
    else:
        surface = hull(points)
        if surface is not None:
            yield Drawing(surface, LOOK.glass)
        edges = _edges(surface, points, middle)
        yield Drawing(
            joined([*(rod(a, b, 0.42 * unit) for a, b in edges), *(ball(0.6 * unit, p) for p in points)])
        )


def _flat(points: Array, middle: Array, axes: Array, unit: float) -> Iterator[Drawing]:
    from scipy.spatial import ConvexHull

    f, g = axes[0], axes[1]
    seen = np.column_stack([(points - middle) @ f, (points - middle) @ g])
    outline = ConvexHull(seen).vertices  # counter-clockwise
    yield Drawing(
        plate(seen[outline], -0.2 * unit, 0.2 * unit).moved(middle, np.column_stack([f, g, np.cross(f, g)]))
    )
    corners = points[outline]
    rim = [rod(a, b, 0.5 * unit) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)]
    yield Drawing(joined([*rim, *(ball(0.5 * unit, p) for p in corners)]))


def _edges(surface: Mesh | None, points: Array, middle: Array) -> list[tuple[Array, Array]]:
    """Edges of a hull where two faces meet at an angle; rods from the middle if there is no hull."""
    if surface is None:
        return [(middle, point) for point in points]
    sides: dict[tuple[tuple[float, ...], ...], list[Array]] = {}
    corners = surface.vertices[surface.faces]
    for a, b, c in corners:
        h = np.cross(b - a, c - a)
        h = h / (np.linalg.norm(h) or 1.0)
        for one, other in ((a, b), (b, c), (c, a)):
            key = tuple(sorted((tuple(one.tolist()), tuple(other.tolist()))))
            sides.setdefault(key, []).append(h)
    sharp = [key for key, faces in sides.items() if len(faces) < 2 or faces[0] @ faces[1] < LOOK.parallel]
    return [(np.array(one), np.array(other)) for one, other in sharp]
