"""Conversion of a description to a model: bodies for moving links, joints between them, all in the initial pose.

Chains of joints for the motions between two links that no single joint has, with massless frames between them.

A frame is a body without mass and inertia. Its accelerations are determined, because each motion of the chain moves
the link at its end.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from contextlib import AbstractContextManager
from dataclasses import replace
from typing import Any

import numpy as np

from ...model import AngleStop, Coupler, DisplacementStop, Distance, FormulaCoupler, Input, PointForce, Tendon
from ...model.checks.findings import Origin
from ...model.errors import ModelError, restated
from ...model.expansion.tree import Branch, walk
from ...model.expression import Name
from ...model.expression.functions import CONSTANTS
from ...model.forces import Force
from ...model.geometry.motion import Free, Motion, Slide, Turn
from ...model.geometry.points import GROUND, Solid, ground
from ...model.geometry.pose import GROUND_POSE
from ...model.joints import Joint
from ...model.quantity import Array, triple
from ...model.show import counted, quote
from ...model.states.input import OWN
from .description import (
    MASSLESS,
    WORLD,
    Description,
    Edge,
    Limit,
    Link,
    Mimic,
    Path,
    Stop,
    TendonEquality,
    TendonForces,
    legal,
)
from .joints import Hinge, coordinate_of, joint
from .loads.actuators import PARAMETERS, actuator_forces
from .loads.dynamics import CREEP, forces_of
from .options import ImportOptions, known, values_of
from .robot import Robot
from .sensors import resolved, unresolved
from .tree.carried import LinkPlace, part_on_bodies
from .tree.closing import closed
from .tree.coordinates import BASE, CoordinateMatch, Coordinates, Route
from .tree.merge import Merger, bodies_of, fold, merge, stopped, without_mass

REMEDY = 'Import it with ignore=["equalities"].'
ROUNDING = 1e-4  # [rad, m] less than the depth of usual loads
TENDONS_REMEDY = 'Import it with ignore=["tendons"].'
STRETCH = "(max(x - longest, 0) + min(x - shortest, 0))"
OF_ONE_LENGTH = "(x - longest)"  # without corners, at which steps would end
TERMS = {
    "stiffness": f"- stiffness*{STRETCH}",
    "stiffness_2": f"- stiffness_2*{STRETCH}^2",
    "stiffness_3": f"- stiffness_3*{STRETCH}^3",
    "damping": "- damping*v",
    "damping_2": "- damping_2*v*abs(v)",
    "damping_3": "- damping_3*v^3",
    "friction": "- friction*tanh(v/creep)",
    "stop": "- stop*(max(x - upper, 0)*max(1 + loss*v, 0) - max(lower - x, 0)*max(1 - loss*v, 0))",
}
NAMES = {"stop": ("loss", "lower", "upper")} | dict.fromkeys(
    ("stiffness", "stiffness_2", "stiffness_3"), ("shortest", "longest")
)
LENGTHS = ("shortest", "longest", "lower", "upper")
MIMICS_REMEDY = 'Import it with mimic="free" or mimic="lock".'


def build(description: Description, options: ImportOptions) -> Robot:
    """Return the model of a description.

    Raises
    ------
    ModelError
        For a robot without mass, or an option that cannot be applied.
    """
    options.check(description.actuators)
    if "dynamics" in options.ignore:
        description = replace(description, dynamics={})
    if "actuators" in options.ignore:
        description = replace(description, actuators={})
    description = _floating(description) if options.base == "floating" else description
    fixed = {WORLD} - {*description.links}  # the root is fixed to the world
    loops = [replace(e, parent=description.root) if e.parent in fixed else e for e in description.loops]
    description = replace(description, loops=loops)
    motions = {motion.name: motion for edge in description.edges for motion in edge.motions}
    values = followers(description, values_of({**description.zero, **options.q0}, motions, "q0"))
    locked = {known(name, motions, "lock") for name in options.lock}
    idle = without_mass(description)
    locked |= idle
    if options.mimic == "lock":
        locked |= set(description.mimics)
    if options.mimic == "couple":
        locked = standing(description.mimics, locked)
    coupled = {name for follower, mimic in description.mimics.items() for name in (follower, mimic.joint)}
    values = closed(description, values, {*options.q0, *locked, *coupled})
    stops = {name: values.get(name, np.array(motions[name].zero)) for name in locked}
    notes = [*description.notes]
    if options.mimic == "free" and (count := len(set(description.mimics) - locked)):
        text = "{n} [joint that follows another moves|joints that follow another move] freely"
        notes.append(counted(text, count))
    if idle:
        locking = counted("{n} [motion of a link|motions of links] without mass [is|are] locked", len(idle))
        notes.append(f"{locking}: {', '.join(sorted(idle))}")
    description = replace(
        description, edges=[stopped(edge, stops) for edge in description.edges], notes=notes
    )
    merged = fold(merge(description, keep_fixed=options.keep_fixed))
    merged = chained(merged, _named(description, options))
    return _robot(description, options, merged, values)


def _named(description: Description, options: ImportOptions) -> set[str]:
    """Return the motions that a force or another joint refers to."""
    followed = description.mimics if options.mimic == "couple" else {}
    acted = {motion for actuator in description.actuators.values() for motion in actuator.motions()}
    paths = [tendon.path for tendon in description.tendons.values()]
    for equality in description.equalities.values():
        paths += [equality.path, *([equality.other] if equality.other else [])]
    acted |= {motion for path in paths for motion in path.joints}
    return {
        *description.dynamics,
        *description.stops,
        *acted,
        *followed,
        *(mimic.joint for mimic in followed.values()),
    }


def _floating(description: Description) -> Description:
    """Return the description with the ground as its root, on which the former root moves freely."""
    if any(edge.name == BASE for edge in description.edges):
        message = f"has the name of the motion of a floating root. Rename joint {quote(BASE)}."
        raise ModelError(message, part=f"joint {quote(BASE)}", where=description.file)
    edge = Edge(
        BASE, WORLD, description.root, GROUND_POSE, (Free(BASE),), description.links[description.root].line
    )
    links = {WORLD: Link(WORLD, None), **description.links}
    return replace(description, root=WORLD, edges=[edge, *description.edges], links=links)


def _robot(
    description: Description, options: ImportOptions, merged: Merger, values: Mapping[str, Array]
) -> Robot:
    names = {WORLD: GROUND, **legal([edge.child for edge in merged.edges], {GROUND}, "_link")}
    branches = tuple(Branch(names[e.parent], names[e.child], e.pose, e.motions) for e in merged.edges)
    poses = {step.branch.body: step.pose for step in walk(branches, values)}
    bodies = bodies_of(description, options.inertia, merged, names, poses)
    joints = legal([edge.name for edge in merged.edges], set(names.values()), "_joint")
    solids: dict[str, Solid] = {GROUND: ground, **{body.name: body for body in bodies}}
    hinges = {
        edge.name: Hinge(joints[edge.name], solids[names[edge.parent]], solids[names[edge.child]], edge.pose)
        for edge in merged.edges
    }
    links = _links(merged, names, solids)
    loops = [edge for edge in description.loops if _moves(edge, links)]
    closing = legal([edge.name for edge in loops], {*names.values(), *joints.values()}, "_loop")
    hinges |= {edge.name: _closing(description, edge, closing[edge.name], links) for edge in loops}
    joined, joints = replace(merged, edges=[*merged.edges, *loops]), joints | closing
    coordinates = Coordinates(joined.edges, joints, links, values)
    held = [part_on_bodies(part) for part in _joints(description, joined, hinges)]
    if options.mimic == "couple":
        held += couplers(description, coordinates, {*names.values(), *joints.values()})
    held += tendon_constraints(description, coordinates, {*names.values(), *(part.name for part in held)})
    moving = {motion.name for branch in branches for motion in branch.motions}
    taken = {*names.values(), *(part.name for part in held)}
    drawn = options.meshes == "draw"
    loads = forces(description, joined, hinges, coordinates, options.controls, taken)
    sensors = resolved(description, coordinates)
    called = legal(sensors, {*taken, *(part.name for part in loads)}, "_sensor")
    return Robot(
        description.name,
        bodies,
        tuple(held),
        loads,
        gravity=description.gravity,
        origin=_origin(description, merged, names, joints),
        branches=branches,
        links=links,
        limits={name: limit for name, limit in description.limits.items() if name in moving},
        mimics={name: mimic for name, mimic in description.mimics.items() if name in moving},
        visuals=tuple(v for v in description.visuals if drawn or v.shape != "mesh"),
        sensors={called[name]: sensor for name, sensor in sensors.items()},
        search=tuple(str(folder) for folder in options.search),
        notes=(
            *description.notes,
            *_outside(description.limits, moving, values),
            *unresolved(description, sensors),
        ),
    )


def _joints(description: Description, merged: Merger, hinges: Mapping[str, Hinge]) -> Iterator[Joint]:
    for edge in merged.edges:
        with located(description, edge):
            part = joint(hinges[edge.name], edge.motions)
            if part is not None:
                yield part


def _outside(limits: Mapping[str, Limit], left: set[str], values: Mapping[str, Array]) -> Iterator[str]:
    """Yield a note for each joint that starts outside of its limits."""
    for name, limit in limits.items():
        value = float(values[name][0]) if name in values else 0.0
        lower, upper = limit.range()
        if name in left and not lower <= value <= upper:
            yield f"the joint {quote(name)} starts at {value:g}, outside of its limits {lower:g} and {upper:g}"


def _moves(edge: Edge, links: Mapping[str, LinkPlace]) -> bool:
    """Return whether the links of an edge are on different bodies."""
    i, j = (links[link].body if link in links else None for link in (edge.parent, edge.child))
    return i is not j


def _closing(description: Description, edge: Edge, name: str, links: Mapping[str, LinkPlace]) -> Hinge:
    """Return the two links of a joint that closes a loop."""
    ends = list[Solid]()
    for link in (edge.parent, edge.child):
        if link != description.root and link not in links:
            message = f"connects link {quote(link)}, which has no mass and no body. Give it mass"
            where = description.where(edge.line)
            raise ModelError(f"{message}.", part=f"joint {quote(edge.name)}", where=where)
        ends.append(ground if link == description.root and link not in links else links[link])
    return Hinge(name, ends[0], ends[1], edge.pose)


def _links(merged: Merger, names: Mapping[str, str], solids: Mapping[str, Solid]) -> dict[str, LinkPlace]:
    places = {name: place for name, place in merged.places.items() if name != WORLD}
    return {name: LinkPlace(name, solids[names[head]], pose) for name, (head, pose) in places.items()}


def _origin(
    description: Description, merged: Merger, names: Mapping[str, str], joints: Mapping[str, str]
) -> Origin | None:
    lines: dict[tuple[str | int, ...], int] = {}
    for edge in merged.edges:
        lines["bodies", names[edge.child]] = description.line_of(edge)
        lines["joints", joints[edge.name]] = edge.line
    return Origin(description.file, {path: line for path, line in lines.items() if line})


def tendon_constraints(
    description: Description, coordinates: Coordinates, taken: set[str]
) -> Iterator[Joint]:
    """Yield a constraint for each equality of a tendon that can move."""
    names = legal(description.equalities, taken, "_equality")
    for name, equality in description.equalities.items():
        with restated(part=f"equality {quote(name)}"):
            yield from _constraint(names[name], equality, coordinates)


def _constraint(name: str, equality: TendonEquality, coordinates: Coordinates) -> Iterator[Joint]:
    route = coordinates.lay(equality.path, REMEDY)
    if route is None:
        return
    if equality.path.points:
        i, j = route.fields["points"]
        yield Distance(name, point_i=i, point_j=j, length=equality.start + equality.factors[0])
        return
    parameters = {f"a{n}": a for n, a in enumerate(equality.factors) if a}
    other = _sum(equality.other, coordinates) if equality.other else "0"
    powers = (word if word == "a0" else f"{word}*({other})^{word[1:]}" for word in parameters)
    (first, factor), *rest = route.fields["joints"].items()
    value = " + ".join(powers) or "0"
    value = "".join(
        [value, *(f" - ({c!r})*{Name(one)}" for one, c in rest), f" - ({_fixed(equality.path, route)!r})"]
    )
    yield FormulaCoupler(name, first, value=f"({value})/({factor!r})", parameters=parameters)


def _sum(path: Path, coordinates: Coordinates) -> str:
    route = coordinates.lay(path, REMEDY)
    if route is None:
        return "0"
    terms = (f"({factor!r})*{Name(name)}" for name, factor in route.fields["joints"].items())
    return f"{' + '.join(terms)} + ({_fixed(path, route)!r})"


def _fixed(path: Path, route: Route) -> float:
    """What joints that do not move add to the sum."""
    return route.start - path.start


def forces(
    description: Description,
    merged: Merger,
    hinges: Mapping[str, Hinge],
    coordinates: Coordinates,
    controls: Mapping[str, Any],
    taken: set[str],
) -> tuple[Force, ...]:
    """Return the forces on motions that are left, each with a name that is free; hinges are by edge."""
    found = [*_of_joints(description, merged, hinges), *_lifts(description, coordinates.links)]
    for name, given in description.tendons.items():
        force = tendon_force(name, given, coordinates)
        found += [force] if force is not None else []
    inputs = list[Input]()
    for name, actuator in description.actuators.items():
        control = Input(input_name(name, taken), controls.get(name, 0.0))
        taken = taken | {control.name}
        acting = [*actuator_forces(name, actuator, coordinates, control)]
        inputs, found = inputs + [control] * bool(acting), found + acting
    taken = {*taken}
    names = [legal([force.name], taken, "_force")[force.name] for force in found]  # two may have the same
    renamed = (replace(force, name=name) for force, name in zip(found, names, strict=True))
    return (*inputs, *map(part_on_bodies, renamed))


def input_name(actuator: str, taken: set[str]) -> str:
    """Return the name of an actuator's input, which formulas can use; one with another meaning ends with _control."""
    name = actuator.replace("-", "_")
    used = taken | {*OWN, *CONSTANTS, *PARAMETERS}
    return legal([name], used, "_control")[name]


