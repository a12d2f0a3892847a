"""Geometrically exact two-node beam between two frames, and its consistent inertia.

The ends have the positions x = r + A s and the section frames P = p∘π, whose axis 1 is along the beam. With

    σ = sign(P_i·P_j),  m = P_i + σ P_j,  n² = m·m,  d = x_j - x_i
    k = 12 σ G(P_i) P_j / (n (2 + n/2))                         rotation of the ends, sin θ · 3/(2 + cos θ) ≈ θ
    l = Ã(m)ᵀd/n²,  Ã(m) = (m_0² - |m|²) I + 2 (m mᵀ + m_0 m̃)    chord in the mean section frame
    l' = l + ((k·k) l - (l·k) k)/24                             arc in place of the chord

the strains are Γ = l'/L - e_1 and κ = k/L. They do not change in a rigid motion of both ends, and their errors are of
the fourth order of the rotation between the ends. The energy is

    U = L/2 (ε - ε_0)ᵀ C (ε - ε_0),   ε = (Γ, κ),   C = diag(EA, S_y, S_z, GJ, EI_y, EI_z).

One point of integration does not lock. With the residual bending flexibility of MacNeal (Computers &
Structures 8, 1978),

    1/S_y = 1/(k_y G A) + L²/(12 EI_z),   1/S_z = 1/(k_z G A) + L²/(12 EI_y),

the stiffness of small deformations is the 12 x 12 matrix of Timoshenko's beam. The paper has none of it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...algebra import I3, Array, Row, cross
from ...elements.derived import strain_force, strain_rate
from ...elements.element import Force, Grid, InertiaElement, Pair, Scalar, Vec3, Vec6
from ...elements.force_outputs import Passive
from ...elements.output import output
from ...euler import B, G, rotate
from ...functions import positive, sqrt

W = ((156, 22, 54, -13), (22, 4, 13, -3), (54, 13, 156, -22), (-13, -3, -22, 4))


class Strained(Passive, Force, abstract=True):
    """Base of both forces: the strains of the beam between two frames."""

    s_i: Vec3  # [m] end in body i
    e_0i: Scalar  # [-] Euler parameters of the section frame in body i
    e_i: Vec3  # [-]
    s_j: Vec3  # [m] end in body j
    e_0j: Scalar  # [-] those in body j
    e_j: Vec3  # [-]
    length: Scalar  # [m] undeformed
    C: Vec6  # [N, N, N, N m², N m², N m²] section stiffness

    def arc(self, x: Pair) -> tuple[Array, Array]:
        """l' [m] and k [rad]."""
        P_i = self.e_0i * x.p_i + self.e_i @ G(x.p_i)
        P_j = self.e_0j * x.p_j + self.e_j @ G(x.p_j)
        sign = 1 - 2 * positive(-(P_i @ P_j))
        m = P_i + sign * P_j
        nn = m @ m
        n = sqrt(nn)
        d = x.r_j + rotate(x.p_j, self.s_j) - x.r_i - rotate(x.p_i, self.s_i)
        m_0, e = m[0], m[1:]
        chord = ((m_0 * m_0 - e @ e) * d + 2 * (e @ d) * e - 2 * m_0 * cross(e, d)) / nn
        k = 12 * sign / (n * (2 + n / 2)) * (G(P_i) @ P_j)
        return chord + ((k @ k) * chord - (chord @ k) * k) / 24, k

    def strains(self, x: Pair) -> Array:
        """ε = (Γ, κ): axial and shear strains [-], twist and curvatures [rad/m], of section axes. (6,)"""
        arc, k = self.arc(x)
        return np.asarray(np.concatenate([arc / self.length - np.array([1, 0, 0]), k / self.length]))


