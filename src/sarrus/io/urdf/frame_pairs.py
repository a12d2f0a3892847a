"""Loops beside a URDF as pairs of frames that coincide, in the form of the package ``example-parallel-robots``.

A YAML file lists pairs of links or joints (``closed_loop``); the frame of a joint is that of its child. A pair of type
``6d`` has the same frame, one of type ``3d`` the same origin. Joints of ``joint_name`` are of another kind than in the
URDF (``joint_type``): spherical, fixed at zero, or two rotations about axes of their frame, ``UJOINT_XY``.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ...model.errors import ModelError
from ...model.file.load import read
from ...model.file.text.document import Document
from ...model.geometry.motion import Ball, Motion, Turn
from ...model.geometry.pose import GROUND_POSE
from ...model.show import quote, show, suggest
from ..robot import Description, Edge
from .marked_loops import without_marked_loops

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
        found = self.document.data.get(key) or ()
        if not isinstance(found, Sequence) or isinstance(found, str):
            raise self._refusal(key, f"must be a list, got {show(found)}. Give a list.")
        return found

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
