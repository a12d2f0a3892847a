"""Independent evaluation of the constraints of a blueprint, with rotation matrices of SciPy."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from sarrus.model.expansion.blueprint import Blueprint, Placement


class Places:
    """Origin and rotation of every body of a blueprint, the ground included."""

    def __init__(self, plan: Blueprint) -> None:
        rows = plan.q.reshape(-1, 7)
        self.r = np.vstack([np.zeros(3), rows[:, :3]])
        p = np.vstack([[1.0, 0.0, 0.0, 0.0], rows[:, 3:]])
        self.A = Rotation.from_quat(p, scalar_first=True).as_matrix()

    def point(self, body: int, s: object) -> NDArray[np.float64]:
        return np.asarray(self.r[body] + self.A[body] @ s)

    def vector(self, body: int, a: object) -> NDArray[np.float64]:
        return np.asarray(self.A[body] @ a)


def spherical(at: Places, i: int, j: int, s_i: object, s_j: object) -> object:
    return at.point(j, s_j) - at.point(i, s_i)


def dot1(at: Places, i: int, j: int, a_i: object, a_j: object) -> object:
    return at.vector(i, a_i) @ at.vector(j, a_j)


def dot2(at: Places, i: int, j: int, a_i: object, s_i: object, s_j: object) -> object:
    return at.vector(i, a_i) @ (at.point(j, s_j) - at.point(i, s_i))


def distance(at: Places, i: int, j: int, s_i: object, s_j: object, length: float) -> object:
    d = at.point(j, s_j) - at.point(i, s_i)
    return d @ d - length**2


def constant_angle(at: Places, i: int, j: int, a_i: object, a_j: object, cosine: float) -> object:
    return at.vector(i, a_i) @ at.vector(j, a_j) - cosine


def screw(at: Places, i: int, j: int, f: object, g: object, h: object, f_j: object, *rest: Any) -> object:
    s_i, s_j, lead, angle, displacement = rest
    moved = at.vector(i, h) @ (at.point(j, s_j) - at.point(i, s_i)) - displacement
    a = at.vector(j, f_j)
    turned = np.arctan2(at.vector(i, g) @ a, at.vector(i, f) @ a) - angle
    return lead * (np.remainder(moved / lead - turned + np.pi, 2 * np.pi) - np.pi)


FORMULAS: dict[str, Callable[..., object]] = {
    "Spherical": spherical,
    "Dot1": dot1,
    "Dot2": dot2,
    "Distance": distance,
    "ConstantAngle": constant_angle,
    "Screw": screw,
}


def violation(plan: Blueprint) -> float:
    """Return the largest entry of Φ in the initial pose."""
    return float(np.max(np.abs(all_of_phi(plan))))


def all_of_phi(plan: Blueprint) -> NDArray[np.float64]:
    """Return Φ of the joints in the initial pose."""
    at = Places(plan)
    return np.concatenate([phi(at, one) for one in constraints(plan)])


def phi(at: Places, placed: Placement) -> NDArray[np.float64]:
    formula = FORMULAS[placed.element.__name__]
    return np.atleast_1d(np.asarray(formula(at, *placed.bodies, *placed.values)))


def constraints(plan: Blueprint) -> list[Placement]:
    """Return the constraint primitives of a blueprint."""
    return [placed for placed in plan.placed if placed.element.__name__ in FORMULAS]


@pytest.fixture
def largest_phi() -> Callable[[Blueprint], float]:
    return violation


@pytest.fixture
def all_phi() -> Callable[[Blueprint], NDArray[np.float64]]:
    return all_of_phi


@pytest.fixture
def places() -> type[Places]:
    return Places
