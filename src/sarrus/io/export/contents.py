"""What an export writes: a tree of edges, the joints that close its loops, and the loads that a format may have."""

from __future__ import annotations

import warnings
from collections.abc import Collection, Container, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...analyses.position.assembly import assemble
from ...elements import Element
from ...elements.element import Pair
from ...euler import E
from ...model import Coupler, Distance, Driver, Joint, Model
from ...model.bodies.shape import Look
from ...model.coordinate import chosen
from ...model.coordinates import slice_of
from ...model.errors import ModelError, SarrusWarning
from ...model.geometry.motion import Free, pose, unit
from ...model.geometry.points import GROUND
from ...model.geometry.pose import GROUND_POSE, Pose
from ...model.primitive import Primitive
from ...model.quantity import Array, Vec3, vector
from ...system import System
from ..robot import Actuator, Dynamics, Edge, Inertia, Mimic
from ..robot.description import WORLD
from ..robot.tree.coordinates import spanned
from ..robot.tree.merge import Merger, Place, fold
from .actuators import Actuators
from .loads import Loads, Match, PointLoad, Spring
from .missing import Gap, NotInFormat, no_place
from .motions import edge_of, motion_of, rates, screw_of


@dataclass(frozen=True, eq=False)
class Link:
    """A rod of constant length between two points: body names and points in body axes [m]."""

    name: str
    bodies: tuple[str, str]
    points: tuple[Vec3, Vec3]


@dataclass(frozen=True, eq=False)
class Contents:
    """A model in the assembled position, where all coordinates are zero.

    Attributes
    ----------
    inertials, poses : by body
    edges : of the tree, each after that of its parent; the parent of the first ones is WORLD
    loops : further edges, between bodies of the tree
    dynamics, ranges, mimics, rates : by motion
    actuators, controls, actuator_parts : by the name of the input, or of the force
    owners : by motion and field of its dynamics, the names of the forces that it is the sum of
    missing : what no format has
    """

    name: str
    gravity: Vec3
    poses: Mapping[str, Pose]
    inertials: Mapping[str, Inertia]
    edges: Sequence[Edge]
    loops: Sequence[Edge]
    rods: Sequence[Link]
    dynamics: Mapping[str, Dynamics]
    ranges: Mapping[str, tuple[float | None, float | None]]
    mimics: Mapping[str, Mimic]
    springs: Sequence[Spring]
    pushes: Sequence[PointLoad]
    actuators: Mapping[str, Actuator]
    controls: Mapping[str, float]
    actuator_parts: Mapping[str, tuple[str, ...]]
    owners: Mapping[tuple[str, str], Sequence[str]]
    missing: Sequence[Gap]
    looks: Sequence[Look]
    rates: Mapping[str, Array]


def contents(model: Model, ignore: Collection[str], cut: Collection[type[object]]) -> Contents:
    """Return what an export writes.

    Parameters
    ----------
    ignore : names of parts to leave out
    cut : the joints that may close loops; others are in the tree if that is possible
    """
    model = _without(model, ignore)
    start = assemble(System(model))
    initial, poses = model.design_poses(), _poses(model, start.q)
    joints = [joint for joint in model.joints if not isinstance(joint, Coupler | Distance)]
    found = {joint.name: edge_of(joint, initial, poses, _link) for joint in joints}
    unknown = [joint for joint in joints if found[joint.name] is None]
    parts: list[Joint | Driver] = [*unknown, *model.drivers]
    missing = [no_place(part.name, type(part).__name__).missing for part in parts]
    edges = {name: edge for name, edge in found.items() if edge is not None}
    kinds = {joint.name: type(joint) for joint in joints}
    order = sorted(edges.values(), key=lambda edge: kinds[edge.name] in cut)
    tree, loops = spanned([body.name for body in model.bodies], _forest(order), _root)
    in_tree = {edge.name for edge in tree}
    loops += [edge for edge in edges.values() if edge.name not in in_tree]
    missing += [
        no_place(edge.name, f"{kinds[edge.name].__name__} that closes a loop").missing
        for edge in loops
        if kinds[edge.name] not in cut
    ]
    inertials = {body.name: _inertial(body) for body in model.bodies}
    folded = fold(Merger({WORLD: Place(WORLD, GROUND_POSE)}, tree, inertials))
    heavy = {edge.child for edge in folded.edges}
    coordinates = Coordinates(model, edges, initial, poses)
    acting = Actuators(model, coordinates.found)
    mimics, wrong = _mimics(model, coordinates)
    loads = Loads(model, edges, poses, acting.done)
    return Contents(
        name=model.name,
        gravity=vector(model.gravity, "gravity"),
        poses=poses,
        inertials={name: inertial for name, inertial in inertials.items() if name in heavy},
        edges=folded.edges,
        loops=loops,
        rods=[_rod(joint, initial) for joint in model.joints if isinstance(joint, Distance)],
        dynamics=loads.dynamics,
        ranges=loads.ranges,
        mimics=mimics | {k: v for joint in joints for k, v in screw_of(joint).items()},
        springs=loads.springs,
        pushes=loads.pushes,
        actuators=acting.actuators,
        controls=acting.controls,
        actuator_parts=acting.parts,
        owners=loads.owners,
        missing=[*missing, *wrong, *acting.missing, *loads.missing],
        looks=model.looks(),
        rates=rates(folded.edges, poses, _twists(model, start.q, start.v)),
    )


def _link(body: str) -> str:
    return WORLD if body == GROUND else body


def _root(name: str, link: str) -> Edge:
    return Edge(name, WORLD, link, GROUND_POSE, (Free(name),))


