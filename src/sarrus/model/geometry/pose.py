"""The pose of a body: origin, Euler parameters and the rotation matrix."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple, TypeAlias

import numpy as np

from ..quantity import Array


class Pose(NamedTuple):
    """Origin ``r`` (3,) [m], Euler parameters ``p`` (4,) and their matrix ``A`` (3, 3)."""

    r: Array
    p: Array
    A: Array

    def local_point(self, point: Array) -> Array:
        """Return s′ = Aᵀ(P − r) of the global point P. (3,) [m]"""
        return np.asarray(self.A.T @ (point - self.r))

    def local_vector(self, vector: Array) -> Array:
        """Return a′ = Aᵀa of the global vector a. (3,)"""
        return np.asarray(self.A.T @ vector)

    def global_point(self, point: Array) -> Array:
        """Return r + A s′. (3,) [m]"""
        return np.asarray(self.r + self.A @ point)


Poses: TypeAlias = Mapping[str, Pose]

GROUND_POSE = Pose(np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]), np.eye(3))
