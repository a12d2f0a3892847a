"""Contacts of an MJCF model between planes and spheres, capsules, corners of boxes and of meshes.

A contact has the stiffness of `compliance`; corners of meshes are those of the convex hull, as in MuJoCo.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from functools import lru_cache
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from ....model import SphereContact
from ....model.geometry.points import Frame
from ....model.geometry.pose import Pose
from ....model.quantity import Array, triple
from ....model.show import quote
from ...robot import Robot
from ...robot.interaction import Ends
from ..bodies import names_of, placed
from ..compiled import Shape, disabled, enabled, name_of, version
from .compliance import STATIONARY, compliance

MOST_CORNERS = 64  # of a mesh
ADDED, INACTIVE_GAP = (3, 5), (3, 9)  # versions of MuJoCo with other meanings of `margin` and `gap`
MANY = 300  # shapes whose pairs are not looked at one by one


class Pair(NamedTuple):
    """A plane and a shape that may touch, and the numbers of their contact."""

    plane: int
    shape: int
    solref: Array
    solimp: Array
    dimension: int  # of the contact force: 1 without friction, 3 with sliding
    friction: Array  # two coefficients of sliding
    margin: float
    more: bool = False  # whether MuJoCo has adhesion or moving surfaces there

    def only_slides(self) -> bool:
        """Return whether all that MuJoCo has there is a cone of friction."""
        one = self.dimension == 1 or self.friction[0] == self.friction[1]
        return bool(one and self.dimension <= 3 and not self.more)


def contacts_of(compiled: Any, robot: Robot) -> Iterator[tuple[SphereContact, Ends]]:
    """Yield a contact for each sphere, end of a capsule, and corner that a plane may touch, and its links."""
    bodies, contacts = names_of(compiled), list[tuple[str, dict[str, Any]]]()
    ends = list[Ends]()
    for pair in pairs_of(compiled):
        spots = spots_of(compiled, pair.shape) or []
        links = [bodies[compiled.geom_bodyid[k]] for k in (pair.plane, pair.shape)]
        if not robot.links.keys() >= {*links} or robot.link(links[0]).body is robot.link(links[1]).body:
            continue
        law = _law(compiled, pair)
        flat = placed(compiled.geom_pos[pair.plane], compiled.geom_quat[pair.plane])
        name = f"{name_of(compiled, 'geom', pair.shape)}_contact"
        for n, (center, radius) in enumerate(spots):
            touching = radius + pair.margin  # distance from the plane
            plane = frame_at(robot, links[0], flat._replace(r=flat.r + min(touching, 0.0) * flat.A[:, 2]))
            place = {
                "center": robot.point(links[1], triple(center)),
                "radius": max(touching, 0.0),
                "plane": plane,
            }
            contacts.append((f"{name}_{n}" if len(spots) > 1 else name, law | place))
            ends.append((links[1], links[0]))
    names = robot.free_names([name for name, _ in _apart(contacts)], "_force")
    for name, (_, fields), links_of_one in zip(names, _apart(contacts), ends, strict=True):
        yield SphereContact(name, **fields), links_of_one


def _apart(found: list[tuple[str, dict[str, Any]]]) -> list[tuple[str, dict[str, Any]]]:
    """Number the contacts of one shape with several planes."""
    count = dict[str, int]()
    numbered = []
    for name, fields in found:
        count[name] = count.get(name, 0) + 1
        numbered.append((name if count[name] == 1 else f"{name}_plane{count[name]}", fields))
    return numbered


def left_out_contacts(compiled: Any) -> tuple[int, int, int]:
    """Return counts of shapes that may touch a plane, but have no corners or too many; that have more than sliding
    friction there; and that may touch others.
    """
    pairs = pairs_of(compiled)
    without = {pair.shape for pair in pairs if spots_of(compiled, pair.shape) is None}
    more = len({pair.shape for pair in pairs if not pair.only_slides()})
    masks = (compiled.geom_contype | compiled.geom_conaffinity) * (compiled.geom_type != Shape.PLANE)
    shapes = np.flatnonzero(masks * (not disabled(compiled, "CONTACT")))
    if len(shapes) > MANY:
        return len(without), more, len(shapes)
    return len(without), more, sum(any(_may_touch(compiled, i, j) for j in shapes if j != i) for i in shapes)


def pairs_of(compiled: Any) -> list[Pair]:
    """Return the planes and shapes that may touch: explicit pairs, and those that no filter excludes."""
    if disabled(compiled, "CONTACT"):
        return []
    types = compiled.geom_type
    explicit = {}
    for n in range(compiled.npair):
        ends = sorted(
            (int(compiled.pair_geom1[n]), int(compiled.pair_geom2[n])), key=lambda k: types[k] != Shape.PLANE
        )
        if [types[k] == Shape.PLANE for k in ends] == [True, False]:
            explicit[tuple(ends)] = _explicit(compiled, n, *ends)
    planes, shapes = np.flatnonzero(types == Shape.PLANE), np.flatnonzero(types != Shape.PLANE)
    both = [(int(i), int(j)) for i, j in product(planes, shapes) if _may_touch(compiled, i, j)]
    pairs = [*explicit.values(), *(_mixed(compiled, *ends) for ends in both if ends not in explicit)]
    return [_overridden(compiled, pair) for pair in pairs] if enabled(compiled, "OVERRIDE") else pairs


def spots_of(compiled: Any, shape: int) -> list[tuple[Array, float]] | None:
    """Return the spheres by which a shape touches a plane, with centre and radius; None if there are none or many."""
    kind, size = int(compiled.geom_type[shape]), compiled.geom_size[shape]
    frame = placed(compiled.geom_pos[shape], compiled.geom_quat[shape])
    if kind == Shape.SPHERE:
        return [(frame.r, float(size[0]))]
    if kind == Shape.CAPSULE:
        return [(frame.global_point(np.array([0, 0, end * size[1]])), float(size[0])) for end in (-1, 1)]
    if kind == Shape.BOX:
        return [(frame.global_point(np.array(signs) * size), 0.0) for signs in product((-1, 1), repeat=3)]
    return _corners(compiled, shape, frame) if kind == Shape.MESH else None


def _corners(compiled: Any, shape: int, frame: Pose) -> list[tuple[Array, float]] | None:
    mesh = int(compiled.geom_dataid[shape])
    first, count = int(compiled.mesh_vertadr[mesh]), int(compiled.mesh_vertnum[mesh])
    points = _hull(np.array(compiled.mesh_vert[first : first + count], dtype=float).tobytes())
    return [(frame.global_point(corner), 0.0) for corner in points] if len(points) <= MOST_CORNERS else None


@lru_cache(maxsize=16)
def _hull(vertices: bytes) -> Array:
    """Return the corners of the convex hull of a mesh, which many shapes may have. (k, 3)"""
    points = np.unique(np.frombuffer(vertices).reshape(-1, 3), axis=0)
    with suppress(QhullError, ValueError):  # it is flat
        points = points[ConvexHull(points).vertices]
    return points


def _may_touch(compiled: Any, i: Any, j: Any) -> bool:
    """Return whether MuJoCo's filters leave a pair of shapes: types, one body, parent and child, exclusions."""
    types, affinities, bodies = compiled.geom_contype, compiled.geom_conaffinity, compiled.geom_bodyid
    one, other = int(bodies[i]), int(bodies[j])
    weld, parents = compiled.body_weldid, compiled.body_parentid
    signature = (min(one, other) << 16) + max(one, other)
    if weld[one] == weld[other] or signature in compiled.exclude_signature:
        return False
    related = weld[parents[weld[one]]] == weld[other] or weld[parents[weld[other]]] == weld[one]
    if related and weld[one] and weld[other] and not disabled(compiled, "FILTERPARENT"):
        return False
    return bool(types[i] & affinities[j] or types[j] & affinities[i])


