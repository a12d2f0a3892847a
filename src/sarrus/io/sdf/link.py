"""A <link> of an SDF file: its inertia and its visuals."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...model.errors import ModelError
from ..robot import Inertial, Link, Visual
from ..xml.element import Element
from .models import Part
from .values import number, pose_of, vector

ENTRIES = {
    "ixx": 1.0,
    "ixy": 0.0,
    "ixz": 0.0,
    "iyy": 1.0,
    "iyz": 0.0,
    "izz": 1.0,
}  # with those of a link without any
SIZES = {
    "box": ("size",),
    "cylinder": ("radius", "length"),
    "capsule": ("radius", "length"),
    "sphere": ("radius",),
    "ellipsoid": ("radii",),
    "mesh": ("scale",),
}


def read_link(part: Part, name: str) -> Link:
    """Return a link; one without <inertial> has a mass of 1 kg and moments of 1 kg m², as the format defines."""
    reader = part.reader
    element = reader.one(part.element, "inertial") or Element("inertial", {}, part.element.line)
    if element.attributes.get("auto", "false").lower() in ("true", "1"):
        message = "has an inertia to be computed from its shapes. Give <mass> and <inertia>, and remove auto."
        raise reader.refusal(message, element.line)
    mass = number(element, "mass", reader, 1.0)
    if mass < 0:
        raise reader.refusal(f"<mass> must not be negative, but is {mass:g}. Give it in kg.", element.line)
    tensor = reader.one(element, "inertia") or Element("inertia", {}, element.line)
    xx, xy, xz, yy, yz, zz = (number(tensor, tag, reader, one) for tag, one in ENTRIES.items())
    J = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return Link(name, Inertial(mass, np.zeros(3), J).seen_from(pose_of(element, reader)), part.element.line)


def read_visuals(part: Part, name: str, notes: list[str]) -> Iterator[Visual]:
    """Yield what a link looks like; unknown shapes are left out, and wrong ones with a note."""
    for visual in part.element.all("visual"):
        for shape in (s for geometry in visual.all("geometry") for s in geometry.children if s.tag in SIZES):
            try:
                yield _visual(visual, shape, name, part)
            except ModelError as error:
                notes.append(
                    f"a visual of {part.reader.part} is left out, line {shape.line}: {error.message}"
                )


def _visual(visual: Element, shape: Element, name: str, part: Part) -> Visual:
    reader = part.reader
    file = reader.needed(shape, "uri", "<uri>meshes/arm.stl</uri>").text if shape.tag == "mesh" else ""
    size: list[float] = []
    for tag in SIZES[shape.tag]:
        wide = tag in ("size", "scale", "radii")
        default = 0.5 if (shape.tag, tag) == ("capsule", "radius") else 1.0
        size += [*vector(shape, tag, reader, (1.0,) * 3)] if wide else [number(shape, tag, reader, default)]
    return Visual(
        name, shape.tag, tuple(map(float, size)), pose_of(visual, reader), file, _color(visual, part)
    )


def _color(visual: Element, part: Part) -> tuple[float, ...]:
    for material in visual.all("material"):
        color = part.reader.one(material, "diffuse")
        if color is not None:
            return tuple(part.reader.content(color, len(color.text.split())))
    return ()
