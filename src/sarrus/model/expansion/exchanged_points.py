"""Joints whose two points are apart in the initial pose, because they are given in the axes of the wrong body."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from ... import elements
from ..quantity import Array
from .blueprint import Blueprint

APART = 1e-2  # of the mechanism's size: the least gap of a joint that counts
CLOSED = 1e-6  # of the mechanism's size: two points coincide


def exchanged_points(plan: Blueprint, place: Callable[[int, Array], Array], size: float) -> Iterator[str]:
    """Yield a message for each joint that would close if its points were exchanged, or has the same point twice.

    Parameters
    ----------
    plan : the blueprint of a model
    place : the function that returns the global position of a point of a body, by number, in the initial pose
    size : the extent of the mechanism [m]
    """
    for one in plan.placed:
        if not issubclass(one.element, elements.Spherical):
            continue
        (i, j), (s_i, s_j) = one.bodies, map(np.array, one.values)
        gap = float(np.linalg.norm(place(i, s_i) - place(j, s_j)))
        if gap <= APART * size:
            continue
        apart = f"{one.owner}: its points are {gap:.4g} m apart in the initial pose"
        if np.linalg.norm(place(i, s_j) - place(j, s_i)) <= CLOSED * size:
            yield f"{apart}, and coincide if they are exchanged. Give each point in the axes of its own body."
        elif i and np.any(s_i) and np.linalg.norm(s_i - s_j) <= CLOSED * size:
            yield f"{apart}, with the same coordinates in both bodies. Give each point in the axes of its own body."