def _explicit(compiled: Any, n: int, plane: int, shape: int) -> Pair:
    law = compiled.pair_solref[n], compiled.pair_solimp[n], int(compiled.pair_dim[n])
    margin = _margin(compiled.pair_margin[n], compiled.pair_gap[n])
    more = _has(compiled, "pair_adhesion", [n])
    return Pair(plane, shape, *law, compiled.pair_friction[n, :2], margin, more)


def _has(compiled: Any, name: str, places: list[int]) -> bool:
    return bool(np.any(getattr(compiled, name, np.zeros(max(places) + 1))[places]))


def _mixed(compiled: Any, plane: int, shape: int) -> Pair:
    """Return the pair with the numbers that MuJoCo takes from both: of the higher priority, or mixed."""
    ends, priority = (plane, shape), compiled.geom_priority
    if priority[plane] != priority[shape]:
        ends = (max(ends, key=lambda k: priority[k]),) * 2
    weights = np.maximum(compiled.geom_solmix[list(ends)], 1e-15)
    refs, limits = compiled.geom_solref[list(ends)], compiled.geom_solimp[list(ends)]
    share = weights / weights.sum()
    solref = share @ refs if np.all(refs[:, 0] > 0) else refs.min(axis=0)
    dimension = int(compiled.geom_condim[list(ends)].max())
    friction = compiled.geom_friction[list(ends), 0].max().repeat(2)
    more = any(_has(compiled, f"geom_{word}", list(ends)) for word in ("adhesion", "surfacevel"))
    margin = _margin(compiled.geom_margin[[plane, shape]], compiled.geom_gap[[plane, shape]])
    return Pair(plane, shape, solref, share @ limits, dimension, friction, margin, more)


def _margin(margins: Any, gaps: Any) -> float:
    """Return the distance at which forces begin, of one pair or of both shapes; a gap is without force since 3.9."""
    combined = np.sum if version() >= ADDED else np.max
    return float(combined(margins) - (combined(gaps) if version() < INACTIVE_GAP else 0.0))


def _overridden(compiled: Any, pair: Pair) -> Pair:
    """Return a pair with the numbers of the file's option ``override``."""
    opt = compiled.opt
    override = {"solref": opt.o_solref, "solimp": opt.o_solimp, "friction": opt.o_friction[:2]}
    return pair._replace(**override, margin=float(opt.o_margin))


def _law(compiled: Any, pair: Pair) -> dict[str, Any]:
    bodies = compiled.geom_bodyid[[pair.plane, pair.shape]]
    inverse = float(compiled.body_invweight0[bodies, 0].sum())
    mass = float(compiled.body_mass[bodies].max()) or _carrying_mass(compiled, bodies)
    if inverse * mass < STATIONARY:  # neither centre of mass can move
        inverse = 1 / mass if mass else 0.0
    part = f"geom {quote(name_of(compiled, 'geom', pair.shape))}"
    law = compliance(compiled, pair.solref, pair.solimp, inverse, part)
    return {
        "stiffness": law.stiffness,
        "damping": law.damping,
        "mu": float(pair.friction[0]) if pair.dimension > 1 else 0.0,
    }


def _carrying_mass(compiled: Any, bodies: Any) -> float:
    """Return the largest mass of what bodies without mass are fixed to, with what hangs on it."""
    roots = compiled.body_weldid[bodies]
    return float(max(compiled.body_subtreemass[roots[roots > 0]], default=0.0))


def frame_at(robot: Robot, link: str, place: Pose) -> Frame:
    """Return the frame at a pose on a link."""
    return robot.frame(link, triple(place.r), x=place.A[:, 0], z=place.A[:, 2])
