"""Tolerances of the local error, for every coordinate and velocity, from what a user gives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ....algebra import Array
from ....model import ModelError
from ....model.checks.arguments import as_numbers
from ....model.expression import parse
from ....model.expression.dimensions import fits, unit_of
from ....system import System
from .alpha_loop import Tolerance

KINDS = {"position": "m", "orientation": "rad", "velocity": "m/s", "rotation": "rad/s"}  # units of texts
HALF = 0.5  # of an angle: by so much, at most, its four Euler parameters change together
Given: TypeAlias = "float | ArrayLike | Mapping[str, float | str]"


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

        Absolute ones by kind may be texts with a unit, "1 um", "0.01 deg", "3 mm/s": those of angles are halved, as
        Euler parameters are what is meant.

        Raises
        ------
        ValueError
            If one is not positive and finite, or a kind, length or unit is wrong.
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
        return _by_kind(system, name, {kind: _in_si(name, kind, value) for kind, value in given.items()})
    if isinstance(given, str):
        raise ValueError(
            f'{name} with a unit goes by kind, {{"position": "{given}", "orientation": "0.01 deg"}}'
        )
    wanted = f"a number, or {system.nq} numbers"
    values = as_numbers(given, lambda: f"{name} must be {wanted}, got {type(given).__name__}")
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
            f'{name} by kind needs "position" and may have {", ".join(list(KINDS)[1:])}, '
            f"but has {', '.join(map(str, given))}"
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


def _in_si(name: str, kind: str, value: Any) -> Any:
    """A text with a unit as a number, of Euler parameters where it is an angle; numbers as they are."""
    if not isinstance(value, str) or kind not in KINDS:
        return value
    try:
        formula = parse(value)
        powers, number = unit_of(formula, {}), formula.value({})
    except (ModelError, KeyError) as error:
        raise ValueError(f"{name} of {kind} is {value!r}, which {error}") from None
    if not fits(powers, "1" if name == "rtol" else KINDS[kind]):
        wanted = "a plain number" if name == "rtol" else f"in {KINDS[kind]}, or another unit of that kind"
        raise ValueError(f"{name} of {kind} must be {wanted}, but is {value!r}")
    return HALF * number if powers and "rad" in powers else number


def _refuse(name: str, values: Array) -> None:
    if not (np.all(np.isfinite(values)) and np.all(values > 0)):
        raise ValueError(f"{name} must be positive and finite, but is {values}; give one like 1e-6")
