"""Links without mass between two joints: the joints become one, as three hinges through such links are a ball joint."""

from __future__ import annotations

from ...model.geometry.motion import Motion, compose
from .description import WORLD, Edge
from .merge import Merged


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
