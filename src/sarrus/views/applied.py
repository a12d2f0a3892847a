"""The forces of a force element on its bodies over the frames of a run."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from ..algebra import Array
from ..elements.evaluation import element_from, partition
from ..euler import A, E
from ..system import System
from .frames import Frames

GROUND = np.array([0.0, 0, 0, 1, 0, 0, 0])


class Load(NamedTuple):
    """Force [N] at a body's points [m] and torque about them [N m], in global axes, each (n, 3)."""

    body: str
    points: Array
    forces: Array
    torques: Array


def loads(system: System, population: Any, place: int, at: Frames) -> Iterator[Load]:
    """Yield what the element at a ``place`` of a population does to each of its moving bodies."""
    slots, bodies = population.variant.slots, population.bodies[place]
    firsts = [None if slot < 0 else int(bodies[slot]) for slot in slots]
    found = [*_over_time(system, population, place, firsts, at)]
    for side, first in enumerate(firsts):
        if first is not None:
            columns = (np.array([now[side][n] for now in found], dtype=float) for n in range(3))
            yield Load(system.bodies[first // 7], *columns)


def _over_time(
    system: System, population: Any, place: int, firsts: list[int | None], at: Frames
) -> Iterator[list[tuple[Array, Array, Array]]]:
    """Yield point, force and torque for each body, for each frame."""
    kind, start = population.kind, population.at + place * population.kind.size()
    numbers, memory = system.b[start : start + kind.size()].copy(), _memory(kind)
    for t, q, v in zip(at.t, at.q, at.v, strict=True):
        element: Any = element_from(kind, numbers, system.b, t)
        flat, rates = _chosen(q, firsts, GROUND), _chosen(v, firsts, 0 * GROUND)
        x, w = partition(kind, flat), partition(kind, rates)
        Q = element.Q(x, w, t)
        if memory:
            numbers[memory] = element.remember(x)
        states = flat.reshape(-1, 7)
        yield [
            _wrench(body, Q[2 * n], Q[2 * n + 1], _point(element, n, len(states)))
            for n, body in enumerate(states)
        ]


def _chosen(y: Array, firsts: list[int | None], ground: Array) -> Array:
    """The coordinates of an element's bodies, one after the other."""
    return np.concatenate([ground if first is None else y[first : first + 7] for first in firsts])


def _memory(kind: Any) -> list[int]:
    """Which of an element's numbers it remembers."""
    starts = np.cumsum([0, *kind.widths()])
    return [int(at) for at, field in zip(starts, kind.fields.values(), strict=False) if field == "Memory"]


def _point(element: Any, side: int, bodies: int) -> Array:
    """The point of a force element on a body in its axes: of a weight the centre of mass; the origin if it has none."""
    alone = "center" if hasattr(element, "center") else "s"
    name = alone if bodies == 1 else ("s_i", "s_j")[side] if bodies == 2 else ""
    return np.asarray(getattr(element, name, np.zeros(3)), dtype=float)


def _wrench(body: Array, Q_r: Any, Q_p: Any, s: Array) -> tuple[Array, Array, Array]:
    """A global point, the force there and the torque about it, of a generalized force [Q_r; Q_p]; n = ½ E Q_p."""
    lever = A(body[3:]) @ s
    force = np.zeros(3) if Q_r is None else np.asarray(Q_r, dtype=float)
    turn = np.zeros(4) if Q_p is None else np.asarray(Q_p, dtype=float)
    return body[:3] + lever, force, 0.5 * E(body[3:]) @ turn - np.cross(lever, force)
