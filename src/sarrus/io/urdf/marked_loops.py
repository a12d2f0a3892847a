"""Loops that links mark by their names, as onshape-to-robot writes them: ``closing_NAME_1`` and ``closing_NAME_2``.

The two links coincide. Two more, ``closing_NAME_1_z`` and ``closing_NAME_2_z``, are on the axis of a revolute joint;
without them, the file does not have the kind of joint.
"""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Collection, Iterator
from dataclasses import replace

import numpy as np

from ...model.errors import SarrusWarning
from ...model.expansion.expand import expand
from ...model.geometry.motion import Turn
from ...model.geometry.pose import GROUND_POSE
from ...model.show import quote
from ..robot import Description, Edge, Robot

PREFIX, FIRST, SECOND, AXIS = "closing_", "_1", "_2", "_z"


def marked_loops(links: Collection[str]) -> list[Edge]:
    """Return the revolute joints that links mark."""
    return [
        Edge(
            first.removesuffix(FIRST),
            first,
            second,
            GROUND_POSE,
            (Turn(first.removesuffix(FIRST), np.array([0.0, 0.0, 1.0]), np.zeros(3)),),
        )
        for first, second in _pairs(links, with_axis=True)
    ]


def without_marked_loops(description: Description) -> Description:
    """Return the description without the joints that links mark, and a note on them."""
    if not description.loops:
        return description
    names = ", ".join(quote(edge.name) for edge in description.loops)
    note = f"the loops that links mark, {names}: left out, as those of `loops` take their place"
    return replace(description, loops=(), notes=[*description.notes, note])


def with_open_loops_noted(robot: Robot, links: Collection[str]) -> Robot:
    """Return the robot with a note for each pair of links that mark a loop without its axis, if no joint closes it."""
    pairs = list(_pairs(links, with_axis=False))
    if not pairs:
        return robot
    joints = {joint.name for joint in robot.joints}
    closed = {(owner, frozenset(one.bodies)) for owner, one in expand(robot).pieces if owner in joints}
    joined = Counter(pair for _, pair in closed)
    joined.subtract({frozenset((branch.parent, branch.body)) for branch in robot.branches})
    bodies = {name: link.body.name for name, link in robot.links.items()}
    remedy = "with `loops`, or with a joint in Python"
    notes = [
        f"the loop between {quote(first)} and {quote(second)}, left open: close it {remedy}"
        for first, second in pairs
        if joined[frozenset((bodies.get(first, first), bodies.get(second, second)))] <= 0
    ]
    for note in notes:
        warnings.warn(note, SarrusWarning, stacklevel=4)
    return replace(robot, notes=(*robot.notes, *notes))


def _pairs(links: Collection[str], *, with_axis: bool) -> Iterator[tuple[str, str]]:
    """Yield the links that mark a loop, with two more on its axis or without them."""
    for first in links:
        second = first.removesuffix(FIRST) + SECOND
        marked = first.startswith(PREFIX) and first.endswith(FIRST) and second in links
        if marked and ({first + AXIS, second + AXIS} <= {*links}) == with_axis:
            yield first, second