def _of_joints(description: Description, merged: Merger, hinges: Mapping[str, Hinge]) -> Iterator[Force]:
    for edge in merged.edges:
        for motion in edge.motions:
            hinge, name = hinges[edge.name], motion.name
            with located(description, edge):
                if name in description.dynamics:
                    yield from forces_of(hinge, motion, description.dynamics[name])
                if name in description.stops and isinstance(motion, Turn | Slide):
                    yield stop_of(hinge, motion, description.stops[name])


def _lifts(description: Description, links: Mapping[str, LinkPlace]) -> Iterator[Force]:
    """Yield the force against gravity on each moving link that has one."""
    for name, part in description.lifted.items():
        inertial = description.links[name].inertial
        if part and inertial is not None and name in links and links[name].body.name != GROUND:
            lift = triple(-part * inertial.mass * np.array(description.gravity))
            yield PointForce(f"{name}_gravcomp", links[name].point(*triple(inertial.center)), lift)


def located(description: Description, edge: Edge, name: str = "") -> AbstractContextManager[None]:
    """Name the joint, that of the edge by default, and its place in messages."""
    return restated(part=f"joint {quote(name or edge.name)}", where=description.where(edge.line))


def stop_of(hinge: Hinge, motion: Turn | Slide, law: Stop) -> Force:
    """Return the stop of a motion, named after it."""
    turn = isinstance(motion, Turn)
    kind: Any = AngleStop if turn else DisplacementStop
    i, j = hinge.frames(motion.point if isinstance(motion, Turn) else np.zeros(3), motion.axis)
    stop: Force = kind(f"{motion.name}_stop", frame_i=i, frame_j=j, rounding=ROUNDING, **law._asdict())
    return stop


