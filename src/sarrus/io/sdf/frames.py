"""The frames of an SDF file, each given in another one, and the links that they are attached to."""

from __future__ import annotations

from contextlib import suppress
from typing import NamedTuple

import numpy as np

from ...model.geometry.motion import compose, pose, relative, unit
from ...model.geometry.orientation import EulerAngles, euler_parameters
from ...model.geometry.pose import GROUND_POSE, Pose
from ...model.quantity import Array
from ...model.show import quote, suggest
from ..xml.element import Element
from ..xml.reader import Reader

QUATERNION = "quat_xyzw"  # scalar last
UNLIMITED = 1e12  # what a file writes for no limit is larger


def number(element: Element, tag: str, reader: Reader, default: float) -> float:
    """Return the number in a child, or the default."""
    child = reader.one(element, tag)
    return default if child is None else reader.content(child)[0]


def maybe(element: Element | None, tag: str, reader: Reader) -> float | None:
    """Return the number in a child, or None: files write inf, or 1e16, for no limit."""
    child = reader.one(element, tag) if element else None
    with suppress(ValueError):
        if child is not None and not abs(float(child.text)) < UNLIMITED:
            return None
    return None if child is None else reader.content(child)[0]


def flag(element: Element, tag: str, reader: Reader, default: bool) -> bool:
    """Return the truth in a child, or the default."""
    child = reader.one(element, tag)
    return default if child is None else reader.flag(child)


def vector(element: Element, tag: str, reader: Reader, default: tuple[float, float, float]) -> Array:
    """Return the three numbers in a child, or the default."""
    child = reader.one(element, tag)
    return np.array(default if child is None else reader.content(child, 3), dtype=float)


def pose_of(element: Element, reader: Reader) -> Pose:
    """Return the pose in the child <pose>: x y z [m] and roll pitch yaw [rad, or degrees], or a quaternion."""
    child = reader.one(element, "pose")
    if child is None or not child.text:
        return GROUND_POSE
    if child.attributes.get("rotation_format") == QUATERNION:
        x, y, z, a, b, c, w = reader.content(child, 7)
        return pose(np.array([x, y, z]), unit(np.array([w, a, b, c])))
    x, y, z, *angles = reader.content(child, 6)
    degrees = child.attributes.get("degrees", "false").lower() in ("true", "1")
    roll, pitch, yaw = np.deg2rad(angles) if degrees else angles
    return pose(np.array([x, y, z]), euler_parameters(EulerAngles((yaw, pitch, roll), "zyx")))


WORLD, MODEL, SEPARATOR = "world", "__model__", "::"


class Name(NamedTuple):
    """A name as it is in the file, and the scope in which it is, ``arm::`` in the model arm, or empty in the world."""

    word: str
    scope: str = ""


class Frame(NamedTuple):
    """A frame at a pose in another one; a link is attached to nothing.

    ``placed`` is the frame that has this pose in place of this one, if any.
    """

    within: Name
    pose: Pose
    reader: Reader
    line: int
    attached: Name | None = None
    placed: Name | None = None


class Frames:
    """All frames of a file by their full names, as ``arm::elbow`` for the joint elbow of the model arm."""

    def __init__(self) -> None:
        self.frames: dict[str, Frame] = {}
        self.found: dict[str, Pose] = {WORLD: GROUND_POSE}

    def full(self, name: Name, reader: Reader, line: int) -> str:
        word, scope = name
        if word == WORLD:
            return WORLD
        for one in (f"{scope}{word}", f"{scope}{word}{SEPARATOR}{MODEL}"):
            if one in self.frames:
                return one
        known = [one.removeprefix(scope) for one in self.frames if one.startswith(scope)]
        raise reader.refusal(f"there is no link or frame {quote(word)}. {suggest(word, known)}", line)

    def pose(self, name: str) -> Pose:
        """Return the pose of a frame in the world, by its full name."""
        if name not in self.found:
            self.found[name] = self._resolved(name, WORLD, ())
        return self.found[name]

    def link(self, name: str) -> str:
        """Return the link that a frame is attached to, or the world."""
        seen: list[str] = []
        while name != WORLD and (frame := self.frames[name]).attached is not None:
            if name in seen:
                raise frame.reader.refusal(
                    f"frame {quote(name)} is attached to itself. Name a link.", frame.line
                )
            seen.append(name)
            name = self.full(frame.attached, frame.reader, frame.line)
        return name

    def _resolved(self, name: str, root: str, seen: tuple[str, ...]) -> Pose:
        """Return the pose of a frame in another one, from which it descends."""
        if name in (root, WORLD):
            return GROUND_POSE
        frame = self.frames[name]
        if name in seen:
            message = f"the pose of {quote(name)} is relative to itself. Give it relative to another frame."
            raise frame.reader.refusal(message, frame.line)
        within = self.full(frame.within, frame.reader, frame.line)
        there = compose(self._resolved(within, root, (*seen, name)), frame.pose)
        if frame.placed is None:
            return there
        placed = self.full(frame.placed, frame.reader, frame.line)
        return compose(there, relative(self._resolved(placed, name, ()), GROUND_POSE))
