"""Bushings that are turned beyond 45°, where their torque, n sin φ cos φ, becomes smaller."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...algebra import Array
from ...elements import Bushing
from ...elements.evaluation import element_from
from ...model.announcement import announce, collected
from ...system import System
from ...system.structure.local import GROUND, firsts

LARGEST = 0.5**0.5  # cosine of the angle of the largest torque


def announce_turned_bushings(system: System, b: Array, t: Array, q: Array) -> None:
    """Announce each bushing that is turned too far, once in an analysis, at states (n,), (n, nq)."""
    for p in system.populations if len(t) else ():
        for k in range(p.count if p.kind is Bushing else 0):
            at, about = p.at + k * p.kind.size(), f"{p.owners[k]}: it is turned by more than 45° at t = "
            element: Any = element_from(p.kind, b[at : at + p.kind.size()], b)
            if not np.reshape(element.K, (6, 6))[3:, 3:].any():
                continue
            i, j = (np.tile(GROUND, (len(t), 1)) if x < 0 else q[:, x : x + 7] for x in firsts(p, k))
            axes = [(getattr(element, f"{n}_i"), getattr(element, f"{n}_j")) for n in "fgh"]
            trace = sum(np.sum(_turned(i, a) * _turned(j, c), axis=1) for a, c in axes)
            far = np.flatnonzero(0.5 * (trace - 1) < LARGEST)
            if len(far) and not any(message.startswith(about) for message in collected()):
                announce([f"{about}{t[far[0]]:.6g} s, where its torque falls. Use an RSDA for large angles."])


def _turned(q: Array, a: Array) -> Array:
    """A body-fixed vector in global axes, at all states (n, 3)."""
    e0, e, a = q[:, 3:4], q[:, 4:7], np.asarray(a, dtype=float)[None]
    across = np.cross(e, a)
    return np.asarray(a + 2 * (np.cross(e, across) + e0 * across))
