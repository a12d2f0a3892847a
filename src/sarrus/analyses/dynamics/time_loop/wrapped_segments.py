"""Warnings of runs in which a point enters the shape that a segment of a tendon wraps, where its length may jump."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ....algebra import Array
from ....elements.evaluation import element_from
from ....model.forces.formula_element import OfOutputs
from ....model.forces.paths.path import PathKind
from ....model.forces.paths.wrapping import Wound
from ....model.geometry.solid import GROUND
from ....results import Trajectory
from ....system import System
from ....system.structure.local import firsts as firsts_of

ENDS, SHAPE, SIDE = (0, 1), 2, 3  # bodies of a segment


def entered_shapes(system: System, run: Trajectory) -> Iterator[str]:
    """Yield a warning for each point that enters or leaves such a shape between two outputs of a run."""
    for p in system.populations:
        if not issubclass(p.kind, OfOutputs) or not isinstance(p.kind.structure.parts[-1].kind, PathKind):
            continue
        places = p.kind.structure.parts[-1].places
        for k, owner in enumerate(p.owners):
            at = p.at + k * p.kind.size()
            element: Any = element_from(p.kind, system.b[at : at + p.kind.size()], system.b)
            firsts = firsts_of(p, k)
            bodies = [firsts[place] for place in places]
            path = element.loaded()
            for segment, part in zip(path.measures, path.kind.parts, strict=True):
                own, bodies = bodies[: part.bodies], bodies[part.bodies :]
                if isinstance(segment, Wound):
                    yield from _entries(owner, segment, run, own)


def _entries(owner: str, segment: Wound, run: Trajectory, firsts: list[int]) -> Iterator[str]:
    names = [GROUND if first < 0 else run.bodies[first // 7] for first in firsts]
    shape = "cylinder" if segment.kind.cylinder else "sphere"
    for place, inside in _inside(segment, run.q, firsts).items():
        changes = np.flatnonzero(inside[1:] != inside[:-1])
        if len(changes):
            n = changes[0] + 1
            what, verb = "side" if place == SIDE else "end", "enters" if inside[n] else "leaves"
            yield (
                f"{owner}: its {what} on {names[place]} {verb} the {shape} on {names[SHAPE]}, which it wraps, before "
                f"t = {run.t[n]:.4g} s, where its length may jump. Move this point, or reduce the radius."
            )


def _inside(segment: Wound, q: Array, firsts: list[int]) -> dict[int, Array]:
    """Return which points are inside of the shape at each state: ends where this makes it straight, and the side."""
    given = segment.values
    center = _moved(given["s_k"], q, firsts[SHAPE])
    axis = _moved(given["h_k"], q, firsts[SHAPE], 0.0) if "h_k" in given else 0.0 * center
    square = given["radius"] ** 2

    def inside(body: int, field: str, axis: Array) -> Array:
        apart = _moved(given[field], q, firsts[body]) - center
        apart = apart - np.sum(apart * axis, axis=1, keepdims=True) * axis
        return np.asarray(np.sum(apart * apart, axis=1) < square)

    found = {SIDE: inside(SIDE, "s_l", 0.0 * axis)} if "s_l" in given else {}
    passes = found.get(SIDE, np.full(len(q), segment.kind.passage == "through"))
    return found | {
        end: inside(end, field, axis) & ~passes for end, field in zip(ENDS, ("s_i", "s_j"), strict=True)
    }


def _moved(s: Array, q: Array, first: int, origin: float = 1.0) -> Array:
    """Return the global coordinates of a point of a body, or of a vector, at each state. Eq. (10)"""
    if first < 0:
        return np.tile(s, (len(q), 1))
    r, e0, e = q[:, first : first + 3], q[:, first + 3 : first + 4], q[:, first + 4 : first + 7]
    return np.asarray(origin * r + (2 * e0**2 - 1) * s + 2 * (e @ s)[:, None] * e + 2 * e0 * np.cross(e, s))
