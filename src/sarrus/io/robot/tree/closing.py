"""Joint coordinates at which the loops of a description are closed.

A loop is closed where points of its two links coincide: one for a ball joint, two along the axis of a revolute joint,
four for a fixed one. Unlike equations of right angles between axes, which a joint that is turned over by 180° satisfies
as well, this has one solution for the orientation. The search, a trust-region method along the tree with its exact
Jacobian, therefore also closes loops that are far open, as those of a description whose zero is no assembled pose.
It keeps to the limits of joints where these allow it, so that it finds the assembly mode that they leave.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping

import numpy as np
from scipy.optimize import least_squares

from ....euler import G
from ....model.expansion.tree import Branch, walk
from ....model.geometry.motion import Ball, Free, Motion, Turn, Twist, unit
from ....model.geometry.points import GROUND
from ....model.geometry.pose import GROUND_POSE, Pose
from ....model.quantity import Array
from ..description import Description, Edge, Limit

LEVER = 0.1  # of the largest distance in the tree: between the points of one loop
CLOSED = 1e-6  # of the largest distance in the tree: openings that are left to the assembly
SPREADS = (0.1, 0.3, 0.1, 0.3)  # random changes [rad, m, -] of the coordinates, for further searches
EVALUATIONS = 100  # of one search


def closed(description: Description, values: Mapping[str, Array], held: Collection[str]) -> dict[str, Array]:
    """Return the values of motions with which the loops are closed, or nearly so if no search closes them.

    Limits are exceeded only if no search within them closes the loops.

    Parameters
    ----------
    description : its loops have points that coincide if they are fixed, ball or revolute joints
    values : of motions by name, where the search begins; zero if left out
    held : motions that keep their values
    """
    if not description.loops:
        return dict(values)
    search = _Search(description, values, held)
    if not search.free or not search.ends or search.closes(search.start):
        return dict(values)
    best = search.start
    for bounds in search.bounds(description.limits):
        random = np.random.default_rng(0)
        for change in (0.0, *(spread * random.normal(size=len(best)) for spread in SPREADS)):
            best = min(best, search.solved(search.start + change, bounds), key=search.opening)
            if search.closes(best):
                return {**values, **search.values(best)}
    return {**values, **search.values(best)}


class _Search:
    """The openings of all loops as a function of the coordinates of a tree."""

    def __init__(self, description: Description, values: Mapping[str, Array], held: Collection[str]) -> None:
        self.branches = [
            Branch(_named(edge.parent, description), edge.child, edge.pose, edge.motions)
            for edge in description.edges
        ]
        motions = [motion for branch in self.branches for motion in branch.motions]
        self.given = dict(values)
        self.free = [motion for motion in motions if motion.name not in held and not isinstance(motion, Free)]
        self.start = np.array([x for one in self.free for x in self.given.get(one.name, np.array(one.zero))])
        self.size = (
            max((float(np.linalg.norm(s.pose.r)) for s in walk(self.branches, values)), default=0.0) or 1.0
        )
        self.ends = []  # of pairs of points: body i, point in its axes, body j, point in its axes
        for edge in description.loops:
            i, j = (_named(link, description) for link in (edge.parent, edge.child))
            points = _points(edge, LEVER * self.size)
            self.ends += [(i, edge.pose.global_point(point), j, point) for point in points]

    def values(self, theta: Array) -> dict[str, Array]:
        """Return the coordinates by motion, with Euler parameters of unit length."""
        parts = np.split(theta, np.cumsum([motion.width for motion in self.free])[:-1])
        return {
            motion.name: unit(part) if isinstance(motion, Ball) else part
            for motion, part in zip(self.free, parts, strict=True)
        }

    def bounds(self, limits: Mapping[str, Limit]) -> Iterator[Array]:
        """Yield the lowest and highest coordinates for searches: within limits if there are any, then without."""
        free = np.array([-np.inf, np.inf])
        ends = [
            limits[motion.name].range() if motion.width == 1 and motion.name in limits else free
            for motion in self.free
        ]
        within = np.repeat(np.array(ends).T, [motion.width for motion in self.free], axis=1)
        if np.isfinite(within).any():
            yield within
        yield np.tile(free[:, None], len(self.start))

    def solved(self, theta: Array, bounds: Array) -> Array:
        """Return the coordinates near to given ones with the smallest openings."""
        tight = {"xtol": 1e-15, "ftol": 1e-15, "gtol": 1e-15}
        solution = least_squares(
            self.openings, theta.clip(*bounds), self.jacobian, bounds, max_nfev=EVALUATIONS, **tight
        )
        return np.asarray(solution.x)

    def closes(self, theta: Array) -> bool:
        """Return whether all loops are closed, but for what the assembly closes."""
        return self.opening(theta) <= CLOSED * self.size

    def opening(self, theta: Array) -> float:
        """Return the largest distance of two points, by component."""
        return float(abs(self.openings(theta)).max())

    def openings(self, theta: Array) -> Array:
        """Return the distances of all pairs of points in global axes. (3 · pairs,)"""
        poses = self._poses(theta)[0]
        return np.concatenate(
            [poses[j].global_point(s_j) - poses[i].global_point(s_i) for i, s_i, j, s_j in self.ends]
        )

    def jacobian(self, theta: Array) -> Array:
        """Return the derivative of the openings. (3 · pairs, coordinates)"""
        poses, carried = self._poses(theta)
        columns, count = self._columns(theta)
        J = np.zeros((3 * len(self.ends), count))
        for n, (i, s_i, j, s_j) in enumerate(self.ends):
            for sign, body, s in ((-1, i, s_i), (1, j, s_j)):
                point = poses[body].global_point(s)
                for key, twist in carried[body].items():
                    if key in columns:
                        place, factors = columns[key]
                        J[3 * n : 3 * n + 3, place] += sign * np.outer(twist.at(point), factors)
        return J

    def _poses(self, theta: Array) -> tuple[dict[str, Pose], dict[str, dict[tuple[str, int], Twist]]]:
        """Return the pose of each link, and the twists that move it by motion and freedom."""
        poses, carried = {GROUND: GROUND_POSE}, {GROUND: dict[tuple[str, int], Twist]()}
        for step in walk(self.branches, {**self.given, **self.values(theta)}):
            keys = [(motion.name, k) for motion in step.branch.motions for k in range(motion.freedoms)]
            poses[step.branch.body] = step.pose
            carried[step.branch.body] = carried[step.branch.parent] | dict(
                zip(keys, step.twists, strict=True)
            )
        return poses, carried

    def _columns(self, theta: Array) -> tuple[dict[tuple[str, int], tuple[slice, Array]], int]:
        """Return the columns of each freedom, with its derivatives by the coordinates of the motion."""
        columns, first = dict[tuple[str, int], tuple[slice, Array]](), 0
        for motion in self.free:
            place = slice(first, first + motion.width)
            for k, factors in enumerate(_speeds(motion, theta[place])):
                columns[motion.name, k] = (place, factors)
            first += motion.width
        return columns, first


def _speeds(motion: Motion, values: Array) -> Array:
    """Return the derivative of a motion's velocity by the rates of its coordinates: ω = 2 G(p) ṗ for a ball."""
    if not isinstance(motion, Ball):
        return np.eye(motion.width)
    length = float(np.linalg.norm(values))
    return np.asarray(2 * G(values / length) / length)


def _points(edge: Edge, lever: float) -> Iterator[Array]:
    """Yield the points of the child that coincide with those of the parent; none for other kinds of joints."""
    origin = np.zeros(3)
    if not edge.motions:
        yield from (origin, *lever * np.eye(3))
    elif len(edge.motions) == 1 and isinstance(edge.motions[0], Ball | Turn):
        yield edge.motions[0].point
        if isinstance(edge.motions[0], Turn):
            yield edge.motions[0].point + lever * edge.motions[0].axis


def _named(link: str, description: Description) -> str:
    return GROUND if link == description.root else link
