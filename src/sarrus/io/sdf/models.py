"""The models of an SDF file with their links, joints and frames, by full names."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from ...model.geometry.pose import GROUND_POSE
from ...model.show import quote
from ..xml.element import Element
from ..xml.reader import Reader
from .frames import MODEL, SEPARATOR, WORLD, Frame, Frames, Name, flag, pose_of


class Part(NamedTuple):
    """A link, joint or model: its full name, its element, the scope of names in it, and whether it is static."""

    name: str
    element: Element
    reader: Reader
    scope: str
    static: bool = False


class Models:
    """The parts of all models of a file; `frames` has a frame for each."""

    def __init__(self, container: Element) -> None:
        self.frames = Frames()
        self.models: list[Part] = []
        self.links: dict[str, Part] = {}
        self.joints: dict[str, Part] = {}
        self._take(container, "", static=False)

    def _take(self, container: Element, scope: str, *, static: bool) -> None:
        for element in container.all("link"):
            part = _part(element, scope, static)
            self._add(part.name, part, Name(MODEL, scope))
            self.links[part.name] = part
        for element in container.all("model"):
            self._model(_part(element, scope, static))
        for element in container.all("frame"):
            part = _part(element, scope, static)
            attached = Name(element.attributes.get("attached_to") or (MODEL if scope else WORLD), scope)
            self._add(part.name, part, attached, attached)
        for element in container.all("joint"):
            self._joint(_part(element, scope, static))

    def _model(self, part: Part) -> None:
        element, scope, inner = part.element, part.scope, f"{part.name}{SEPARATOR}"
        static = part.static or flag(element, "static", part.reader, False)
        self.models.append(part)
        placed = element.attributes.get("placement_frame")
        root = element.attributes.get("canonical_link") or next(_links(element), "")
        self._add(
            f"{inner}{MODEL}",
            part,
            Name(MODEL if scope else WORLD, scope),
            Name(root, inner) if root else Name(WORLD),
            Name(placed, inner) if placed else None,
        )
        self._take(element, inner, static=static)

    def _joint(self, part: Part) -> None:
        child = part.reader.needed(part.element, "child", "<child>arm</child>").text
        if part.name in self.joints:
            other = self.joints[part.name].element.line
            message = f"is there twice, the first time on line {other}. Rename one of them."
            raise part.reader.refusal(message, part.element.line)
        self.joints[part.name] = part
        name = self.frame_of(part)
        self._add(name, part, Name(child, part.scope), Name(child, part.scope))

    def frame_of(self, joint: Part) -> str:
        """Return the full name of a joint's frame; old files have links with the name of the joint."""
        return f"{joint.name}{SEPARATOR}__joint__" if joint.name in self.links else joint.name

    def _add(
        self, name: str, part: Part, default: Name, attached: Name | None = None, placed: Name | None = None
    ) -> None:
        reader, element = part.reader, part.element
        if name in self.frames.frames:
            message = f"the name {quote(name)} is there twice. Rename one of the parts."
            raise reader.refusal(message, element.line)
        given = next((one.attributes.get("relative_to", "") for one in element.all("pose")), "")
        within = Name(given, part.scope) if given else default
        pose = pose_of(element, reader) if element.tag != "world" else GROUND_POSE
        self.frames.frames[name] = Frame(within, pose, reader, element.line, attached, placed)


def _part(element: Element, scope: str, static: bool) -> Part:
    name = Reader(element.file, element.tag).text(element, "name")
    return Part(
        f"{scope}{name}", element, Reader(element.file, f"{element.tag} {quote(name)}"), scope, static
    )


def _links(model: Element) -> Iterator[str]:
    """Yield the names of links, those of nested models after the own ones."""
    yield from (link.attributes.get("name", "") for link in model.all("link"))
    for inner in model.all("model"):
        yield from (f"{inner.attributes.get('name', '')}{SEPARATOR}{name}" for name in _links(inner))