def _forest(edges: Sequence[Edge]) -> list[Edge]:
    """Return edges without a loop, the first ones if possible."""
    group: dict[str, str] = {}

    def head(link: str) -> str:
        while group.get(link, link) != link:
            link = group[link]
        return link

    chosen_edges = []
    for edge in edges:
        i, j = head(edge.parent), head(edge.child)
        if i != j:
            group[i] = j
            chosen_edges.append(edge)
    return chosen_edges


def _without(model: Model, ignore: Collection[str]) -> Model:
    """Return the model without some joints, drivers and forces."""
    sections: dict[str, Any] = {
        name: tuple(part for part in getattr(model, name) if part.name not in ignore)
        for name in ("joints", "drivers", "forces")
    }
    known = {part.name for parts in model.sections().values() for part in parts}
    for name in ignore:
        if name not in known:
            raise ModelError(
                f"ignore names {name}, but the model has no such part. Check the name.", field="ignore"
            )
    rates = {name: rate for name, rate in model.rates.items() if name.partition(".")[0] not in ignore}
    return replace(model, **sections, rates=rates)


def _poses(model: Model, q: Array) -> dict[str, Pose]:
    rows = {body.name: q[slice_of(n)] for n, body in enumerate(model.bodies)}
    poses = {name: pose(row[:3], unit(row[3:])) for name, row in rows.items()}
    return {GROUND: GROUND_POSE, **poses}


def _twists(model: Model, q: Array, v: Array) -> dict[str, tuple[Array, Array]]:
    """Return the velocity of the origin and the angular velocity of each body, in global axes."""
    twists = {GROUND: (np.zeros(3), np.zeros(3))}
    for n, body in enumerate(model.bodies):
        p, rate = q[slice_of(n)][3:], v[slice_of(n)]
        twists[body.name] = rate[:3], 2 * E(p) @ rate[3:]  # Eq. (1)
    return twists


def _inertial(body: object) -> Inertia:
    mass, J, center = body.mass_properties()  # type: ignore[attr-defined]
    xx, yy, zz, xy, xz, yz = J
    return Inertia(float(mass), np.array(center), np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))


def _rod(joint: Distance, initial: Mapping[str, Pose]) -> Link:
    (piece,) = joint.primitives(initial)
    return Link(joint.name, (piece.bodies[0], piece.bodies[1]), (piece.values[0], piece.values[1]))


class Coordinates:
    """The coordinates of joints as motions of edges."""

    def __init__(
        self, model: Model, edges: Mapping[str, Edge], initial: Mapping[str, Pose], poses: Mapping[str, Pose]
    ) -> None:
        self.known = {joint.name: tuple(joint.coordinates(initial)) for joint in model.joints}
        self.edges, self.initial, self.poses = edges, initial, poses

    def found(self, reference: str, kind: type[Element] | None) -> Match | None:
        """Return the motion of a coordinate, None if no motion is just that."""
        coordinate = chosen(reference, kind, self.known, "joint")
        motion = motion_of(reference.partition(".")[0], coordinate.name, self.edges)
        if motion is None or coordinate.name.startswith("angle_"):
            return None
        values = [self._value(coordinate.measure, poses) for poses in (self.initial, self.poses)]
        return Match(motion.name, 1.0, coordinate.start + values[1] - values[0])

    def _value(self, measure: Primitive, poses: Mapping[str, Pose]) -> float:
        i, j = (poses[body] for body in measure.bodies)
        element: Any = measure.element(*(np.array(one) if np.ndim(one) else one for one in measure.values))
        return float(element.Phi(Pair(i.r, i.p, j.r, j.p))[0])


def _mimics(model: Model, coordinates: Coordinates) -> tuple[dict[str, Mimic], list[Gap]]:
    """Return the motions that follow another by a coupler, and the couplers that cannot be written."""
    mimics, missing = dict[str, Mimic](), list[Gap]()
    for coupler in (joint for joint in model.joints if isinstance(joint, Coupler)):
        try:
            leader, follower = (
                _end(coupler, reference, coordinates) for reference in (coupler.joint_i, coupler.joint_j)
            )
            if follower in mimics:
                raise no_place(coupler.name, f"second {type(coupler).__name__} of a joint")
            mimics[follower] = Mimic(leader, float(coupler.ratio))
        except NotInFormat as error:
            missing.append(error.missing)
    return mimics, missing


def _end(coupler: Coupler, reference: str, coordinates: Coordinates) -> str:
    end = coordinates.found(reference, coupler.kind)
    if end is None:
        raise no_place(coupler.name, f"{type(coupler).__name__} of {reference}")
    return end.motion


def missing_loads(contents: Contents, allowed: Container[str]) -> Iterator[Gap]:
    """Yield rods, springs between points, constant forces, actuators, and dynamics other than those allowed."""
    for parts, what in (
        (contents.rods, "rods"),
        (contents.springs, "springs between points"),
        (contents.pushes, "constant forces"),
    ):
        for part in parts:
            yield Gap(f"no {what}", (part.name,))
    for parts_of_actuator in contents.actuator_parts.values():
        yield Gap("no actuators", parts_of_actuator)
    for (_, field), names in contents.owners.items():
        if field not in allowed:
            yield Gap(f"no {field} of joints", tuple(names))


def warn_of_rates(contents: Contents) -> None:
    """Warn that initial velocities are not in the file."""
    if any(np.any(np.abs(rate) > 0) for rate in contents.rates.values()):
        message = f"{contents.name}: the format has no initial velocities; the file is at rest."
        warnings.warn(message, SarrusWarning, stacklevel=5)
