"""Tolerances of the local error, for every coordinate and velocity, from what a user gives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ...algebra import Array
from ...system import System
from .alpha_loop import Tolerance

KINDS = ("position", "orientation", "velocity", "rotation")
Given: TypeAlias = "float | ArrayLike | Mapping[str, float]"


@dataclass(frozen=True, eq=False)
class Tolerances:
    """Relative and absolute tolerances (nq,), of coordinates and of velocities.

    Attributes
    ----------
    rtol_q, atol_q, rtol_v, atol_v : (nq,)
    speed : whether velocities were given tolerances of their own, and so are controlled
    """

    rtol_q: Array
    atol_q: Array
    rtol_v: Array
    atol_v: Array
    speed: bool

    @classmethod
    def of(cls, system: System, rtol: Given, atol: Given) -> Tolerances:
        """From a number, an array for all coordinates, or a mapping of kinds of coordinates to numbers.

        Raises
        ------
        ValueError
            If one is not positive and finite, or a kind or length is wrong.
        """
        relative, absolute = (_both(system, name, x) for name, x in (("rtol", rtol), ("atol", atol)))
        speed = any(isinstance(x, Mapping) and {"velocity", "rotation"} & set(x) for x in (rtol, atol))
        return cls(relative[0], absolute[0], relative[1], absolute[1], bool(speed))

    def of_q(self, q: Array) -> Array:
        """The tolerance of each coordinate at a position."""
        return np.asarray(self.atol_q + self.rtol_q * abs(q))

    def greatest(self) -> dict[str, float]:
        """The greatest of each kind, of coordinates."""
        return {"rtol": float(self.rtol_q.max()), "atol": float(self.atol_q.max())}

    def for_loop(self) -> Tolerance:
        """For the compiled loop."""
        return Tolerance(self.rtol_q, self.atol_q, self.rtol_v, self.atol_v, float(self.speed))


def _both(system: System, name: str, given: Any) -> tuple[Array, Array]:
    """Of coordinates and of velocities."""
    if isinstance(given, Mapping):
        return _by_kind(system, name, given)
    values = np.asarray(given, dtype=float)
    if values.shape not in ((), (system.nq,)):
        raise ValueError(
            f"{name} must be a number or {system.nq} numbers, one for each coordinate, but has {values.size}"
        )
    _refuse(name, values)
    every = np.broadcast_to(values, system.nq).copy()
    return every, every.copy()


def _by_kind(system: System, name: str, given: Mapping[str, Any]) -> tuple[Array, Array]:
    unknown = [kind for kind in given if kind not in KINDS]
    if unknown or "position" not in given:
        raise ValueError(
            f'{name} by kind needs "position" and may have {", ".join(KINDS[1:])}, but has {", ".join(given)}'
        )
    for kind, value in given.items():
        _refuse(f"{name} of {kind}", np.asarray(value, dtype=float))
    position = float(given["position"])
    turning = float(given.get("orientation", position))
    speeds = (
        float(given.get("velocity", position)),
        float(given.get("rotation", given.get("velocity", turning))),
    )
    bodies = len(system.bodies)
    return tuple(np.tile(np.repeat(pair, (3, 4)), bodies) for pair in ((position, turning), speeds))  # type: ignore[return-value]


def _refuse(name: str, values: Array) -> None:
    if not (np.all(np.isfinite(values)) and np.all(values > 0)):
        raise ValueError(f"{name} must be positive and finite, but is {values}; give one like 1e-6")
