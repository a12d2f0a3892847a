"""Loops of a URDF: links that mark them by their names, and pairs of frames in a side file.

Links mark a loop as onshape-to-robot writes them, by ``closing_NAME_1`` and ``closing_NAME_2``: they coincide. Two
more, ``closing_NAME_1_z`` and ``closing_NAME_2_z``, are on the axis of a revolute joint; without
them, the file does not have the kind of joint.

A YAML file lists pairs of links or joints (``closed_loop``); the frame of a joint is that of its child. A pair of type
``6d`` has the same frame, one of type ``3d`` the same origin. Joints of ``joint_name`` are of another kind than in the
URDF (``joint_type``): spherical, fixed at zero, or two rotations about axes of their frame, ``UJOINT_XY``.
"""

from __future__ import annotations

import os
import warnings
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ...model.errors import ModelError, SarrusWarning
from ...model.expansion.expand import expand
from ...model.file.load import read
from ...model.file.text.document import Document
from ...model.geometry.motion import Ball, Motion, Turn
from ...model.geometry.pose import GROUND_POSE
from ...model.show import quote, show, suggest
from ..robot import Description, Edge, Robot

PREFIX, FIRST, SECOND, AXIS = "closing_", "_1", "_2", "_z"


def marked_loops(links: Collection[str]) -> list[Edge]:
    """Return the revolute joints that links mark."""
    return [
        Edge(
            first.removesuffix(FIRST),
            first,
            second,
            GROUND_POSE,
            (Turn(first.removesuffix(FIRST), np.array([0.0, 0.0, 1.0]), np.zeros(3)),),
        )
        for first, second in _pairs(links, with_axis=True)
    ]


def without_marked_loops(description: Description) -> Description:
    """Return the description without the joints that links mark, and a note on them."""
    if not description.loops:
        return description
    names = ", ".join(quote(edge.name) for edge in description.loops)
    note = f"the loops that links mark, {names}: left out, as those of `loops` take their place"
    return replace(description, loops=(), notes=[*description.notes, note])


def with_open_loops_noted(robot: Robot, links: Collection[str]) -> Robot:
    """Return the robot with a note for each pair of links that mark a loop without its axis, if no joint closes it."""
    pairs = list(_pairs(links, with_axis=False))
    if not pairs:
        return robot
    joints = {joint.name for joint in robot.joints}
    closed = {(owner, frozenset(one.bodies)) for owner, one in expand(robot).pieces if owner in joints}
    joined = Counter(pair for _, pair in closed)
    joined.subtract({frozenset((branch.parent, branch.body)) for branch in robot.branches})
    bodies = {name: link.body.name for name, link in robot.links.items()}
    remedy = "with `loops`, or with a joint in Python"
    notes = [
        f"the loop between {quote(first)} and {quote(second)}, left open: close it {remedy}"
        for first, second in pairs
        if joined[frozenset((bodies.get(first, first), bodies.get(second, second)))] <= 0
    ]
    for note in notes:
        warnings.warn(note, SarrusWarning, stacklevel=4)
    return replace(robot, notes=(*robot.notes, *notes))


def _pairs(links: Collection[str], *, with_axis: bool) -> Iterator[tuple[str, str]]:
    """Yield the links that mark a loop, with two more on its axis or without them."""
    for first in links:
        second = first.removesuffix(FIRST) + SECOND
        marked = first.startswith(PREFIX) and first.endswith(FIRST) and second in links
        if marked and ({first + AXIS, second + AXIS} <= {*links}) == with_axis:
            yield first, second


PAIRS, TYPES, MOTORS, JOINTS, KINDS = FIELDS = ("closed_loop", "type", "name_mot", "joint_name", "joint_type")
RIGID, POINT = "6d", "3d"
AXES = dict(zip("XYZ", np.eye(3), strict=True))
UNIVERSAL = "UJOINT_"


def with_frame_pairs(
    description: Description, loops: str | os.PathLike[str] | None
) -> tuple[Description, str | os.PathLike[str] | None]:
    """Return the description with the loops of a file of frame pairs, and the file if it has another form.

    If the file has loops, they take the place of those that links mark by their names.

    Raises
    ------
    ModelError
        For anything that is wrong with the file.
    """
    if loops is None:
        return description, None
    document = read(Path(loops))
    if not isinstance(document.data, Mapping):
        return description, loops
    if document.data.get("joints") or document.data.get(PAIRS):
        description = without_marked_loops(description)
    if PAIRS not in document.data:
        return description, loops
    return _FramePairs(document).applied(description), None


