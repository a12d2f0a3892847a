"""What joints look like: pins, balls, crosses, rails, sleeves, plates, and the massless rods that stand for links."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from ...algebra import Array
from ..shapes import Mesh, ball, box, coil, cone, disc, ring, rod
from ..shapes.mesh import joined
from .anchors import Anchor
from .part import DARK, GROUND, STEEL, Part, Span


class Room(NamedTuple):
    """How large to draw: thickness of a rod, size of the drawing [m], and which way is up.

    ``travels`` are the least and the greatest travel [m] that joints are shown with.
    """

    unit: float
    size: float
    up: Array
    travels: dict[str, tuple[float, float]]


def joint_parts(anchor: Anchor, room: Room) -> Iterator[Part | Span]:
    """Yield what a joint looks like; a kind that is not known is a small ball."""
    told = anchor.kind.replace("_", " ")
    for side, mesh, color in _LOOKS.get(anchor.kind, _point)(anchor, room):
        place = mesh.moved(anchor.points[side], anchor.axes[side])
        glass = 0.45 if anchor.kind in TABLES and side == 0 else 1.0
        yield Part(anchor.name, "joint", told, anchor.bodies[side], place, color, glass)
    if anchor.kind in LINKS:
        yield from _link(anchor, room, told)
    if 0 in anchor.bodies and anchor.kind not in (*RAILS, *TABLES):
        yield mount(anchor, room)


Look = Iterator[tuple[int, Mesh, str]]
LINKS = ("distance", "revolute_revolute", "revolute_spherical", "revolute_cylindrical")
TABLES = ("planar", "point_on_plane")
RAILS = ("translational", "cylindrical", "screw", "point_on_line")


def _pin(anchor: Anchor, room: Room) -> Look:
    u = room.unit
    yield 1, disc(0.55 * u, -1.7 * u, 1.7 * u), DARK
    yield 0, joined([disc(1.0 * u, -1.35 * u, -0.75 * u), disc(1.0 * u, 0.75 * u, 1.35 * u)]), STEEL


def _ball(anchor: Anchor, room: Room) -> Look:
    yield 1, ball(1.15 * room.unit), DARK
    yield 0, ring(1.15 * room.unit, 0.28 * room.unit), STEEL


def _point(anchor: Anchor, room: Room) -> Look:
    yield 1, ball(0.9 * room.unit), DARK


def _cross(anchor: Anchor, room: Room) -> Look:
    u = room.unit
    yield 0, disc(0.5 * u, -2.0 * u, 2.0 * u), DARK
    yield 1, disc(0.5 * u, -2.0 * u, 2.0 * u), DARK
    yield 1, ball(0.8 * u), STEEL


def _rail(anchor: Anchor, room: Room) -> Look:
    low, high = _reach(anchor, room)
    stops = [disc(1.1 * room.unit, end - 0.2 * room.unit, end + 0.2 * room.unit) for end in (low, high)]
    yield 0, joined([disc(0.5 * room.unit, low, high), *stops]), STEEL


def _sleeve(anchor: Anchor, room: Room) -> Look:
    yield from _rail(anchor, room)
    yield 1, disc(1.2 * room.unit, -2.2 * room.unit, 2.2 * room.unit), DARK


def _screw(anchor: Anchor, room: Room) -> Look:
    yield from _sleeve(anchor, room)
    low, high = _reach(anchor, room)
    thread = coil(high - low, 0.55 * room.unit, 0.14 * room.unit, turns=max(4, int((high - low) / room.unit)))
    yield 0, thread.moved(np.array([0.0, 0.0, low])), DARK


def _bead(anchor: Anchor, room: Room) -> Look:
    yield from _rail(anchor, room)
    yield 1, ball(1.2 * room.unit), DARK


def _table(anchor: Anchor, room: Room) -> Look:
    side = 9 * room.unit
    yield 0, box((side, side, 0.3 * room.unit)), STEEL
    yield 1, disc(1.6 * room.unit, -0.4 * room.unit, 0.4 * room.unit), DARK


def _weld(anchor: Anchor, room: Room) -> Look:
    yield 1, box((1.8 * room.unit,) * 3), DARK


def _nothing(anchor: Anchor, room: Room) -> Look:
    yield from ()


_LOOKS: dict[str, Callable[[Anchor, Room], Look]] = {
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
    "parallel_axes": _nothing,
    "constant_angle": _nothing,
    "distance": _nothing,
    "revolute_revolute": _nothing,
    "revolute_spherical": _nothing,
}


def _reach(anchor: Anchor, room: Room) -> tuple[float, float]:
    low, high = room.travels.get(anchor.name, (0.0, 0.0))
    spare = max(5 * room.unit, 0.04 * room.size)
    return low - spare, high + spare


def _link(anchor: Anchor, room: Room, told: str) -> Iterator[Part | Span]:
    """A rod of constant length, with balls at its ends."""
    length = max(getattr(anchor.part, "length", None) or 0.0, room.unit)
    z = np.array([0.0, 0.0, 1.0])
    mesh = rod(0 * z, length * z, 0.45 * room.unit)
    yield Span(anchor.name, "joint", told, anchor.bodies, anchor.points, length, mesh, STEEL)
    for body, point in zip(anchor.bodies, anchor.points, strict=True):
        yield Part(anchor.name, "joint", told, body, ball(0.9 * room.unit, point), DARK)


def mount(anchor: Anchor, room: Room) -> Part:
    """A foot on the ground with a hatched plate, below the joint's point."""
    u, side = room.unit, anchor.bodies.index(0)
    slants = [
        rod(np.array([x, 0.0, -3.75 * u]), np.array([x - 0.9 * u, 0.0, -4.65 * u]), 0.12 * u)
        for x in np.linspace(-1.8 * u, 2.2 * u, 6)
    ]
    foot = [
        cone(1.9 * u, 0.9 * u, -3.3 * u, -0.6 * u),
        box((5 * u, 3.4 * u, 0.45 * u)).moved(np.array([0, 0, -3.5 * u])),
    ]
    mesh = joined([*foot, *slants]).moved(anchor.points[side], _upright(room.up))
    return Part(anchor.name, "ground", "held by the ground", 0, mesh, GROUND)


def _upright(up: Array) -> Array:
    """Axes with z up and x, where that can be, along global x."""
    across = np.eye(3)[0] if abs(up[0]) < 0.9 else np.eye(3)[1]
    f = across - (across @ up) * up
    f = f / np.linalg.norm(f)
    return np.column_stack([f, np.cross(up, f), up])
