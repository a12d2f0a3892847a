"""The angle of body j about an axis h of body i, its rate and its derivatives; what rotational forces are made of.

θ is the angle of f_j in the plane of f_i and g_i: with c = f_i·f_j and s = g_i·f_j it is the argument of z = c + i s,
two DOT-1 functions, whose derivatives it inherits: θ_q = Im(z_q / z), (θ_q v)_q = Im((z_q v)_q / z - z_v z_q / z²).
These hold for any p; the paper's (110), (112), (114), (116) only on unit p with f_j orthogonal to h_i (see the errata).
"""

from __future__ import annotations

from math import pi
from typing import Any, NamedTuple

from ..._jit.formulas.functions import atan2, nearest
from ...algebra import Array, Row, present
from ...euler import G
from ..constraints.dot1 import Dot1
from ..element import Memory, Pair, Scalar, Vec3


class Turn(NamedTuple):
    """c, s and c² + s²; z_q / z by the blocks p_i and p_j, z_v / z, real and imaginary parts; θ̇ is the last."""

    c: Scalar
    s: Scalar
    rho: Scalar
    re_q: list[Array]
    im_q: list[Array]
    re_v: Scalar
    rate: Scalar


class AngleGeometry:
    """Geometry of θ for elements with these fields.

    `reference` is the angle, with its revolutions, that θ is nearest to; it is a state variable, not a parameter.
    """

    f_i: Vec3
    g_i: Vec3
    h_i: Vec3
    f_j: Vec3
    h_j: Vec3
    reference: Memory

    def _dots(self) -> tuple[Dot1, Dot1]:
        return Dot1(self.f_i, self.f_j), Dot1(self.g_i, self.f_j)

    def angle_of(self, x: Pair) -> Scalar:
        """θ [rad] with the revolutions that bring it nearest to the reference."""
        C, S = self._dots()
        theta = atan2(S.Phi(x)[0], C.Phi(x)[0])
        return theta + 2 * pi * nearest((self.reference - theta) / (2 * pi))

    def remember(self, x: Pair) -> tuple[Scalar, ...]:
        """New values of the memory fields at an accepted state."""
        return (self.angle_of(x),)

    def turn(self, x: Pair, v: Pair) -> Turn:
        """θ̇ and the first derivatives."""
        C, S = self._dots()
        c, s = C.Phi(x)[0], S.Phi(x)[0]
        rho = c * c + s * s
        parts = quotients(c, s, rho, C.Phi_q(x), S.Phi_q(x))
        c_v, s_v = present(C.Phi_q_xi(x, v))[0], present(S.Phi_q_xi(x, v))[0]
        re_v, im_v = quotient(c, s, rho, c_v, s_v)
        return Turn(c, s, rho, [re for re, _ in parts], [im for _, im in parts], re_v, im_v)

    def rate_q(self, x: Pair, v: Pair, turn: Turn) -> list[Array]:
        """(θ_q v)_q by the blocks p_i and p_j; those of r vanish."""
        C, S = self._dots()
        second = quotients(turn.c, turn.s, turn.rho, C.Phi_q_xi_q(x, v), S.Phi_q_xi_q(x, v))
        parts = zip(second, turn.re_q, turn.im_q, strict=True)
        return [a - turn.re_v * im - turn.rate * re for (_, a), re, im in parts]

    def w(self, x: Pair) -> tuple[Array, Array]:
        """The two blocks (p_i and p_j) of Q / n for a torque n on body i about h_i, opposed on body j about h_j."""
        return 2 * (self.h_i @ G(x.p_i)), -2 * (self.h_j @ G(x.p_j))


def quotient(c: Scalar, s: Scalar, rho: Scalar, a: Any, b: Any) -> tuple[Any, Any]:
    """Real and imaginary part of (a + i b) / (c + i s)."""
    return (c * a + s * b) / rho, (c * b - s * a) / rho


def quotients(c: Scalar, s: Scalar, rho: Scalar, c_q: Row, s_q: Row) -> list[tuple[Array, Array]]:
    """`quotient` for the blocks p_i and p_j of the single row of two DOT-1 functions."""
    return [quotient(c, s, rho, present(c_q[n])[0], present(s_q[n])[0]) for n in (1, 3)]
