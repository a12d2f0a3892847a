"""Inertia of a joint coordinate ξ, as that of a motor's rotor behind a gear: kinetic energy ½ I ξ̇².

M = I ξ_qᵀ ξ_q and S = -I ξ_qᵀ (ξ_q v)_q v. These are Lagrange's equations, as ξ_q is a gradient. The paper has no
such inertia.
"""

from __future__ import annotations

from typing import Any

from ..algebra import Row, outer, present
from .constraints.argument import Argument
from .constraints.dot2 import Dot2
from .element import Grid, InertiaElement, Pair, Scalar, Vec3
from .follows import contracted


class CoordinateInertia:
    """Base of both kinds: everything except the coordinate."""

    inertia: Scalar

    def coordinate(self) -> Any:
        """ξ with the kernels of a constraint."""
        raise NotImplementedError

    def M(self, x: Pair) -> Grid:
        gradient = self.coordinate().Phi_q(x)
        return _dyadic(self.inertia, gradient, gradient)

    def S(self, x: Pair, v: Pair) -> Row:
        coordinate = self.coordinate()
        force = -self.inertia * present(contracted(coordinate.Phi_q_xi_q(x, v), v))[0]
        return tuple(None if block is None else force * block[0] for block in coordinate.Phi_q(x))

    def S_v(self, x: Pair, v: Pair) -> Grid:
        coordinate = self.coordinate()
        return _dyadic(-2 * self.inertia, coordinate.Phi_q(x), coordinate.Phi_q_xi_q(x, v))


def _dyadic(factor: Scalar, a: Row, b: Row) -> Grid:
    """factor aᵀ b, for two rows of blocks."""
    return tuple(tuple(None if m is None or n is None else factor * outer(m[0], n[0]) for n in b) for m in a)


class AngleInertia(CoordinateInertia, InertiaElement, bodies=2, derivatives="automatic", rare=True):
    """Inertia of the angle of f_j in the plane of f_i and g_i."""

    f_i: Vec3  # [-] fixed in body i
    g_i: Vec3  # [-] f_i rotated by a right angle
    f_j: Vec3  # [-] fixed in body j
    inertia: Scalar  # [kg m²]

    def coordinate(self) -> Argument:
        return Argument(self.f_i, self.g_i, self.f_j)


class DisplacementInertia(CoordinateInertia, InertiaElement, bodies=2, derivatives="automatic", rare=True):
    """Inertia of the displacement h_i·d_ij."""

    h_i: Vec3  # [-] unit vector along the joint in body i
    s_i: Vec3  # [m] P_i in body i
    s_j: Vec3  # [m] P_j in body j
    inertia: Scalar  # [kg]

    def coordinate(self) -> Dot2:
        return Dot2(self.h_i, self.s_i, self.s_j)
