"""Zones of touch sensors: unions of convex solids, each an intersection of ellipsoids, elliptic cylinders and slabs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from ...model.tape import value_of

LEAST = 1e-200  # in place of a zero in a division


class Solid(NamedTuple):
    """Points x with |(x − center)/sizes| ≤ 1 over each group of axes: all three for an ellipsoid, one for a slab."""

    sizes: Sequence[float]  # [m]
    groups: Sequence[Sequence[int]]
    center: Sequence[float] = (0.0, 0.0, 0.0)


Zone: TypeAlias = "Sequence[Solid]"
ALL, ROUND, EACH = ((0, 1, 2),), ((0, 1), (2,)), ((0,), (1,), (2,))


def zone(shape: str, sizes: Sequence[float]) -> Zone:
    """Return a zone by its shape and MuJoCo's sizes: radii, and halves of sides and lengths [m]."""
    radius, half = float(sizes[0]), float(sizes[1])
    if shape == "sphere":
        return (Solid((radius,) * 3, ALL),)
    if shape in ("ellipsoid", "box"):
        return (Solid(tuple(map(float, sizes)), ALL if shape == "ellipsoid" else EACH),)
    cylinder = Solid((radius, radius, half), ROUND)
    if shape == "cylinder":
        return (cylinder,)
    assert shape == "capsule"
    return cylinder, *(Solid((radius,) * 3, ALL, (0.0, 0.0, end)) for end in (-half, half))


def is_met(zone: Zone, start: Any, ray: Any) -> Any:
    """Return whether a half-line from a point in a direction meets a zone, all in the axes of the zone."""
    met: Any = False
    for solid in zone:
        first: Any = 0.0
        last: Any = np.inf
        at, along = (start - np.array(solid.center)) / solid.sizes, ray / np.array(solid.sizes)
        for axes in (list(group) for group in solid.groups):
            s, r = at[axes], along[axes]
            a, b, c = (
                value_of(one) for one in (r @ r, s @ r, s @ s - 1)
            )  # |s + τ r|² − 1 = a τ² + 2 b τ + c
            a = np.maximum(a, LEAST)
            root = np.sqrt(np.maximum(b * b - a * c, 0.0))
            first = np.where(b * b < a * c, np.inf, np.maximum(first, (-b - root) / a))
            last = np.minimum(last, (-b + root) / a)
        met = met | (first <= last)
    return met
