"""Loops that links mark by their names, as onshape-to-robot writes them: ``closing_NAME_1`` and ``closing_NAME_2``.

The two links coincide. Two more, ``closing_NAME_1_z`` and ``closing_NAME_2_z``, are on the axis of a revolute joint;
without them, the file does not have the kind of joint.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from ...model.geometry.motion import Turn
from ...model.geometry.pose import GROUND_POSE
from ...model.show import quote
from ..robot import Edge

PREFIX, FIRST, SECOND, AXIS = "closing_", "_1", "_2", "_z"


def marked_loops(links: Collection[str]) -> tuple[list[Edge], list[str]]:
    """Return the revolute joints that links mark, and a note for each loop that stays open."""
    loops, notes = [], []
    for link in links:
        name, first, second = link.removesuffix(FIRST), link, link.removesuffix(FIRST) + SECOND
        if not link.startswith(PREFIX) or not link.endswith(FIRST) or second not in links:
            continue
        if {first + AXIS, second + AXIS} <= set(links):
            turn = Turn(name, np.array([0.0, 0.0, 1.0]), np.zeros(3))
            loops.append(Edge(name, first, second, GROUND_POSE, (turn,)))
        else:
            remedy = "with `loops`, or with a joint in Python"
            notes.append(f"the loop between {quote(first)} and {quote(second)}, left open: close it {remedy}")
    return loops, notes
