"""Translational spring-damper-actuators: a force along the line between two points. Eqs. (59)-(79).

With the length l = |d|, its rate l̇ = l_q v and any law f(l, l̇, t), tension positive,

    Q = -f l_qᵀ,    Q_q = -l_qᵀ (f_l l_q + f_l̇ l̇_q) - f l_qq,    Q_v = -f_l̇ l_qᵀ l_q.

The paper's k and c are f_l and f_l̇. Singular at l = 0.
"""

from __future__ import annotations

from typing import NamedTuple

from ..._jit.formulas.functions import sqrt
from ...algebra import Array, Row, outer
from ..constraints.segment import Segment
from ..element import Curve, Force, Grid, Pair, Scalar, Vec3
from ..output import output


class Law(NamedTuple):
    """Tension, and its derivatives to length and rate."""

    f: Scalar
    f_l: Scalar
    f_rate: Scalar


class Length(NamedTuple):
    """Length of a segment, its rate, and their derivatives to q."""

    l: Scalar
    rate: Scalar
    l_q: list[Array]
    rate_q: list[Array]


class SpringDamper(Segment):
    """Base of all TSDA: everything except the law."""

    def law(self, l: Scalar, rate: Scalar, t: Scalar) -> Law:
        raise NotImplementedError

    def damper(self, rate: Scalar) -> Scalar:
        """The damper's share of the tension."""
        raise NotImplementedError

    def actuated(self, t: Scalar) -> Scalar:
        """The actuator's share of the tension."""
        raise NotImplementedError

    @output("m", "length")
    def present_length(self, x: Pair) -> Scalar:
        """|d|."""
        d = self.d(x)
        return sqrt(d @ d)

    @output("m/s")
    def rate(self, x: Pair, v: Pair) -> Scalar:
        """l̇."""
        return self._length(x, v).rate

    @output("N")
    def tension(self, x: Pair, v: Pair, t: Scalar) -> Scalar:
        """f(l, l̇, t), positive where it pulls."""
        return self.law(*self._length(x, v)[:2], t).f

    def dissipated_power(self, x: Pair, v: Pair, t: Scalar) -> Scalar:
        """Power that the damper dissipates."""
        rate = self.rate(x, v)
        return self.damper(rate) * rate

    def supplied_power(self, x: Pair, v: Pair, t: Scalar) -> Scalar:
        """Power that the actuator supplies."""
        return -self.actuated(t) * self.rate(x, v)

    def _length(self, x: Pair, v: Pair) -> Length:  # Eqs. (61), (62), (68), (76), (77)
        d, w = self.d(x), self.d_xi(x, v)
        l = sqrt(d @ d)
        u = d / l
        rate = u @ w
        across = (w - rate * u) / l
        l_q = [u @ block for block in self.d_q(x)]
        rate_q = [across @ block for block in self.d_q(x)]
        turn_i, turn_j = self.d_xi_q(v)
        rate_q[1], rate_q[3] = rate_q[1] + u @ turn_i, rate_q[3] + u @ turn_j
        return Length(l, rate, l_q, rate_q)

    def Q(self, x: Pair, v: Pair, t: Scalar) -> Row:  # Eqs. (59), (63)
        size = self._length(x, v)
        f = self.law(size.l, size.rate, t).f
        return tuple(-f * block for block in size.l_q)

    def Q_q(self, x: Pair, v: Pair, t: Scalar) -> Grid:  # Eqs. (64)-(72), both bodies
        size, d_q, curvature = self._length(x, v), self.d_q(x), self.curvature(self.d(x))
        law = self.law(size.l, size.rate, t)
        tension = law.f / size.l
        change = [
            (law.f_l - tension) * a + law.f_rate * b for a, b in zip(size.l_q, size.rate_q, strict=True)
        ]

        def block(m: int, n: int) -> Array:
            return -outer(size.l_q[m], change[n]) - tension * (d_q[m].T @ d_q[n] + curvature.get((m, n), 0))

        return tuple(tuple(block(m, n) for n in range(4)) for m in range(4))

    def Q_v(self, x: Pair, v: Pair, t: Scalar) -> Grid:  # Eqs. (73)-(79), both bodies
        size = self._length(x, v)
        f_v = [-self.law(size.l, size.rate, t).f_rate * block for block in size.l_q]
        return tuple(tuple(outer(a, b) for b in f_v) for a in size.l_q)


class TSDA(SpringDamper, Force, derivatives="automatic"):
    """Linear spring, damper and constant actuator: f = k (l - length) + c l̇ + force. Eq. (60)."""

    s_i: Vec3  # [m] P_i in body i
    s_j: Vec3  # [m] P_j in body j
    k: Scalar  # [N/m]
    c: Scalar  # [N s/m]
    length: Scalar  # [m] free length
    force: Scalar  # [N] tension of the actuator

    def damper(self, rate: Scalar) -> Scalar:
        return self.c * rate

    def actuated(self, t: Scalar) -> Scalar:
        return self.force

    def law(self, l: Scalar, rate: Scalar, t: Scalar) -> Law:
        stretch = l - self.length
        return Law(self.k * stretch + self.c * rate + self.force, self.k, self.c)

    def potential(self, x: Pair) -> tuple[Scalar, ...]:
        """½ k (l - length)² [J]; the actuator's work is none of it."""
        d = self.d(x)
        stretch = sqrt(d @ d) - self.length
        return (self.k * stretch * stretch / 2,)


class NonlinearTSDA(SpringDamper, Force, derivatives="automatic"):
    """Curves for stiffness, damping and actuator: f = k κ(l) (l - length) + c χ(l̇) l̇ + force φ(t)."""

    s_i: Vec3  # [m] P_i in body i
    s_j: Vec3  # [m] P_j in body j
    k: Scalar  # [N/m] scale of the stiffness curve
    c: Scalar  # [N s/m] scale of the damping curve
    length: Scalar  # [m] free length
    force: Scalar  # [N] scale of the actuator curve
    stiffness: Curve  # κ(l)
    damping: Curve  # χ(l̇)
    actuator: Curve  # φ(t)

    def damper(self, rate: Scalar) -> Scalar:
        return self.c * self.damping(rate) * rate

    def actuated(self, t: Scalar) -> Scalar:
        return self.force * self.actuator(t)

    def law(self, l: Scalar, rate: Scalar, t: Scalar) -> Law:
        stretch, kappa, chi = l - self.length, self.stiffness(l), self.damping(rate)
        spring, damper, actuator = stretch * kappa, chi * rate, self.actuator(t)
        f_l = self.k * (kappa + stretch * self.stiffness.slope(l))
        f_rate = self.c * (chi + rate * self.damping.slope(rate))
        return Law(self.k * spring + self.c * damper + self.force * actuator, f_l, f_rate)

    def potential(self, x: Pair) -> tuple[Scalar, ...]:
        """∫ k κ(s) (s - length) ds from the free length on [J]; the actuator's work is none of it."""
        d = self.d(x)
        return (self.k * self.stiffness.moment(self.length, sqrt(d @ d)),)
