"""The angle θ of f_j in the plane of f_i and g_i: the argument of z = f_i·f_j + i g_i·f_j, two DOT-1 functions.

With u = z_ / z for any derivative of z, the derivatives of log z to x (a coordinate or a number) and along ξ, η are

    u_x,    u_ξx - u_ξ u_x,    u_ξηx - u_ξη u_x - u_η u_ξx - u_ξ u_ηx + 2 u_ξ u_η u_x,

and those of θ are their imaginary parts, for any p with z ≠ 0. The paper does not go beyond the first of them.
"""

from __future__ import annotations

from math import pi
from typing import Any, NamedTuple

import numpy as np

from ..._jit.formulas.functions import atan2, nearest
from ...algebra import Array, Row, outer, present, row, single
from ..element import Grid, Pair, Scalar
from .dot1 import Dot1

ONE = np.array([1])
TURNING = (1, 3)  # the blocks p_i and p_j; those of r vanish


class Complex(NamedTuple):
    """A complex number, vector or matrix in its parts, which may be any kind of number."""

    re: Any
    im: Any

    def plus(self, other: Complex) -> Complex:
        return Complex(self.re + other.re, self.im + other.im)

    def minus(self, other: Complex) -> Complex:
        return Complex(self.re - other.re, self.im - other.im)

    def times(self, other: Complex) -> Complex:
        return Complex(self.re * other.re - self.im * other.im, self.re * other.im + self.im * other.re)

    def outer(self, other: Complex) -> Complex:
        """The dyadic product of two vectors."""
        a, b = self, other
        return Complex(
            outer(a.re, b.re) - outer(a.im, b.im), outer(a.re, b.im) + outer(a.im, b.re)
        )  # fmt: skip


