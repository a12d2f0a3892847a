"""Check that a position can be assembled from the parts as drawn: parallel axes have not been reversed.

The equations of a revolute joint hold also with the second body's axis reversed. Assembly from random guesses finds
such positions, which no motion can reach from the model's.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ....model.coordinates import WIDTH
from ....model.geometry.pose import GROUND_POSE
from ....model.geometry.rotation import matrix
from ....model.geometry.solid import GROUND
from ....system import System

PARALLEL = 1e-6  # how far the product of unit vectors may be from 1 or -1


class _Axes(NamedTuple):
    """The axes of a joint on its two bodies, as rows (3, 3)."""

    i: int
    j: int
    on_i: Array
    on_j: Array


class Handedness:
    """Compares the parallel axes of all joints with those of the model's position.

    Parameters
    ----------
    system : System
    positions : (nq,) each, random ones: axes that are parallel in all of them remain so by the constraints
    """

    def __init__(self, system: System, positions: Sequence[Array]) -> None:
        poses = {GROUND: GROUND_POSE, **{body.name: body.pose() for body in system.model.bodies}}
        number = {name: n for n, name in enumerate((GROUND, *system.bodies))}
        self._joints = []
        for joint in system.model.joints:
            if hasattr(joint, "frames"):
                i, j = joint.frames(poses)
                on = [np.array([frame.f, frame.g, frame.h]) for frame in (i, j)]
                self._joints.append(_Axes(number[i.body], number[j.body], on[0], on[1]))
        self._drawn = self._products(system.q0)
        found = abs(np.array([self._products(q) for q in (system.q0, *positions)]))
        self._parallel = np.all(found > 1 - PARALLEL, axis=0) & (len(positions) > 0)

    def _products(self, q: Array) -> Array:
        A = [np.eye(3), *(matrix(p / np.linalg.norm(p)) for p in q.reshape(-1, WIDTH)[:, 3:])]
        found = [(A[one.i] @ one.on_i.T).T @ (A[one.j] @ one.on_j.T) for one in self._joints]
        return np.array(found).reshape(-1)

    def preserved(self, q: Array) -> bool:
        """Whether a position (nq,) is of the drawn kind."""
        return bool(np.all((self._products(q) * self._drawn)[self._parallel] > 0))
