"""From a description to a model: bodies where links move, joints between them, all in the initial pose."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from ...model.errors import ModelError
from ...model.joints import Joint
from ...model.motion import Free
from ...model.origin import Origin
from ...model.pose import GROUND_POSE
from ...model.quantity import Array
from ...model.show import quote
from ...model.solid import GROUND, Solid, ground
from ...model.tree import Branch, walk
from .bodies import bodies_of
from .carried import Carried
from .chains import fold
from .description import WORLD, Description, Edge, Link
from .joints import Hinge, joint
from .merge import Merged, lock, merge
from .mimics import couplers, followers, freed, standing
from .names import legal
from .robot import Robot
from .values import known, values_of
from .wishes import Wishes

BASE = "base"  # the motion of a floating root


def build(told: Description, wishes: Wishes) -> Robot:
    """Return the model of a description.

    Raises
    ------
    ModelError
        For a link that moves without mass, motions that no joint leaves, or a wish that cannot be met.
    """
    wishes.check()
    told = _floating(told) if wishes.base == "floating" else told
    motions = {motion.name: motion for edge in told.edges for motion in edge.motions}
    values = followers(told, values_of({**told.zero, **wishes.q0}, motions, "q0"))
    locked = {known(name, motions, "lock") for name in wishes.lock}
    if wishes.mimic == "lock":
        locked |= set(told.mimics)
    if wishes.mimic == "couple":
        locked = standing(told.mimics, locked)
    stops = {name: values.get(name, np.array(motions[name].zero)) for name in locked}
    notes = [*told.notes, *(freed(told, locked) if wishes.mimic == "free" else ())]
    told = replace(told, edges=lock(told.edges, stops), notes=notes)
    merged = fold(merge(told, keep_fixed=wishes.keep_fixed))
    return _robot(told, wishes, merged, values)


def _floating(told: Description) -> Description:
    """Return the description with what stands still as its root, on which the former root moves freely."""
    if any(edge.name == BASE for edge in told.edges):
        sentence = f"has the name of the motion of a floating root; rename joint {quote(BASE)}"
        raise ModelError(sentence, part=f"joint {quote(BASE)}", where=told.file)
    edge = Edge(BASE, WORLD, told.root, GROUND_POSE, (Free(BASE),), told.links[told.root].line)
    links = {WORLD: Link(WORLD, None), **told.links}
    return replace(told, root=WORLD, edges=[edge, *told.edges], links=links)


def _robot(told: Description, wishes: Wishes, merged: Merged, values: Mapping[str, Array]) -> Robot:
    names = {WORLD: GROUND, **legal([edge.child for edge in merged.edges], {GROUND}, "_link")}
    branches = tuple(Branch(names[e.parent], names[e.child], e.pose, e.motions) for e in merged.edges)
    poses = {step.branch.body: step.pose for step in walk(branches, values)}
    bodies = bodies_of(told, wishes.inertia, merged, names, poses)
    joints = legal([edge.name for edge in merged.edges], set(names.values()), "_joint")
    solids: dict[str, Solid] = {GROUND: ground, **{body.name: body for body in bodies}}
    held = list(_joints(told, merged, names, joints, solids))
    if wishes.mimic == "couple":
        held += couplers(told, merged, joints, {*names.values(), *joints.values()})
    left = {motion.name for branch in branches for motion in branch.motions}
    return Robot(
        told.name,
        bodies,
        tuple(held),
        gravity=told.gravity,
        origin=_origin(told, merged, names, joints),
        branches=branches,
        links=_links(merged, names, solids),
        limits={name: limit for name, limit in told.limits.items() if name in left},
        mimics={name: mimic for name, mimic in told.mimics.items() if name in left},
        visuals=tuple(told.visuals),
        notes=tuple(told.notes),
    )


def _joints(
    told: Description,
    merged: Merged,
    names: Mapping[str, str],
    joints: Mapping[str, str],
    solids: Mapping[str, Solid],
) -> Iterator[Joint]:
    for edge in merged.edges:
        parent, child = solids[names[edge.parent]], solids[names[edge.child]]
        try:
            made = joint(Hinge(joints[edge.name], parent, child, edge.pose), edge.motions)
        except ModelError as error:
            part = f"joint {quote(edge.name)}"
            raise ModelError(error.sentence, part=part, where=told.where(edge.line)) from None
        if made is not None:
            yield made


def _links(merged: Merged, names: Mapping[str, str], solids: Mapping[str, Solid]) -> dict[str, Carried]:
    places = {name: place for name, place in merged.places.items() if name != WORLD}
    return {name: Carried(name, solids[names[head]], pose) for name, (head, pose) in places.items()}


def _origin(
    told: Description, merged: Merged, names: Mapping[str, str], joints: Mapping[str, str]
) -> Origin | None:
    lines: dict[tuple[str | int, ...], int] = {}
    for edge in merged.edges:
        lines["bodies", names[edge.child]] = told.links[edge.child].line
        lines["joints", joints[edge.name]] = edge.line
    return Origin(told.file, {path: line for path, line in lines.items() if line})
