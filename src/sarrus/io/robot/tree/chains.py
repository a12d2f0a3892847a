"""Chains of joints for the motions between two links that no single joint has, with massless frames between them.

A frame is a body without mass and inertia. Its accelerations are determined, because each motion of the chain moves
the link at its end.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace

from ....model.errors import ModelError
from ....model.geometry.motion import Motion
from ....model.geometry.pose import GROUND_POSE
from ....model.geometry.solid import ground
from ..description import MASSLESS, Edge
from ..joints import Hinge, coordinate_of, joint
from .merge import Merged


def chained(merged: Merged, named: Collection[str]) -> Merged:
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
