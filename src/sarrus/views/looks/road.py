"""The road under tyres: slabs below the paths of their wheels, with the profile of the road."""

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
    """Yield a slab for each road; tyres on the same one have it in common.

    Those that move have the numbers of bodies behind those of the model.
    """
    number = len(plan.bodies)
    values = {one.owner: fields(one) for one in plan.placed}
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
        number += bump is not None
        slab = _slab(given, paths, radius)
        yield Road(Part(name, "ground", "road", number if bump else 0, slab, GROUND), bump)


def _slab(values: dict[str, Any], paths: Array, radius: float) -> Mesh:
    """A slab below paths (n, 3) of the centres of wheels."""
    low, high = paths.min(axis=0), paths.max(axis=0)
    x = np.linspace(
        low[0] - LOOK.road_ends * radius,
        high[0] + LOOK.road_ends * radius,
        LOOK.stations if "profile" in values else 2,
    )
    height = np.full(len(x), float(values["road"]))
    if "profile" in values:
        height += [values["profile"](at) for at in x.tolist()]
    left, right = low[1] - LOOK.road_sides * radius, high[1] + LOOK.road_sides * radius
    edges = [(right, 0.0), (left, 0.0), (left, LOOK.road_height * radius), (right, LOOK.road_height * radius)]
    lines = [np.column_stack([x, np.full(len(x), y), height - below]) for y, below in edges]
    begin, end = (np.array([line[at] for line in lines]) for at in (0, -1))
    ends = [_ribbon(begin[:2], begin[[3, 2]]), _ribbon(end[[3, 2]], end[:2])]
    return joined([*(_ribbon(lines[n], lines[(n + 1) % 4]) for n in range(4)), *ends])


def _ribbon(first_line: Array, second_line: Array) -> Mesh:
    """The surface between two lines of as many points."""
    k, count = np.arange(len(first_line) - 1), len(first_line)
    faces = [np.column_stack([k, k + count, k + 1]), np.column_stack([k + 1, k + count, k + 1 + count])]
    return Mesh(np.concatenate([first_line, second_line]), np.concatenate(faces))