class Argument(NamedTuple):
    """θ [rad] as a function of the coordinates of two bodies, with the kernels of a constraint."""

    f_i: Array  # [-] fixed in body i
    g_i: Array  # [-] a quarter turn on
    f_j: Array  # [-] fixed in body j

    def _parts(self) -> tuple[Dot1, Dot1]:
        return Dot1(self.f_i, self.f_j), Dot1(self.g_i, self.f_j)

    def _z(self, x: Pair) -> Complex:
        C, S = self._parts()
        return Complex(C.Phi(x)[0], S.Phi(x)[0])

    def _over_z(self, x: Pair) -> Complex:
        c, s = self._z(x)
        return Complex(c / (c * c + s * s), -s / (c * c + s * s))

    def _u(self, x: Pair, name: str, *directions: Pair) -> list[Complex]:
        """The blocks p_i and p_j of an operator of z, over z."""
        C, S = (getattr(part, name)(x, *directions) for part in self._parts())
        return [self._over_z(x).times(Complex(present(C[n])[0], present(S[n])[0])) for n in TURNING]

    def _u_along(self, x: Pair, name: str, *directions: Pair) -> Complex:
        """The same, contracted with the last direction."""
        *others, last = directions
        u_i, u_j = self._u(x, name, *others)
        return Complex(u_i.re @ last.p_i + u_j.re @ last.p_j, u_i.im @ last.p_i + u_j.im @ last.p_j)

    def _u_b(self, x: Pair, name: str, *directions: Pair) -> list[Complex]:
        """The blocks f_i, g_i and f_j of an operator of z, over z."""
        C, S = (getattr(part, name)(x, *directions) for part in self._parts())
        blocks = (C[0], None), (None, S[0]), (C[1], S[1])
        return [self._over_z(x).times(Complex(*(0 if b is None else b[0] for b in pair))) for pair in blocks]

    def Phi(self, x: Pair) -> Array:
        """θ in (-π, π]."""
        z = self._z(x)
        return single(atan2(z.im, z.re))[0]

    def near(self, x: Pair, angle: Scalar) -> Scalar:
        """θ with the revolutions that bring it nearest to another angle; they are constant in derivatives."""
        theta = self.Phi(x)[0]
        return theta + 2 * pi * nearest((angle - theta) / (2 * pi))

    def Phi_q(self, x: Pair) -> Row:
        return _row(self._u(x, "Phi_q"))

    def Phi_q_xi_q(self, x: Pair, xi: Pair) -> Row:
        return _row(self._second(x, xi, self._u(x, "Phi_q"), self._u(x, "Phi_q_xi_q", xi)))

    def _second(self, x: Pair, xi: Pair, u: list[Complex], u_xi: list[Complex]) -> list[Complex]:
        along = self._u_along(x, "Phi_q", xi)
        return [second.minus(along.times(first)) for first, second in zip(u, u_xi, strict=True)]

    def Phi_q_xi_q_eta_q(self, x: Pair, xi: Pair, eta: Pair) -> Row:
        u, u_xi, u_eta = (
            self._u(x, "Phi_q"),
            self._u(x, "Phi_q_xi_q", xi),
            self._u(x, "Phi_q_xi_q", eta),
        )
        return _row(self._third(x, xi, eta, u, u_xi, u_eta, self._u(x, "Phi_q_xi_q_eta_q", xi, eta)))

    def _third(self, x: Pair, xi: Pair, eta: Pair, *by: list[Complex]) -> list[Complex]:
        """The third derivative, from the blocks of u_x, u_ξx, u_ηx and u_ξηx."""
        along_xi, along_eta = self._u_along(x, "Phi_q", xi), self._u_along(x, "Phi_q", eta)
        both = along_xi.times(along_eta)
        first = both.plus(both).minus(self._u_along(x, "Phi_q_xi_q", xi, eta))
        return [
            u_xi_eta.minus(along_eta.times(u_xi)).minus(along_xi.times(u_eta)).plus(first.times(u))
            for u, u_xi, u_eta, u_xi_eta in zip(*by, strict=True)
        ]

    def _u_grid(self, x: Pair, name: str, *direction: Pair) -> list[list[Complex]]:
        """The four blocks of a second derivative of z, over z."""
        C, S = (getattr(part, name)(x, ONE, *direction) for part in self._parts())
        over = self._over_z(x)
        return [[over.times(Complex(present(C[m][n]), present(S[m][n]))) for n in TURNING] for m in TURNING]

    def Phi_qT_lam_q(self, x: Pair, lam: Array) -> Grid:
        u, u_qq = self._u(x, "Phi_q"), self._u_grid(x, "Phi_qT_lam_q")
        return _grid(lam[0], [[u_qq[m][n].minus(u[m].outer(u[n])) for n in (0, 1)] for m in (0, 1)])

    def Phi_qT_lam_q_xi_q(self, x: Pair, lam: Array, xi: Pair) -> Grid:
        u, u_xi = self._u(x, "Phi_q"), self._u(x, "Phi_q_xi_q", xi)
        u_qq, u_qq_xi = self._u_grid(x, "Phi_qT_lam_q"), self._u_grid(x, "Phi_qT_lam_q_xi_q", xi)
        along = self._u_along(x, "Phi_q", xi)

        def block(m: int, n: int) -> Complex:
            crossed = u[m].outer(u_xi[n]).plus(u_xi[m].outer(u[n]))
            square = u[m].outer(u[n])
            return u_qq_xi[m][n].minus(crossed).plus(along.times(square.plus(square).minus(u_qq[m][n])))

        return _grid(lam[0], [[block(m, n) for n in (0, 1)] for m in (0, 1)])

    def Phi_b(self, x: Pair) -> Row:
        return tuple(row(u.im) for u in self._u_b(x, "Phi_b"))

    def Phi_q_xi_b(self, x: Pair, xi: Pair) -> Row:
        found = self._second(x, xi, self._u_b(x, "Phi_b"), self._u_b(x, "Phi_q_xi_b", xi))
        return tuple(row(u.im) for u in found)

    def Phi_q_xi_q_eta_b(self, x: Pair, xi: Pair, eta: Pair) -> Row:
        u, u_xi, u_eta = (
            self._u_b(x, "Phi_b"),
            self._u_b(x, "Phi_q_xi_b", xi),
            self._u_b(x, "Phi_q_xi_b", eta),
        )
        found = self._third(x, xi, eta, u, u_xi, u_eta, self._u_b(x, "Phi_q_xi_q_eta_b", xi, eta))
        return tuple(row(u.im) for u in found)

    def Phi_qT_lam_b(self, x: Pair, lam: Array) -> Grid:
        u, u_b = self._u(x, "Phi_q"), self._u_b(x, "Phi_b")
        C, S = (part.Phi_qT_lam_b(x, ONE) for part in self._parts())
        over = self._over_z(x)
        lines: list[Row] = []
        for m in (0, 1):
            c, s = C[TURNING[m]], S[TURNING[m]]
            z_qb = Complex(c[0], 0), Complex(0, s[0]), Complex(c[1], s[1])
            lines.append(
                tuple(lam[0] * over.times(z).minus(u[m].outer(v)).im for z, v in zip(z_qb, u_b, strict=True))
            )
        return (None,) * 3, lines[0], (None,) * 3, lines[1]


def _row(blocks: list[Complex]) -> Row:
    return None, row(blocks[0].im), None, row(blocks[1].im)


def _grid(factor: Scalar, blocks: list[list[Complex]]) -> Grid:
    (ii, ij), (ji, jj) = ([factor * block.im for block in line] for line in blocks)
    none: Row = (None,) * 4
    return none, (None, ii, None, ij), none, (None, ji, None, jj)
