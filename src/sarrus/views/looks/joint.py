"""The look of joints: pins, balls, crosses, rails, sleeves, plates, and rods for massless links."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from ...algebra import Array
from ..meshes.mesh import Mesh, joined, upright
from ..meshes.solids import ball, box, coil, cone, disc, rim, ring, rod, wheel
from .anchors import Anchor
from .part import DARK, GROUND, STEEL, Part, Span


class DrawingScale(NamedTuple):
    """Sizes of a drawing: thickness of a rod, extent [m], and the upward direction.

    ``displacements`` are the least and the greatest displacement [m] that joints are shown with.
    """

    unit: float
    size: float
    up: Array
    displacements: dict[str, tuple[float, float]]


def joint_parts(anchor: Anchor, scale: DrawingScale) -> Iterator[Part | Span]:
    """Yield what a joint looks like; a kind that is not known is a small ball."""
    for side, mesh, color in _LOOKS.get(anchor.kind, _point)(anchor, scale):
        yield anchor.held("joint", side, mesh, color, 0.45 if anchor.kind in TABLES and side == 0 else 1.0)
    if anchor.kind in LINKS:
        yield from _link(anchor, scale)
    if 0 in anchor.bodies and anchor.kind not in (*RAILS, *TABLES):
        yield mount(anchor, scale)


Look = Iterator[tuple[int, Mesh, str]]
LINKS = ("distance", "revolute_revolute", "revolute_spherical", "revolute_cylindrical")
ROUND = ("rolling_sphere", "rolling_disc", "rolling_wheel")
TABLES = ("planar", "point_on_plane", *ROUND)
WITHOUT = ("parallel_axes", "constant_angle", "distance", "revolute_revolute", "revolute_spherical")
RAILS = ("translational", "cylindrical", "screw", "point_on_line")


def _pin(anchor: Anchor, scale: DrawingScale) -> Look:
    u = scale.unit
    yield 1, disc(0.55 * u, -1.7 * u, 1.7 * u), DARK
    yield 0, joined([disc(1.0 * u, -1.35 * u, -0.75 * u), disc(1.0 * u, 0.75 * u, 1.35 * u)]), STEEL


def _ball(anchor: Anchor, scale: DrawingScale) -> Look:
    yield 1, ball(1.15 * scale.unit), DARK
    yield 0, ring(1.15 * scale.unit, 0.28 * scale.unit), STEEL


def _point(anchor: Anchor, scale: DrawingScale) -> Look:
    yield 1, ball(0.9 * scale.unit), DARK


def _cross(anchor: Anchor, scale: DrawingScale) -> Look:
    u = scale.unit
    yield 0, disc(0.5 * u, -2.0 * u, 2.0 * u), DARK
    yield 1, disc(0.5 * u, -2.0 * u, 2.0 * u), DARK
    yield 1, ball(0.8 * u), STEEL


def _rail(anchor: Anchor, scale: DrawingScale) -> Look:
    low, high = _reach(anchor, scale)
    stops = [disc(1.1 * scale.unit, end - 0.2 * scale.unit, end + 0.2 * scale.unit) for end in (low, high)]
    yield 0, joined([disc(0.5 * scale.unit, low, high), *stops]), STEEL


def _sleeve(anchor: Anchor, scale: DrawingScale) -> Look:
    yield from _rail(anchor, scale)
    yield 1, disc(1.2 * scale.unit, -2.2 * scale.unit, 2.2 * scale.unit), DARK


def _screw(anchor: Anchor, scale: DrawingScale) -> Look:
    yield from _sleeve(anchor, scale)
    low, high = _reach(anchor, scale)
    thread = coil(
        high - low, 0.55 * scale.unit, 0.14 * scale.unit, windings=max(4, int((high - low) / scale.unit))
    )
    yield 0, thread.moved(np.array([0.0, 0.0, low])), DARK


def _bead(anchor: Anchor, scale: DrawingScale) -> Look:
    yield from _rail(anchor, scale)
    yield 1, ball(1.2 * scale.unit), DARK


def _table(anchor: Anchor, scale: DrawingScale) -> Look:
    side = 9 * scale.unit
    yield 0, box((side, side, 0.3 * scale.unit)), STEEL
    yield 1, disc(1.6 * scale.unit, -0.4 * scale.unit, 0.4 * scale.unit), DARK


def _weld(anchor: Anchor, scale: DrawingScale) -> Look:
    yield 1, box((1.8 * scale.unit,) * 3), DARK


def _plane(anchor: Anchor) -> Look:
    radius = float(anchor.part.radius)
    yield 0, box((6 * radius, 6 * radius, 0.02 * radius)), STEEL


def _roller(anchor: Anchor, scale: DrawingScale) -> Look:
    radius = float(anchor.part.radius)
    yield 1, wheel(radius, 0.2 * radius), DARK
    yield 1, rim(radius, 0.2 * radius), STEEL
    yield 1, rod(np.zeros(3), np.array([0.62 * radius, 0.0, 0.0]), 0.06 * radius), DARK
    yield from _plane(anchor)


def _globe(anchor: Anchor, scale: DrawingScale) -> Look:
    radius, across = float(anchor.part.radius), np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
    yield 1, ball(radius), STEEL
    meridian = ring(radius, 0.03 * radius).moved(np.zeros(3), across)
    yield 1, joined([ring(radius, 0.03 * radius), meridian]), DARK
    yield from _plane(anchor)


def _blade(anchor: Anchor, scale: DrawingScale) -> Look:
    yield 1, box((2.5 * scale.unit, 5 * scale.unit, 0.3 * scale.unit)), DARK


_LOOKS: dict[str, Callable[[Anchor, DrawingScale], Look]] = {
    "revolute": _pin,
    "spherical": _ball,
    "universal": _cross,
    "translational": _rail,
    "cylindrical": _sleeve,
    "screw": _screw,
    "point_on_line": _bead,
    "planar": _table,
    "point_on_plane": _table,
    "fixed": _weld,
    "rolling_sphere": _globe,
    "rolling_disc": _roller,
    "rolling_wheel": _roller,
    "knife_edge": _blade,
    **dict.fromkeys(WITHOUT, lambda anchor, scale: iter(())),
}


def _reach(anchor: Anchor, scale: DrawingScale) -> tuple[float, float]:
    low, high = scale.displacements.get(anchor.name, (0.0, 0.0))
    spare = max(5 * scale.unit, 0.04 * scale.size)
    return low - spare, high + spare


def _link(anchor: Anchor, scale: DrawingScale) -> Iterator[Part | Span]:
    """A rod of constant length, with balls at its ends."""
    length = max(getattr(anchor.part, "length", None) or 0.0, scale.unit)
    z = np.array([0.0, 0.0, 1.0])
    yield anchor.spanned("joint", length, rod(0 * z, length * z, 0.45 * scale.unit), STEEL)
    for body, point in zip(anchor.bodies, anchor.points, strict=True):
        yield Part(anchor.name, "joint", anchor.description, body, ball(0.9 * scale.unit, point), DARK)


def mount(anchor: Anchor, scale: DrawingScale) -> Part:
    """A foot on the ground with a hatched plate, below the joint's point."""
    u, side = scale.unit, anchor.bodies.index(0)
    slants = [
        rod(np.array([x, 0.0, -3.75 * u]), np.array([x - 0.9 * u, 0.0, -4.65 * u]), 0.12 * u)
        for x in np.linspace(-1.8 * u, 2.2 * u, 6)
    ]
    foot = [
        cone(1.9 * u, 0.9 * u, -3.3 * u, -0.6 * u),
        box((5 * u, 3.4 * u, 0.45 * u)).moved(np.array([0, 0, -3.5 * u])),
    ]
    mesh = joined([*foot, *slants]).moved(anchor.points[side], upright(scale.up))
    return Part(anchor.name, "ground", "held by the ground", 0, mesh, GROUND)
