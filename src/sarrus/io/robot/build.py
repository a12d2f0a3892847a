"""Conversion of a description to a model: bodies for moving links, joints between them, all in the initial pose."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from ...model.checks.origin import Origin
from ...model.errors import ModelError
from ...model.expansion.tree import Branch, walk
from ...model.geometry.motion import Free
from ...model.geometry.pose import GROUND_POSE
from ...model.geometry.solid import GROUND, Solid, ground
from ...model.joints import Joint
from ...model.quantity import Array
from ...model.show import quote
from ..plurals import counted
from .bodies import bodies_of
from .description import WORLD, Description, Edge, Limit, Link, legal
from .joints import Hinge, joint
from .loads.equalities import tendon_constraints
from .loads.forces import forces, located
from .mimics import couplers, followers, freed, standing
from .options import ImportOptions, known, values_of
from .robot import Robot
from .sensors import resolved, unresolved
from .tree.carried import Carried, part_on_bodies
from .tree.chains import chained
from .tree.closing import closed
from .tree.coordinates import Coordinates
from .tree.merge import Merged, fold, merge, stopped, without_mass
from .tree.spanning import BASE


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
    notes = [*description.notes, *(freed(description, locked) if options.mimic == "free" else ())]
    locking = counted("{n} [motion of a link|motions of links] without mass [is|are] locked", len(idle))
    notes += [f"{locking}: {', '.join(sorted(idle))}"] if idle else []
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
    for one in description.equalities.values():
        paths += [one.path, *([one.other] if one.other else [])]
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
    description: Description, options: ImportOptions, merged: Merged, values: Mapping[str, Array]
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
    held = [part_on_bodies(one) for one in _joints(description, joined, hinges)]
    if options.mimic == "couple":
        held += couplers(description, coordinates, {*names.values(), *joints.values()})
    held += tendon_constraints(description, coordinates, {*names.values(), *(one.name for one in held)})
    left = {motion.name for branch in branches for motion in branch.motions}
    taken = {*names.values(), *(one.name for one in held)}
    drawn = options.meshes == "draw"
    acting = forces(description, joined, hinges, coordinates, options.controls, taken)
    sensors = resolved(description, coordinates)
    called = legal(sensors, {*taken, *(one.name for one in acting)}, "_sensor")
    return Robot(
        description.name,
        bodies,
        tuple(held),
        acting,
        gravity=description.gravity,
        origin=_origin(description, merged, names, joints),
        branches=branches,
        links=links,
        limits={name: limit for name, limit in description.limits.items() if name in left},
        mimics={name: mimic for name, mimic in description.mimics.items() if name in left},
        visuals=tuple(v for v in description.visuals if drawn or v.shape != "mesh"),
        sensors={called[name]: sensor for name, sensor in sensors.items()},
        search=tuple(str(folder) for folder in options.search),
        notes=(
            *description.notes,
            *_outside(description.limits, left, values),
            *unresolved(description, sensors),
        ),
    )


def _joints(description: Description, merged: Merged, hinges: Mapping[str, Hinge]) -> Iterator[Joint]:
    for edge in merged.edges:
        with located(description, edge):
            made = joint(hinges[edge.name], edge.motions)
            if made is not None:
                yield made


def _outside(limits: Mapping[str, Limit], left: set[str], values: Mapping[str, Array]) -> Iterator[str]:
    """Yield a note for each joint that starts outside of its limits."""
    for name, limit in limits.items():
        value = float(values[name][0]) if name in values else 0.0
        lower, upper = limit.range()
        if name in left and not lower <= value <= upper:
            yield f"the joint {quote(name)} starts at {value:g}, outside of its limits {lower:g} and {upper:g}"


def _moves(edge: Edge, links: Mapping[str, Carried]) -> bool:
    """Return whether the links of an edge are on different bodies."""
    i, j = (links[link].body if link in links else None for link in (edge.parent, edge.child))
    return i is not j


def _closing(description: Description, edge: Edge, name: str, links: Mapping[str, Carried]) -> Hinge:
    """Return the two links of a joint that closes a loop."""
    ends = list[Solid]()
    for link in (edge.parent, edge.child):
        if link != description.root and link not in links:
            message = f"connects link {quote(link)}, which has no mass and no body. Give it mass"
            where = description.where(edge.line)
            raise ModelError(f"{message}.", part=f"joint {quote(edge.name)}", where=where)
        ends.append(ground if link == description.root and link not in links else links[link])
    return Hinge(name, ends[0], ends[1], edge.pose)


def _links(merged: Merged, names: Mapping[str, str], solids: Mapping[str, Solid]) -> dict[str, Carried]:
    places = {name: place for name, place in merged.places.items() if name != WORLD}
    return {name: Carried(name, solids[names[head]], pose) for name, (head, pose) in places.items()}


def _origin(
    description: Description, merged: Merged, names: Mapping[str, str], joints: Mapping[str, str]
) -> Origin | None:
    lines: dict[tuple[str | int, ...], int] = {}
    for edge in merged.edges:
        lines["bodies", names[edge.child]] = description.line_of(edge)
        lines["joints", joints[edge.name]] = edge.line
    return Origin(description.file, {path: line for path, line in lines.items() if line})
