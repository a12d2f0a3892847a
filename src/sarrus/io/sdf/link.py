"""A <link> of an SDF file: its inertia and its visuals."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from ...model.bodies import solids
from ..robot import Inertia, Link, Visual
from ..robot.description import combined
from ..xml.element import Element
from ..xml.reader import read_shapes
from .frames import number, pose_of, vector
from .models import Part

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
WATER = 1000.0  # [kg/m³] the density of the format where none is given
SOLIDS: dict[str, Callable[..., solids.Uniform]] = {
    "box": lambda x, y, z, density: solids.box((x, y, z), None, density),
    "cylinder": lambda radius, length, density: solids.cylinder(radius, length, "z", 0.0, None, density),
    "capsule": lambda radius, length, density: solids.capsule(radius, length, None, density),
    "sphere": lambda radius, density: solids.sphere(radius, None, density),
    "ellipsoid": lambda x, y, z, density: solids.ellipsoid((x, y, z), None, density),
}


def read_link(part: Part, name: str) -> Link:
    """Return a link; one without <inertial> has a mass of 1 kg and moments of 1 kg m², as the format defines."""
    reader = part.reader
    element = reader.one(part.element, "inertial") or Element("inertial", {}, part.element.line)
    if element.attributes.get("auto", "false").lower() in ("true", "1"):
        return Link(name, _automatic(part, element), part.element.line)
    mass = number(element, "mass", reader, 1.0)
    if mass < 0:
        raise reader.refusal(f"<mass> must not be negative, but is {mass:g}. Give it in kg.", element.line)
    tensor = reader.one(element, "inertia") or Element("inertia", {}, element.line)
    xx, xy, xz, yy, yz, zz = (number(tensor, tag, reader, default) for tag, default in ENTRIES.items())
    J = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return Link(name, Inertia(mass, np.zeros(3), J).seen_from(pose_of(element, reader)), part.element.line)


def _automatic(part: Part, element: Element) -> Inertia:
    """Return the inertial of the collision shapes, whose density is their own, that of the link, or water's."""
    reader, inertials = part.reader, list[Inertia]()
    surplus = reader.one(element, "mass") or reader.one(element, "inertia")
    if surplus is not None:
        message = f"has <{surplus.tag}> beside an inertial that is computed. Remove one of them."
        raise reader.refusal(message, surplus.line)
    density = number(element, "density", reader, WATER)
    for collision in part.element.all("collision"):
        own = number(collision, "density", reader, density)
        for shape in (s for geometry in collision.all("geometry") for s in geometry.children):
            if shape.tag not in SOLIDS:
                message = f"has a {shape.tag} from which no inertia is computed. Give <mass> and <inertia>."
                raise reader.refusal(message, shape.line)
            with reader.placed(shape.line):
                solid = SOLIDS[shape.tag](*_size(shape, part), own)
            tensor = np.asarray(solid.inertia, dtype=float)
            tensor = np.diag(tensor) if tensor.ndim == 1 else tensor
            inertials.append(Inertia(solid.mass, np.zeros(3), tensor).seen_from(pose_of(collision, reader)))
    if not inertials:
        raise reader.refusal(
            "has no <collision> to compute its inertial from. Give <mass> and <inertia>.", element.line
        )
    return combined(inertials)


def _size(shape: Element, part: Part) -> list[float]:
    """The numbers of a shape in the order of `SIZES`, three for each direction."""
    size: list[float] = []
    for tag in SIZES[shape.tag]:
        wide = tag in ("size", "scale", "radii")
        default = 0.5 if (shape.tag, tag) == ("capsule", "radius") else 1.0
        reader = part.reader
        size += [*vector(shape, tag, reader, (1.0,) * 3)] if wide else [number(shape, tag, reader, default)]
    return size


def read_visuals(part: Part, name: str, notes: list[str]) -> Iterator[Visual]:
    """Return what a link looks like; unknown shapes are left out, and wrong ones with a note."""
    return read_shapes(part.element, part.reader, SIZES, partial(_visual, name, part), notes)


def _visual(name: str, part: Part, visual: Element, shape: Element) -> Visual:
    reader = part.reader
    file = reader.needed(shape, "uri", "<uri>meshes/arm.stl</uri>").text if shape.tag == "mesh" else ""
    size = tuple(map(float, _size(shape, part)))
    return Visual(name, shape.tag, size, pose_of(visual, reader), file, _color(visual, part))


def _color(visual: Element, part: Part) -> tuple[float, ...]:
    for material in visual.all("material"):
        color = part.reader.one(material, "diffuse")
        if color is not None:
            return tuple(part.reader.content(color, len(color.text.split())))
    return ()
