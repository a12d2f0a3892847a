"""Warnings of runs in which the length of a tendon jumps, or a point enters the shape that its segment wraps."""

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
FIELDS = "s_i", "s_j"  # the points of its ends


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
            path, found, most = element.loaded(), list[str](), np.zeros(max(len(run.t) - 1, 0))
            wraps = any(isinstance(segment, Wound) for segment in path.measures)
            for segment, part, factor in zip(path.measures, path.kind.parts, path.factors, strict=True):
                own, bodies = bodies[: part.bodies], bodies[part.bodies :]
                if isinstance(segment, Wound):
                    found += _entries(owner, segment, run, own)
                most = most + (abs(factor) * _moved_by(segment, run.q, own) if wraps else 0.0)
            yield from found or (_jump(owner, run, most) if wraps else ())


def _jump(owner: str, run: Trajectory, most: Array) -> Iterator[str]:
    """A warning where the length of a path changes by more than its points have moved between two outputs."""
    changes = abs(np.diff(run[f"{owner}.length"]))
    for n in np.flatnonzero(changes > most)[:1]:
        yield (
            f"{owner}: its length jumps by {changes[n]:.3g} m before t = {run.t[n + 1]:.4g} s, where it changes the "
            "way around a shape. Keep its points from passing behind the shape, or end the run before."
        )


def _moved_by(segment: Any, q: Array, firsts: list[int]) -> Array:
    """How much a segment can have been lengthened by the motion of its ends between states (n - 1,) [m].

    Around a shape an end moves by π/2 times the distance between two places at most, in the axes of the shape.
    """
    if not hasattr(segment, "act") and not hasattr(segment, "s_i"):
        return np.full(max(len(q) - 1, 0), np.inf)  # a coordinate of a joint
    if isinstance(segment, Wound):
        ends = [
            _moved(segment.values[field], q, firsts[end]) for end, field in zip(ENDS, FIELDS, strict=True)
        ]
        shape = firsts[SHAPE]
        center = _moved(segment.values["s_k"], q, shape)
        paths = [np.pi / 2 * _turned_back(end - center, q, shape) for end in ends]
    else:
        first, last = (
            _moved(np.array(getattr(segment, field)), q, firsts[end])
            for end, field in zip(ENDS, FIELDS, strict=True)
        )
        paths = [last - first]
    return np.asarray(sum(np.linalg.norm(np.diff(path, axis=0), axis=1) for path in paths))


def _turned_back(vector: Array, q: Array, first: int) -> Array:
    """A global vector in the axes of a body, at each state."""
    if first < 0:
        return vector
    back = q.copy()
    back[:, first + 4 : first + 7] *= -1
    return _moved(vector, back, first, 0.0)


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
    return found | {end: inside(end, field, axis) & ~passes for end, field in zip(ENDS, FIELDS, strict=True)}


def _moved(s: Array, q: Array, first: int, origin: float = 1.0) -> Array:
    """Return the global coordinates of a point of a body, or of a vector, at each state. Eq. (10)"""
    s = np.broadcast_to(s, (len(q), 3))
    if first < 0:
        return s
    r, e0, e = q[:, first : first + 3], q[:, first + 3 : first + 4], q[:, first + 4 : first + 7]
    return np.asarray(
        origin * r
        + (2 * e0**2 - 1) * s
        + 2 * np.sum(e * s, axis=1, keepdims=True) * e
        + 2 * e0 * np.cross(e, s)
    )