class Beam(Strained, derivatives="automatic", rare=True):
    """Elastic force of a beam, Q = -U_q."""

    undeformed: Vec6  # ε_0

    def _load(self, x: Pair) -> Array:
        return np.asarray(self.C * (self.strains(x) - self.undeformed))

    @output("N", vector=True)
    def section_force(self, x: Pair) -> Array:
        """Axial and shear forces in the middle of the beam, in section axes: positive axial force is tension."""
        return self._load(x)[:3]

    @output("N m", vector=True)
    def moment(self, x: Pair) -> Array:
        """Torsion and bending moments in the middle of the beam, in section axes."""
        return self._load(x)[3:]

    @output("1", vector=True)
    def strain(self, x: Pair) -> Array:
        """Axial and shear strains, those without load included."""
        return self.strains(x)[:3]

    @output("rad/m", vector=True)
    def curvature(self, x: Pair) -> Array:
        """Twist and curvatures, those without load included."""
        return self.strains(x)[3:]

    def potential(self, x: Pair) -> tuple[Scalar, ...]:
        """U [J]."""
        strain = self.strains(x) - self.undeformed
        return (self.length / 2 * sum(self.C * strain * strain),)


class BeamDamping(Strained, derivatives="automatic", rare=True):
    """Stiffness-proportional damping of a beam, Q = -τ L ε_qᵀ C ε_q v."""

    time: Scalar  # [s] τ

    def _load(self, x: Pair, v: Pair) -> tuple[Array, Array]:
        rate = strain_rate(self, x, v)
        return self.time * self.length * self.C * rate, rate

    def dissipated_power(self, x: Pair, v: Pair, t: Scalar) -> Scalar:
        """τ L ε̇ᵀ C ε̇."""
        load, rate = self._load(x, v)
        return load @ rate

    def Q(self, x: Pair, v: Pair, t: Scalar) -> Row:
        return strain_force(self, x, self._load(x, v)[0])


class BeamInertia(InertiaElement, bodies=2, derivatives="automatic", rare=True):
    """Inertia of the cubic curve through both ends with the tangents t = A(p) e of the sections.

    With X = (x_i, L t_i, x_j, L t_j) and J = X_q, M = JᵀWJ and S = -JᵀW J̇v. W is the consistent mass matrix of a
    cubic Hermite curve.
    """

    s_i: Vec3  # [m] end in body i
    e_i: Vec3  # [-] tangent in body i
    s_j: Vec3  # [m] end in body j
    e_j: Vec3  # [-] tangent in body j
    length: Scalar  # [m]
    mass: Scalar  # [kg]

    def _by_p(self, x: Pair) -> tuple[tuple[Array, Array], ...]:
        """The derivatives of x and of L t by p, for each end."""
        ends = ((x.p_i, self.s_i, self.e_i), (x.p_j, self.s_j, self.e_j))
        return tuple((B(p, s), self.length * B(p, e)) for p, s, e in ends)

    def M(self, x: Pair) -> Grid:
        w = [[self.mass * entry / 420 for entry in line] for line in W]
        by_p = self._by_p(x)
        grid: list[list[Any]] = [[None] * 4 for _ in range(4)]
        for a in (0, 1):
            for b in (0, 1):
                (X_a, T_a), (X_b, T_b) = by_p[a], by_p[b]
                xx, xt, tx, tt = (w[2 * a + m][2 * b + n] for m in (0, 1) for n in (0, 1))
                grid[2 * a][2 * b] = xx * I3
                grid[2 * a][2 * b + 1] = xx * X_b + xt * T_b
                grid[2 * a + 1][2 * b] = (xx * X_a + tx * T_a).T
                grid[2 * a + 1][2 * b + 1] = X_a.T @ (xx * X_b + xt * T_b) + T_a.T @ (tx * X_b + tt * T_b)
        return tuple(map(tuple, grid))

    def S(self, x: Pair, v: Pair) -> Row:
        ends = ((v.p_i, self.s_i, self.e_i), (v.p_j, self.s_j, self.e_j))
        rates = [part for p, s, e in ends for part in (B(p, s) @ p, self.length * (B(p, e) @ p))]
        loads = [sum(-self.mass * w / 420 * rate for w, rate in zip(line, rates, strict=True)) for line in W]
        (X_i, T_i), (X_j, T_j) = self._by_p(x)
        return loads[0], loads[0] @ X_i + loads[1] @ T_i, loads[2], loads[2] @ X_j + loads[3] @ T_j
