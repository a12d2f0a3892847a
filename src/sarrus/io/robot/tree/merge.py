"""Links that move as one become one body: fixed and locked edges disappear, the others become branches."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from ....model.errors import ModelError
from ....model.geometry.motion import Motion, compose
from ....model.geometry.pose import GROUND_POSE, Pose
from ....model.quantity import Array
from ....model.show import quote
from ..description import WORLD, Description, Edge, Inertial, combined


class Place(NamedTuple):
    """The link whose frame is the body's, and where a link is in it."""

    head: str
    pose: Pose


@dataclass
class Merged:
    """Result of merging links.

    Attributes
    ----------
    places : every link -> its place; the head is WORLD for what does not move
    edges : those that are left, between heads, in the order of the tree
    inertials : head -> the inertial of all that is merged into it
    """

    places: dict[str, Place] = field(default_factory=dict)
    edges: list[Edge] = field(default_factory=list)
    inertials: dict[str, Inertial] = field(default_factory=dict)


def merge(description: Description, *, keep_fixed: bool) -> Merged:
    """Return the heads and branches of a description, whose root is fixed."""
    merged = Merged()
    merged.places[description.root] = Place(WORLD, GROUND_POSE)
    _take(merged, description, description.root)
    for edge in description.edges:
        parent = merged.places[edge.parent]
        pose = compose(parent.pose, edge.pose)
        if not edge.motions and not (keep_fixed and _can_stand_alone(merged, description, edge)):
            merged.places[edge.child] = Place(parent.head, pose)
        else:
            merged.places[edge.child] = Place(edge.child, GROUND_POSE)
            merged.edges.append(Edge(edge.name, parent.head, edge.child, pose, edge.motions, edge.line))
        _take(merged, description, edge.child)
    return merged


def without_mass(description: Description) -> set[str]:
    """Return the motions that move no mass.

    Raises
    ------
    ModelError
        If links move, and none has mass.
    """
    heavy = {name for name, link in description.links.items() if link.inertial and link.inertial.mass > 0}
    if not heavy and any(edge.motions for edge in description.edges):
        raise ModelError("has no mass. Give its links inertials.", part="robot", where=description.file)
    idle = set[str]()
    for edge in reversed(description.edges):
        if edge.child in heavy:
            heavy.add(edge.parent)
        else:
            idle |= {motion.name for motion in edge.motions}
    return idle


def stopped(edge: Edge, values: Mapping[str, Array]) -> Edge:
    """Return the edge with a constant displacement in place of each stopped motion, before those that are left."""
    pose, left = edge.pose, list[Motion]()
    for motion in edge.motions:
        if motion.name in values:
            stop = motion.moved(GROUND_POSE, values[motion.name])
            pose, left = compose(pose, stop), [_behind(stop, one) for one in left]
        else:
            left.append(motion)
    return replace(edge, pose=pose, motions=tuple(left))


def _behind(stop: Pose, motion: Motion) -> Motion:
    converted = motion.expressed_in(stop)
    if converted is None:
        message = "can be locked only together with the joints after it. Lock them all, or none."
        raise ModelError(message, part=f"joint {quote(motion.name)}")
    return converted


def _take(merged: Merged, description: Description, link: str) -> None:
    """Add a link's inertial to that of its head."""
    head, pose = merged.places[link]
    inertial = description.links[link].inertial
    if inertial is not None and head != WORLD:
        held = [merged.inertials[head]] if head in merged.inertials else []
        merged.inertials[head] = combined([*held, inertial.seen_from(pose)])


def _can_stand_alone(merged: Merged, description: Description, edge: Edge) -> bool:
    """Whether a fixed link may stay a body: it and what it hangs on have mass."""
    inertial, head = description.links[edge.child].inertial, merged.places[edge.parent].head
    heavy = head == WORLD or (head in merged.inertials and merged.inertials[head].mass > 0)
    return inertial is not None and inertial.mass > 0 and heavy


def fold(merged: Merged) -> Merged:
    """Return what is left when every link without mass that carries just one other is taken out.

    Such a link has no place of its own afterwards; one that carries none, or several, stays.
    """
    above = {edge.child: edge for edge in merged.edges}
    below: dict[str, set[str]] = {}
    for edge in merged.edges:
        below.setdefault(edge.parent, set()).add(edge.child)
    for edge in merged.edges:
        if not _has_mass(edge.child, merged) and len(below.get(edge.child, ())) == 1:
            _take_out(edge.child, above, below)
    heads = {WORLD, *above}
    places = {name: place for name, place in merged.places.items() if place.head in heads}
    return Merged(places, list(above.values()), merged.inertials)


def _has_mass(link: str, merged: Merged) -> bool:
    inertial = merged.inertials.get(link)
    return inertial is not None and inertial.mass > 0


def _take_out(link: str, above: dict[str, Edge], below: dict[str, set[str]]) -> None:
    """Join the edge above a link with the one below it, if one joint can have the motions of both."""
    (child,) = below[link]
    one = _in_one(above[link], above[child])
    if one is not None:
        above[child] = one
        del above[link]
        below[one.parent] ^= {link, child}


def _in_one(above: Edge, below: Edge) -> Edge | None:
    """Return both edges as one, or None if the motions of the first cannot be expressed in the axes of the second."""
    motions: list[Motion] = []
    for motion in above.motions:
        converted = motion.expressed_in(below.pose)
        if converted is None:
            return None
        motions.append(converted)
    pose = compose(above.pose, below.pose)
    return Edge(below.name, above.parent, below.child, pose, (*motions, *below.motions), below.line)
