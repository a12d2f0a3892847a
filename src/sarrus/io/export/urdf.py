"""Models as URDF: a tree of joints with one motion each, and massless links between the motions of a joint."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import atan2, cos, hypot, sin
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np

from ...model import (
    Body,
    Cylindrical,
    Fixed,
    Model,
    Planar,
    Revolute,
    Spherical,
    Translational,
    Universal,
    ground,
)
from ...model.file.plain_data import plain_data
from ...model.file.text.model_text import yaml_text
from ...model.geometry.motion import Ball, Free, Motion, Slide, Turn, compose, relative
from ...model.geometry.points import GROUND
from ...model.geometry.pose import GROUND_POSE, Pose
from ...model.quantity import Array
from ..robot import Dynamics, Edge
from ..robot.description import WORLD
from ..robot.joints import Hinge, joint
from .contents import Contents, missing_loads, warn_of_rates
from .looks import looks_by_body, rgba, sizes
from .missing import Gap
from .xml import child, numbers, text_of

CUT = (Fixed, Revolute, Spherical, Translational, Cylindrical, Universal, Planar)  # a second file has them
DYNAMICS = ("damping", "friction")


def missing(contents: Contents) -> list[Gap]:
    """Return what the format does not have."""
    return [*missing_loads(contents, DYNAMICS)]


def urdf(contents: Contents) -> str:
    """Return the text of a URDF file; the frame of a link is at the joint above it, in the axes of the body."""
    warn_of_rates(contents)
    return text_of(_written(contents).root)


def loops(contents: Contents) -> str:
    """Return the text of the file with the joints that close loops, as `load_urdf` reads it; empty without any."""
    if not contents.loops:
        return ""
    frames = _written(contents).frames
    poses = {name: compose(contents.poses[name or GROUND], frame) for name, frame in frames.items()}
    bodies = {name: Body(name, mass=1, inertia=(1, 1, 1)) for name in poses if name}
    solids = {WORLD: ground, **bodies}
    joints = []
    for edge in contents.loops:
        i, j = edge.parent, edge.child
        motions = tuple(_moved(motion, frames[j].r) for motion in edge.motions)
        closing = joint(Hinge(edge.name, solids[i], solids[j], relative(poses[i], poses[j])), motions)
        joints += [closing] if closing is not None else []
    model = Model(contents.name, [*bodies.values()], joints)
    return yaml_text({"joints": plain_data(model, Path())["joints"]})


def _written(contents: Contents) -> _Writer:
    writer = _Writer(contents)
    for edge in contents.edges:
        writer.add(edge)
    return writer


def _moved(motion: Motion, origin: Array) -> Motion:
    """Return a motion in the axes of the body, from another origin."""
    return replace(motion, point=motion.point - origin) if isinstance(motion, Turn | Ball) else motion


class _Writer:
    def __init__(self, contents: Contents) -> None:
        self.contents = contents
        self.root = Element("robot", name=contents.name)
        self.frames = {WORLD: GROUND_POSE}  # of links in the axes of their bodies
        self.looks = looks_by_body(contents)
        self._shapes(child(self.root, "link", name="world"), GROUND, np.zeros(3))

    def add(self, edge: Edge) -> None:
        """Add a body with the joints above it."""
        motions = [one for motion in edge.motions for one in _single(motion)]
        parent, frame = edge.parent or "world", self.frames[edge.parent]
        body = edge.pose if not _is_free(motions) else GROUND_POSE
        at = np.zeros(3)
        for n, motion in enumerate(motions or [None]):
            last = n >= len(motions) - 1
            link = edge.child if last else f"{edge.child}_{motion.name if motion else ''}"
            at = motion.point if isinstance(motion, Turn) else at
            there = compose(body, Pose(at, GROUND_POSE.p, GROUND_POSE.A))
            self._joint(motion, edge.name, parent, link, relative(frame, there))
            if not last:
                child(self.root, "link", name=link)
            parent, frame = link, there
        self.frames[edge.child] = Pose(at, GROUND_POSE.p, GROUND_POSE.A)
        self._link(edge.child, at)

    def _joint(self, motion: Motion | None, name: str, parent: str, link: str, origin: Pose) -> None:
        kind = _kind(motion)
        joint = child(self.root, "joint", name=motion.name if motion else name, type=kind)
        child(joint, "parent", link=parent)
        child(joint, "child", link=link)
        child(joint, "origin", xyz=origin.r, rpy=roll_pitch_yaw(origin.A))
        if not isinstance(motion, Turn | Slide):
            return
        child(joint, "axis", xyz=motion.axis)
        given = self.contents.dynamics.get(motion.name, Dynamics())
        if given != Dynamics():
            child(joint, "dynamics", damping=given.damping, friction=given.friction)
        lower, upper = self.contents.ranges.get(motion.name, (None, None))
        if kind == "prismatic" or lower is not None or upper is not None:
            child(joint, "limit", lower=lower, upper=upper, effort=0, velocity=0)
        mimic = self.contents.mimics.get(motion.name)
        if mimic is not None:
            child(joint, "mimic", joint=mimic.joint, multiplier=mimic.multiplier)

    def _link(self, name: str, at: Array) -> None:
        mass, center, J = self.contents.inertials[name]
        link = child(self.root, "link", name=name)
        self._shapes(link, name, at)
        inertial = child(link, "inertial")
        child(inertial, "origin", xyz=center - at, rpy=(0, 0, 0))
        child(inertial, "mass", value=mass)
        entries = {f"i{'xyz'[i]}{'xyz'[j]}": J[i, j] for i in range(3) for j in range(i, 3)}
        child(inertial, "inertia", **entries)

    def _shapes(self, link: Element, body: str, at: Array) -> None:
        for look in self.looks.get(body, ()):
            visual = child(link, "visual")
            child(visual, "origin", xyz=look.pose.r - at, rpy=roll_pitch_yaw(look.pose.A))
            shape = child(child(visual, "geometry"), look.shape)
            for name, values in sizes(look):
                shape.set(name, numbers(values))
            if look.file is not None:
                shape.set("filename", look.file.as_posix())
            if look.color:
                child(child(visual, "material", name=look.color), "color", rgba=rgba(look))


def _single(motion: Motion) -> list[Motion]:
    """Return a motion, or the three rotations of a ball."""
    if not isinstance(motion, Ball):
        return [motion]
    axes = zip("xyz", np.eye(3), strict=True)
    return [Turn(f"{motion.name}.{word}", axis, motion.point) for word, axis in axes]


def _is_free(motions: Sequence[Motion]) -> bool:
    return bool(motions) and isinstance(motions[0], Free)


def _kind(motion: Motion | None) -> str:
    kinds = {Turn: "continuous", Slide: "prismatic", Free: "floating"}
    return "fixed" if motion is None else kinds[type(motion)]


def roll_pitch_yaw(A: Array) -> tuple[float, float, float]:
    """Return the angles [rad] about the fixed axes x, y, z in turn.

    Near a pitch of 90° the roll is mostly rounding; the yaw that belongs to it is from
    A Rx(roll)ᵀ = Rz(yaw) Ry(pitch).
    """
    roll = atan2(A[2, 1], A[2, 2])
    c, s = cos(roll), sin(roll)
    pitch = atan2(-A[2, 0], hypot(A[0, 0], A[1, 0]))
    return roll, pitch, atan2(s * A[0, 2] - c * A[0, 1], c * A[1, 1] - s * A[1, 2])
