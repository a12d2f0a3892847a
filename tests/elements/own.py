"""Elements that only the tests have: what no built-in one does. They are compiled and checked like those.

Time in a constraint, coded and differentiated automatically; three and four bodies, one of them met twice; a force
with nothing but its formula, every function that kernels may call, tables, a stored formula and memory.
"""

import numpy as np

from sarrus import functions as f
from sarrus.algebra import I3, I4, row
from sarrus.elements import Element, Force, Primitive
from sarrus.elements.element import Curve, Memory, Scalar, Surface, Time, Vec3
from sarrus.euler import rotate

ZERO3, ZERO4 = row(np.zeros(3, dtype=int)), row(np.zeros(4, dtype=int))


class Swaying(Primitive, rows=2, bodies=1):
    """Φ = [t² k n·r + r·r,  t³ c + t p·p], coded. The time stands between the numbers."""

    n: Vec3
    t: Time
    k: Scalar
    c: Scalar

    def Phi(self, x):
        t = self.t
        return np.array([t * t * self.k * (self.n @ x.r) + x.r @ x.r, t * t * t * self.c + t * (x.p @ x.p)])

    def Phi_q(self, x):
        t = self.t
        by_r, by_p = row(t * t * self.k * self.n + 2 * x.r), row(2 * t * x.p)
        return np.concatenate([by_r, ZERO3]), np.concatenate([ZERO4, by_p])

    def Phi_q_xi_q(self, x, xi):
        by_r, by_p = row(2 * xi.r), row(2 * self.t * xi.p)
        return np.concatenate([by_r, ZERO3]), np.concatenate([ZERO4, by_p])

    def Phi_q_xi_q_eta_q(self, x, xi, eta):
        return None, None

    def Phi_qT_lam_q(self, x, lam):
        return (2 * lam[0] * I3, None), (None, 2 * self.t * lam[1] * I4)

    def Phi_qT_lam_q_xi_q(self, x, lam, xi):
        return (None, None), (None, None)

    def Phi_b(self, x):
        t, nothing = self.t, 0 * self.t
        by_n = np.concatenate([row(t * t * self.k * x.r), ZERO3])
        return by_n, None, np.array([[t * t * (self.n @ x.r)], [nothing]]), np.array([[nothing], [t * t * t]])

    def Phi_q_xi_b(self, x, xi):
        t = self.t
        by_n = np.concatenate([row(t * t * self.k * xi.r), ZERO3])
        return by_n, None, np.array([[t * t * (self.n @ xi.r)], [0 * t]]), None

    def Phi_q_xi_q_eta_b(self, x, xi, eta):
        return None, None, None, None

    def Phi_qT_lam_b(self, x, lam):
        size = lam[0] * self.t * self.t
        return (size * self.k * I3, None, size * self.n[:, None], None), (None,) * 4


class Driven(Primitive, rows=1, bodies=2, derivatives="automatic"):
    """A distance that follows a curve and a formula of time: Φ = d·d + k law(3t/8) a·d - formula(t)."""

    time: Time
    law: Curve
    a: Vec3
    k: Scalar
    formula: Curve

    def Phi(self, x):
        d = x.r_j + rotate(x.p_j, self.a) - x.r_i
        drive = self.k * self.law(3 * self.time / 8) * (rotate(x.p_i, self.a) @ d)
        return row(d) @ d + drive - self.formula(self.time)


class Coupler(Primitive, rows=2, bodies=3, derivatives="automatic"):
    """Three bodies: the turning of each is bound to where the others are."""

    a: Vec3
    k: Scalar

    def Phi(self, x):
        r_1, p_1, r_2, p_2, r_3, p_3 = x
        u, w = rotate(p_1, self.a), r_3 - r_2
        return np.array([(u @ w) * self.k + p_2 @ p_3, r_1 @ w + self.k * (p_1 @ p_2)])


class Tangle(Force, bodies=4, derivatives="automatic"):
    """Four bodies, Q alone: a force on the first and the last, of all others' places and velocities."""

    k: Scalar
    n: Vec3

    def Q(self, x, v, t):
        size = self.k * (x[2] @ v[4]) + t * (x[3] @ x[5]) * (x[6] @ self.n)
        return size * x[2], None, None, None, None, None, v[0] @ v[6] * self.n, size * v[7]


class Strained(Force, bodies=2, derivatives="automatic"):
    """Q alone, of every function that kernels may call, tables, a formula, the time, and something remembered."""

    k: Scalar
    law: Curve
    surface: Surface
    formula: Curve
    memory: Memory

    def remember(self, x):
        return (x.r_i[0],)

    def _size(self, x, v, t):
        a = f.exp(f.sin(x.r_i[0])) + f.log(2 + x.r_j @ x.r_j) + f.tan(x.p_i[0] / 8)
        b = f.asin(f.tanh(x.p_j[1] / 4)) + f.acos(f.cos(x.r_j[2]) / 2) + f.atan(v.r_i[1])
        c = f.sqrt(1 + x.r_i @ x.r_i) + f.atan2(x.r_j[2], 1 + x.p_i @ x.p_i)
        d = f.absolute(x.p_i[1] - 3) + f.ramp(v.r_j[0]) + f.maximum(x.r_i[2], 2) + f.minimum(x.r_i[1], t / 4)
        return self.k * (a + b * c) + d + f.nearest(x.p_j[2] + self.memory) + f.positive(t)

    def Q(self, x, v, t):
        size = self._size(x, v, t) + self.law(3 * (x.r_i[0] + v.r_j[1]) / 8) * self.formula(x.r_j[0] / 8)
        size = size + self.surface(x.r_i[1] * x.r_j[1] / 2, v.r_i[0] - x.r_j[2])
        return size * (v.r_i + t * x.r_j), None, None, size * v.p_i


class Implicit(Force, bodies=2, derivatives="automatic"):
    """Q alone, of the root of an equation, in which another one has its own."""

    k: Scalar

    def Q(self, x, v, t):
        def inner(u):
            return f.root(lambda w: w + f.tanh(w) / 2 - u * x.p_j[1], u / 2)

        u = f.root(
            lambda u: 2 * u + f.sin(u - x.r_i[1]) / 2 + inner(u) / 8 - self.k * (v.r_j[0] + t), x.r_i[0]
        )
        return u * v.r_i + x.r_j, None, f.cos(u) * x.r_j, u * v.p_i


OWN = (Swaying, Driven, Coupler, Tangle, Strained, Implicit)
for _kind in OWN:
    del Element.registry[_kind.__name__]  # other tests and users see the built-in elements alone
