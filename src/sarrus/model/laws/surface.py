"""A surface through the points of a grid: the height of a road."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..._jit.formulas.surfaces import hermite
from ..errors import ModelError
from ..quantity import Array
from ..show import show
from .curve import spline_ends

_GRID = "Give rising x, rising y, and a row of heights for each x."


@dataclass(frozen=True, eq=False)
class Surface:
    """A height z(x, y) through the points of a grid, twice continuously differentiable.

    It is the tensor product of cubic splines: not-a-knot, or natural in a direction with fewer than four points, as
    `Curve.table`. Beyond the grid it is continued by its tangent in x and in y, and a run that leaves it has a warning.
    Heights of the grid are no parameters of a model.

    Parameters
    ----------
    x, y
        The rising coordinates of the points [m], at least two each.
    z
        Heights (len(x), len(y)) [m].

    Raises
    ------
    ModelError
        If x or y does not rise, or has fewer than two numbers; if z has another shape; if a number is not finite.

    Examples
    --------
    >>> road = Surface([0, 1, 2, 3], [0, 1], [[0, 0], [1, 2], [8, 16], [27, 54]])
    >>> round(float(road.height(1.5, 0.5)), 12)
    5.0625
    """

    x: Any
    y: Any
    z: Any

    def __post_init__(self) -> None:
        for name in ("x", "y"):
            knots = _numbers(getattr(self, name), name, 1)
            falls = np.flatnonzero(np.diff(knots) <= 0)
            if len(knots) < 2:
                raise ModelError(
                    f"{name} must have at least two numbers, but has {len(knots)}. {_GRID}", field=name
                )
            if len(falls):
                before, after = knots[falls[0]], knots[falls[0] + 1]
                message = f"{name} must rise, but {show(float(after))} follows {show(float(before))}"
                raise ModelError(f"{message}. {_GRID}", field=name)
            object.__setattr__(self, name, knots)
        z, shape = _numbers(self.z, "z", 2), (len(self.x), len(self.y))
        if z.shape != shape:
            found, wanted = (" x ".join(map(str, one)) for one in (z.shape, shape))
            message = f"z has {found} heights, but x and y need {wanted}"
            raise ModelError(f"{message}. {_GRID}", field="z")
        object.__setattr__(self, "z", z)

    @cached_property
    def _digest(self) -> str:
        return hashlib.sha256(b"".join(part.tobytes() for part in (self.x, self.y, self.z))).hexdigest()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Surface) and self._digest == other._digest

    def __hash__(self) -> int:
        return hash(self._digest)

    def __repr__(self) -> str:
        ends = ", ".join(
            f"{name} {knots[0]:g} to {knots[-1]:g}" for name, knots in (("x", self.x), ("y", self.y))
        )
        return f"<Surface of {len(self.x)} x {len(self.y)} points, {ends}, {self._digest[:8]}>"

    @cached_property
    def nodes(self) -> Array:
        """z, z_x, z_y and z_xy of each point (len(x), len(y), 4)."""
        z_x, z_y = _slopes(self.x, self.z, 0), _slopes(self.y, self.z, 1)
        return np.stack([self.z, z_x, z_y, _slopes(self.y, z_x, 1)], axis=-1)

    def numbers(self) -> tuple[float, ...]:
        """Return what is stored, see `_jit.formulas.surfaces`."""
        sizes = [float(len(self.x)), float(len(self.y))]
        return (*sizes, *self.x.tolist(), *self.y.tolist(), *self.nodes.ravel().tolist())

    def height(self, x: Any, y: Any) -> Array:
        """Return heights at x and y, numbers or arrays [m]."""
        return self.derivative(x, y, 0, 0)

    def derivative(self, x: Any, y: Any, i: int, j: int) -> Array:
        """Return ∂ⁱ⁺ʲz/∂xⁱ∂yʲ at x and y, numbers or arrays."""
        x, y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
        k, by_x = _factors(self.x, x, i)
        h, by_y = _factors(self.y, y, j)
        found = np.zeros(x.shape)
        for side in (0, 1):
            for other in (0, 1):
                node = self.nodes[k + side, h + other]
                (value_x, slope_x), (value_y, slope_y) = by_x[2 * side :][:2], by_y[2 * other :][:2]
                found += value_y * (value_x * node[..., 0] + slope_x * node[..., 1])
                found += slope_y * (value_x * node[..., 2] + slope_x * node[..., 3])
        return found


def _numbers(values: Any, name: str, dimensions: int) -> Array:
    try:
        found = np.array(values, dtype=float)
    except (TypeError, ValueError):
        raise ModelError(f"{name} must be an array of numbers. {_GRID}", field=name) from None
    if found.ndim != dimensions:
        words = "a list of numbers" if dimensions == 1 else "a list of rows of numbers"
        raise ModelError(f"{name} must be {words}. {_GRID}", field=name)
    if not np.all(np.isfinite(found)):
        raise ModelError(f"{name} has a number that is not finite. {_GRID}", field=name)
    found.flags.writeable = False
    return found


def _slopes(knots: Array, values: Array, axis: int) -> Array:
    """The slopes of splines along an axis."""
    from scipy.interpolate import CubicSpline  # 1 s to import: only models with tables pay

    spline = CubicSpline(knots, values, axis=axis, bc_type=spline_ends(len(knots)))
    return np.asarray(spline(knots, 1))


def _factors(knots: Array, x: Array, order: int) -> tuple[Any, tuple[Any, ...]]:
    """The interval of each x, and the factors of values and slopes at its ends, see `_jit.formulas.surfaces`."""
    k = np.searchsorted(knots[1:-1], x, side="right")
    width, inside = knots[k + 1] - knots[k], np.clip(x, knots[0], knots[-1])
    found = hermite(inside - knots[k], width, order)
    beyond = x - inside
    if order == 0:
        return k, tuple(
            f + beyond * g for f, g in zip(found, hermite(inside - knots[k], width, 1), strict=True)
        )
    return k, found if order == 1 else tuple(np.where(beyond == 0, f, 0.0) for f in found)
