"""Geometrically exact beam between two bodies: section, material and initial shape of one element."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from math import pi
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np

from ... import elements
from ...functions import tanh
from ..errors import ModelError
from ..geometry import rotation
from ..geometry.placement import points_apart
from ..geometry.points import GROUND, PERPENDICULAR, LocalPoint, Point
from ..geometry.pose import Poses
from ..measure import Direction, In, Length, Ratio
from ..parity import declared
from ..primitive import Primitive
from ..quantity import Array, Vec3, direction, not_negative, number, numbers, positive, triple
from . import beam_element
from .force import Force

ODD_FIFTH = 1.0045237627951383  # Σ 1/n⁵ over odd n, 31/32 ζ(5)


class SectionProperties(NamedTuple):
    """Area [m²], second moments [m⁴], torsion constant [m⁴] and factors of the shear areas [-]; 0 for no shear."""

    area: float
    I_y: float
    I_z: float
    J: float
    shear: tuple[float, float]


def rectangle(width: float, height: float, nu: float) -> SectionProperties:
    """Width along y, height along z."""
    k = 10 * (1 + nu) / (12 + 11 * nu)
    a, b = (width, height) if width > height else (height, width)
    series = ODD_FIFTH + sum((tanh(n * pi / 2 * a / b) - 1) / n**5 for n in range(1, 13, 2))
    J = a * b**3 * (1 / 3 - 64 / pi**5 * (b / a) * series)  # Saint-Venant, to round-off
    return SectionProperties(width * height, width * height**3 / 12, height * width**3 / 12, J, (k, k))


def tube(radius: float, inner: float, nu: float) -> SectionProperties:
    """Circle with a concentric hole, which may be 0; shear factors of Cowper (J. Appl. Mech. 33, 1966)."""
    ratio = inner / radius
    q = (1 + ratio**2) ** 2
    k = 6 * (1 + nu) * q / ((7 + 6 * nu) * q + (20 + 12 * nu) * ratio**2)
    inertia = pi / 4 * (radius**4 - inner**4)
    return SectionProperties(pi * (radius**2 - inner**2), inertia, inertia, 2 * inertia, (k, k))


def i_section(width: float, height: float, flange: float, web: float, nu: float) -> SectionProperties:
    """Flanges along y, web along z; torsion of thin walls, shear forces in flanges and web."""
    inside = height - 2 * flange
    area = 2 * width * flange + inside * web
    I_y = (width * height**3 - (width - web) * inside**3) / 12
    I_z = (2 * flange * width**3 + inside * web**3) / 12
    J = (2 * width * flange**3 + inside * web**3) / 3
    return SectionProperties(area, I_y, I_z, J, (5 / 3 * width * flange / area, inside * web / area))


@dataclass(frozen=True, eq=False, kw_only=True)
class BeamSection:
    """Material and cross section of a beam.

    Parameters
    ----------
    E
        Young's modulus [N/m²].
    nu, G
        Poisson's ratio, or the shear modulus [N/m²].
    density
        [kg/m³]; 0 for a beam without mass.
    rectangle
        Width along y and height along z of the section [m].
    circle
        Radius [m].
    tube
        Outer and inner radius [m].
    i_section
        Width along y, height along z, thickness of the flanges and of the web [m].
    area, I_y, I_z, J
        Instead of a shape: area [m²], second moments of bending about y and z [m⁴], torsion constant [m⁴].
    shear
        Factors k of the shear areas k A along y and z. Left out, those of the shape; for a section by values, the beam
        does not shear.
    damping
        Stiffness-proportional damping [s]: a vibration of frequency ω has the damping ratio ω damping/2.
    """

    E: Annotated[float, In("N/m^2")]
    nu: Ratio | None = None
    G: Annotated[float, In("N/m^2")] | None = None
    density: Annotated[float, In("kg/m^3")] = 0.0
    rectangle: Annotated[Sequence[float], In("m")] | None = None
    circle: Length | None = None
    tube: Annotated[Sequence[float], In("m")] | None = None
    i_section: Annotated[Sequence[float], In("m")] | None = None
    area: Annotated[float, In("m^2")] | None = None
    I_y: Annotated[float, In("m^4")] | None = None
    I_z: Annotated[float, In("m^4")] | None = None
    J: Annotated[float, In("m^4")] | None = None
    shear: Annotated[Sequence[float], In("1")] | None = None
    damping: Annotated[float, In("s")] = 0.0

    def moduli(self) -> tuple[float, float, float]:
        """Return E, G and ν, checked."""
        E = positive(self.E, "E", "Give Young's modulus in N/m², such as 210e9 for steel.")
        if (self.nu is None) == (self.G is None):
            raise ModelError("needs one of nu and G. Give Poisson's ratio, such as nu=0.3, or G.", field="nu")
        if self.nu is None:
            G = positive(self.G, "G", "Give the shear modulus in N/m², such as 81e9 for steel.")
            return E, G, E / (2 * G) - 1
        nu = number(self.nu, "nu", "Give Poisson's ratio, such as 0.3.")
        if not -1 < nu <= 0.5:
            raise ModelError(
                f"nu is {nu:g}, but Poisson's ratio is between -1 and 0.5. Give 0.3 for steel.", field="nu"
            )
        return E, E / (2 * (1 + nu)), nu

    def properties(self, nu: float) -> SectionProperties:
        """Return the properties of the section, checked."""
        shapes: dict[str, Callable[[float], SectionProperties]] = {
            "rectangle": lambda nu: rectangle(*_sizes(self.rectangle, 2, "rectangle") + (nu,)),
            "circle": lambda nu: tube(positive(self.circle, "circle", "Give the radius in m."), 0.0, nu),
            "tube": lambda nu: tube(*_inside("tube", _sizes(self.tube, 2, "tube"), (1, 1.0, 0)) + (nu,)),
            "i_section": lambda nu: i_section(
                *_inside("i_section", _sizes(self.i_section, 4, "i_section"), (2, 2.0, 1), (3, 1.0, 0))
                + (nu,)
            ),
        }
        given = [name for name in (*shapes, "area") if getattr(self, name) is not None]
        if len(given) != 1:
            what = f"has {' and '.join(given)}" if given else "its section is missing"
            raise ModelError(
                f"{what}. Give one of rectangle, circle, tube and i_section, or area, I_y, I_z and J.",
                field="rectangle",
            )
        found = shapes[given[0]](nu) if given[0] in shapes else self._values()
        if self.shear is None:
            return found
        k_y, k_z = _sizes(self.shear, 2, "shear")
        return found._replace(shear=(k_y, k_z))

    def section_area(self) -> float:
        """Return the area of the section [m²]."""
        return self.properties(self.moduli()[2]).area

    def _values(self) -> SectionProperties:
        area, I_y, I_z, J = (
            positive(getattr(self, name), name, "Give area in m², I_y, I_z and J in m⁴.")
            for name in ("area", "I_y", "I_z", "J")
        )
        return SectionProperties(area, I_y, I_z, J, (0.0, 0.0))

    def stiffness(self, length: float) -> tuple[float, ...]:
        """Return C of an element of this length, with the residual bending flexibility."""
        E, G, nu = self.moduli()
        A, I_y, I_z, J, (k_y, k_z) = self.properties(nu)
        S_y, S_z = (
            1 / ((1 / (k * G * A) if k else 0.0) + length**2 / (12 * E * bending))
            for k, bending in ((k_y, I_z), (k_z, I_y))
        )
        return E * A, S_y, S_z, G * J, E * I_y, E * I_z


def _sizes(value: Any, count: int, field: str) -> Any:
    found = numbers(value, count, field, f"Give {count} numbers greater than 0.")
    return tuple(positive(one, field, f"Give {count} numbers greater than 0.") for one in found)


def _inside(field: str, sizes: Any, *pairs: tuple[int, float, int]) -> Any:
    """Return the sizes, or raise a ModelError where one of them does not leave material within another."""
    for inner, times, outer in pairs:
        if times * sizes[inner] >= sizes[outer]:
            raise ModelError(
                f"{field} has {sizes[inner]:g} m within {sizes[outer]:g} m. Give the outer sizes first.",
                field=field,
            )
    return sizes


class End(NamedTuple):
    """An end of a beam: its point, its position, and the axes of the section in the body as columns."""

    point: LocalPoint
    axes: Array

    def parameters(self) -> tuple[Vec3, float, Vec3]:
        """The point, and the Euler parameters of the section in the body, the first one apart."""
        e_0, *e = rotation.parameters(self.axes)
        return self.point.s, e_0, triple(np.array(e))

    def tensor(self, I_y: float, I_z: float) -> tuple[float, ...]:
        """Entries of diag(I_y + I_z, I_y, I_z) in body axes."""
        J = self.axes @ np.diag(np.array([I_y + I_z, I_y, I_z], dtype=object)) @ self.axes.T
        return tuple(J[a, b] for a, b in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))


@dataclass(frozen=True, eq=False)
class Beam(BeamSection, Force):
    """Elastic beam of large displacements and rotations between two points of bodies.

    It is undeformed in the design position, and exact for small deformations by loads at its ends. Where rotations are
    large, or frequencies of a massive beam matter, use several with bodies between them.

    Parameters
    ----------
    point_i, point_j
        The ends.
    tangent_i, tangent_j
        Global directions of the beam at its ends in the design position, for a curved beam. Left out, the beam is
        straight.
    up
        Global direction of the section's z axis in the design position, as far as it is across the beam. Left out, it
        is the global z axis; for a beam along it, the y axis.

    Notes
    -----
    Outputs: ``section_force``, ``moment``, ``strain`` and ``curvature`` in the middle, in axes of the section, x along
    the beam: ``rod.moment.z`` is the bending moment about the section's z axis.
    """

    parity: ClassVar[Any] = declared(tangent_i="polar", tangent_j="polar", up="polar")

    point_i: Point
    point_j: Point
    tangent_i: Direction | None = field(default=None, kw_only=True)
    tangent_j: Direction | None = field(default=None, kw_only=True)
    up: Direction | None = field(default=None, kw_only=True)

    def ends(self, poses: Poses) -> tuple[End, End]:
        """Return both ends."""
        points = points_apart(self.point_i, self.point_j, poses)
        chord = points.j.position(poses) - points.i.position(poses)
        chord = chord / np.linalg.norm(chord)
        ends = []
        for point, name in ((points.i, "tangent_i"), (points.j, "tangent_j")):
            given = getattr(self, name)
            along = chord if given is None else direction(given, name)
            if along @ chord <= 0:
                raise ModelError(
                    f"{name} points away from the beam. Give the direction from point_i to point_j, and use several "
                    "beams for a large arc.",
                    field=name,
                )
            axes = np.column_stack(self._section_axes(along))
            ends.append(End(point, poses[point.body].A.T @ axes))
        return ends[0], ends[1]

    def _section_axes(self, along: Array) -> tuple[Array, Array, Array]:
        choices = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]] if self.up is None else [direction(self.up, "up")]
        for up in map(np.array, choices):
            across = up - (up @ along) * along
            if (size := np.linalg.norm(across)) > PERPENDICULAR:
                z = across / size
                return along, np.cross(z, along), z
        raise ModelError("up is along the beam. Give a direction across it.", field="up")

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        i, j = self.ends(poses)
        bodies, frames = (i.point.body, j.point.body), (*i.parameters(), *j.parameters())
        size, strain = initial_shape(frames, bodies, poses)
        stiffness = self.stiffness(size)
        yield Primitive(beam_element.Beam, bodies, (*frames, size, stiffness, strain), "beam")
        damping = not_negative(self.damping, "damping", "Give a time in s.")
        if damping:
            yield Primitive(beam_element.BeamDamping, bodies, (*frames, size, stiffness, damping), "damping")
        if mass := self.mass(size):
            _, I_y, I_z, *_ = self.properties(self.moduli()[2])
            values = (i.point.s, triple(i.axes[:, 0]), j.point.s, triple(j.axes[:, 0]), size, mass)
            yield Primitive(beam_element.BeamInertia, bodies, values, "mass")
            for end in (i, j):
                if end.point.body != GROUND:
                    half = self.density * size / 2
                    tensor = end.tensor(half * I_y, half * I_z)
                    yield Primitive(elements.RigidInertia, (end.point.body,), (0.0, tensor), "rotary inertia")

    def mass(self, length: float) -> float:
        """Return the mass of a beam of this length [kg]."""
        return not_negative(self.density, "density", "Give it in kg/m³.") * self.section_area() * length

    def weight(self, poses: Poses, gravity: Vec3) -> Iterator[Primitive]:
        """Yield the weight of its consistent mass, two halves at s ± L e/6: -m gᵀ(6 x_i + L t_i + 6 x_j - L t_j)/12."""
        i, j = self.ends(poses)
        size, _ = initial_shape((*i.parameters(), *j.parameters()), (i.point.body, j.point.body), poses)
        if mass := self.mass(size):
            for end, side in ((i, 1), (j, -1)):
                center = triple(np.array(end.point.s) + side * size / 6 * end.axes[:, 0])
                if end.point.body != GROUND:
                    yield Primitive(
                        elements.EccentricGravity, (end.point.body,), (mass / 2, center, gravity), "gravity"
                    )


def initial_shape(
    frames: tuple[Any, ...], bodies: tuple[str, str], poses: Poses
) -> tuple[float, tuple[float, ...]]:
    """Return the length of the undeformed arc in the design position [m], and its strains ε_0."""
    i, j = (poses[body] for body in bodies)
    values: Any = [np.array(one) if isinstance(one, tuple) else one for one in frames]
    values += [1.0, np.zeros(6), np.zeros(6)]
    beam = beam_element.Beam(*values)
    arc, k = beam.arc(elements.Pair(i.r, i.p, j.r, j.p))
    size = np.sqrt(arc @ arc)
    strain = [*(arc / size - np.array([1.0, 0.0, 0.0])), *(k / size)]
    return size, tuple(strain)
