"""Characteristic length of a system: what displacements are compared with where they are added to rotations.

Metres and radians have no common unit. Analyses that need one norm for both divide displacements by a length of the
system itself, so that no verdict depends on the unit in which a model is written.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from ...algebra import Array
from ...linalg.rank import rows_of_entries, with_data
from ...model.coordinates import POSITION, WIDTH
from ...system import System
from ...system.cached import once, once_alike
from ...system.layout import Layout
from ...system.structure.population import Population

POINTS = {"s": 0, "center": 0, "s_i": 0, "s_j": 1}  # fields of elements that hold a point, and of which body
RADIUS = "radius"  # field of constraints of rolling bodies
SMALL = 0.01  # of the radius of gyration: a model has no dimensions below it
NEXT, LAST = np.array([[1, 2, 0], [2, 0, 1]])  # axes in cyclic order
LEAST_LEVER = 1e-6  # of the extent: lever arms below it are round-off of positions far from the origin


def extent(system: System, q: Array) -> float:
    """Largest distance along an axis between points of the model: origins, joint points, ends of springs [m].

    Without any two different points it is the radius of gyration, and 1 m without inertia.
    """
    points = np.concatenate([q[system.layout.positions].T, *_points(system, q)], axis=1)
    size, radius = float((points.max(axis=1) - points.min(axis=1)).max()), radius_of_gyration(system)
    return size if size > 1e-12 * max(float(abs(points).max()), radius) else radius or 1.0


def lever(system: System, q: Array, J: csr_array) -> float:
    """Largest lever arm of the constraints at a position: gradient by rotation over gradient by displacement [m]."""
    size, (by_p, by_r) = extent(system, q), _norms(J, system.layout)
    arms = 0.5 * by_p[by_r > 0] / by_r[by_r > 0]
    return float(max(arms.max(initial=0.0), LEAST_LEVER * size))


def units(system: System, q: Array, J: csr_array) -> Array:
    """The unit of each coordinate at a position: the largest lever arm for displacements (nq,)."""
    return system.layout.scales(lever(system, q, J))


def unit_displacement(system: System, q: Array) -> float:
    """Displacement that counts like 1 in p, which is 2 rad: twice the root mean square of the model's dimensions [m].

    Unlike the extent, it is a smooth function of the parameters and coordinates, so that derivatives can take it into
    account. Of a model without dimensions it is twice the radius of gyration, and 1 m without inertia.
    """
    size, number = float(np.linalg.norm(dimensions_at(system, q))), dimensions(system).number
    return 2 * size / np.sqrt(number) if size else 2 * radius_of_gyration(system) or 1.0


def dimensions_at(system: System, q: Array) -> Array:
    """The model's dimensions in their places among b and q (len(b) + nq,); zeros if they are small.

    Concentric bodies that are off their common point by round-off, or by an error of the estimate, have no dimensions.
    Displacements and rotations are then nearly independent of each other, and of the unit with which both are compared.
    """
    own = dimensions(system)
    found = own.of(system.b, q)
    least = SMALL * radius_of_gyration(system) * np.sqrt(own.number)
    return np.asarray(found if np.linalg.norm(found) > least else 0 * found)


class Dimensions(NamedTuple):
    """Places among the parameters and coordinates of what the size of a model follows from.

    Attributes
    ----------
    arms : among the parameters, of points of bodies, relative to the origins of these, and of radii of rolling bodies
    ground : among the parameters, of points on the ground (count, 3)
    origins : among the coordinates, of the origins of bodies (count, 3)
    number : of all of these
    """

    arms: Array
    ground: Array
    origins: Array
    number: int

    def of(self, b: Array, q: Array) -> Array:
        """Lever arms, and points relative to their mean, in their places; zeros in the others (len(b) + nq,)."""
        given = np.concatenate([b, q])
        found, at = np.zeros(len(given)), np.concatenate([self.ground, len(b) + self.origins])
        found[self.arms], found[at] = given[self.arms], given[at] - given[at].mean(axis=0)
        return found


@once_alike
def dimensions(system: System) -> Dimensions:
    """Places of the dimensions of a model."""
    fixed, moving, _ = _places(system)
    rolling = [p for p in system.populations if p.count and p.kind.rows and RADIUS in p.kind.fields]
    radii = np.concatenate([np.zeros(0, dtype=np.int64), *(first_places(p, RADIUS) for p in rolling)])
    origins = system.layout.positions
    number = len(moving) + len(radii) + len(fixed) + len(origins)
    return Dimensions(np.append(moving, radii), fixed, origins, number)


@once
def kinematic_weights(system: System) -> Array:
    """W of W (q' - v) + Φ_qᵀμ = 0, displacements in the extent of the system (nq,) [1/m², 1].

    With the unit matrix in their place, by how much μ moves r and p would depend on the unit of length.
    """
    return system.layout.scales(extent(system, system.q0) ** -2.0)


def row_sizes(J: csr_array, layout: Layout, length: float) -> Array:
    """Return the change of each equation for a displacement by the length, or for a rotation."""
    by_p, by_r = _norms(J, layout)
    sizes = np.where(by_r > 0, length * by_r, by_p)
    return np.where(sizes > 0, sizes, 1.0)


def _norms(J: csr_array, layout: Layout) -> tuple[Array, Array]:
    """The norms of each row's derivatives by Euler parameters, and by displacements (m,)."""
    place = 2 * rows_of_entries(J) + layout.is_length[J.indices]
    by_p, by_r = np.sqrt(np.bincount(place, J.data**2, 2 * J.shape[0])).reshape(-1, 2).T
    return by_p, by_r


def scaled(J: csr_array, unit: Array) -> csr_array:
    """J by coordinates that are measured in these units (nq,)."""
    return with_data(J, J.data * unit[J.indices])


def _points(system: System, q: Array) -> tuple[Array, Array]:
    """Points of elements in global axes, on the ground and on bodies (3, count)."""
    fixed, moving, firsts = _places(system)
    x, s = q[firsts + np.arange(WIDTH)[:, None]], system.b[moving.T]
    e0, e_next, e_last = x[POSITION], x[POSITION + 1 + NEXT], x[POSITION + 1 + LAST]
    d = e_next * s[LAST] - e_last * s[NEXT] + e0 * s
    return system.b[fixed.T], x[:POSITION] + s + 2 * (e_next * d[LAST] - e_last * d[NEXT])


@once_alike
def _places(system: System) -> tuple[Array, Array, Array]:
    """Places (count, 3) among the parameters of points on the ground and of others, and the firsts of their bodies."""
    found = list(_fields(system))
    none = np.zeros((0, 3), dtype=np.int64)
    fixed = [none, *(at for at, bodies in found if bodies is None)]
    moving = [none, *(at for at, bodies in found if bodies is not None)]
    of = [none[:, 0], *(bodies for _, bodies in found if bodies is not None)]
    return np.concatenate(fixed), np.concatenate(moving), np.concatenate(of)


def first_places(p: Population, name: str) -> Array:
    """Places in `b` of the first number of a field (count,)."""
    starts = dict(zip(p.kind.fields, np.cumsum([0, *p.kind.widths()]), strict=False))
    return np.asarray(p.at + starts[name] + p.kind.size() * np.arange(p.count))


def _fields(system: System) -> Iterator[tuple[Array, Array | None]]:
    """Yield the places of points (count, 3), and where their bodies begin but for the ground."""
    for p in system.populations:
        bodies = [slot for n, slot in enumerate(p.variant.slots) if p.kind.is_body(n)]
        if p.count and len(bodies) <= 2:
            for name, side in POINTS.items():
                if p.kind.fields.get(name) == "Vec3" and side < len(bodies):
                    slot = bodies[side]
                    at = first_places(p, name)[:, None] + np.arange(3)
                    yield at, None if slot < 0 else p.bodies[:, slot]


@once
def radius_of_gyration(system: System) -> float:
    """The largest of all bodies, which does not depend on the position; 0 without inertia [m]."""
    inertia, layout = system.M(system.q0).diagonal(), system.layout.bodies
    mass, turning = inertia[layout.positions[:, 0]], inertia[layout.rotations]
    heavy = mass > 0
    squares = turning[heavy].sum(axis=1) / (12 * mass[heavy])  # the trace of 4 GᵀJG is 4 tr J
    return float(np.sqrt(squares.max(initial=0.0)))
