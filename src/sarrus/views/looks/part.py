"""A drawn part: a mesh that moves with a body, or one that spans two bodies."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from ...algebra import Array
from ...euler import A
from ...model.coordinates import POSITION, slice_of
from ..meshes.mesh import POINT, Mesh

Kind = Literal["body", "joint", "force", "ground"]
Grip = Literal["both", "start", "end"]

PALETTE = [
    "#3b76b5",
    "#e08a3c",
    "#4f9d69",
    "#b5545f",
    "#7a68a6",
    "#5aa7b0",
    "#c97fae",
    "#8c6d4f",
    "#a39a35",
    "#6b7a8f",
]
STEEL, DARK, SPRING, DAMPER = "#c3c8ce", "#4a5058", "#c2410c", "#7c8794"
GROUND, RUBBER, MOTOR = "#9aa1a9", "#33373c", "#d97706"


class Proportions(NamedTuple):
    """Sizes of what is drawn, in thicknesses of a rod unless stated."""

    rod: float = 0.05  # of the median extent of bodies: a thickness
    thinnest: float = 0.004  # of the size of the drawing
    thickest: float = 0.018  # of the size of the drawing
    block: float = (
        0.12  # of the size of the drawing: half the largest edge of a block that represents an inertia
    )
    off: float = 2.5  # from a link to a centre of mass that is drawn
    pitch: float = 1.3  # from one tooth to the next
    teeth: int = 8  # at least
    wheel: float = 1.1  # half the width of a wheel
    road_ends: float = 2.5  # radii of the tyre, beyond its path
    road_sides: float = 0.7  # radii of the tyre, beside its path
    road_height: float = 0.05  # radii of the tyre
    stations: int = 241  # along a road that is not flat
    glass: float = 0.28  # opacity
    parallel: float = 0.999  # least cosine of directions that are drawn as one


LOOK = Proportions()


class Part(NamedTuple):
    """A mesh in the axes of body number ``body`` (0 is the ground), under the name of what it belongs to."""

    name: str
    kind: Kind
    description: str
    body: int
    mesh: Mesh
    color: str
    opacity: float = 1.0


class Span(NamedTuple):
    """A mesh along z between two points of two bodies, made for the distance ``length`` [m].

    ``grip`` determines what changes with the distance: ``"both"`` ends hold and it is stretched, or it keeps its
    length at the ``"start"`` or with its own end at the ``"end"``.
    """

    name: str
    kind: Kind
    description: str
    bodies: tuple[int, int]
    points: tuple[Array, Array]
    length: float
    mesh: Mesh
    color: str
    grip: Grip = "both"

    def placed(self, start: Array, end: Array) -> tuple[Array, Array, Array]:
        """Between points (..., 3): the place of its mesh (..., 3), a unit vector along it, and its stretch (..., 1)."""
        way = end - start
        distance = np.maximum(np.linalg.norm(way, axis=-1, keepdims=True), POINT)
        place = end - self.length * way / distance if self.grip == "end" else start
        stretch = distance / self.length if self.grip == "both" else np.ones_like(distance)
        return place, way / distance, stretch


def body_frame(q: Array, body: int) -> tuple[Array, Array]:
    """The origin and the axes, as columns, of a body by its number; those of the ground are global."""
    if not body:
        return np.zeros(3), np.eye(3)
    r, p = np.split(q[slice_of(body - 1)], [POSITION])
    return r, np.asarray(A(p / np.linalg.norm(p)), dtype=float)


def place_of(q: Array, body: int, point: Array) -> Array:
    """A point of a body in space (3,), or for positions (n, nq) its path (n, 3)."""
    if q.ndim > 1:
        return np.array([place_of(row, body, point) for row in q])
    r, axes = body_frame(q, body)
    return np.asarray(r + axes @ point)