class _FramePairs:
    """The lists of a file, checked."""

    def __init__(self, document: Document) -> None:
        self.document = document
        for key in document.data:
            if key not in FIELDS:
                raise self._refusal(key, f"is no key of frame pairs. {suggest(key, FIELDS)}")

    def applied(self, description: Description) -> Description:
        names = [edge.name for edge in description.edges]
        kinds = {self._known(JOINTS, name, names): kind for name, kind in self._zipped(JOINTS, KINDS)}
        unused = [f"the driven joints of `{MOTORS}`: left out"] if self._list(MOTORS) else []
        description = retyped(description, [self._edge(edge, kinds) for edge in description.edges])
        loops = [*description.loops, *self._loops(description)]
        return replace(description, loops=loops, notes=[*description.notes, *unused])

    def _loops(self, description: Description) -> Iterator[Edge]:
        children = {edge.name: edge.child for edge in description.edges}
        frames = children | {name: name for name in description.links}
        for number, (pair, kind) in enumerate(self._zipped(PAIRS, TYPES), 1):
            if not isinstance(pair, Sequence) or isinstance(pair, str) or len(pair) != 2:
                raise self._refusal(PAIRS, f"has {show(pair)}. Give the names of two links or joints.")
            if str(kind).lower() not in (RIGID, POINT):
                raise self._refusal(TYPES, f"has {show(kind)}. Choose from {POINT}, {RIGID}.")
            first, second = (frames[self._known(PAIRS, name, frames)] for name in pair)
            name = f"loop{number}"
            motions = () if str(kind).lower() == RIGID else (Ball(name, np.zeros(3)),)
            yield Edge(name, first, second, GROUND_POSE, motions)

    def _edge(self, edge: Edge, kinds: Mapping[str, Any]) -> Edge:
        return (
            replace(edge, motions=self._motions(edge.name, kinds[edge.name])) if edge.name in kinds else edge
        )

    def _motions(self, name: str, kind: Any) -> tuple[Motion, ...]:
        axes = str(kind).removeprefix(UNIVERSAL)
        if axes != kind and len(axes) == len(set(axes)) == 2 and all(axis in AXES for axis in axes):
            return tuple(Turn(f"{name}_{axis}", AXES[axis], np.zeros(3)) for axis in axes)
        if kind not in ("SPHERICAL", "FIXED"):
            raise self._refusal(
                KINDS, f"has {show(kind)}. Choose from SPHERICAL, FIXED, UJOINT_XY, ..., UJOINT_ZY."
            )
        return (Ball(name, np.zeros(3)),) if kind == "SPHERICAL" else ()

    def _zipped(self, names: str, values: str) -> list[tuple[Any, Any]]:
        first, second = self._list(names), self._list(values)
        if len(first) != len(second):
            raise self._refusal(
                values, f"must have one value for each of the {len(first)} in {names}. Add or remove some."
            )
        return list(zip(first, second, strict=True))

    def _list(self, key: str) -> Sequence[Any]:
        values = self.document.data.get(key) or ()
        if not isinstance(values, Sequence) or isinstance(values, str):
            raise self._refusal(key, f"must be a list, got {show(values)}. Give a list.")
        return values

    def _known(self, key: str, name: Any, right: Mapping[str, Any] | Sequence[str]) -> str:
        if not isinstance(name, str) or name not in right:
            raise self._refusal(
                key, f"has {show(name)}, which the robot does not have. {suggest(str(name), right)}"
            )
        return name

    def _refusal(self, key: str, message: str) -> ModelError:
        return ModelError(message, part=key, where=self.document.origin.where((key,)))


def retyped(description: Description, edges: Sequence[Edge]) -> Description:
    """Return the description with other motions of its edges, and notes on what refers to motions of another kind.

    Damping remains where a rotation becomes a ball of the same name.
    """
    before, after = (
        {motion.name: type(motion) for edge in given for motion in edge.motions}
        for given in (description.edges, edges)
    )
    changed = {name for name in {*before, *after} if before.get(name) is not after.get(name)}
    lost = {
        "dynamics": changed - after.keys(),
        "limits": changed,
        "mimics": {name for name, mimic in description.mimics.items() if {name, mimic.joint} & changed},
        "actuators": {name for name, one in description.actuators.items() if {*one.motions()} & changed},
    }
    rest, notes = dict[str, Any](), [*description.notes]
    for section, names in lost.items():
        given = getattr(description, section)
        rest[section] = {name: value for name, value in given.items() if name not in names}
        out = ", ".join(quote(name) for name in given if name in names)
        notes += [f"{section} of {out}: left out, as `joint_type` has another kind of joint"] if out else []
    return replace(description, edges=edges, notes=notes, **rest)
