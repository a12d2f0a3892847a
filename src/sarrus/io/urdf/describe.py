"""A <robot>: its links and joints as one tree."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

from ...model.quantity import Vec3
from ...model.show import quote, suggest
from ..robot import Description, Dynamics, Edge, Link, Visual
from ..xml.element import Element, read_xml
from ..xml.left_out import left_out
from ..xml.reader import Part, Reader, named
from .gazebo import read_gazebo, read_loops
from .joint import dynamics_of, read_joint, read_limit, read_mimics
from .link import colors_of, read_link, read_visuals
from .marked_loops import marked_loops
from .specification import ELSEWHERE, NOTED, USED
from .transmissions import read_transmissions
from .tree import in_order, root_of

Given = TypeVar("Given")
IMPLICIT_WORLD = "world"
MOST_LINKS = 10_000
CHILDREN = ("link", "joint", "material", "transmission", "gazebo", "sensor")


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
    visuals = _visuals(link_parts, colors_of(root, Reader(file, "robot")), wrong)
    single = {name for name, edge in edges.items() if [motion.name for motion in edge.motions] == [name]}
    actuators, without_motor = read_transmissions(root, single, file)
    gazebo, tree = read_gazebo(root, file), in_order(edges, links, start, file)
    closing = read_loops(root, tree, start)
    return Description(
        name=root.attributes.get("name", "").strip() or path.stem,
        file=file,
        links=links,
        edges=tree,
        root=start,
        loops=[*marked_loops(links), *(joint.edge for joint in closing)],
        gravity=gravity,
        limits=_given(joint_parts, read_limit) | _merged(joint.limits for joint in closing),
        mimics=read_mimics(joint_parts, edges) | _merged(joint.mimics for joint in closing),
        dynamics=_dynamics(joint_parts, edges, gazebo.springs) | _merged(joint.dynamics for joint in closing),
        actuators=actuators,
        lifted={name: 1.0 for name in gazebo.weightless if name in links},
        visuals=visuals,
        notes=[*_notes(root), *without_motor, *gazebo.notes, *wrong],
    )


def _check_root(root: Element, reader: Reader) -> None:
    if root.tag != "robot":
        raise reader.refusal(
            f"the file is a <{root.tag}>, not a <robot>. Give a URDF file, or use sarrus.load.", root.line
        )
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


def _merged(found: Iterable[Mapping[str, Given]]) -> dict[str, Given]:
    return {name: given for one in found for name, given in one.items()}


def _given(parts: Mapping[str, Part], read: Callable[[Element, Reader], Given | None]) -> dict[str, Given]:
    """Return what is read of each joint, where it has any."""
    found = {name: read(part.element, part.reader) for name, part in parts.items()}
    return {name: given for name, given in found.items() if given}


def _dynamics(
    parts: Mapping[str, Part], edges: Mapping[str, Edge], springs: Mapping[str, tuple[float, float]]
) -> dict[str, Dynamics]:
    """Return the dynamics of each motion that has any."""
    found: dict[str, Dynamics] = {}
    for name, part in parts.items():
        given = dynamics_of(part.element, part.reader, *springs.get(name, (0.0, 0.0)))
        if given != Dynamics():
            found |= {motion.name: given for motion in edges[name].motions}
    return found


def _visuals(
    parts: Mapping[str, Part], colors: Mapping[str, tuple[float, ...]], wrong: list[str]
) -> list[Visual]:
    return [
        visual
        for name, part in parts.items()
        for visual in read_visuals(part.element, name, part.reader, colors, wrong)
    ]


def _notes(root: Element) -> list[str]:
    """Return one message for each kind of thing that is left out."""
    rest = [child for child in root.children if child.tag not in ELSEWHERE]
    return left_out([replace(root, children=rest)], USED, NOTED)
