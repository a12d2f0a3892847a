"""Round bodies: profiles turned about an axis, and tubes along a path."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from ...algebra import Array
from ...model.quantity import SMALLEST_LENGTH
from .mesh import Mesh, along, joined

AROUND = 24  # corners of a circle
SPOKES = 5  # of a wheel

Profile = Sequence[Sequence[float]] | Array


def turned(profiles: Iterable[Profile], around: int = AROUND) -> Mesh:
    """Profiles of pairs (radius, z) turned about z; edges between two profiles are sharp."""
    return joined(_turned(np.array(profile, dtype=float), around) for profile in profiles)


def _turned(profile: Array, around: int) -> Mesh:
    angles = np.linspace(0.0, 2 * np.pi, around, endpoint=False)
    circle = np.column_stack([np.cos(angles), np.sin(angles)])
    rows = [np.column_stack([r * circle, np.full(around, z)]) for r, z in profile]
    return Mesh(np.concatenate(rows), _quads(len(profile), around, closed=False))


def _quads(rows: int, around: int, *, closed: bool) -> Array:
    """Triangles between neighbouring rows of ``around`` corners each, wound so that they face outwards."""
    k, n = np.meshgrid(np.arange(rows if closed else rows - 1), np.arange(around), indexing="ij")
    a, b = k * around + n, k * around + (n + 1) % around
    c, d = ((k + 1) % rows) * around + n, ((k + 1) % rows) * around + (n + 1) % around
    return np.stack([a, b, d, a, d, c], axis=-1).reshape(-1, 3)


def disc(radius: float, low: float, high: float, around: int = AROUND) -> Mesh:
    """A cylinder about z from ``low`` to ``high``."""
    top = [(radius, high), (0, high)]
    return turned([[(0, low), (radius, low)], [(radius, low), (radius, high)], top], around)


def cone(radius: float, top: float, low: float, high: float) -> Mesh:
    """A cone about z, from ``radius`` at ``low`` to ``top`` at ``high``."""
    return turned([[(0, low), (radius, low)], [(radius, low), (top, high)], [(top, high), (0, high)]])


def ball(radius: float, center: Array | Sequence[float] = (0.0, 0.0, 0.0)) -> Mesh:
    """A sphere."""
    angles = np.linspace(-np.pi / 2, np.pi / 2, 13)
    return turned([np.column_stack([radius * np.cos(angles), radius * np.sin(angles)])]).moved(
        np.asarray(center)
    )


def rod(start: Array, end: Array, radius: float) -> Mesh:
    """A round rod between two points."""
    way = np.asarray(end, dtype=float) - start
    length = float(np.linalg.norm(way))
    if length < SMALLEST_LENGTH:
        return ball(radius, start)
    return disc(radius, 0.0, length).moved(np.asarray(start), along(way))


def ring(radius: float, thickness: float, around: int = 32) -> Mesh:
    """A torus about z: the radius of its middle line, and that of its section."""
    angles = np.linspace(0.0, 2 * np.pi, around, endpoint=False)
    path = radius * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(around)])
    return tube(path, thickness, closed=True)


def wheel(radius: float, width: float) -> Mesh:
    """A tyre about z."""
    half, inner, bulge = width / 2, 0.62 * radius, 0.94 * radius
    tread = [(inner, -half), (bulge, -half), (radius, -0.6 * half), (radius, 0.6 * half), (bulge, half)]
    return turned([[*tread, (inner, half)], [(inner, half), (inner, -half)]], 40)


def rim(radius: float, width: float) -> Mesh:
    """The spokes in a tyre, with their hub: they show that it turns."""
    half = width / 2
    spoke = box((0.5 * radius, 0.14 * radius, 0.6 * half)).moved(np.array([0.36 * radius, 0.0, 0.0]))
    angles = np.linspace(0.0, 2 * np.pi, SPOKES, endpoint=False)
    axes = (
        np.array([[np.cos(a), -np.sin(a), 0.0], [np.sin(a), np.cos(a), 0.0], [0.0, 0.0, 1.0]]) for a in angles
    )
    spokes = (spoke.moved(np.zeros(3), turn) for turn in axes)
    return joined([disc(0.16 * radius, -0.6 * half, 0.6 * half), *spokes])


def tube(path: Array, radius: float, *, closed: bool = False, around: int = 8) -> Mesh:
    """A tube along a path (n, 3) with moderate curvature."""
    ahead, behind = np.roll(path, -1, axis=0), np.roll(path, 1, axis=0)
    if not closed:
        ahead[-1], behind[0] = path[-1], path[0]
    tangents = ahead - behind
    angles = np.linspace(0.0, 2 * np.pi, around, endpoint=False)
    circle = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    rows = [
        point + circle @ axes[:, :2].T for point, axes in zip(path, _carried(tangents, closed), strict=True)
    ]
    return Mesh(np.concatenate(rows), _quads(len(path), around, closed=closed))


def _carried(tangents: Array, closed: bool) -> list[Array]:
    """Axes along a path, each turned as little as may be from the one before; a closed path's are about z."""
    axes = [along(tangents[0])]
    for tangent in tangents[1:]:
        h = tangent / np.linalg.norm(tangent)
        f = np.array([0.0, 0.0, 1.0]) if closed else axes[-1][:, 0] - (axes[-1][:, 0] @ h) * h
        f = f / np.linalg.norm(f)
        axes.append(np.column_stack([f, np.cross(h, f), h]))
    if closed:
        h, f = axes[0][:, 2], np.array([0.0, 0.0, 1.0])
        axes[0] = np.column_stack([f, np.cross(h, f), h])
    return axes


