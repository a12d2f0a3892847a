"""Mass and inertia of uniform solids: boxes, cylinders, spheres, rods, and meshes by trimesh.

Inertias are about the centre of mass, in the axes in which the solid is described.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...algebra import Array
from ..errors import ModelError
from ..quantity import Vec3, Vector, direction, is_list, number, positive, vector
from .mesh_file import read_scene

AXES = ("x", "y", "z")
SLENDER = 40  # length of a rod over its radius, where none is given


class Uniform(NamedTuple):
    """Mass [kg], inertia about the centre of mass [kg m²], and the centre of mass [m]."""

    mass: float
    inertia: Array | Sequence[float]
    center: Vec3 = (0.0, 0.0, 0.0)


def mass_of(volume: float, mass: float | None, density: float | None) -> float:
    """The mass of a solid, of which either the mass or the density is given.

    Raises
    ------
    ModelError
        If both are given, or none.
    """
    if (mass is None) == (density is None):
        raise ModelError(
            "mass or density must be given, and only one of them. Give mass= in kg.", field="mass"
        )
    if density is None:
        return positive(mass, "mass", "Give the mass in kg.")
    return positive(density, "density", "Give the density in kg/m³, as 7850 for steel.") * volume


def _length(value: float, field: str) -> float:
    return positive(value, field, "Give a length in m.")


def box(size: Vector, mass: float | None, density: float | None) -> Uniform:
    """Return the properties of a box with edges along x, y and z."""
    x, y, z = (positive(edge, "size", "Give three lengths in m.") for edge in vector(size, "size"))
    m = mass_of(x * y * z, mass, density)
    return Uniform(m, tuple(m / 12 * sum_of for sum_of in (y * y + z * z, z * z + x * x, x * x + y * y)))


def cylinder(
    radius: float, length: float, axis: str, inner_radius: float, mass: float | None, density: float | None
) -> Uniform:
    """Return the properties of a cylinder, hollow with an inner radius."""
    if axis not in AXES:
        raise ModelError(
            f"axis must be x, y or z, but is {axis!r}. Turn the body by its orientation.", field="axis"
        )
    r, l = _length(radius, "radius"), _length(length, "length")
    hole = number(inner_radius, "inner_radius")
    if not 0 <= hole < r:
        raise ModelError(
            f"inner_radius must be at least 0 and less than the radius {r:g}, but is {hole:g}. Give 0 for a solid one.",
            field="inner_radius",
        )
    m = mass_of(np.pi * (r * r - hole * hole) * l, mass, density)
    along, across = m / 2 * (r * r + hole * hole), m / 12 * (3 * (r * r + hole * hole) + l * l)
    return Uniform(m, tuple(along if own == axis else across for own in AXES))


def capsule(radius: float, length: float, mass: float | None, density: float | None) -> Uniform:
    """Return the properties of a cylinder about z with a half ball on each end, which the length does not contain."""
    r, l = _length(radius, "radius"), _length(length, "length")
    m = mass_of(np.pi * r * r * (l + 4 / 3 * r), mass, density)
    middle, ends = m * l / (l + 4 / 3 * r), m * 4 / 3 * r / (l + 4 / 3 * r)
    across = middle * (r * r / 4 + l * l / 12) + ends * (0.4 * r * r + l * l / 4 + 3 / 8 * l * r)
    return Uniform(m, (across, across, (middle / 2 + 0.4 * ends) * r * r))


def ellipsoid(radii: Vector, mass: float | None, density: float | None) -> Uniform:
    """Return the properties of an ellipsoid with half axes along x, y and z."""
    x, y, z = (positive(one, "radii", "Give three lengths in m.") for one in vector(radii, "radii"))
    m = mass_of(4 / 3 * np.pi * x * y * z, mass, density)
    return Uniform(m, tuple(m / 5 * sum_of for sum_of in (y * y + z * z, z * z + x * x, x * x + y * y)))


def sphere(radius: float, mass: float | None, density: float | None) -> Uniform:
    """Return the properties of a ball."""
    r = _length(radius, "radius")
    m = mass_of(4 / 3 * np.pi * r**3, mass, density)
    return Uniform(m, (0.4 * m * r * r,) * 3)


def rod(
    start: Vector, end: Vector, radius: float | None, mass: float | None, density: float | None
) -> Uniform:
    """Return the properties of a round rod between two points, in global axes about its middle."""
    first, last = np.array(vector(start, "start")), np.array(vector(end, "end"))
    if np.array_equal(first, last):
        raise ModelError("start and end are the same point. Give two points in m.", field="end")
    u, l = direction(last - first, "end"), float(np.linalg.norm(last - first))
    r = l / SLENDER if radius is None else _length(radius, "radius")
    m = mass_of(np.pi * r * r * l, mass, density)
    along, across = m / 2 * r * r, m / 12 * (3 * r * r + l * l)
    x, y, z = (float(number) for number in (first + last) / 2)
    return Uniform(m, across * np.eye(3) + (along - across) * np.outer(u, u), (x, y, z))


def frame(
    points: Sequence[Vector], radius: float | None, closed: bool, mass: float | None, density: float | None
) -> Uniform:
    """Return the properties of round rods from point to point, in global axes about their common centre of mass."""
    if not is_list(points) or len(points) < 2:
        raise ModelError(
            "points must be two or more points. Give a list, as [(0, 0, 0), (1, 0, 0)].", field="points"
        )
    ends = [np.array(vector(point, "points")) for point in points]
    pairs = list(pairwise([*ends, ends[0]] if closed else ends))
    lengths = [float(np.linalg.norm(b - a)) for a, b in pairs]
    if not min(lengths):
        raise ModelError("points has the same point twice in a row. Remove one.", field="points")
    width = sum(lengths) / SLENDER if radius is None else radius
    whole = mass_of(np.pi * _length(width, "radius") ** 2 * sum(lengths), mass, density)
    rods = [
        rod(a, b, width, whole * l / sum(lengths), None) for (a, b), l in zip(pairs, lengths, strict=True)
    ]
    center = np.sum([one.mass * np.array(one.center) for one in rods], axis=0) / whole
    inertia = np.zeros((3, 3))
    for one in rods:
        d = np.array(one.center) - center
        inertia += np.asarray(one.inertia) + one.mass * (d @ d * np.eye(3) - np.outer(d, d))
    x, y, z = (float(number) for number in center)
    return Uniform(whole, inertia, (x, y, z))


def mesh(file: str | Path, scale: float, mass: float | None, density: float | None) -> Uniform:
    """Return the properties of the inside of a closed mesh, in its own axes; needs the extra `mesh`.

    Raises
    ------
    MeshError
        For a file that cannot be read, or if trimesh is not installed.
    ModelError
        For a mesh with holes, or without an inside.
    """
    found = read_scene(Path(file)).to_mesh()
    found.merge_vertices(merge_tex=True, merge_norm=True)
    found.apply_scale(
        positive(scale, "scale", "Give what the mesh's numbers are multiplied by to give metres.")
    )
    if not found.is_watertight or not found.volume > 0:
        raise ModelError(
            f"{file} is no closed mesh with faces that look outwards, so that it has no volume. Repair it, or give "
            "mass and inertia."
        )
    m = mass_of(float(found.volume), mass, density)
    found.density = m / found.volume
    x, y, z = (float(number) for number in found.center_mass)
    return Uniform(m, np.array(found.moment_inertia), (x, y, z))
