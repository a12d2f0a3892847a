"""The attachments of joints and forces: numbers of the bodies, points and axes in their frames."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...algebra import Array
from ...elements import EccentricInertia, RigidInertia
from ...model import Model
from ...model.expansion.blueprint import Blueprint, Placement
from ...model.expansion.marker import FramedPart
from ...model.geometry.points import GROUND
from ...model.geometry.pose import Poses
from ...model.joints.couplings import Coupling
from ...model.registry import kind_name
from ..meshes.mesh import Mesh, along
from .part import Grip, Kind, Part, Span

ORIGIN = np.zeros(3)


class Anchor(NamedTuple):
    """A part's kind and name, its bodies by number, its point on each [m], and its axes f, g, h on each as columns."""

    kind: str
    name: str
    bodies: tuple[int, int]
    points: tuple[Array, Array]
    axes: tuple[Array, Array]
    part: Any
    description: str

    def held(self, kind: Kind, side: int, mesh: Mesh, color: str, opacity: float = 1.0) -> Part:
        """A mesh in the part's axes on one of its bodies."""
        placed = mesh.moved(self.points[side], self.axes[side])
        return Part(self.name, kind, self.description, self.bodies[side], placed, color, opacity)

    def spanned(self, kind: Kind, length: float, mesh: Mesh, color: str, grip: Grip = "both") -> Span:
        """A mesh along z between the part's two points, made for a distance [m]."""
        bodies, points = self.bodies, self.points
        return Span(self.name, kind, self.description, bodies, points, length, mesh, color, grip)


def anchors(model: Model, plan: Blueprint, section: str) -> list[Anchor]:
    """The anchors of all joints, or of all forces, that are somewhere, which couplings are not."""
    numbers = {name: n for n, name in enumerate((GROUND, *plan.bodies))}
    poses = model.design_poses()
    placed: dict[str, list[Placement]] = {}
    for one in plan.placed:
        if bodies := plan.bodies_of(one):
            placed.setdefault(one.owner, []).append(one._replace(bodies=bodies))
    parts: Any = model.sections()[section]
    somewhere = (part for part in parts if not isinstance(part, Coupling))
    every = (_anchor(part, numbers, poses, placed.get(part.name, [])) for part in somewhere)
    return [anchor for anchor in every if anchor is not None]


def _anchor(part: Any, numbers: dict[str, int], poses: Poses, placed: list[Placement]) -> Anchor | None:
    kind = kind_name(type(part))

    def anchor(bodies: Sequence[int], points: Sequence[Any], axes: tuple[Array, Array]) -> Anchor:
        s_i, s_j = (np.array(point) for point in points)
        return Anchor(
            kind, part.name, (bodies[0], bodies[-1]), (s_i, s_j), axes, part, kind.replace("_", " ")
        )

    if isinstance(part, FramedPart) and not getattr(part, "joint", ""):  # a joint by name has its own mark
        i, j = part.frames(poses)
        axes_i, axes_j = (np.column_stack([frame.f, frame.g, frame.h]) for frame in (i, j))
        return anchor([numbers[i.body], numbers[j.body]], [i.s, j.s], (axes_i, axes_j))
    for one in placed:
        known = fields(one)
        if "s" in known:
            return anchor(one.bodies[-1:], [known["s"]] * 2, (np.eye(3), np.eye(3)))
        if "s_i" in known and "s_j" in known:
            return anchor(one.bodies, [known["s_i"], known["s_j"]], _axes(placed))
    return None


def _axes(placed: list[Placement]) -> tuple[Array, Array]:
    """Axes along the first vector of body i that the elements hold, if there is one."""
    for one in placed:
        a_i = fields(one).get("a_i")
        if a_i is not None and len(one.bodies) == 2:
            return along(np.array(a_i)), np.eye(3)
    return np.eye(3), np.eye(3)


def fields(one: Placement) -> dict[str, Any]:
    """The values of an element by the names of its fields."""
    names = [name for name, kind in one.element.fields.items() if kind != "Time"]
    return dict(zip(names, one.values, strict=True))


def masses(plan: Blueprint) -> dict[int, tuple[float, Array, Array]]:
    """Mass [kg], inertia about the centre of mass (3, 3) and centre of mass in body axes, by number of the body."""
    kinds = RigidInertia | EccentricInertia
    return {one.bodies[0]: _mass(fields(one)) for one in plan.placed if issubclass(one.element, kinds)}


def _mass(fields: dict[str, Any]) -> tuple[float, Array, Array]:
    values = [np.asarray(value, dtype=float) for value in fields.values()]
    xx, yy, zz, xy, xz, yz = next(value for value in values if value.shape == (6,))
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return float(fields["mass"]), inertia, np.asarray(fields.get("center", ORIGIN), dtype=float)


def points_of(body: int, anchors: list[Anchor]) -> Iterator[Array]:
    """All points that anchors have on a body."""
    for anchor in anchors:
        for number, point in zip(anchor.bodies, anchor.points, strict=True):
            if number == body:
                yield point
