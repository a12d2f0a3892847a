"""The side file of a robot description: joints and forces between links, as those that close its loops."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from ..model.checks.findings import Findings
from ..model.errors import ModelError
from ..model.expansion.expand import expand
from ..model.file.load import build_parts, read, validate
from ..model.file.numbers import Numbers
from ..model.file.text.document import Document
from ..model.forces import Force
from ..model.geometry.points import GROUND, Solid, ground
from ..model.joints import Joint
from ..model.show import quote, suggest
from .robot.robot import Robot
from .robot.tree.carried import part_on_bodies

SECTIONS = ("joints", "forces", "description", "$schema")


def close(robot: Robot, loops: str | os.PathLike[str] | None) -> Robot:
    """Return the checked robot with the joints and forces of a side file.

    Raises
    ------
    ModelError
        For anything that is wrong with the file or the robot.
    """
    if loops is not None:
        robot = robot.adding(*_parts(robot, read(Path(loops))))
    expand(robot)
    return robot


def _parts(robot: Robot, document: Document) -> list[Joint | Force]:
    entry = _entry(document)
    solids: dict[str, Solid] = {GROUND: ground, **robot.links}
    with Findings(document.origin) as findings:
        parts = build_parts(entry.joints, "joints", Joint.kinds, solids, findings)
        parts += build_parts(entry.forces, "forces", Force.kinds, solids, findings)
        return list(_on_bodies(robot, parts, findings))


def _entry(document: Document) -> Any:
    """Return the joints and forces as the reader of model files has them; it asks for a name and bodies too."""
    _check_sections(document)
    whole = Document({"name": "loops", "bodies": {}, **document.data}, document.origin)
    return validate(whole, Numbers(whole.data))


def _check_sections(document: Document) -> None:
    if not isinstance(document.data, Mapping):
        where = document.origin.where(())
        raise ModelError("must be a mapping with the key joints. Add it.", part="file", where=where)
    for key in document.data:
        if key not in SECTIONS:
            message = f"a side file has no key {quote(key)}. {suggest(key, SECTIONS[:2])}"
            raise ModelError(message, part="file", where=document.origin.where((key,)))


def _on_bodies(robot: Robot, parts: Iterable[Joint | Force], findings: Findings) -> Iterator[Joint | Force]:
    """Yield the parts of a side file on the bodies that carry their links."""
    poses = {GROUND: ground.pose(), **{body.name: body.pose() for body in robot.bodies}}
    taken = {part.name for parts_ in robot.sections().values() for part in parts_}
    for part in parts:
        with findings.about("joints" if isinstance(part, Joint) else "forces", part.name):
            if part.name in taken:
                raise ModelError(f"the name {quote(part.name)} is taken by a part of the robot. Rename it.")
            placed = part_on_bodies(part)
            list(placed.primitives(poses))
            yield placed
