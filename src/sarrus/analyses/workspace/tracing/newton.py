"""Newton's method on a curve of candidates, and the curve's tangent and curvature at a point of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.linalg import lapack

from ....algebra import Array
from .stratum import Linear, Stratum

TOLERANCE = 1e-12  # of the largest entry of G, free of units
LARGE = 1.0  # a Newton step longer than this leads elsewhere
Row = Callable[[Array, Linear], tuple[float, Array]]  # one more equation: its value and gradient at x


class NoPoint(ArithmeticError):
    """Newton's method found no point of the curve near the guess."""


class Tangent(NamedTuple):
    """Unit tangent t of the curve, its derivative t' by arc length, and the sign of det [G_x; t]."""

    t: Array
    turn: Array
    sign: float
    bends: bool = True  # whether t' is known; it is not where curves cross


class Factors:
    """LU factors of a square matrix, by LAPACK.

    Raises
    ------
    NoPoint
        If it is singular.
    """

    def __init__(self, matrix: Array) -> None:
        self.lu, self.pivots, error = lapack.dgetrf(matrix.T)
        if error:
            raise NoPoint("the equations of the curve are singular here")

    def solve(self, right: Array) -> Array:
        """x of A x = right."""
        return np.asarray(lapack.dgetrs(self.lu, self.pivots, right, trans=1)[0])

    def sign(self) -> float:
        """Sign of the determinant."""
        swaps = np.count_nonzero(self.pivots != np.arange(len(self.pivots)))
        return float(np.prod(np.sign(np.diagonal(self.lu))) * (-1) ** swaps)


def bordered(G_x: Array, row: Array) -> Array:
    """G_x with one more row."""
    return np.concatenate([G_x, row[None]])


def correct(stratum: Stratum, x: Array, row: Row, steps: int = 8) -> tuple[Array, Linear]:
    """The point near x with G = 0 and one more equation.

    Raises
    ------
    NoPoint
        If Newton's method leads far away or does not converge.
    """
    moved = 0.0
    for _ in range(steps):
        linear = stratum.linear(x)
        value, gradient = row(x, linear)
        right = np.append(linear.G, value)
        if abs(right).max() <= TOLERANCE:
            return x, linear
        step = Factors(bordered(linear.G_x, gradient)).solve(-right)
        moved += float(np.linalg.norm(step))
        if not moved < LARGE:
            break
        x = x + step
    raise NoPoint("Newton's method does not converge")


def plane(point: Array, normal: Array) -> Row:
    """The plane through a point."""

    def row(x: Array, linear: Linear) -> tuple[float, Array]:
        return float(normal @ (x - point)), normal

    return row


def tangent(stratum: Stratum, x: Array, linear: Linear, along: Array) -> Tangent:
    """The tangent that makes an acute angle with a direction, and its derivative -[G_x; t]⁻¹ [G_xx[t, t]; 0].

    Raises
    ------
    NoPoint
        If the curve is not regular here.
    """
    factors = Factors(bordered(linear.G_x, along))
    t = factors.solve(np.append(np.zeros(stratum.size - 1), 1.0))
    t /= np.linalg.norm(t)
    turn = factors.solve(np.append(-stratum.second(x, t, t), 0.0))
    return Tangent(t, turn - (t @ turn) * t, factors.sign())
