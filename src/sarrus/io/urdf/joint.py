"""A <joint>: what it connects, how it moves, and its limits."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...model.geometry.motion import Free, Motion, Slide, Turn
from ...model.geometry.rotation import perpendicular
from ...model.quantity import Array
from ...model.show import quote, suggest
from ..robot import Edge, Limit
from .element import Element
from .reader import Reader

CHILDREN = (
    "origin",
    "parent",
    "child",
    "axis",
    "limit",
    "mimic",
    "dynamics",
    "calibration",
    "safety_controller",
)
X = (1.0, 0.0, 0.0)
WITHOUT_AXIS = ("fixed", "floating")


def read_joint(element: Element, name: str, reader: Reader) -> Edge:
    """Return a joint as an edge of the tree."""
    reader.check(element, ("name", "type"), CHILDREN)
    parent, child = _link_of(element, "parent", reader), _link_of(element, "child", reader)
    if parent == child:
        message = f"connects link {quote(parent)} to itself; name two different links"
        raise reader.refusal(message, element.line)
    motions = _motions(element, name, reader)
    return Edge(name, parent, child, reader.pose(element), motions, element.line)


def read_limit(element: Element, reader: Reader) -> Limit | None:
    """Return the limits of a joint, if it has any."""
    limit = reader.one(element, "limit")
    if limit is None:
        return None
    return Limit(*(reader.maybe(limit, name) for name in Limit._fields))


def _link_of(element: Element, tag: str, reader: Reader) -> str:
    return reader.text(reader.needed(element, tag, f'<{tag} link="..."/>'), "link")


def _motions(element: Element, name: str, reader: Reader) -> tuple[Motion, ...]:
    kind = reader.text(element, "type")
    if kind not in KINDS:
        message = f"has the unknown type {quote(kind)}; {suggest(kind, KINDS)}"
        raise reader.refusal(message, element.line)
    axis = reader.one(element, "axis") if kind not in WITHOUT_AXIS else None
    return KINDS[kind](name, reader.direction(axis, X))


def _turn(name: str, axis: Array) -> tuple[Motion, ...]:
    return (Turn(name, axis, np.zeros(3)),)


def _slide(name: str, axis: Array) -> tuple[Motion, ...]:
    return (Slide(name, axis),)


def _plane(name: str, axis: Array) -> tuple[Motion, ...]:
    first = perpendicular(axis)
    second = np.cross(axis, first)
    return Slide(f"{name}.x", first), Slide(f"{name}.y", second), Turn(f"{name}.angle", axis, np.zeros(3))


KINDS: dict[str, Callable[[str, Array], tuple[Motion, ...]]] = {
    "fixed": lambda name, axis: (),
    "revolute": _turn,
    "continuous": _turn,
    "prismatic": _slide,
    "planar": _plane,
    "floating": lambda name, axis: (Free(name),),
}
