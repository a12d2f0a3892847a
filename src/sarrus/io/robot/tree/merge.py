"""Links that move as one become one body: fixed and locked edges disappear, the others become branches."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from ....model.bodies.body import Body, MassProperties
from ....model.errors import ModelError
from ....model.geometry.motion import Motion, compose
from ....model.geometry.pose import GROUND_POSE, Pose
from ....model.quantity import ROUND_OFF, Array, positive, vector
from ....model.show import quote
from ..description import MASSLESS, WORLD, Description, Edge, Inertia, combined
from ..options import InertiaOption


class Place(NamedTuple):
    """The link whose frame is the body's, and where a link is in it."""

    head: str
    pose: Pose


@dataclass
class Merger:
    """Result of merging links.

    Attributes
    ----------
    places : every link -> its place; the head is WORLD for what does not move
    edges : those that are left, between heads, in the order of the tree
    inertials : head -> the inertial of all that is merged into it
    """

    places: dict[str, Place] = field(default_factory=dict)
    edges: list[Edge] = field(default_factory=list)
    inertials: dict[str, Inertia] = field(default_factory=dict)


def merge(description: Description, *, keep_fixed: bool) -> Merger:
    """Return the heads and branches of a description, whose root is fixed."""
    merged = Merger()
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
    pose, moving = edge.pose, list[Motion]()
    for motion in edge.motions:
        if motion.name in values:
            stop = motion.moved(GROUND_POSE, values[motion.name])
            pose, moving = compose(pose, stop), [_behind(stop, one) for one in moving]
        else:
            moving.append(motion)
    return replace(edge, pose=pose, motions=tuple(moving))


def _behind(stop: Pose, motion: Motion) -> Motion:
    converted = motion.expressed_in(stop)
    if converted is None:
        message = "can be locked only together with the joints after it. Lock them all, or none."
        raise ModelError(message, part=f"joint {quote(motion.name)}")
    return converted


def _take(merged: Merger, description: Description, link: str) -> None:
    """Add a link's inertial to that of its head."""
    head, pose = merged.places[link]
    inertial = description.links[link].inertial
    if inertial is not None and head != WORLD:
        before = [merged.inertials[head]] if head in merged.inertials else []
        merged.inertials[head] = combined([*before, inertial.seen_from(pose)])


def _can_stand_alone(merged: Merger, description: Description, edge: Edge) -> bool:
    """Whether a fixed link may stay a body: it and what it hangs on have mass."""
    inertial, head = description.links[edge.child].inertial, merged.places[edge.parent].head
    heavy = head == WORLD or (head in merged.inertials and merged.inertials[head].mass > 0)
    return inertial is not None and inertial.mass > 0 and heavy


def fold(merged: Merger) -> Merger:
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
    return Merger(places, list(above.values()), merged.inertials)


def _has_mass(link: str, merged: Merger) -> bool:
    inertial = merged.inertials.get(link)
    return inertial is not None and inertial.mass > 0


def _take_out(link: str, above: dict[str, Edge], below: dict[str, set[str]]) -> None:
    """Join the edge above a link with the one below it, if one joint can have the motions of both."""
    (child,) = below[link]
    joined = _in_one(above[link], above[child])
    if joined is not None:
        above[child] = joined
        del above[link]
        below[joined.parent] ^= {link, child}


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


def bodies_of(
    description: Description,
    inertia: InertiaOption,
    merged: Merger,
    names: Mapping[str, str],
    poses: Mapping[str, Pose],
) -> tuple[Body, ...]:
    """Return a checked body for every link that heads others.

    Raises
    ------
    ModelError
        If nothing moves, or a body has an inertia that no body can have.
    """
    if not merged.edges:
        urdf = description.file.lower().endswith(".urdf")
        remedy = 'Import it with base="floating", or give it' if urdf else "Give a body"
        message = f"nothing in it moves. {remedy} a joint that moves."
        raise ModelError(message, part="robot", where=description.file)
    bodies = []
    for edge in merged.edges:
        name, inertial = names[edge.child], _inertial(merged, edge)
        kind = Body if inertia == "check" or inertial is MASSLESS else UncheckedBody
        try:
            body = _body(kind, name, inertial, poses[name])
            body.mass_properties()
        except ModelError as error:
            checked = error.field == "inertia" and inertia == "check"
            remedy = ' Or take it as it is: inertia="given".' if checked else ""
            part, where = f"link {quote(edge.child)}", description.where(description.line_of(edge))
            raise ModelError(error.message + remedy, part=part, field=error.field, where=where) from None
        bodies.append(body)
    return tuple(bodies)


def _body(kind: type[Body], name: str, inertial: Inertia, pose: Pose) -> Body:
    return kind(name, inertial.mass, inertial.tensor, pose.r, pose.p, inertial.center)


def _inertial(merged: Merger, edge: Edge) -> Inertia:
    """Return the inertial of a link with what is fixed to it; without mass it is a frame between joints."""
    inertial = merged.inertials.get(edge.child)
    return inertial if inertial is not None and inertial.mass else MASSLESS


GYRATION = 1e-6  # [m] radius of gyration of such a moment where the others are zero, too


@dataclass(frozen=True, eq=False)
class UncheckedBody(Body):
    """A body whose inertia need not be that of a distribution of mass, but may not be negative about any axis."""

    def mass_properties(self) -> MassProperties:
        """Return the mass, inertia and centre of mass.

        Raises
        ------
        ModelError
            If a principal moment is negative or no number: some rotation would have a negative kinetic energy.
        """
        mass = positive(self.mass, "mass", "Give the mass in kg.")
        J = np.array(self.inertia, dtype=float)
        _check_not_negative(J, mass)
        xx, yy, zz, xy, xz, yz = (float(J[i, j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))
        center = (0.0, 0.0, 0.0) if self.center_of_mass is None else self.center_of_mass
        return MassProperties(mass, (xx, yy, zz, xy, xz, yz), vector(center, "center_of_mass"))


def _check_not_negative(J: Array, mass: float) -> None:
    moments = np.linalg.eigvalsh(J) if np.all(np.isfinite(J)) else np.full(3, np.nan)
    if not moments[0] >= -max(ROUND_OFF * abs(moments).max(), mass * GYRATION**2):
        message = ", ".join(f"{moment:.6g}" for moment in moments)
        raise ModelError(
            f"inertia has the principal moments {message}, but a negative one gives a negative kinetic energy. "
            "Correct the inertia.",
            field="inertia",
        )
