"""The tree in a graph of links and joints, from the world outward, and the joints that close its loops."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Sequence

from ....model.errors import ModelError
from ....model.geometry.motion import Ball, Motion, Slide, Turn, relative
from ....model.geometry.pose import GROUND_POSE, Pose
from ..description import WORLD, Edge

BASE = "base"  # the motion of a floating root


def spanned(
    links: Iterable[str], edges: Sequence[Edge], root_edge: Callable[[str, str], Edge]
) -> tuple[list[Edge], list[Edge]]:
    """Return the edges of the tree, in its order, and those that close loops.

    An edge from a child to its parent is reversed, so that its coordinates are the same. The first link of each part
    that is not connected with the world is its root.

    Parameters
    ----------
    links : names, in the order in which roots are chosen; a link that is no child comes first
    edges : between them and WORLD
    root_edge : returns the edge with a name from the world to a root
    """
    tree, loops = list[Edge](), list[Edge]()
    reached, used = {WORLD}, set[str]()
    _grow(WORLD, edges, reached, used, tree, loops)
    children, names = {edge.child for edge in edges}, iter([BASE])
    for link in sorted(links, key=lambda name: name in children):
        if link not in reached:
            name = next(names, f"{link}_{BASE}")
            tree.append(root_edge(name, link))
            reached.add(link)
            _grow(link, edges, reached, used, tree, loops)
    return tree, loops


def _grow(
    root: str, edges: Sequence[Edge], reached: set[str], used: set[str], tree: list[Edge], loops: list[Edge]
) -> None:
    """Add what is connected with a link, near links first."""
    waiting = deque([root])
    while waiting:
        at = waiting.popleft()
        for edge in edges:
            if at not in (edge.parent, edge.child) or edge.name in used:
                continue
            used.add(edge.name)
            outward = edge if edge.parent == at else reversed_edge(edge)
            if outward.child in reached:
                loops.append(edge)
            else:
                tree.append(outward)
                reached.add(outward.child)
                waiting.append(outward.child)


def reversed_edge(edge: Edge) -> Edge:
    """Return the edge from the child to the parent, with the same coordinates."""
    there = relative(edge.pose, GROUND_POSE)
    motions = tuple(_reversed(motion, there) for motion in reversed(edge.motions))
    return Edge(edge.name, edge.child, edge.parent, there, motions, edge.line)


def _reversed(motion: Motion, parent: Pose) -> Motion:
    """Return the motion of the parent, which is at a pose in the child's axes."""
    if isinstance(motion, Turn):
        return Turn(motion.name, -parent.local_vector(motion.axis), parent.local_point(motion.point))
    if isinstance(motion, Slide):
        return Slide(motion.name, -parent.local_vector(motion.axis))
    if isinstance(motion, Ball):
        return Ball(motion.name, parent.local_point(motion.point))
    raise ModelError("moves freely, and cannot be reversed. Exchange its parent and child.", part=motion.name)