def tendon_force(name: str, tendon: TendonForces, coordinates: Coordinates) -> Force | None:
    """Return the force of a tendon, None if its length is constant."""
    route = coordinates.lay(tendon.path, TENDONS_REMEDY)
    if route is None:
        return None
    terms = [word for word in TERMS if getattr(tendon, word)]
    parameters = {field: getattr(tendon, field) for word in terms for field in (word, *NAMES.get(word, ()))}
    parameters |= {field: parameters[field] - route.start for field in LENGTHS if field in parameters}
    if "friction" in terms:
        parameters["creep"] = CREEP
    value = " ".join(TERMS[word] for word in terms)
    if tendon.shortest == tendon.longest:
        value = value.replace(STRETCH, OF_ONE_LENGTH)
        parameters.pop("shortest", None)
    return Tendon(name, **route.fields, value=value or None, parameters=parameters, inertia=tendon.inertia)


def followers(description: Description, values: Mapping[str, Array]) -> dict[str, Array]:
    """Return where the following joints start, unless a value is given for them."""
    starts = dict(values)
    for name in description.mimics:
        _follow(name, description.mimics, starts)
    return starts


def standing(mimics: Mapping[str, Mimic], locked: set[str]) -> set[str]:
    """Return the joints that follow one that does not move, or follow by nothing."""
    still = set(locked)
    for _ in mimics:
        still |= {name for name, mimic in mimics.items() if mimic.joint in still or mimic.is_constant()}
    return still


