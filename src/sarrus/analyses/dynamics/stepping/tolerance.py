"""Tolerances of the local error for every coordinate and velocity, from the options of a run; its first step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ...._jit.linking.link import link
from ....algebra import Array
from ....linalg.factors import SingularSystem
from ....model import ModelError
from ....model.checks.arguments import as_numbers
from ....model.expression import parse
from ....model.expression.quantity import quantity_of
from ....system import System
from ....system.layout import Layout
from ...equations.length import extent
from ..methods.leading_error import ErrorTerm
from .motion_scale import LARGEST, LEAST_MOTION, LENGTH, MOVES, SIZES, SPAN, UNUSED, Tolerance, follow_motion

KINDS = {"position": "m", "orientation": "rad", "velocity": "m/s", "rotation": "rad/s"}  # units of texts
FINEST = 1e-10  # of coordinates: less is not asked for close to singular configurations
HALF = 0.5  # of an angle: by so much, at most, its four Euler parameters change together
TRIALS = 20  # lengths that are tried, each at most half of the one before
# variables of methods whose tolerances follow a motion
FOLLOWED = ("_tolerance.base", "_tolerance.motion", "_tolerance.size", "_tolerance.states")
FIRST = ErrorTerm(3, 1.0)  # of a solver whose own is not known: h² times the change of a
Given: TypeAlias = "float | ArrayLike | Mapping[str, float | str]"
Absolute: TypeAlias = "Given | None"  # None: relative to the size of the motion


@dataclass(frozen=True, eq=False)
class Tolerances:
    """Relative and absolute tolerances (nq,), of coordinates and of velocities.

    Attributes
    ----------
    rtol_q, atol_q, rtol_v, atol_v : (nq,)
    speed : whether velocities were given tolerances of their own, and so are controlled
    layout : of the coordinates
    follow : whether tolerances are relative to the size of the motion, and absolute ones follow it, see `motion_scale`
    states : of the coordinates of blocks of states, behind those of bodies, the least sizes, or `UNUSED`
    """

    rtol_q: Array
    atol_q: Array
    rtol_v: Array
    atol_v: Array
    speed: bool
    layout: Layout
    follow: bool = False
    states: Array = field(default_factory=lambda: np.zeros(0))

    @classmethod
    def of(cls, system: System, rtol: Given, atol: Absolute) -> Tolerances:
        """Create the tolerances from a number, an array, or a mapping of kinds of coordinates.

        Without `atol` tolerances are relative to the size of the motion.

        Absolute ones by kind may be texts with a unit, "1 um", "0.01 deg", "3 mm/s": those of angles are halved, as
        Euler parameters are what is meant.

        Raises
        ------
        ValueError
            If one is not positive and finite, or a kind, length or unit is wrong.
        """
        relative = _both(system, "rtol", rtol)
        absolute = (np.zeros(system.nq),) * 2 if atol is None else _both(system, "atol", atol)
        speed = any(isinstance(x, Mapping) and {"velocity", "rotation"} & set(x) for x in (rtol, atol))
        least = np.full(system.nq - system.moving, UNUSED)
        for one in (*system.states.values(), *system.followed_states.values()):
            least[one.place - system.moving] = LEAST_MOTION * one.nominal
        return cls(
            relative[0],
            absolute[0],
            relative[1],
            absolute[1],
            bool(speed),
            system.layout,
            atol is None,
            least,
        )

    def of_state(self, q: Array, v: Array, length: float) -> tuple[Array, Array]:
        """Tolerances of q and of v at a state; those that follow a motion, for motions over the length of a system."""
        if not self.follow:
            least = FINEST * max(1.0, abs(q).max(initial=0.0)), FINEST * max(1.0, abs(v).max(initial=0.0))
            return np.maximum(self.atol_q + self.rtol_q * abs(q), least[0]), np.maximum(
                self.atol_v + self.rtol_v * abs(v), least[1]
            )
        unit = self.layout.scales(length)
        return self.rtol_q * unit, self.rtol_v * unit * abs(v / unit).max(initial=0.0)

    def of_motion(self, q: Array) -> Array:
        """The tolerance of each coordinate at the end of a motion (n, nq)."""
        if not self.follow:
            return np.asarray(self.atol_q + self.rtol_q * abs(q[-1]))
        moved = np.maximum.reduceat(abs(q - q[0]).max(axis=0), self.layout.starts)
        return np.asarray(self.rtol_q * np.repeat(moved, self.layout.widths))

    def greatest(self, tolerance: Tolerance) -> dict[str, float]:
        """The greatest of each kind, of coordinates, at the end of a run by a compiled loop."""
        rtol, atol = float(self.rtol_q.max()), float(self.atol_q.max())
        moved = float(tolerance.size[LARGEST : LARGEST + 2].max())
        return {"rtol": rtol, "atol": rtol * (moved or 1.0) if self.follow else atol}

    def for_loop(
        self, factor_q: ArrayLike = 1.0, factor_v: ArrayLike = 1.0, *, speed: bool = False
    ) -> Tolerance:
        """For a compiled loop; all multiplied by factors."""
        shares = [np.asarray(factor_q * self.rtol_q), np.asarray(factor_v * self.rtol_v)]
        fixed = [np.asarray(factor_q * self.atol_q), np.asarray(factor_v * self.atol_v)]
        nothing = np.zeros_like(self.rtol_q)
        given = [nothing, nothing.copy()] if self.follow else shares
        bounds, moving = self.layout.moving.bounds, self.layout.moving.size
        size, motion = np.zeros(SIZES), np.zeros((len(bounds), MOVES))
        fast = float(speed or self.speed)
        given[1][moving:] = np.where(self.states == UNUSED, 0.0, shares[1][moving:])
        own = (shares[0], shares[1], nothing.copy(), bounds, motion, size, self.states.copy())
        return Tolerance(given[0], fixed[0], given[1], fixed[1], fast, *own)


def _both(system: System, name: str, given: Any) -> tuple[Array, Array]:
    """Return the tolerances of coordinates and of velocities."""
    if isinstance(given, Mapping):
        return _by_kind(system, name, {kind: _in_si(name, kind, value) for kind, value in given.items()})
    if isinstance(given, str):
        raise ValueError(
            f'{name}: a unit needs a kind. Give {{"position": "{given}", "orientation": "0.01 deg"}}.'
        )
    wanted = f"a number, or {system.nq} numbers"
    values = as_numbers(given, lambda: f"{name} must be {wanted}, got {type(given).__name__}")
    if values.shape not in ((), (system.nq,)):
        raise ValueError(
            f"{name} must be a number or {system.nq} numbers, one for each coordinate, but has {values.size}. "
            "Give one of both."
        )
    _refuse(name, values)
    every = np.broadcast_to(values, system.nq).copy()
    return every, every.copy()


def _by_kind(system: System, name: str, given: Mapping[str, Any]) -> tuple[Array, Array]:
    unknown = [kind for kind in given if kind not in KINDS]
    if unknown or "position" not in given:
        raise ValueError(
            f'{name} by kind needs "position" and may have {", ".join(list(KINDS)[1:])}, '
            f"but has {', '.join(map(str, given))}. Name these kinds."
        )
    for kind, value in given.items():
        _refuse(f"{name} of {kind}", np.asarray(value, dtype=float))
    position = float(given["position"])
    turning = float(given.get("orientation", position))
    speeds = (
        float(given.get("velocity", position)),
        float(given.get("rotation", given.get("velocity", turning))),
    )
    is_length = system.layout.is_length
    return np.where(is_length, position, turning), np.where(is_length, *speeds)


def _in_si(name: str, kind: str, value: Any) -> Any:
    """A text with a unit as a number, of Euler parameters where it is an angle; numbers as they are."""
    if not isinstance(value, str) or kind not in KINDS:
        return value
    try:
        found = quantity_of(parse(value), "1" if name == "rtol" else KINDS[kind], value)
    except ModelError as error:
        raise ValueError(f"{name} of {kind} {error.message}") from None
    return HALF * found.value if "rad" in found.powers else found.value


def _refuse(name: str, values: Array) -> None:
    if not (np.all(np.isfinite(values)) and np.all(values > 0)):
        raise ValueError(f"{name} must be positive and finite, but is {values}. Give one like 1e-6.")
    if name == "rtol" and np.any(values >= 1):
        raise ValueError(f"rtol must be less than 1, but is {values}. Give one like 1e-6.")


class Accelerations(Protocol):
    """Solver of the equations of motion, see `Motion`."""

    def acceleration(self, t: float, q: Array, v: Array) -> tuple[Array, Array]:
        """a (nq,) and lam (m,) at a state."""


def begin_motion(
    tolerance: Tolerance, system: System, t: float, q: Array, until: float | None = None
) -> None:
    """Let tolerances follow the motion from a position on, if they do and have not started.

    `until` is the end of the run, for methods whose tolerances depend on the number of periods.
    """
    if not np.any(tolerance.atol_q) and tolerance.size[LENGTH] == 0.0:
        tolerance.base[:] = q
        tolerance.size[LENGTH], tolerance.size[SPAN] = extent(system, q), 0.0 if until is None else until - t


def _over_length(bounds: Array, v: Array, a: Array, length: float) -> float:
    """The time in which a body moves by a length, or rotates by a radian, with v or a of a state [s]."""
    unit = np.repeat(np.tile([1.0, length], len(bounds)), np.diff(bounds).ravel())
    speed, gain = (float(abs(unit * x[: len(unit)]).max(initial=0.0)) for x in (v, a))
    return min(length / speed if speed else np.inf, (2 * length / gain) ** 0.5 if gain else np.inf)


def first_step(
    motion: Accelerations,
    tolerance: Tolerance,
    error: ErrorTerm,
    t: float,
    q: Array,
    v: Array,
    a: Array,
    longest: float,
) -> float:
    """A step whose estimated error, h² times the change of a over it, is within the tolerance.

    Tolerances that follow the motion are those of the longest step that is tried.
    """
    exponent, constant = error
    length = float(tolerance.size[LENGTH])
    h = min(longest, _over_length(tolerance.bounds, v, a, length) if length else np.inf)
    link(follow_motion)(tolerance, h, q, v, a, True)
    allowed = tolerance.atol_q + tolerance.rtol_q * abs(q)
    for _ in range(TRIALS):
        try:
            later = motion.acceleration(t + h, q + h * (v + 0.5 * h * a), v + h * a)[0]
        except SingularSystem:
            h *= 0.1
            continue
        change = (later - a if exponent > 2 else later) / allowed
        size = constant * h**2 * float(np.sqrt(np.mean(change**2)))
        if size <= 1.0:
            break
        h *= min(max(0.8 * size ** (-1 / min(exponent, 3)), 0.1), 0.5) if size < np.inf else 0.1
    return h
