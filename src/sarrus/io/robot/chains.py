"""Links without mass between two joints: the joints become one, as three hinges through such links are a ball joint."""

from __future__ import annotations

from ...model.motion import Motion, compose
from .description import WORLD, Edge
from .merge import Merged


def fold(merged: Merged) -> Merged:
    """Return what is left when every link without mass that carries just one other is taken out.

    Such a link has no place of its own afterwards; one that carries none, or several, stays.
    """
    edges = list(merged.edges)
    for edge in merged.edges:
        edges = _without(edges, edge.child, merged)
    heads = {WORLD, *(edge.child for edge in edges)}
    places = {name: place for name, place in merged.places.items() if place.head in heads}
    return Merged(places, edges, merged.inertials)


def _without(edges: list[Edge], link: str, merged: Merged) -> list[Edge]:
    inertial = merged.inertials.get(link)
    above = next(edge for edge in edges if edge.child == link)
    below = [edge for edge in edges if edge.parent == link]
    if (inertial is not None and inertial.mass > 0) or len(below) != 1:
        return edges
    one = _in_one(above, below[0])
    return (
        edges if one is None else [one if edge is below[0] else edge for edge in edges if edge is not above]
    )


def _in_one(above: Edge, below: Edge) -> Edge | None:
    """Return both edges as one, or None if the motions of the first cannot be said in the axes of the second."""
    motions: list[Motion] = []
    for motion in above.motions:
        said = motion.said_in(below.pose)
        if said is None:
            return None
        motions.append(said)
    pose = compose(above.pose, below.pose)
    return Edge(below.name, above.parent, below.child, pose, (*motions, *below.motions), below.line)