def couplers(description: Description, coordinates: Coordinates, taken: set[str]) -> Iterator[Joint]:
    """Yield a coupler for each following joint that moves.

    Raises
    ------
    ModelError
        If the value of a joint cannot be computed because it is part of a combined joint.
    """
    moving = {name: mimic for name, mimic in description.mimics.items() if name in coordinates.edges}
    names = legal([f"{name}_mimic" for name in moving], taken, "_coupler")
    for (name, mimic), coupler in zip(moving.items(), names.values(), strict=True):
        with located(description, coordinates.edges[name], name):
            leader, follower = (coordinates.find(motion, MIMICS_REMEDY) for motion in (mimic.joint, name))
        yield _coupler(coupler, leader, follower, mimic)


def _coupler(name: str, leader: CoordinateMatch, follower: CoordinateMatch, mimic: Mimic) -> Joint:
    if not any(mimic.higher):
        ratio = mimic.multiplier * leader.sign * follower.sign
        return Coupler(name, leader.name, follower.name, ratio, mimic.offset * follower.sign)
    factors = [mimic.offset, mimic.multiplier, *mimic.higher]
    parameters = {f"a{n}": a * follower.sign * leader.sign**n for n, a in enumerate(factors) if a}
    powers = (word if word == "a0" else f"{word}*{Name(leader.name)}^{word[1:]}" for word in parameters)
    return FormulaCoupler(name, follower.name, value=" + ".join(powers), parameters=parameters)


