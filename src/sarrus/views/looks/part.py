"""A drawn part: a mesh that moves with a body, or one that spans two bodies."""

from __future__ import annotations

from typing import Literal, NamedTuple

from ...algebra import Array
from ..meshes.mesh import Mesh

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
