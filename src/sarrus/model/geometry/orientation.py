"""The orientation of a body: four ways to give it, converted to Euler parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError, restated
from ..quantity import Array, Vector, direction, has_rows, number, numbers, vector
from ..show import show
from ..tape import values_of
from . import rotation
from .points import PERPENDICULAR

_FOUR = "Give four numbers [e0, e1, e2, e3] whose squares add up to 1."
_NINE = "Give three rows of three numbers, or four Euler parameters."


@dataclass(frozen=True)
class AxisAngle:
    """Orientation by a right-handed rotation about ``axis`` by ``angle`` [rad]; the axis need not have unit length."""

    axis: Vector
    angle: float


@dataclass(frozen=True)
class EulerAngles:
    """Orientation by three successive rotations by ``angles`` [rad] about the body-fixed axes in ``sequence``.

    ``EulerAngles((a, b, c), "zxz")`` is A = A_z(a) A_x(b) A_z(c).
    """

    angles: Vector
    sequence: str = "xyz"


Orientation: TypeAlias = (
    AxisAngle | EulerAngles | Sequence[float] | Sequence[Sequence[float]] | NDArray[np.float64]
)


def euler_parameters(orientation: Any) -> Array:
    """Return p = [e0, e1, e2, e3] with |p| = 1 for any of the four ways to give an orientation.

    Raises
    ------
    ModelError
        If the numbers are not a rotation to within ``PERPENDICULAR``.
    """
    if isinstance(orientation, AxisAngle):
        return _from_axis_angle(orientation)
    if isinstance(orientation, EulerAngles):
        return _from_euler_angles(orientation)
    return _from_matrix(orientation) if has_rows(orientation) else _from_parameters(orientation)


def _from_parameters(value: Any) -> Array:
    p = np.array(numbers(value, 4, "orientation", _FOUR))
    length = np.sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3])
    if abs(length - 1) > PERPENDICULAR:
        message = f"orientation must be unit Euler parameters, but their length is {length:.9g}. {_FOUR}"
        raise ModelError(message, field="orientation")
    return np.asarray(p / length)


def _from_matrix(value: Any) -> Array:
    A = np.array([numbers(row, 3, "orientation", _NINE) for row in value])
    given = values_of(A)
    if np.max(np.abs(given.T @ given - np.eye(3))) > PERPENDICULAR:
        message = "orientation must be a rotation matrix, but its columns are not perpendicular unit vectors"
        raise ModelError(f"{message}. {_NINE}", field="orientation")
    if np.linalg.det(given) < 0:
        message = "orientation must be a right-handed rotation matrix, but its determinant is -1"
        raise ModelError(f"{message}. Reverse one column.", field="orientation")
    return rotation.parameters(A)


def _from_axis_angle(turn: AxisAngle) -> Array:
    with restated(field="orientation"):
        u, half = direction(turn.axis, "orientation axis"), number(turn.angle, "orientation angle") / 2
    return np.array([np.cos(half), *(np.sin(half) * u)])


def _from_euler_angles(turn: EulerAngles) -> Array:
    with restated(field="orientation"):
        angles = vector(turn.angles, "orientation angles")
    rotations = [_turn(axis, angle) for axis, angle in zip(_sequence(turn.sequence), angles, strict=True)]
    return reduce(rotation.product, rotations)


def _sequence(given: Any) -> str:
    letters = given if isinstance(given, str) else ""
    repeats = any(a == b for a, b in pairwise(letters))
    if len(letters) != 3 or set(letters) - set("xyz") or repeats:
        message = f'orientation sequence must be three axes like "xyz" or "zxz", but is {show(given)}'
        raise ModelError(f"{message}. Let no axis follow itself.", field="orientation")
    return letters


def _turn(axis: str, angle: float) -> Array:
    half = np.sin(angle / 2)
    return np.array([np.cos(angle / 2), *(half if axis == name else 0.0 for name in "xyz")])