def _follow(name: str, mimics: Mapping[str, Mimic], starts: dict[str, Array]) -> Array:
    if name not in starts:
        starts[name] = np.zeros(1)
        if name in mimics:
            leader, multiplier, offset, higher = mimics[name]
            value, factors = _follow(leader, mimics, starts), (offset, multiplier, *higher)
            starts[name] = sum((a * value**n for n, a in enumerate(factors)), np.zeros(1))
    return starts[name]


def chained(merged: Merger, named: Collection[str]) -> Merger:
    """Return the links with a chain in place of each edge whose motions no joint has.

    Motions in ``named`` must be coordinates of a joint of their own, because a force or another joint refers to them.
    """
    edges, inertials = list[Edge](), dict(merged.inertials)
    for edge in merged.edges:
        links = list(_chain(edge)) if _needs_chain(edge.motions, named) else [edge]
        edges += links
        inertials |= {link.child: MASSLESS for link in links[:-1]}
    return replace(merged, edges=edges, inertials=inertials)


def _needs_chain(motions: tuple[Motion, ...], named: Collection[str]) -> bool:
    if len(motions) < 2:
        return False
    apart = (m.name for m in motions if m.name in named)
    return any(coordinate_of(motions, name) is None for name in apart) or not _has_joint(motions)


def _has_joint(motions: tuple[Motion, ...]) -> bool:
    try:
        joint(Hinge("", ground, ground, GROUND_POSE), motions)
    except ModelError:
        return False
    return True


def _chain(edge: Edge) -> Iterator[Edge]:
    """Yield one edge for each motion; every frame is where the link is before the motions that follow."""
    parent, pose = edge.parent, edge.pose
    for motion in edge.motions:
        last = motion is edge.motions[-1]
        child = edge.child if last else f"{edge.child}_{motion.name}"
        yield Edge(motion.name, parent, child, pose, (motion,), edge.line)
        parent, pose = child, GROUND_POSE
