"""The attachments of joints and forces: numbers of the bodies, points and axes in their frames."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from ...algebra import Array
from ...model import Model
from ...model.blueprint import Blueprint, Placed
from ...model.bodies.solid import GROUND
from ...model.geometry.marker import Framed
from ...model.geometry.pose import GROUND_POSE, Poses
from ...model.joints.couplings import Coupling
from ...model.registry import kind_name

ORIGIN = np.zeros(3)


class Anchor(NamedTuple):
    """A part's kind and name, its bodies by number, its point on each [m], and its axes f, g, h on each as columns."""

    kind: str
    name: str
    bodies: tuple[int, int]
    points: tuple[Array, Array]
    axes: tuple[Array, Array]
    part: Any


def anchors(model: Model, plan: Blueprint, section: str) -> list[Anchor]:
    """The anchors of all joints, or of all forces, that are somewhere, which couplings are not."""
    numbers = {name: n for n, name in enumerate((GROUND, *plan.bodies))}
    poses: Poses = {GROUND: GROUND_POSE, **{body.name: body.pose() for body in model.bodies}}
    placed: dict[str, list[Placed]] = {}
    for one in plan.placed:
        placed.setdefault(one.owner, []).append(one)
    parts: Any = model.sections()[section]
    somewhere = (part for part in parts if not isinstance(part, Coupling))
    found = (_anchor(part, numbers, poses, placed.get(part.name, [])) for part in somewhere)
    return [anchor for anchor in found if anchor is not None]


def _anchor(part: Any, numbers: dict[str, int], poses: Poses, placed: list[Placed]) -> Anchor | None:
    kind, name = kind_name(type(part)), part.name
    if isinstance(part, Framed):
        frames = part.frames(poses)
        bodies = numbers[frames.i.body], numbers[frames.j.body]
        axes = tuple(np.column_stack([frame.f, frame.g, frame.h]) for frame in frames)
        return Anchor(
            kind, name, bodies, (np.array(frames.i.s), np.array(frames.j.s)), (axes[0], axes[1]), part
        )
    for one in placed:
        fields = _fields(one)
        if "s" in fields:
            points = (np.array(fields["s"]), np.array(fields["s"]))
            return Anchor(kind, name, (one.bodies[0], one.bodies[0]), points, (np.eye(3), np.eye(3)), part)
        if "s_i" in fields and "s_j" in fields:
            points = (np.array(fields["s_i"]), np.array(fields["s_j"]))
            return Anchor(kind, name, (one.bodies[0], one.bodies[1]), points, _axes(placed), part)
    return None


def _axes(placed: list[Placed]) -> tuple[Array, Array]:
    """Axes along the first vector of body i that the elements hold, if there is one."""
    from ..meshes.mesh import along

    for one in placed:
        a_i = _fields(one).get("a_i")
        if a_i is not None and len(one.bodies) == 2:
            return along(np.array(a_i)), np.eye(3)
    return np.eye(3), np.eye(3)


def _fields(one: Placed) -> dict[str, Any]:
    names = [name for name, kind in one.element.fields.items() if kind != "Time"]
    return dict(zip(names, one.values, strict=True))


def centers(plan: Blueprint) -> dict[int, tuple[float, Array, Array]]:
    """Mass [kg], inertia about the centre of mass (3, 3) and centre of mass in body axes, by number of the body."""
    return {one.bodies[0]: _mass(_fields(one)) for one in plan.placed if one.label == "inertia"}


def _mass(fields: dict[str, Any]) -> tuple[float, Array, Array]:
    values = [np.asarray(value, dtype=float) for value in fields.values()]
    xx, yy, zz, xy, xz, yz = next(value for value in values if value.shape == (6,))
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return float(fields["mass"]), inertia, np.asarray(fields.get("center", ORIGIN), dtype=float)


def points_of(body: int, found: list[Anchor]) -> Iterator[Array]:
    """All points that anchors have on a body."""
    for anchor in found:
        for number, point in zip(anchor.bodies, anchor.points, strict=True):
            if number == body:
                yield point
