"""The look of forces: coils, dashpots, spirals, rubber rings, wheels, spheres."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from ...algebra import Array
from ..meshes.mesh import along, joined
from ..meshes.solids import ball, coil, disc, rim, ring, rod, spiral, wheel
from .anchors import Anchor
from .joint import DrawingScale, mount
from .part import DAMPER, DARK, RUBBER, SPRING, STEEL, Part, Span

Look = Iterator[Part | Span]


def force_parts(anchor: Anchor, scale: DrawingScale, length: float, axle: Array) -> Look:
    """Yield what a force looks like.

    ``length`` is the distance of its points [m], ``axle`` the axis of a wheel in axes of its body.
    """
    if anchor.kind in ("tyre", "road_tyre"):
        yield from _tyre(anchor, axle)
    elif anchor.kind in _LOOKS:
        yield from _LOOKS[anchor.kind](anchor, scale, length)


def _description(anchor: Anchor) -> str:
    return (
        anchor.kind.replace("_", " ").replace("tsda", "spring and damper").replace("rsda", "torsion spring")
    )


def _acts(value: Any) -> bool:
    return not (isinstance(value, (int, float)) and value == 0)


def _spring(anchor: Anchor, scale: DrawingScale, length: float) -> Look:
    given = anchor.part
    springy, damped = _acts(given.k), _acts(given.c)
    radius = min(1.5 * scale.unit, 0.16 * length)
    if 0 in anchor.bodies:
        yield mount(anchor, scale)
    if springy or not damped:
        mesh = coil(length, radius, 0.16 * radius)
        yield Span(
            anchor.name, "force", _description(anchor), anchor.bodies, anchor.points, length, mesh, SPRING
        )
    if damped:
        yield from _dashpot(anchor, length, 0.5 * radius)


def _dashpot(anchor: Anchor, length: float, radius: float) -> Look:
    cylinder = joined([disc(0.35 * radius, 0.0, 0.1 * length), disc(radius, 0.1 * length, 0.55 * length)])
    piston = rod(np.array([0.0, 0.0, 0.35 * length]), np.array([0.0, 0.0, length]), 0.35 * radius)
    body = Span(
        anchor.name,
        "force",
        _description(anchor),
        anchor.bodies,
        anchor.points,
        length,
        cylinder,
        DAMPER,
        "start",
    )
    yield body
    yield body._replace(mesh=piston, color=DARK, grip="end")


def _torsion(anchor: Anchor, scale: DrawingScale, length: float) -> Look:
    mesh = spiral(0.8 * scale.unit, 2.6 * scale.unit, 0.2 * scale.unit)
    yield Part(
        anchor.name,
        "force",
        _description(anchor),
        anchor.bodies[1],
        mesh.moved(anchor.points[1], anchor.axes[1]),
        SPRING,
    )


def _bushing(anchor: Anchor, scale: DrawingScale, length: float) -> Look:
    mesh = ring(1.4 * scale.unit, 0.7 * scale.unit).moved(anchor.points[1], anchor.axes[1])
    yield Part(anchor.name, "force", "bushing", anchor.bodies[1], mesh, RUBBER, 0.85)


def _sphere(anchor: Anchor, scale: DrawingScale, length: float) -> Look:
    radius = float(anchor.part.radius) or 0.6 * scale.unit
    yield Part(anchor.name, "force", "contact", anchor.bodies[0], ball(radius, anchor.points[0]), RUBBER, 0.8)


def _limit(anchor: Anchor, scale: DrawingScale, length: float) -> Look:
    z = np.array([0.0, 0.0, 1.0])
    mesh = rod(0 * z, length * z, 0.15 * scale.unit)
    yield Span(anchor.name, "force", _description(anchor), anchor.bodies, anchor.points, length, mesh, DAMPER)


def _push(anchor: Anchor, scale: DrawingScale, length: float) -> Look:
    yield Part(
        anchor.name,
        "force",
        _description(anchor),
        anchor.bodies[0],
        ball(0.5 * scale.unit, anchor.points[0]),
        SPRING,
    )


def _tyre(anchor: Anchor, axle: Array) -> Look:
    radius, axes = float(anchor.part.radius), along(axle)
    for mesh, color in ((wheel(radius, 0.55 * radius), RUBBER), (rim(radius, 0.55 * radius), STEEL)):
        yield Part(anchor.name, "force", "tyre", anchor.bodies[0], mesh.moved(anchor.points[0], axes), color)


_LOOKS: dict[str, Callable[[Anchor, DrawingScale, float], Look]] = {
    "tsda": _spring,
    "rsda": _torsion,
    "bushing": _bushing,
    "sphere_contact": _sphere,
    "length_stop": _limit,
    "point_force": _push,
}
