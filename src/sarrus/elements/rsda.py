"""Rotational spring-damper-actuator about a common axis h of two bodies. Eqs. (104)-(116).

θ is the angle of f_j in the plane of f_i and g_i: with c = f_i·f_j and s = g_i·f_j it is the argument of z = c + i s,
two DOT-1 functions, whose derivatives it inherits: θ_q = Im(z_q / z), (θ_q v)_q = Im((z_q v)_q / z - z_v z_q / z²).
These hold for any p; the paper's (110), (112), (114), (116) only on unit p with f_j orthogonal to h_i (see the errata).
"""

from __future__ import annotations

from math import pi
from typing import NamedTuple

from ..algebra import Array, Block, Row, column, outer
from ..euler import G, bar
from .dot1 import Dot1
from .element import ZERO_PAIR, Force, Grid, Memory, Pair, Scalar, Vec3
from .._jit.functions import atan2, nearest


class Turn(NamedTuple):
    """z, and w z_q, w z_v (real and imaginary parts) with w = 1 / z; the last is the rate of θ."""

    c: Scalar
    s: Scalar
    rho: Scalar
    re_q: Row
    im_q: Row
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
        re_q, im_q = self._over_z(c, s, rho, C.Phi_q(x), S.Phi_q(x))
        c_v, s_v = C.Phi_q_xi(x, v)[0], S.Phi_q_xi(x, v)[0]
        return Turn(c, s, rho, re_q, im_q, (c * c_v + s * s_v) / rho, (c * s_v - s * c_v) / rho)

    @staticmethod
    def _over_z(c: Scalar, s: Scalar, rho: Scalar, c_q: Row, s_q: Row) -> tuple[Row, Row]:
        """Real and imaginary parts of (c_q + i s_q) / z, block by block."""
        blocks = [(a, b) for a, b in zip(c_q, s_q, strict=True)]
        re = tuple(None if a is None or b is None else (c * a + s * b) / rho for a, b in blocks)
        im = tuple(None if a is None or b is None else (c * b - s * a) / rho for a, b in blocks)
        return re, im

    def _rate_q(self, x: Pair, v: Pair, turn: Turn) -> list[Block]:
        """(θ_q v)_q, block by block."""
        C, S = self._dots()
        _, im = self._over_z(turn.c, turn.s, turn.rho, C.Phi_q_xi_q(x, v), S.Phi_q_xi_q(x, v))
        parts = zip(im, turn.re_q, turn.im_q, strict=True)
        return [
            None if a is None or r is None or i is None else a - turn.re_v * i - turn.rate * r for a, r, i in parts
        ]

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
        rate_q = self._rate_q(x, v, turn)
        own = 2 * n * bar(self.h_i), -2 * n * bar(self.h_j)
        ii, ij, ji, jj = self._grid(x, [self._n_q(turn.im_q[m], rate_q[m]) for m in (1, 3)])
        none = ZERO_PAIR[0]
        return none, (None, ii + own[0], None, ij), none, (None, ji, None, jj + own[1])

    def _n_q(self, theta_q: Block, rate_q: Block) -> Array:  # Eqs. (109)-(113)
        assert theta_q is not None and rate_q is not None
        return self.k * theta_q[0] + self.c * rate_q[0]

    def _grid(self, x: Pair, n_q: list[Array]) -> list[Array]:
        return [outer(w, part) for w in self._w(x) for part in n_q]

    def Q_v(self, x: Pair, v: Pair, t: Scalar) -> Grid:  # Eq. (108), (114), (116)
        turn = self._turn(x, v)
        theta_q = [block for block in turn.im_q if block is not None]
        ii, ij, ji, jj = self._grid(x, [self.c * block[0] for block in theta_q])
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
        result = []
        for z_b, zv_b in (((c_fi, 0), (cv_fi, 0)), ((0, s_gi), (0, sv_gi)), ((c_fj, s_fj), (cv_fj, sv_fj))):
            re, theta_b = self._divided(turn, *z_b)
            _, first = self._divided(turn, *zv_b)
            rate_b = first - turn.re_v * theta_b - turn.rate * re
            result.append((self.k * theta_b + self.c * rate_b)[0])
        return result

    @staticmethod
    def _divided(turn: Turn, c: Scalar, s: Scalar) -> tuple[Array, Array]:
        return (turn.c * c + turn.s * s) / turn.rho, (turn.c * s - turn.s * c) / turn.rho
