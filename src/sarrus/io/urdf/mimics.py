"""The joints of a URDF that follow another: whom, and whether that can be."""

from __future__ import annotations

from collections.abc import Mapping

from ...model.show import quote, suggest
from ..robot import Edge, Mimic
from .part import Part
from .reader import Reader


def read_mimics(parts: Mapping[str, Part], edges: Mapping[str, Edge]) -> dict[str, Mimic]:
    """Return whom each joint follows that follows one and moves."""
    moving = {name: part for name, part in parts.items() if edges[name].motions}
    read = {name: _read(part) for name, part in moving.items()}
    mimics = {name: mimic for name, mimic in read.items() if mimic}
    for name in mimics:
        _check(name, mimics, edges, parts[name].reader)
    return mimics


def _read(part: Part) -> Mimic | None:
    reader = part.reader
    mimic = reader.one(part.element, "mimic")
    if mimic is None:
        return None
    reader.check(mimic, Mimic._fields)
    leader = reader.text(mimic, "joint")
    return Mimic(leader, reader.number(mimic, "multiplier", 1.0), reader.number(mimic, "offset", 0.0))


def _check(name: str, mimics: Mapping[str, Mimic], edges: Mapping[str, Edge], reader: Reader) -> None:
    leaders = [name for name, edge in edges.items() if [motion.name for motion in edge.motions] == [name]]
    leader = mimics[name].joint
    if leader not in leaders:
        told = f"<mimic> names {quote(leader)}, which is no joint that turns or slides"
        raise reader.refusal(f"{told}; {suggest(leader, leaders)}", edges[name].line)
    if _leads_back(name, mimics):
        told = f"<mimic> leads from {quote(name)} back to it; let one of these joints follow none"
        raise reader.refusal(told, edges[name].line)


def _leads_back(name: str, mimics: Mapping[str, Mimic]) -> bool:
    at = name
    for _ in mimics:
        at = mimics[at].joint if at in mimics else at
        if at == name:
            return True
    return False