def coil(length: float, radius: float, wire: float, windings: int = 9) -> Mesh:
    """A coil spring along z from 0 to ``length``, with straight ends on its axis."""
    angles = np.linspace(0.0, 2 * np.pi * windings, 16 * windings + 1)
    low, high = 0.12 * length, 0.88 * length
    body = np.column_stack(
        [radius * np.cos(angles), radius * np.sin(angles), np.linspace(low, high, len(angles))]
    )
    first, last = ([[0, 0, 0], [0, 0, 0.8 * low]], [[0, 0, length - 0.8 * low], [0, 0, length]])
    return tube(np.concatenate([first, body, last]), wire)


def spiral(inner: float, outer: float, wire: float, windings: int = 3) -> Mesh:
    """A flat spiral spring about z."""
    angles = np.linspace(0.0, 2 * np.pi * windings, 20 * windings + 1)
    radius = np.linspace(inner, outer, len(angles))
    path = np.column_stack([radius * np.cos(angles), radius * np.sin(angles), np.zeros(len(angles))])
    return tube(path, wire)


def box(size: Sequence[float] | Array) -> Mesh:
    """A box with its centre at the origin; edges sharp."""
    x, y, z = (float(s) / 2 for s in size)
    return plate(np.array([(-x, -y), (x, -y), (x, y), (-x, y)]), -z, z)


def plate(outline: Array, low: float, high: float) -> Mesh:
    """A convex outline (n, 2), counter-clockwise in x and y, from z = low to high."""
    n = len(outline)
    bottom, top = (np.column_stack([outline, np.full(n, z)]) for z in (low, high))
    fan = np.array([(0, k, k + 1) for k in range(1, n - 1)])
    return joined([Mesh(bottom, fan[:, ::-1]), Mesh(top, fan), *_sides(bottom, top)])


def toothed(radius: float, height: float, teeth: int, low: float, high: float) -> Mesh:
    """A toothed wheel about z: pitch radius, height of the teeth, from z = low to high."""
    steps = np.linspace(0.0, 2 * np.pi, 4 * teeth, endpoint=False)
    reach = radius + 0.5 * height * np.tile([1.0, 1.0, -1.0, -1.0], teeth)
    outline = reach[:, None] * np.column_stack([np.cos(steps), np.sin(steps)])
    n = len(outline)
    bottom, top = (
        np.column_stack([np.vstack([outline, [0.0, 0.0]]), np.full(n + 1, z)]) for z in (low, high)
    )
    fan = np.array([(n, k, (k + 1) % n) for k in range(n)])
    return joined([Mesh(bottom, fan[:, ::-1]), Mesh(top, fan), *_sides(bottom[:n], top[:n])])


def _sides(bottom: Array, top: Array) -> list[Mesh]:
    faces = np.array([(0, 1, 2), (0, 2, 3)])
    after = np.roll(np.arange(len(bottom)), -1)
    return [Mesh(np.array([bottom[k], bottom[m], top[m], top[k]]), faces) for k, m in enumerate(after)]


def bar(length: float, radius: float, thickness: float) -> Mesh:
    """A link along x from 0 to ``length`` with round ends, flat across z."""
    angles = np.linspace(-np.pi / 2, np.pi / 2, 13)
    end = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    outline = np.concatenate([end + [length, 0.0], -end])
    return plate(outline, -thickness / 2, thickness / 2)


def hull(points: Array) -> Mesh | None:
    """The convex hull of points that span a volume, with sharp edges; None if they do not."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        found = ConvexHull(points)
    except (QhullError, ValueError):
        return None
    triangles = points[found.simplices]
    a, b, c = (triangles[:, k] for k in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), found.equations[:, :3]) < 0
    triangles[inward] = triangles[inward][:, ::-1]
    return Mesh(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3))
