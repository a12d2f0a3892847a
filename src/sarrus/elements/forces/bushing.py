"""Bushing: a linear elastic and damping connection of two frames, with full 6 x 6 matrices.

The six deformations Ξ are measured in the frame of body i: the line d from P_i to P_j, and the rotation vector ϑ = φ n
of frame j, which is turned by φ ≤ π about n,

    Ξ = (f_i·d, g_i·d, h_i·d, f_i·ϑ, g_i·ϑ, h_i·ϑ).

The work of the force F = K Ξ + C Ξ̇ - F₀ is that of Ξ: net force and moment on the pair vanish, and energy is conserved
for C = 0 and K = Kᵀ. With the relative angular velocity ω,

    ϑ̇ = J⁻¹ω in the axes of frame i,   J⁻¹ = I - ½ϑ̃ + βϑ̃²,   β = (1 - φ/2 cot φ/2)/φ²,

so that the moment is -J⁻ᵀ times the last three components of F. ϑ jumps at half a revolution, where n is not unique.
The paper has none of it.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np

from ...algebra import Array, Row, cross
from ...euler import E, G, rotate
from ...functions import positive, sqrt
from ..element import Force, Mat66, Pair, Scalar, Vec3, Vec6
from ..output import output


class Bushing(Force, derivatives="automatic", rare=True):
    """Force K Ξ + C Ξ̇ - preload in the axes of frame i, resisting the deformation Ξ of frame j relative to frame i."""

    s_i: Vec3  # [m] P_i in body i
    f_i: Vec3  # [-] frame in body i
    g_i: Vec3  # [-]
    h_i: Vec3  # [-]
    s_j: Vec3  # [m] P_j in body j
    e_0: Scalar  # [-] Euler parameters of body j in body i where the frames are parallel
    e: Vec3  # [-]
    K: Mat66  # [N/m, N/rad; N, N m/rad]
    C: Mat66  # [N s/m, N s/rad; N s, N m s/rad]
    preload: Vec6  # [N, N m] on body j in frame i at rest and undeformed

    def _axes(self, x: Pair) -> Array:
        """The axes of frame i in global axes, as rows."""
        return np.array([rotate(x.p_i, a) for a in (self.f_i, self.g_i, self.h_i)])

    def _arms(self, x: Pair) -> tuple[Array, Array]:
        """P_j from the origins of both bodies."""
        arm = rotate(x.p_j, self.s_j)
        return x.r_j + arm - x.r_i, arm

    def _turn(self, x: Pair) -> tuple[Array, Scalar]:
        """ϑ in global axes, and β."""
        free = self.e_0 * x.p_i + self.e @ G(x.p_i)
        return rotation_vector(free @ x.p_j, E(free) @ x.p_j)

    def _strain(self, x: Pair) -> Array:
        axes, d = self._axes(x), self._arms(x)[0] - rotate(x.p_i, self.s_i)
        return np.concatenate([axes @ d, axes @ self._turn(x)[0]])

    def _rate(self, x: Pair, v: Pair) -> Array:
        axes, (arm_i, arm_j), (turn, beta) = self._axes(x), self._arms(x), self._turn(x)
        w_i, w_j = 2 * (E(x.p_i) @ v.p_i), 2 * (E(x.p_j) @ v.p_j)
        w = w_j - w_i
        across = cross(turn, w)
        moved = v.r_j + cross(w_j, arm_j) - v.r_i - cross(w_i, arm_i)
        return np.concatenate([axes @ moved, axes @ (w - across / 2 + beta * cross(turn, across))])

    @output("m", vector=True)
    def displacement(self, x: Pair) -> Array:
        """Displacement of P_j from P_i, in the axes of frame i."""
        return self._strain(x)[:3]

    @output("rad", vector=True)
    def rotation(self, x: Pair) -> Array:
        """The rotation vector of frame j, in the axes of frame i."""
        return self._strain(x)[3:]

    @output("m/s", vector=True)
    def displacement_rate(self, x: Pair, v: Pair) -> Array:
        """The rate of the displacement."""
        return self._rate(x, v)[:3]

    @output("rad/s", vector=True)
    def rotation_rate(self, x: Pair, v: Pair) -> Array:
        """The rate of the rotation vector."""
        return self._rate(x, v)[3:]

    def dissipated_power(self, x: Pair, v: Pair, t: Scalar) -> Scalar:
        """Ξ̇ᵀ C Ξ̇."""
        rate = self._rate(x, v)
        return rate @ (self.C.reshape(6, 6) @ rate)

    def supplied_power(self, x: Pair, v: Pair, t: Scalar) -> Scalar:
        """-½ Ξ̇ᵀ (K - Kᵀ) Ξ: zero for symmetric K."""
        K = self.K.reshape(6, 6)
        return self._rate(x, v) @ ((K.T - K) @ self._strain(x)) / 2

    def potential(self, x: Pair) -> tuple[Scalar, ...]:
        """½ Ξᵀ K Ξ - F₀ᵀΞ [J], for symmetric K."""
        strain = self._strain(x)
        return (strain @ (self.K.reshape(6, 6) @ strain) / 2 - self.preload @ strain,)

    def Q(self, x: Pair, v: Pair, t: Scalar) -> Row:
        K, C = self.K.reshape(6, 6), self.C.reshape(6, 6)
        F = K @ self._strain(x) + C @ self._rate(x, v) - self.preload
        axes, (arm_i, arm_j), (turn, beta) = self._axes(x), self._arms(x), self._turn(x)
        force, moment = F[:3] @ axes, F[3:] @ axes
        across = cross(turn, moment)
        moment = moment + across / 2 + beta * cross(turn, across)
        torques = (2 * ((moment + cross(arm, force)) @ E(p)) for arm, p in ((arm_i, x.p_i), (arm_j, x.p_j)))
        return force, next(torques), -force, -next(torques)


def rotation_vector(d_0: Scalar, d: Array) -> tuple[Array, Scalar]:
    """ϑ = φ n, φ ≤ π, of unit Euler parameters (d_0, d), and β = (1 - φ/2 cot φ/2)/φ².

    With x = φ/2, |d| = sin x = 16 sin x/16 · cos x/2 ⋯ cos x/16 and x cot x = (x/2) cot x/2 - (x/2) tan x/2, so that
    almost equal numbers are never subtracted. With τ = tan x/16 < 0.1, x/16 = τ - τ³ (1/3 - τ²/5 + ⋯) of eight terms.
    """
    side = 2 * positive(d_0) - 1
    cosine, product, sum_ = side * d_0, 1, 0
    for n in range(2, 6):
        cosine = sqrt((1 + cosine) / 2)
        product = product * cosine
        sum_ = sum_ + 1 / (product * cosine * 4**n)
    negative = 1 - 1 / (cosine * cosine)  # -τ²
    rest: Any = 0
    for n in range(17, 1, -2):
        rest = Fraction(1, n) + negative * rest
    series = 1 + negative * rest
    half = series / (product * cosine)  # x / sin x
    vector: Array = 2 * side * half * d
    return vector, sum_ / half + rest / (1024 * series * series)
