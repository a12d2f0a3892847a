"""The frames of an SDF file, each given in another one, and the links that they are attached to."""

from __future__ import annotations

from typing import NamedTuple

from ...model.geometry.motion import compose, relative
from ...model.geometry.pose import GROUND_POSE, Pose
from ...model.show import quote, suggest
from ..xml.reader import Reader

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
        """Return the full name."""
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
