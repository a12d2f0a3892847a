"""The joints of a URDF that follow another: whom, and whether that can be."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from ...model.show import quote, suggest
from ..robot import Edge, Mimic
from .part import Part
from .reader import Reader

LONGEST = 100  # joints that follow one another


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
        raise reader.refusal(f"{message}; {suggest(leader, leaders)}", line)


def _check_circle(name: str, mimics: Mapping[str, Mimic], line: int, reader: Reader) -> None:
    at, steps = name, 0
    while at in mimics:
        at, steps = mimics[at].joint, steps + 1
        if at == name:
            message = f"<mimic> leads from {quote(name)} back to it; let one of these joints follow none"
            raise reader.refusal(message, line)
        if steps > LONGEST:
            message = f"<mimic> leads through more than {LONGEST} joints; let it follow the last of them"
            raise reader.refusal(message, line)
