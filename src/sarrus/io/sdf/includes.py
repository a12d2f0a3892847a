"""Models that an SDF file includes from other files."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from ...model.bodies.shape import listed
from ...model.errors import ModelError
from ...model.file.include import DEEPEST
from ...model.show import quote
from ..robot.tree.carried import allowed
from ..xml.element import Element, read_xml
from ..xml.reader import Reader
from .frames import MODEL

PATHS = ("SDF_PATH", "GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH", "GAZEBO_MODEL_PATH")
SCENERY = ("sun", "ground_plane")  # included by most worlds; nothing in them moves


class Includes:
    """Replaces <include> by the model that it names.

    Parameters
    ----------
    search : folders in which models are searched
    optional : leave out models that are not found
    """

    def __init__(self, search: Sequence[str | os.PathLike[str]], optional: bool) -> None:
        self.search = [*map(Path, search), *listed(*PATHS)]
        self.optional = optional
        self.notes: list[str] = []

    def expanded(self, element: Element, depth: int = 0) -> Element:
        """Return a world or model with the included models in it."""
        if depth > DEEPEST:
            reader = Reader(element.file, "file")
            raise reader.refusal(
                f"includes more than {DEEPEST} levels of files. Remove levels.", element.line
            )
        children = list[Element]()
        for child in element.children:
            if child.tag == "include":
                children += self._included(child, depth)
            else:
                children.append(self.expanded(child, depth) if child.tag == "model" else child)
        return replace(element, children=children)

    def _included(self, include: Element, depth: int) -> Iterator[Element]:
        reader = Reader(include.file, "include")
        uri = reader.needed(include, "uri", "<uri>model://arm</uri>").text
        folder = Path(include.file).resolve().parent
        file = self._file(uri, folder)
        if file is None:
            if not self.optional and uri.rstrip("/").rpartition("/")[2] not in SCENERY:
                message = f"the model {quote(uri)} is not found. Name its folder in search, or leave it out"
                raise reader.refusal(f'{message}, ignore=["includes"].', include.line)
            self.notes.append(f"the included model {uri} is not found and left out")
            return
        if not allowed(file, uri if "://" in uri else f"model://{uri}", folder, self.search):
            message = f"{quote(uri)} is outside of the folder of the model. Name its folder in search."
            raise reader.refusal(message, include.line)
        model = self.expanded(_named(_model(file), include, reader), depth + 1)
        merged = include.attributes.get("merge", "false").lower() in ("true", "1")
        yield from _merged(model) if merged else [model]

    def _file(self, uri: str, folder: Path) -> Path | None:
        scheme, _, rest = uri.rpartition("://")
        if scheme in ("http", "https"):
            return None
        places = (
            [Path(rest)]
            if scheme == "file"
            else [one / rest for one in (folder, *folder.parents, *self.search)]
        )
        return next((file for place in places if (file := _model_file(place))), None)


def _model_file(place: Path) -> Path | None:
    """Return the file of a model that is a file, or a folder with model.config or model.sdf."""
    if place.is_file():
        return place
    config = place / "model.config"
    names = [element.text for element in read_xml(config).all("sdf")] if config.is_file() else []
    return next((place / name for name in (*reversed(names), "model.sdf") if (place / name).is_file()), None)


def _model(file: Path) -> Element:
    models = list(read_xml(file).all("model"))
    if len(models) != 1:
        message = f"has {len(models)} models. An included file must have one."
        raise ModelError(message, part="file", where=str(file))
    return models[0]


def _named(model: Element, include: Element, reader: Reader) -> Element:
    """Return the model with the name, pose and placement of the include."""
    children = {tag: reader.one(include, tag) for tag in ("name", "pose", "static", "placement_frame")}
    attributes = dict(model.attributes)
    for tag, attribute in (("name", "name"), ("placement_frame", "placement_frame")):
        if (one := children[tag]) is not None:
            attributes[attribute] = one.text
    new = [one for tag in ("pose", "static") if (one := children[tag]) is not None]
    tags = {one.tag for one in new}
    rest = [child for child in model.children if child.tag not in tags]
    return replace(model, attributes=attributes, children=[*new, *rest, *include.all("plugin")])


def _merged(model: Element) -> Iterator[Element]:
    """Yield the parts of a model as parts of the one that includes it, with a frame in place of its own."""
    frame = f"_merged__{model.attributes.get('name', '')}__{MODEL}"
    canonical = next((link.attributes.get("name", "") for link in model.all("link")), "")
    poses = [*model.all("pose")]
    yield Element("frame", {"name": frame}, model.line, poses, file=model.file)
    for child in model.children:
        if child.tag in ("link", "model", "frame") and "attached_to" not in child.attributes:
            child = _within(child, frame)
        if child.tag == "frame" and "attached_to" not in child.attributes:
            child = replace(child, attributes={**child.attributes, "attached_to": canonical})
        if child.tag not in ("pose", "static"):
            yield _renamed(child, frame)


def _within(part: Element, frame: str) -> Element:
    """Return a part with its pose in a frame, unless it names another one."""
    poses = [*part.all("pose")] or [Element("pose", {}, part.line, pieces=["0 0 0 0 0 0"], file=part.file)]
    moved = [replace(pose, attributes={"relative_to": frame, **pose.attributes}) for pose in poses]
    return replace(part, children=[*moved, *(child for child in part.children if child.tag != "pose")])


def _renamed(part: Element, frame: str) -> Element:
    """Return a part that refers to the frame where it referred to that of its model."""
    attributes = {name: frame if value == MODEL else value for name, value in part.attributes.items()}
    children = [_renamed(child, frame) for child in part.children]
    return replace(
        part, attributes=attributes, children=children, pieces=[frame] if part.text == MODEL else part.pieces
    )
