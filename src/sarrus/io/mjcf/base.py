"""Whether the bodies of the world move freely, where that is not as in the file."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...model.geometry.motion import Free, pose, unit
from ...model.geometry.pose import GROUND_POSE
from ...model.quantity import Array
from ..robot import Description
from ..robot.options import Base, check_floating
from ..robot.tree.spanning import BASE


def with_base(description: Description, base: Base) -> Description:
    """Return a description whose free bodies are fixed, or whose first fixed body is free."""
    edges, zero = list(description.edges), dict(description.zero)
    free = [n for n, edge in enumerate(edges) if edge.motions and isinstance(edge.motions[0], Free)]
    if base == "fixed":
        for n in free:
            values: Array = np.array(zero.pop(edges[n].motions[0].name))
            edges[n] = replace(edges[n], pose=pose(values[:3], unit(values[3:])), motions=())
    roots = [n for n, edge in enumerate(edges) if edge.parent == description.root and not edge.motions]
    if base == "floating" and not free and roots:
        there = edges[roots[0]].pose
        zero[BASE] = [*map(float, there.r), *map(float, there.p)]
        edges[roots[0]] = replace(edges[roots[0]], name=BASE, pose=GROUND_POSE, motions=(Free(BASE),))
    check_floating(base, edges)
    return replace(description, edges=edges, zero=zero)
