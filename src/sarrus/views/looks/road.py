"""The road under tyres: slabs below the paths of their wheels, with the profile or the surface of the road."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...algebra import Array
from ...model.expansion.blueprint import Blueprint
from ...model.laws.law import varies
from ..meshes.mesh import Mesh, joined
from .anchors import Anchor, fields
from .part import GROUND, LOOK, Part, place_of


class Road(NamedTuple):
    """A slab, and the law of time [m] that is added to its height: None of one that does not move."""

    part: Part
    bump: Callable[[float], float] | None

    def lowest(self, up: Array, t: Array) -> float:
        """Its least height [m] at some times."""
        bumps = [0.0] if self.bump is None else [float(self.bump(at)) for at in t.tolist()]
        return float((self.part.mesh.vertices @ up).min() + min(bumps) * up[2])


def roads_of(plan: Blueprint, tyres: Sequence[Anchor], positions: Array) -> Iterator[Road]:
    """Yield a slab for each road; tyres on the same one have it in common."""
    values = {one.owner: fields(one) for one in plan.placed if one.label == "tyre"}
    roads: dict[str, list[Anchor]] = {}
    for tyre in tyres:
        laws = [getattr(tyre.part, field, 0.0) for field in ("road", "bump")]
        roads.setdefault(repr(laws), []).append(tyre)
    for own in roads.values():
        paths = np.concatenate([place_of(positions, one.bodies[0], one.points[0]) for one in own])
        radius = max(float(one.part.radius) for one in own)
        name = "road of " + ", ".join(one.name for one in own)
        given = values[own[0].name]
        bump = given["bump"] if varies(getattr(own[0].part, "bump", 0.0)) else None
        slab = _slab(given, paths, radius)
        yield Road(Part(name, "ground", "road", 0, slab, GROUND), bump)


def _slab(values: dict[str, Any], paths: Array, radius: float) -> Mesh:
    """A slab below paths (n, 3) of the centres of wheels."""
    low, high = paths.min(axis=0), paths.max(axis=0)
    ends = low[0] - LOOK.road_ends * radius, high[0] + LOOK.road_ends * radius
    sides = low[1] - LOOK.road_sides * radius, high[1] + LOOK.road_sides * radius
    stations, across, surface = 2, 2, values.get("surface")
    if surface is not None:
        ends, sides = _within(ends, surface.x), _within(sides, surface.y)
        across = int(np.clip(np.ceil(LOOK.stations * np.ptp(sides) / np.ptp(ends)), 2, LOOK.stations))
    if surface is not None or "profile" in values:
        stations = LOOK.stations
    x, y = np.linspace(*ends, stations), np.linspace(sides[1], sides[0], across)
    height = np.full((stations, across), float(values["road"]))
    if surface is not None:
        height += surface.height(x[:, None], y)
    elif "profile" in values:
        height += np.array([[values["profile"](at)] for at in x.tolist()])
    thickness = LOOK.road_height * radius
    lines = [np.column_stack([x, np.full(len(x), at), z]) for at, z in zip(y, height.T, strict=True)]
    ring = [*lines, *(line - [0.0, 0.0, thickness] for line in reversed(lines))]
    begin, end = (np.array([line[at] for line in ring]) for at in (0, -1))
    top, below = slice(across), slice(None, across - 1, -1)
    caps = [_ribbon(begin[top], begin[below]), _ribbon(end[below], end[top])]
    return joined([*(_ribbon(line, ring[n + 1 - len(ring)]) for n, line in enumerate(ring)), *caps])


def _within(ends: tuple[float, float], knots: Array) -> tuple[float, float]:
    """An interval as far as a grid reaches; all of it if it is beyond."""
    inside = np.clip(ends, knots[0], knots[-1])
    return (float(inside[0]), float(inside[1])) if inside[1] > inside[0] else ends


def _ribbon(first_line: Array, second_line: Array) -> Mesh:
    """The surface between two lines of as many points."""
    k, count = np.arange(len(first_line) - 1), len(first_line)
    faces = [np.column_stack([k, k + count, k + 1]), np.column_stack([k + 1, k + count, k + 1 + count])]
    return Mesh(np.concatenate([first_line, second_line]), np.concatenate(faces))
