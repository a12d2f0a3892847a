"""Where the motions of a description are in its model: coordinates of joints, and paths of tendons."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple, TypedDict

import numpy as np

from ....model.errors import ModelError
from ....model.forces.paths.wrapping import Wrap
from ....model.geometry.motion import Ball, Motion, Slide, Turn, relative
from ....model.geometry.points import Point
from ....model.geometry.pose import GROUND_POSE, Pose
from ....model.quantity import Array, triple
from ....model.show import quote
from ..description import WORLD, Edge, Obstacle, Path
from ..joints import coordinate_of
from .carried import LinkPlace


class CoordinateMatch(NamedTuple):
    """A coordinate of a joint, ``hook.angle``, its sign relative to the motion, and whether it is an angle."""

    name: str
    sign: float
    rotates: bool


class PathFields(TypedDict, total=False):
    """The fields of a `sarrus.Tendon` that give its path: points and factors, or joints."""

    points: Sequence[Point]
    factors: Sequence[float]
    around: Sequence[Wrap | None]
    joints: Mapping[str, float]


class Route(NamedTuple):
    """A path in the model: the fields of its `sarrus.Tendon`, and what its length is longer than x."""

    fields: PathFields
    start: float


class Coordinates:
    """The coordinates of the motions that are left, and the values of all others.

    Parameters
    ----------
    edges : those that are left
    joints : the names of their joints, by edge
    links : by name
    values : where motions are at the start
    """

    def __init__(
        self,
        edges: Iterable[Edge],
        joints: Mapping[str, str],
        links: Mapping[str, LinkPlace],
        values: Mapping[str, Array],
    ) -> None:
        self.edges = {motion.name: edge for edge in edges for motion in edge.motions}
        self.joints, self.links, self.values = joints, links, values

    def find(self, motion: str, remedy: str) -> CoordinateMatch:
        """Return the coordinate of a motion that is left.

        Raises
        ------
        ModelError
            If it is not a coordinate of its joint.
        """
        edge = self.edges[motion]
        found = coordinate_of(edge.motions, motion)
        if found is None:
            message = f"acts on {quote(motion)}, which neither rotates about one axis nor slides along one"
            raise ModelError(f"{message}. {remedy}")
        rotates = isinstance(next(one for one in edge.motions if one.name == motion), Turn)
        return CoordinateMatch(f"{self.joints[edge.name]}.{found[0]}", found[1], rotates)

    def lay(self, path: Path, remedy: str) -> Route | None:
        """Return a path in the model, None if its length is constant."""
        if path.points:
            return self._points(path)
        factors, start = dict[str, float](), path.start
        for motion, factor in path.joints.items():
            if motion in self.edges:
                coordinate = self.find(motion, remedy)
                factors[coordinate.name] = coordinate.sign * factor
            elif motion in self.values:
                start += factor * float(self.values[motion][0])
        return Route({"joints": factors}, start) if factors else None

    def _points(self, path: Path) -> Route | None:
        obstacles = path.around or [None] * len(path.factors)
        for link in (*(link for link, _ in path.points), *_links_of(obstacles)):
            if link not in self.links:
                message = f"uses {quote(link)}, a link without mass that became part of a joint"
                raise ModelError(f"{message}. Give it a mass.")
        points = [self.links[link].point(*place) for link, place in path.points]
        around = [self._wrap(obstacle) if obstacle else None for obstacle in obstacles]
        ends = zip(points, points[1:], path.factors, around, strict=False)
        if not any(factor and _moves(i, j, shape) for i, j, factor, shape in ends):
            return None
        fields: PathFields = {"points": points, "factors": path.factors}
        return Route(fields | {"around": around} if any(around) else fields, 0.0)

    def _wrap(self, obstacle: Obstacle) -> Wrap:
        link = self.links[obstacle.link]
        axis = triple(link.place.A @ np.array(obstacle.axis)) if obstacle.axis else None
        side = self.links[obstacle.side[0]].point(*obstacle.side[1]) if obstacle.side else None
        return Wrap(link.point(*obstacle.center), obstacle.radius, axis, side)


def _links_of(obstacles: Iterable[Obstacle | None]) -> list[str]:
    """Return the links of shapes, and of their sides."""
    pairs = [(one.link, one.side[0] if one.side else one.link) for one in obstacles if one]
    return [link for pair in pairs for link in pair]


def _moves(i: Point, j: Point, shape: Wrap | None) -> bool:
    """Return whether the length of a segment changes."""
    return any(end.body is not i.body for end in (j, *([shape.center] if shape else [])))


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
