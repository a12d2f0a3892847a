"""The angle θ of f_j in the plane of f_i and g_i: the argument of z = f_i·f_j + i g_i·f_j, two DOT-1 functions.

With u = z_q / z, the derivatives of log z are u and z_qq / z - u uᵀ, and those of θ are their imaginary parts, for
any p with z ≠ 0. The paper does not go beyond the first of them; all others are derived from these two.
"""

from __future__ import annotations

from math import pi
from typing import Any, NamedTuple

import numpy as np

from ..._jit.formulas.functions import atan2, nearest
from ...algebra import Array, Row, outer, present, row, single
from ..element import Grid, Pair, Primitive, Scalar, Vec3
from .dot1 import Dot1

ONE = np.array([1])
TURNING = (1, 3)  # the blocks p_i and p_j; those of r vanish


class Complex(NamedTuple):
    """A complex number, vector or matrix in its parts, which may be any kind of number."""

    re: Any
    im: Any

    def times(self, other: Complex) -> Complex:
        return Complex(self.re * other.re - self.im * other.im, self.re * other.im + self.im * other.re)

    def squared(self, other: Complex) -> Any:
        """The imaginary part of the dyadic product with another vector."""
        return outer(self.re, other.im) + outer(self.im, other.re)


class Argument(Primitive, rows=1, derivatives="automatic", rare=True, registered=False):
    """Φ = θ [rad]."""

    f_i: Vec3  # [-] fixed in body i
    g_i: Vec3  # [-] f_i rotated by a right angle
    f_j: Vec3  # [-] fixed in body j

    def _parts(self) -> tuple[Dot1, Dot1]:
        return Dot1(self.f_i, self.f_j), Dot1(self.g_i, self.f_j)

    def theta(self, x: Pair) -> Scalar:
        """θ in (-π, π]."""
        c, s = (part.Phi(x)[0] for part in self._parts())
        return atan2(s, c)

    def near(self, x: Pair, angle: Scalar) -> Scalar:
        """θ with the revolutions that bring it nearest to another angle; they are constant in derivatives."""
        theta = self.theta(x)
        return theta + 2 * pi * nearest((angle - theta) / (2 * pi))

    def _over_z(self, x: Pair) -> Complex:
        c, s = (part.Phi(x)[0] for part in self._parts())
        over = 1 / (c * c + s * s)
        return Complex(c * over, -s * over)

    def _u(self, x: Pair) -> list[Complex]:
        """The blocks p_i and p_j of z_q / z."""
        C, S = (part.Phi_q(x) for part in self._parts())
        return [self._over_z(x).times(Complex(present(C[n])[0], present(S[n])[0])) for n in TURNING]

    def Phi(self, x: Pair) -> Array:
        return single(self.theta(x))[0]

    def Phi_q(self, x: Pair) -> Row:
        u_i, u_j = self._u(x)
        return None, row(u_i.im), None, row(u_j.im)

    def Phi_qT_lam_q(self, x: Pair, lam: Array) -> Grid:
        over, u = self._over_z(x), self._u(x)
        C, S = (part.Phi_qT_lam_q(x, ONE) for part in self._parts())

        def block(m: int, n: int) -> Array:
            z_qq = Complex(present(C[TURNING[m]][TURNING[n]]), present(S[TURNING[m]][TURNING[n]]))
            bent: Array = lam[0] * (over.times(z_qq).im - u[m].squared(u[n]))
            return bent

        none: Row = (None,) * 4
        return none, (None, block(0, 0), None, block(0, 1)), none, (None, block(1, 0), None, block(1, 1))
