"""A <robot>: its links and joints as one tree."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from ...model.quantity import Vec3
from ...model.show import quote, suggest
from ..robot import Description, Edge, Link, Mimic
from .element import Element, read_xml
from .joint import read_joint, read_limit, read_mimic
from .link import read_link, read_visuals
from .notes import notes
from .reader import Reader
from .tree import in_order, root_of

CHILDREN = ("link", "joint", "material", "transmission", "gazebo")


def describe(path: Path, gravity: Vec3) -> Description:
    """Return the description that a URDF file gives.

    Raises
    ------
    ModelError
        For anything that is wrong with it, in one sentence with file, line, part and remedy.
    """
    root = read_xml(path)
    file = str(path)
    reader = Reader(file, "robot")
    if root.tag != "robot":
        raise reader.refusal(f"the file is a <{root.tag}>, not a <robot>; give a URDF file", root.line)
    reader.check(root, ("name", "version"), CHILDREN)
    name = root.attributes.get("name", "").strip() or path.stem
    readers = {id(part): _reader(part, reader) for part in root.children if part.tag in ("link", "joint")}
    links = {n: read_link(e, n, readers[id(e)]) for n, e in _named(root, "link", reader).items()}
    if not links:
        raise reader.refusal("has no links; give at least one", root.line)
    elements = _named(root, "joint", reader)
    edges = {n: read_joint(e, n, readers[id(e)]) for n, e in elements.items()}
    _check_links(edges, links, file)
    start = root_of(edges, links, file)
    limits = {n: read_limit(e, readers[id(e)]) for n, e in elements.items()}
    mimics = {n: read_mimic(e, readers[id(e)]) for n, e in elements.items()}
    following = {n: mimic for n, mimic in mimics.items() if mimic and edges[n].motions}
    _check_mimics(following, edges, file)
    return Description(
        name,
        file,
        links,
        in_order(edges, links, start, file),
        start,
        gravity,
        limits={n: limit for n, limit in limits.items() if limit},
        mimics=following,
        visuals=[v for e in root.all("link") for v in read_visuals(e, e.attributes["name"], readers[id(e)])],
        notes=notes(root),
    )


def _reader(part: Element, reader: Reader) -> Reader:
    return Reader(reader.file, f"{part.tag} {quote(part.attributes.get('name', ''))}")


def _named(root: Element, tag: str, reader: Reader) -> dict[str, Element]:
    """Return the children with a tag by their names, which must be different."""
    found: dict[str, Element] = {}
    for element in root.all(tag):
        name = reader.text(element, "name")
        if name in found:
            told = f"the {tag} {quote(name)} is there twice, the first time on line {found[name].line}"
            raise reader.refusal(f"{told}; rename one of them", element.line)
        found[name] = element
    return found


def _check_links(edges: Mapping[str, Edge], links: Mapping[str, Link], file: str) -> None:
    for edge in edges.values():
        for name in (edge.parent, edge.child):
            if name not in links:
                told = f"there is no link {quote(name)}; {suggest(name, links)}"
                raise Reader(file, f"joint {quote(edge.name)}").refusal(told, edge.line)


def _check_mimics(mimics: Mapping[str, Mimic], edges: Mapping[str, Edge], file: str) -> None:
    leaders = [name for name, edge in edges.items() if [motion.name for motion in edge.motions] == [name]]
    for name, mimic in mimics.items():
        reader = Reader(file, f"joint {quote(name)}")
        if mimic.joint not in leaders:
            told = f"<mimic> names {quote(mimic.joint)}, which is no joint that turns or slides"
            raise reader.refusal(f"{told}; {suggest(mimic.joint, leaders)}", edges[name].line)
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
