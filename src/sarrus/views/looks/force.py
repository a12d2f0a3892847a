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
Z = np.array([0.0, 0.0, 1.0])
DESCRIPTIONS = {
    "tsda": "spring and damper",
    "rsda": "torsion spring",
    "sphere_contact": "contact",
    "road_tyre": "tyre",
}


def force_parts(anchor: Anchor, scale: DrawingScale, length: float, axle: Array) -> Look:
    """Yield what a force looks like.

    ``length`` is the distance of its points [m], ``axle`` the axis of a wheel in axes of its body.
    """
    known = anchor._replace(description=DESCRIPTIONS.get(anchor.kind, anchor.description))
    if anchor.kind in ("tyre", "road_tyre"):
        yield from _tyre(known, axle)
    elif anchor.kind in _LOOKS:
        yield from _LOOKS[anchor.kind](known, scale, length)


def _acts(value: Any) -> bool:
    return not (isinstance(value, (int, float)) and value == 0)


def _spring(anchor: Anchor, scale: DrawingScale, length: float) -> Look:
    damped = _acts(anchor.part.c)
    radius = min(1.5 * scale.unit, 0.16 * length)
    if 0 in anchor.bodies:
        yield mount(anchor, scale)
    if _acts(anchor.part.k) or not damped:
        yield anchor.spanned("force", length, coil(length, radius, 0.16 * radius), SPRING)
    if damped:
        yield from _dashpot(anchor, length, 0.5 * radius)


def _dashpot(anchor: Anchor, length: float, radius: float) -> Look:
    cylinder = joined([disc(0.35 * radius, 0.0, 0.1 * length), disc(radius, 0.1 * length, 0.55 * length)])
    piston = rod(0.35 * length * Z, length * Z, 0.35 * radius)
    yield anchor.spanned("force", length, cylinder, DAMPER, "start")
    yield anchor.spanned("force", length, piston, DARK, "end")


def _torsion(anchor: Anchor, scale: DrawingScale, length: float) -> Look:
    yield anchor.held("force", 1, spiral(0.8 * scale.unit, 2.6 * scale.unit, 0.2 * scale.unit), SPRING)


def _bushing(anchor: Anchor, scale: DrawingScale, length: float) -> Look:
    yield anchor.held("force", 1, ring(1.4 * scale.unit, 0.7 * scale.unit), RUBBER, 0.85)


def _sphere(anchor: Anchor, scale: DrawingScale, length: float) -> Look:
    yield anchor.held("force", 0, ball(float(anchor.part.radius) or 0.6 * scale.unit), RUBBER, 0.8)


def _limit(anchor: Anchor, scale: DrawingScale, length: float) -> Look:
    yield anchor.spanned("force", length, rod(0 * Z, length * Z, 0.15 * scale.unit), DAMPER)


def _push(anchor: Anchor, scale: DrawingScale, length: float) -> Look:
    yield anchor.held("force", 0, ball(0.5 * scale.unit), SPRING)


def _tyre(anchor: Anchor, axle: Array) -> Look:
    radius, turned = float(anchor.part.radius), anchor._replace(axes=(along(axle), anchor.axes[1]))
    yield turned.held("force", 0, wheel(radius, 0.55 * radius), RUBBER)
    yield turned.held("force", 0, rim(radius, 0.55 * radius), STEEL)


_LOOKS: dict[str, Callable[[Anchor, DrawingScale, float], Look]] = {
    "tsda": _spring,
    "rsda": _torsion,
    "bushing": _bushing,
    "sphere_contact": _sphere,
    "length_stop": _limit,
    "point_force": _push,
}
