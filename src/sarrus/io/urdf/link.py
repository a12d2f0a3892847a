"""A <link>: its inertia and its visuals."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial

import numpy as np

from ...model.geometry.pose import Pose
from ..robot import Inertia, Link, Visual
from ..xml.element import Element
from ..xml.reader import Reader, read_shapes

CHILDREN = ("inertial", "visual", "collision")
ENTRIES = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
SIZES = {
    "box": ("size",),
    "cylinder": ("radius", "length"),
    "capsule": ("radius", "length"),
    "sphere": ("radius",),
    "mesh": (),
}


def read_link(element: Element, name: str, reader: Reader) -> Link:
    """Return a link; one without <inertial> has no mass."""
    reader.check(element, ("name", "type"), CHILDREN)
    inertial = reader.one(element, "inertial")
    return Link(name, None if inertial is None else _inertial(inertial, reader), element.line)


def colors_of(root: Element, reader: Reader) -> dict[str, tuple[float, ...]]:
    """Return the colors of the materials that a robot declares, by name."""
    return {m.attributes.get("name", ""): c for m in root.all("material") if (c := _own_color(m, reader))}


def read_visuals(
    element: Element, name: str, reader: Reader, colors: Mapping[str, tuple[float, ...]], notes: list[str]
) -> Iterator[Visual]:
    """Return what a link looks like; unknown shapes are left out, and wrong ones with a note."""
    return read_shapes(element, reader, SIZES, partial(_visual, name, reader, colors), notes)


def _visual(
    name: str, reader: Reader, colors: Mapping[str, tuple[float, ...]], visual: Element, shape: Element
) -> Visual:
    file = reader.text(shape, "filename") if shape.tag == "mesh" else ""
    pose, color = reader.pose(visual), _color(visual, reader, colors)
    return Visual(name, shape.tag, _size(shape, reader), pose, file, color)


def _inertial(element: Element, reader: Reader) -> Inertia:
    reader.check(element, (), ("origin", "mass", "inertia"))
    mass = reader.needed(element, "mass", '<mass value="1.5"/>')
    reader.check(mass, ("value",))
    value = reader.number(mass, "value")
    if value < 0:
        raise reader.refusal(f"<mass> must not be negative, but is {value:g}. Give it in kg.", mass.line)
    frame = reader.pose(element)
    inertia = reader.needed(element, "inertia", '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>')
    return _turned(value, _tensor(inertia, reader), frame)


def _tensor(element: Element, reader: Reader) -> list[list[float]]:
    reader.check(element, ENTRIES)
    xx, xy, xz, yy, yz, zz = (reader.number(element, entry) for entry in ENTRIES)
    return [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]


def _turned(mass: float, tensor: list[list[float]], frame: Pose) -> Inertia:
    return Inertia(mass, np.zeros(3), np.array(tensor)).seen_from(frame)


def _size(shape: Element, reader: Reader) -> tuple[float, ...]:
    if shape.tag == "box":
        return tuple(float(x) for x in reader.vector(shape, "size", (0.0, 0.0, 0.0)))
    if shape.tag == "mesh":
        count = 1 if len(shape.attributes.get("scale", "").split()) == 1 else 3
        scale = [float(x) for x in reader.vector(shape, "scale", (1.0,) * count)]
        return tuple(scale * (3 // count))
    return tuple(reader.number(shape, name) for name in SIZES[shape.tag])


def _color(visual: Element, reader: Reader, colors: Mapping[str, tuple[float, ...]]) -> tuple[float, ...]:
    """Return the color of a visual, its own or that of the material it names."""
    for material in visual.all("material"):
        return _own_color(material, reader) or colors.get(material.attributes.get("name", ""), ())
    return ()


def _own_color(material: Element, reader: Reader) -> tuple[float, ...]:
    color = reader.one(material, "color")
    return () if color is None else tuple(float(x) for x in reader.vector(color, "rgba", (0.0,) * 4))
