"""Rotational spring-damper-actuator about a common axis h of two bodies. Eqs. (104)-(116).

θ is the angle of f_j in the plane of f_i and g_i: with c = f_i·f_j and s = g_i·f_j it is the argument of z = c + i s,
two DOT-1 functions, whose derivatives it inherits: θ_q = Im(z_q / z), (θ_q v)_q = Im((z_q v)_q / z - z_v z_q / z²).
These hold for any p; the paper's (110), (112), (114), (116) only on unit p with f_j orthogonal to h_i (see the errata).
"""

from __future__ import annotations

from math import pi
from typing import Any, NamedTuple

from .._jit.functions import atan2, nearest
from ..algebra import Array, Block, Row, column, outer, present
from ..euler import G, bar
from .dot1 import Dot1
from .element import ZERO_PAIR, Force, Grid, Memory, Pair, Scalar, Vec3


class Turn(NamedTuple):
    """c, s and c² + s²; z_q / z by the blocks p_i and p_j, z_v / z, real and imaginary parts; θ̇ is the last."""

    c: Scalar
    s: Scalar
    rho: Scalar
    re_q: list[Array]
    im_q: list[Array]
    re_v: Scalar
    rate: Scalar


class RSDA(Force):
    """Torque n = k (θ - angle) + c θ̇ + torque on body i about h_i, opposed on body j about h_j; turns are counted.

    `reference` is the angle, in turns counted, near which θ is looked for; it is memory, not a design number.
    """

    f_i: Vec3  # [-] fixed in body i; f_i, g_i, h_i right-handed
    g_i: Vec3  # [-]
    h_i: Vec3  # [-] the axis in body i
    f_j: Vec3  # [-] fixed in body j
    h_j: Vec3  # [-] the axis in body j
    k: Scalar  # [N m/rad]
    c: Scalar  # [N m s/rad]
    angle: Scalar  # [rad] free angle
    torque: Scalar  # [N m] of the actuator
    reference: Memory  # [rad]

    def _dots(self) -> tuple[Dot1, Dot1]:
        return Dot1(self.f_i, self.f_j), Dot1(self.g_i, self.f_j)

    def angle_of(self, x: Pair) -> Scalar:
        """θ [rad], turns counted: the value nearest to the reference."""
        C, S = self._dots()
        theta = atan2(S.Phi(x)[0], C.Phi(x)[0])
        return theta + 2 * pi * nearest((self.reference - theta) / (2 * pi))

    def remember(self, x: Pair) -> tuple[Scalar, ...]:
        """New values of the memory fields at an accepted state."""
        return (self.angle_of(x),)

    def _turn(self, x: Pair, v: Pair) -> Turn:
        C, S = self._dots()
        c, s = C.Phi(x)[0], S.Phi(x)[0]
        rho = c * c + s * s
        quotients = _quotients(c, s, rho, C.Phi_q(x), S.Phi_q(x))
        c_v, s_v = present(C.Phi_q_xi(x, v))[0], present(S.Phi_q_xi(x, v))[0]
        re_v, im_v = _quotient(c, s, rho, c_v, s_v)
        return Turn(c, s, rho, [re for re, _ in quotients], [im for _, im in quotients], re_v, im_v)

    def _n_q(self, x: Pair, v: Pair, turn: Turn) -> list[Array]:  # Eqs. (109)-(113)
        """n_q = k θ_q + c (θ_q v)_q by the blocks p_i and p_j; those of r vanish."""
        C, S = self._dots()
        second = _quotients(turn.c, turn.s, turn.rho, C.Phi_q_xi_q(x, v), S.Phi_q_xi_q(x, v))
        parts = zip(second, turn.re_q, turn.im_q, strict=True)
        return [self.k * im + self.c * (a - turn.re_v * im - turn.rate * re) for (_, a), re, im in parts]

    def _n(self, x: Pair, turn: Turn) -> Scalar:  # Eq. (106)
        return self.k * (self.angle_of(x) - self.angle) + self.c * turn.rate + self.torque

    def _w(self, x: Pair) -> tuple[Array, Array]:
        """The two blocks (p_i and p_j) of Q / n."""
        return 2 * (self.h_i @ G(x.p_i)), -2 * (self.h_j @ G(x.p_j))

    def Q(self, x: Pair, v: Pair, t: Scalar) -> Row:  # Eqs. (104), (105)
        n, (w_i, w_j) = self._n(x, self._turn(x, v)), self._w(x)
        return None, n * w_i, None, n * w_j

    def Q_q(self, x: Pair, v: Pair, t: Scalar) -> Grid:  # Eq. (107)
        turn = self._turn(x, v)
        n = self._n(x, turn)
        ii, ij, ji, jj = self._grid(x, self._n_q(x, v, turn))
        own = 2 * n * bar(self.h_i), -2 * n * bar(self.h_j)
        none = ZERO_PAIR[0]
        return none, (None, ii + own[0], None, ij), none, (None, ji, None, jj + own[1])

    def _grid(self, x: Pair, n_q: list[Array]) -> list[Array]:
        return [outer(w, part) for w in self._w(x) for part in n_q]

    def Q_v(self, x: Pair, v: Pair, t: Scalar) -> Grid:  # Eqs. (108), (114)-(116)
        ii, ij, ji, jj = self._grid(x, [self.c * theta_q for theta_q in self._turn(x, v).im_q])
        none = ZERO_PAIR[0]
        return none, (None, ii, None, ij), none, (None, ji, None, jj)

    def Q_b(self, x: Pair, v: Pair, t: Scalar) -> Grid:
        turn, (w_i, w_j) = self._turn(x, v), self._w(x)
        n = self._n(x, turn)
        by_f_i, by_g_i, by_f_j = self._n_frames(x, v, turn)
        scalars = [self.angle_of(x) - self.angle, turn.rate, -self.k, 1]

        def line(w: Array, by_h_i: Block, by_h_j: Block) -> Row:
            axes = outer(w, by_f_i), outer(w, by_g_i), by_h_i, outer(w, by_f_j), by_h_j
            return (*axes, *(column(n_b * w) for n_b in scalars), None)

        none: Row = (None,) * 10
        by_h = 2 * n * G(x.p_i).T, -2 * n * G(x.p_j).T
        return none, line(w_i, by_h[0], None), none, line(w_j, None, by_h[1])

    def _n_frames(self, x: Pair, v: Pair, turn: Turn) -> list[Array]:
        """Derivatives of n to f_i, g_i and f_j: those of θ and of its rate."""
        C, S = self._dots()
        (c_fi, c_fj), (s_gi, s_fj) = C.Phi_b(x), S.Phi_b(x)
        (cv_fi, cv_fj), (sv_gi, sv_fj) = C.Phi_q_xi_b(x, v), S.Phi_q_xi_b(x, v)
        z_b = ((c_fi, 0), (0, s_gi), (c_fj, s_fj))
        z_v_b = ((cv_fi, 0), (0, sv_gi), (cv_fj, sv_fj))
        result = []
        for first, second in zip(z_b, z_v_b, strict=True):
            re, theta_b = _quotient(turn.c, turn.s, turn.rho, *first)
            _, im = _quotient(turn.c, turn.s, turn.rho, *second)
            result.append((self.k * theta_b + self.c * (im - turn.re_v * theta_b - turn.rate * re))[0])
        return result


def _quotient(c: Scalar, s: Scalar, rho: Scalar, a: Any, b: Any) -> tuple[Any, Any]:
    """Real and imaginary part of (a + i b) / (c + i s)."""
    return (c * a + s * b) / rho, (c * b - s * a) / rho


def _quotients(c: Scalar, s: Scalar, rho: Scalar, c_q: Row, s_q: Row) -> list[tuple[Array, Array]]:
    """The same for the one row of the blocks p_i and p_j of two DOT-1 functions."""
    return [_quotient(c, s, rho, present(c_q[n])[0], present(s_q[n])[0]) for n in (1, 3)]
