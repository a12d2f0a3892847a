"""Candidates for the boundary with a given set of active limits: the equations G(x) = 0 and their derivatives.

x = (q, lam, c):   rows active in S vanish,   Aᵀ lam + Uᵀ c = 0,   lam·lam + c·c = 1

A are the gradients of Φ, of the functions that are held and of the active limits, U those of the outputs: they are
dependent. c is normal to the candidate curve in the space of the outputs. For singularities of the inputs, U are their
gradients, and functions that are held push on nothing: they only choose a section.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.linalg import lapack

from ....algebra import Array
from ....model.coordinates import POSITION, by_body
from ..problem.rows import Problem
from ..problem.settle import CLOSE

Limit = tuple[int, int]  # by its number, with its end: 0 the lowest, 1 the highest value
Active = frozenset[Limit]


class Tangents(NamedTuple):
    """G, G_x and the gradients of all rows at one x."""

    G: Array
    G_x: Array
    values: Array
    J: Array


class Stratum:
    """G for one set of active limits.

    Attributes
    ----------
    active : the limits that are active, in the order of their multipliers
    rows : rows of the table that vanish; `pushing` those with multipliers; `normal` those with the normal c
    size : unknowns
    """

    def __init__(self, problem: Problem, active: Active) -> None:
        self.problem, self.key, self.active = problem, active, tuple(sorted(active))
        limit_rows = [problem.m + problem.limited[i] for i, _ in self.active]
        held = problem.m + problem.held
        self.rows = np.concatenate([np.arange(problem.m), held, np.array(limit_rows, dtype=int)]).astype(int)
        self.normal = problem.m + problem.normal
        ends = [problem.bounds[i, end] for i, end in self.active]
        self.goal = np.concatenate([np.zeros(problem.m), problem.targets, np.array(ends)])
        self.pushing = self.rows
        if not problem.of_outputs:
            locks = problem.m + np.array(problem.locked, dtype=int)
            self.pushing = np.concatenate([np.arange(problem.m), locks])
        self.n, self.count, self.k = problem.n, len(self.pushing), len(self.normal)
        self.size = self.n + self.count + self.k
        self.first_limit = self.n + self.count - len(self.active)

    @property
    def dimension(self) -> int:
        """Dimension of the set of positions with these limits active."""
        return self.n - len(self.rows)

    @cached_property
    def signs(self) -> Array:
        """+1 for limits at their lowest, -1 at their highest value: the admissible direction."""
        return np.array([1.0 - 2.0 * end for _, end in self.active])

    def parts(self, x: Array) -> tuple[Array, Array, Array]:
        """q, lam and c of x."""
        end = self.n + self.count
        return x[: self.n], x[self.n : end], x[end:]

    def weights(self, x: Array) -> Array:
        """The multipliers of x in their places in the table."""
        _, lam, c = self.parts(x)
        found = np.zeros(self.problem.rows)
        found[self.pushing] = lam
        found[self.normal] += c  # an output may be limited, too
        return found

    def multiplier(self, limit: Limit) -> int:
        """The place in x of the multiplier of an active limit."""
        return self.first_limit + self.active.index(limit)

    def residual(self, x: Array) -> Array:
        """G (size - 1,) for curves."""
        q = x[: self.n]
        values, J = self.problem.values(q), self.problem.jacobian(q)
        return self._residual(x, values, J)

    def _residual(self, x: Array, values: Array, J: Array) -> Array:
        _, lam, c = self.parts(x)
        force = J[self.pushing].T @ lam + J[self.normal].T @ c
        return np.concatenate([values[self.rows] - self.goal, force, [0.5 * (lam @ lam + c @ c - 1)]])

    def linear(self, x: Array) -> Tangents:
        """G and its exact derivative."""
        q = x[: self.n]
        values, J = self.problem.values(q), self.problem.jacobian(q)
        n, m, first = self.n, len(self.rows), self.n + self.count
        G_x = np.zeros((m + n + 1, self.size))
        G_x[:m, :n] = J[self.rows]
        G_x[m:-1, :n] = self.problem.curvature(q, self.weights(x))
        G_x[m:-1, n:first] = J[self.pushing].T
        G_x[m:-1, first:] = J[self.normal].T
        G_x[-1, n:] = x[n:]
        return Tangents(self._residual(x, values, J), G_x, values, J)

    def second(self, x: Array, t: Array, s: Array) -> Array:
        """G_xx[t, s], exact; symmetric in t and s."""
        q, p, n = x[: self.n], self.problem, self.n
        alpha, beta = t[:n], s[:n]
        top = self._top(q, alpha, beta)
        force = p.curvature_along(q, self.weights(x), alpha) @ beta
        force += p.curvature(q, self.weights(t)) @ beta + p.curvature(q, self.weights(s)) @ alpha
        return np.concatenate([top, force, [t[n:] @ s[n:]]])

    def _top(self, q: Array, alpha: Array, beta: Array) -> Array:
        """(A alpha)_q beta, by polarization of the quadratic form where they differ."""
        along = self.problem.second_along
        if alpha is beta or np.array_equal(alpha, beta):
            return np.asarray(along(q, alpha)[self.rows])
        return np.asarray(0.25 * (along(q, alpha + beta) - along(q, alpha - beta))[self.rows])


SAME = 1e-6  # free of units: nearer positions are one


def signs(stratum: Stratum, x: Array, like: Array) -> Array:
    """The signs (size,) that bring x nearest to another one."""
    n = stratum.n
    found = np.ones(stratum.size)
    found[:n] = body_signs(x[:n], like[:n])
    if x[n:] @ like[n:] < 0:
        found[n:] = -1.0
    return found


def body_signs(q: Array, like: Array) -> Array:
    """The signs (n,) of the Euler parameters alone."""
    products = by_body(q * like)[:, POSITION:].sum(axis=1)
    found = np.ones_like(by_body(q))
    found[products < 0, POSITION:] = -1.0
    return found.reshape(-1)


def apart(q: Array, like: Array) -> float:
    """Return the distance of two positions, without units."""
    return float(np.linalg.norm(q * body_signs(q, like) - like))


LARGE = 1.0  # a Newton step longer than this leads elsewhere
Row = Callable[[Array, Tangents], tuple[float, Array]]  # one more equation: its value and gradient at x


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


def correct(stratum: Stratum, x: Array, row: Row, steps: int = 8) -> tuple[Array, Tangents]:
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
        if abs(right).max() <= CLOSE:
            return x, linear
        step = Factors(bordered(linear.G_x, gradient)).solve(-right)
        moved += float(np.linalg.norm(step))
        if not moved < LARGE:
            break
        x = x + step
    raise NoPoint("Newton's method does not converge")


def plane(point: Array, normal: Array) -> Row:
    """The plane through a point."""

    def row(x: Array, linear: Tangents) -> tuple[float, Array]:
        return float(normal @ (x - point)), normal

    return row


def tangent(stratum: Stratum, x: Array, linear: Tangents, along: Array) -> Tangent:
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
