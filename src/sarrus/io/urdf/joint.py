"""A <joint>: its links, its motion, its limits, and the joint that it mimics."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping

import numpy as np

from ...model.geometry.motion import Ball, Free, Motion, Slide, Turn
from ...model.geometry.rotation import perpendicular
from ...model.quantity import Array
from ...model.show import quote, suggest
from ..robot import Dynamics, Edge, Limit, Mimic
from ..xml.element import Element
from ..xml.reader import Part, Reader

CHILDREN = [
    "origin",
    "parent",
    "child",
    "axis",
    "limit",
    "mimic",
    "dynamics",
    "calibration",
    "safety_controller",
]
LONGEST = 100  # joints that follow one another
X = (1.0, 0.0, 0.0)
WITHOUT_AXIS = ("fixed", "floating", "ball", "spherical")
HARD, SOFT = ("lower", "upper", "effort", "velocity"), ("soft_lower", "soft_upper")  # fields of a limit


def read_joint(element: Element, name: str, reader: Reader) -> Edge:
    """Return a joint as an edge of the tree."""
    reader.check(element, ("name", "type"), CHILDREN)
    parent, child = _link_of(element, "parent", reader), _link_of(element, "child", reader)
    if parent == child:
        message = f"connects link {quote(parent)} to itself. Name two different links."
        raise reader.refusal(message, element.line)
    motions = _motions(element, name, reader)
    return Edge(name, parent, child, reader.pose(element), motions, element.line)


def read_limit(element: Element, reader: Reader) -> Limit | None:
    """Return the limits of a joint, if it has any; one end of a range without the other has the other at zero."""
    limit, soft = (reader.one(element, tag) for tag in ("limit", "safety_controller"))
    if limit is None and soft is None:
        return None
    lower, upper, *most = (reader.maybe(limit, name) if limit else None for name in HARD)
    if element.attributes.get("type") == "continuous":
        lower = upper = None
    elif (lower is None) != (upper is None):
        lower, upper = lower or 0.0, upper or 0.0
    return Limit(
        lower, upper, *most, *(reader.maybe(soft, f"{name}_limit") if soft else None for name in SOFT)
    )


def dynamics_of(element: Element, reader: Reader, stiffness: float, free: float) -> Dynamics:
    """Return damping and dry friction of a joint, with a spring."""
    given = reader.one(element, "dynamics")
    names = ("damping", "friction")
    damping, friction = (reader.number(given, name, 0.0) if given else 0.0 for name in names)
    return Dynamics(stiffness=stiffness, free=free, damping=damping, friction=friction)


def _link_of(element: Element, tag: str, reader: Reader) -> str:
    return reader.text(reader.needed(element, tag, f'<{tag} link="..."/>'), "link")


def _motions(element: Element, name: str, reader: Reader) -> tuple[Motion, ...]:
    kind = reader.text(element, "type")
    if kind not in KINDS:
        message = f"has the unknown type {quote(kind)}. {suggest(kind, KINDS)}"
        raise reader.refusal(message, element.line)
    axis = reader.one(element, "axis") if kind not in WITHOUT_AXIS else None
    return KINDS[kind](name, reader.direction(axis, X))


def _plane(name: str, axis: Array) -> tuple[Motion, ...]:
    first = perpendicular(axis)
    second = np.cross(axis, first)
    return Slide(f"{name}.x", first), Slide(f"{name}.y", second), Turn(f"{name}.angle", axis, np.zeros(3))


KINDS: dict[str, Callable[[str, Array], tuple[Motion, ...]]] = {
    "fixed": lambda name, axis: (),
    **dict.fromkeys(("revolute", "continuous"), lambda name, axis: (Turn(name, axis, np.zeros(3)),)),
    "prismatic": lambda name, axis: (Slide(name, axis),),
    "planar": _plane,
    "floating": lambda name, axis: (Free(name),),
    **dict.fromkeys(("ball", "spherical"), lambda name, axis: (Ball(name, np.zeros(3)),)),
}


def read_mimics(parts: Mapping[str, Part], edges: Mapping[str, Edge]) -> dict[str, Mimic]:
    """Return whom each joint follows that follows one and moves."""
    moving = {name: part for name, part in parts.items() if edges[name].motions}
    read = {name: _read(part) for name, part in moving.items()}
    mimics = {name: mimic for name, mimic in read.items() if mimic}
    leaders = {name for name, edge in edges.items() if [motion.name for motion in edge.motions] == [name]}
    for name, mimic in mimics.items():
        _check_leader(mimic.joint, leaders, edges[name].line, parts[name].reader)
    for name in mimics:
        _check_circle(name, mimics, edges[name].line, parts[name].reader)
    return mimics


def _read(part: Part) -> Mimic | None:
    reader = part.reader
    mimic = reader.one(part.element, "mimic")
    if mimic is None:
        return None
    reader.check(mimic, Mimic._fields)
    leader = reader.text(mimic, "joint")
    return Mimic(leader, reader.number(mimic, "multiplier", 1.0), reader.number(mimic, "offset", 0.0))


def _check_leader(leader: str, leaders: Collection[str], line: int, reader: Reader) -> None:
    if leader not in leaders:
        message = f"<mimic> names {quote(leader)}, which is no joint that rotates or slides"
        raise reader.refusal(f"{message}. {suggest(leader, sorted(leaders))}", line)


def _check_circle(name: str, mimics: Mapping[str, Mimic], line: int, reader: Reader) -> None:
    joint, steps = name, 0
    while joint in mimics:
        joint, steps = mimics[joint].joint, steps + 1
        if joint == name:
            message = f"<mimic> leads from {quote(name)} back to it. Let one of these joints follow none."
            raise reader.refusal(message, line)
        if steps > LONGEST:
            message = f"<mimic> leads through more than {LONGEST} joints. Let it follow the last of them."
            raise reader.refusal(message, line)
