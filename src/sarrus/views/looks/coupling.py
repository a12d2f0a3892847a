"""The look of couplings: gears as toothed wheels, a rack with its pinion, collars on coupled joints."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any, NamedTuple

import numpy as np

from ...algebra import Array
from ...model.joints.couplings import Coupler, Coupling, Gear, RackAndPinion
from ..meshes.mesh import Mesh, joined
from ..meshes.solids import box, disc, ring, toothed
from .joint import DrawingScale
from .part import DARK, LOOK, MOTOR, STEEL, Part


class Hold(NamedTuple):
    """Where a joint holds its moving body: the body's number, its point and axes in space, and the way to its frame."""

    name: str
    body: int
    point: Array
    axes: Array
    local: Callable[[Mesh], Mesh]


def coupling_parts(part: Coupling, holds: dict[str, Hold], scale: DrawingScale) -> Iterator[Part]:
    """Yield what a coupling of two joints looks like; nothing if one of them is nowhere."""
    i, j = held(part, holds)
    if i is None or j is None:
        return
    if isinstance(part, Gear):
        yield from _gears(part, i, j, scale)
    elif isinstance(part, RackAndPinion):
        yield from _rack(part, i, j, scale)
    elif isinstance(part, Coupler):
        description = f"coupler, {part.joint_j} = {part.ratio:g} times {part.joint_i}"
        collar = ring(1.9 * scale.unit, 0.7 * scale.unit)
        for hold in (i, j):
            yield Part(part.name, "joint", description, hold.body, _at(hold, collar), MOTOR)


def held(part: Coupling, holds: dict[str, Hold]) -> tuple[Hold | None, Hold | None]:
    """Return the places of the two joints of a coupling, that of the pinion first."""
    if isinstance(part, RackAndPinion):
        names = part.pinion, part.rack
    elif isinstance(part, Coupler):
        names = part.joint_i, part.joint_j
    else:
        return None, None
    first, second = (holds.get(name.partition(".")[0]) for name in names)
    return first, second


def wheels(parts: Iterable[Any], holds: dict[str, Hold]) -> dict[int, Hold]:
    """The bodies that are drawn with a toothed wheel, by number."""
    bodies: dict[int, Hold] = {}
    for part in parts:
        if isinstance(part, Gear | RackAndPinion):
            i, j = held(part, holds)
            turning = (i,) if isinstance(part, RackAndPinion) else (i, j)
            bodies |= {hold.body: hold for hold in turning if hold is not None and j is not None}
    return bodies


def hub(hold: Hold, scale: DrawingScale) -> Mesh:
    """What is left to draw of a body that is a wheel and no more."""
    return _at(hold, disc(1.5 * scale.unit, -1.1 * scale.unit, 1.1 * scale.unit))


def radii(ratio: float, i: Hold, j: Hold, scale: DrawingScale) -> tuple[float, float]:
    """Radii [m] of two wheels, as the ratio has them; they touch where parallel axes turn in opposite senses."""
    between = j.point - i.point
    across = between - (between @ i.axes[:, 2]) * i.axes[:, 2]
    apart, parallel = float(np.linalg.norm(across)), abs(i.axes[:, 2] @ j.axes[:, 2]) > LOOK.parallel
    opposite = ratio * (i.axes[:, 2] @ j.axes[:, 2]) < 0
    whole = apart if parallel and opposite and apart > 2 * scale.unit else 8 * scale.unit
    return whole * abs(ratio) / (1 + abs(ratio)), whole / (1 + abs(ratio))


def _gears(part: Gear, i: Hold, j: Hold, scale: DrawingScale) -> Iterator[Part]:
    description = f"gear, angle of {j.name} = {part.ratio:g} times that of {i.name}"
    for hold, radius, color in zip((i, j), radii(part.ratio, i, j, scale), (STEEL, DARK), strict=True):
        yield Part(part.name, "joint", description, hold.body, _at(hold, _wheel(radius, scale)), color)


def _rack(part: RackAndPinion, pinion: Hold, rack: Hold, scale: DrawingScale) -> Iterator[Part]:
    description = f"rack and pinion, {part.radius:g} m for a radian"
    radius = abs(part.radius)
    yield Part(part.name, "joint", description, pinion.body, _at(pinion, _wheel(radius, scale)), STEEL)
    way, axle = rack.axes[:, 2], pinion.axes[:, 2]
    out = np.cross(way, axle) * np.sign(part.radius)  # ω × (r out) is along the way
    axes = np.column_stack([way, np.cross(out, way), out])
    count = max(LOOK.teeth, int(4 * radius / (LOOK.pitch * scale.unit)))
    u = scale.unit
    tooth = box((0.5 * LOOK.pitch * u, LOOK.wheel * u, 0.6 * u))
    teeth = [tooth.moved(np.array([(n - (count - 1) / 2) * LOOK.pitch * u, 0.0, 0.0])) for n in range(count)]
    back = box((count * LOOK.pitch * u, LOOK.wheel * u, 0.8 * u)).moved(np.array([0.0, 0.0, 0.7 * u]))
    mesh = rack.local(joined([back, *teeth]).moved(pinion.point + radius * out, axes))
    yield Part(part.name, "joint", description, rack.body, mesh, DARK)


def _wheel(radius: float, scale: DrawingScale) -> Mesh:
    """A toothed wheel about z, on a hub."""
    teeth = max(LOOK.teeth, round(2 * np.pi * radius / (LOOK.pitch * scale.unit)))
    half = 0.5 * LOOK.wheel * scale.unit
    hub = disc(0.9 * scale.unit, -1.6 * half, 1.6 * half)
    return joined([toothed(radius, 0.35 * scale.unit, teeth, -half, half), hub])


def _at(hold: Hold, mesh: Mesh) -> Mesh:
    return hold.local(mesh.moved(hold.point, hold.axes))
