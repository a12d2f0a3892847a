"""A <robot>: its links and joints as one tree."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeVar

from ...model.quantity import Vec3
from ...model.show import quote, suggest
from ..robot import Description, Edge, Link, Visual
from .element import Element, read_xml
from .joint import SINGLE, read_dynamics, read_joint, read_limit, read_mimics
from .link import read_link, read_visuals
from .reader import Part, Reader, named
from .tree import in_order, root_of

Given = TypeVar("Given")
IMPLICIT_WORLD = "world"
MOST_LINKS = 10_000
CHILDREN = ("link", "joint", "material", "transmission", "gazebo")


def describe(path: Path, gravity: Vec3) -> Description:
    """Return the description that a URDF file gives.

    Raises
    ------
    ModelError
        For anything that is wrong with it, in one message with file, line, part and remedy.
    """
    root, file = read_xml(path), str(path)
    _check_root(root, Reader(file, "robot"))
    link_parts, joint_parts = (named(root, tag, Reader(file, "robot")) for tag in ("link", "joint"))
    links = {name: read_link(part.element, name, part.reader) for name, part in link_parts.items()}
    if IMPLICIT_WORLD in _parents(joint_parts):
        links.setdefault(IMPLICIT_WORLD, Link(IMPLICIT_WORLD, None))  # files name it without declaring it
    edges = {name: _edge(part, name, links) for name, part in joint_parts.items()}
    start = root_of(edges, links, file)
    wrong: list[str] = []
    visuals = _visuals(link_parts, wrong)
    return Description(
        name=root.attributes.get("name", "").strip() or path.stem,
        file=file,
        links=links,
        edges=in_order(edges, links, start, file),
        root=start,
        gravity=gravity,
        limits=_given(joint_parts, read_limit),
        mimics=read_mimics(joint_parts, edges),
        dynamics=_given(joint_parts, read_dynamics),
        visuals=visuals,
        notes=[*notes(root), *wrong],
    )


def _check_root(root: Element, reader: Reader) -> None:
    if root.tag != "robot":
        raise reader.refusal(f"the file is a <{root.tag}>, not a <robot>. Give a URDF file.", root.line)
    reader.check(root, ("name", "version"), CHILDREN)
    links = sum(1 for _ in root.all("link"))
    if links > MOST_LINKS:
        message = f"has {links:,} links, more than {MOST_LINKS:,}. Split it, or build it in Python."
        raise reader.refusal(message, root.line)
    if not links:
        raise reader.refusal("has no links. Give at least one.", root.line)


def _edge(part: Part, name: str, links: Mapping[str, Link]) -> Edge:
    edge = read_joint(part.element, name, part.reader)
    for end in (edge.parent, edge.child):
        if end not in links:
            raise part.reader.refusal(f"there is no link {quote(end)}. {suggest(end, links)}", edge.line)
    return edge


def _parents(parts: Mapping[str, Part]) -> set[str]:
    return {end.attributes.get("link", "") for part in parts.values() for end in part.element.all("parent")}


def _given(parts: Mapping[str, Part], read: Callable[[Element, Reader], Given | None]) -> dict[str, Given]:
    """Return what is read of each joint, where it has any."""
    found = {name: read(part.element, part.reader) for name, part in parts.items()}
    return {name: given for name, given in found.items() if given}


def _visuals(parts: Mapping[str, Part], wrong: list[str]) -> list[Visual]:
    return [v for name, part in parts.items() for v in read_visuals(part.element, name, part.reader, wrong)]


def notes(root: Element) -> list[str]:
    """Return one message for each kind of thing that is left out."""
    joints = [*root.all("joint")]
    counts = {
        "{n} transmissions are left out": len([*root.all("transmission")]),
        "{n} <gazebo> extensions are left out": len([*root.all("gazebo")]),
        "{n} collision shapes are left out: there is no contact": len(
            [shape for link in root.all("link") for shape in link.all("collision")]
        ),
        "damping or friction of {n} planar, floating or ball joints is left out": sum(map(_lossy, joints)),
        "limits of {n} joints are stored, not enforced": sum(any(joint.all("limit")) for joint in joints),
    }
    return [message.format(n=n) for message, n in counts.items() if n]


def _lossy(joint: Element) -> bool:
    if joint.attributes.get("type") in SINGLE:
        return False
    given = (d.attributes.get(key, "0") for d in joint.all("dynamics") for key in ("damping", "friction"))
    return any(value.strip().strip("0.") for value in given)
