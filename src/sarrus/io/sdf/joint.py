"""A <joint> of an SDF file: its links, its motions with their dynamics and limits, and what couples them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from math import tau
from typing import NamedTuple

import numpy as np

from ...model.geometry.motion import Ball, Motion, Slide, Turn, relative
from ...model.geometry.pose import Pose
from ...model.quantity import Array, direction
from ...model.show import quote, suggest
from ..robot import Dynamics, Edge, Limit, Mimic
from ..robot.description import WORLD
from ..xml.element import Element
from . import frames
from .frames import MODEL, Name, flag, maybe, number, vector
from .models import Models, Part

AXES = ("axis", "axis2")
IN_JOINT_AXES = 5  # version 1.5, from which axes are in those of the joint


class Joint(NamedTuple):
    """A joint as an edge, and what its motions have, by their names."""

    edge: Edge
    dynamics: dict[str, Dynamics]
    limits: dict[str, Limit]
    mimics: dict[str, Mimic]


def read_joint(part: Part, models: Models, version: int) -> Joint:
    reader, element = part.reader, part.element
    kind = reader.text(element, "type")
    if kind not in KINDS:
        raise reader.refusal(f"has the unknown type {quote(kind)}. {suggest(kind, KINDS)}", element.line)
    parent, child = (link_of(part, tag, models) for tag in ("parent", "child"))
    if parent == child:
        message = f"connects link {quote(parent)} to itself. Name two different links."
        raise reader.refusal(message, element.line)
    there = models.frames.pose(child)
    frame = relative(there, models.frames.pose(models.frame_of(part)))
    axes = [axis_of(part, tag, models, version, there) for tag in AXES[: COUNTS.get(kind, 0)]]
    motions = KINDS[kind](part.name, frame.r, axes)
    pose = relative(models.frames.pose(parent), there)
    parent = WORLD if parent == frames.WORLD else parent
    edge = Edge(part.name, parent, child, pose, motions, element.line)
    return Joint(edge, *_values(part, kind, motions), mimics_of(part, kind, motions))


def link_of(part: Part, tag: str, models: Models) -> str:
    """Return the link that a frame is attached to which is a parent or child."""
    element = part.reader.needed(part.element, tag, f"<{tag}>arm</{tag}>")
    name = models.frames.full(Name(element.text, part.scope), part.reader, element.line)
    if name == frames.WORLD and tag == "child":
        raise part.reader.refusal("has the world as its child. Exchange parent and child.", element.line)
    return models.frames.link(name)


def axis_of(part: Part, tag: str, models: Models, version: int, there: Pose) -> Array:
    """Return a unit axis in the axes of the child link, which is at a pose in the world."""
    reader = part.reader
    if reader.one(part.element, tag) is None and part.element.attributes.get("type") == "universal":
        axis = np.eye(3)[AXES.index(tag)]  # x and y of the joint
        return there.local_vector(models.frames.pose(models.frame_of(part)).A @ axis)
    element = reader.needed(part.element, tag, f"<{tag}><xyz>0 0 1</xyz></{tag}>")
    xyz = reader.one(element, "xyz")
    name = xyz.attributes.get("expressed_in", "") if xyz else ""
    if version < IN_JOINT_AXES or flag(element, "use_parent_model_frame", reader, False):
        name = MODEL if part.scope else frames.WORLD
    full = models.frames.full(Name(name, part.scope), reader, element.line) if name else models.frame_of(part)
    with reader.placed(element.line):
        axis = direction(vector(element, "xyz", reader, (0.0, 0.0, 1.0)), f"<{tag}> xyz")
    return there.local_vector(models.frames.pose(full).A @ axis)


def motion_name(joint: str, tag: str, kind: str) -> str:
    """Return the name of the motion of an axis: that of the joint, or JOINT.1 and JOINT.2 where it has two."""
    return f"{joint}.{AXES.index(tag) + 1}" if kind in ("universal", "revolute2") else joint


def _values(part: Part, kind: str, motions: Sequence[Motion]) -> tuple[dict[str, Dynamics], dict[str, Limit]]:
    names = {motion.name for motion in motions if isinstance(motion, Turn | Slide)}
    dynamics, limits = dict[str, Dynamics](), dict[str, Limit]()
    for tag, element in _axis_elements(part):
        name = motion_name(part.name, tag, kind)
        if name not in names:
            continue
        given, limit = (part.reader.one(element, one) for one in ("dynamics", "limit"))
        if given is not None:
            words = ("spring_stiffness", "spring_reference", "damping", "friction")
            values = Dynamics(*(number(given, word, part.reader, 0.0) for word in words))
            dynamics |= {name: values} if values._replace(free=0.0) != Dynamics() else {}
        if limit is not None and kind != "continuous":
            limits[name] = _limit(limit, part)
    return dynamics, limits


def _limit(element: Element, part: Part) -> Limit:
    """Return the limits of an axis: without the number there is none, nor with a negative effort or velocity."""
    lower, upper, *most = (maybe(element, word, part.reader) for word in Limit._fields[:4])
    return Limit(lower, upper, *(value if value is None or value >= 0 else None for value in most))


def _axis_elements(part: Part) -> Iterator[tuple[str, Element]]:
    for tag in AXES:
        element = part.reader.one(part.element, tag)
        if element is not None:
            yield tag, element


def mimics_of(part: Part, kind: str, motions: Sequence[Motion]) -> dict[str, Mimic]:
    """Return the motions that follow another: by <mimic>, and the displacement of a screw."""
    mimics = {}
    for tag, element in _axis_elements(part):
        for mimic in element.all("mimic"):
            values = ("multiplier", 1.0), ("offset", 0.0), ("reference", 0.0)
            factor, offset, reference = (number(mimic, word, part.reader, one) for word, one in values)
            leader = f"{part.scope}{part.reader.text(mimic, 'joint')}"
            name = motion_name(part.name, tag, kind)
            mimics[name] = Mimic(
                f"{leader}@{mimic.attributes.get('axis', AXES[0])}", factor, offset - factor * reference
            )
    if kind == "screw":
        slide = next(motion.name for motion in motions if isinstance(motion, Slide))
        mimics[slide] = Mimic(part.name, _pitch(part) / tau)
    return mimics


def resolved(mimics: Mapping[str, Mimic], joints: Mapping[str, Part]) -> dict[str, Mimic]:
    """Return the mimics with the motions that they follow, in place of joints and axes."""
    found = {}
    for name, mimic in mimics.items():
        joint, _, axis = mimic.joint.partition("@")
        if joint not in joints:
            part = joints[name.rpartition(".")[0] if name not in joints else name]
            message = f"<mimic> names {quote(joint)}, which is no joint. {suggest(joint, joints)}"
            raise part.reader.refusal(message, part.element.line)
        kind = joints[joint].element.attributes.get("type", "")
        found[name] = mimic._replace(joint=motion_name(joint, axis, kind) if axis else joint)
    return found


def _pitch(part: Part) -> float:
    """Return the displacement of a screw in a revolution [m]."""
    new = part.reader.one(part.element, "screw_thread_pitch")
    if new is not None:
        return part.reader.content(new)[0]
    old = number(part.element, "thread_pitch", part.reader, 1.0)  # [rad/m], positive for a left-handed thread
    if not old:
        raise part.reader.refusal("<thread_pitch> must not be 0. Give it in rad/m.", part.element.line)
    return -tau / old


COUNTS = {"revolute": 1, "continuous": 1, "prismatic": 1, "screw": 1, "universal": 2, "revolute2": 2}  # axes
KINDS: dict[str, Callable[[str, Array, Sequence[Array]], tuple[Motion, ...]]] = {  # by name, point and axes
    **dict.fromkeys(("revolute", "continuous"), lambda name, r, axes: (Turn(name, axes[0], r),)),
    "prismatic": lambda name, r, axes: (Slide(name, axes[0]),),
    "screw": lambda name, r, axes: (Slide(f"{name}.displacement", axes[0]), Turn(name, axes[0], r)),
    **dict.fromkeys(
        ("universal", "revolute2"),
        lambda name, r, axes: tuple(Turn(f"{name}.{n}", axis, r) for n, axis in enumerate(axes, 1)),
    ),
    "ball": lambda name, r, axes: (Ball(name, r),),
    "fixed": lambda name, r, axes: (),
}
