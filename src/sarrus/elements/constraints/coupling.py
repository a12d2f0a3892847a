"""Couplings: the coordinates of two joints are proportional.

i and j are the bodies of the first joint, k and l of the second; they may repeat. The paper has no formulas for them;
derivatives to the numbers are made by differentiating what is recorded.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ...algebra import Array, single
from ..element import Memory, Primitive, Scalar, Vec3
from .argument import Argument
from .combination import Combination, Term
from .dot2 import Dot2


class AngleAngle(Combination, Primitive, rows=1, bodies=4, derivatives="automatic", rare=True):
    """Gears, Φ = θ_kl - ratio θ_ij - offset [rad].

    The revolutions of θ_ij are those nearest to the reference, a state variable; those of θ_kl follow from them.
    """

    f_i: Vec3  # [-] of the first angle, as in `Angle`
    g_i: Vec3  # [-]
    f_j: Vec3  # [-]
    f_k: Vec3  # [-] of the second
    g_k: Vec3  # [-]
    f_l: Vec3  # [-]
    ratio: Scalar  # [-]
    offset: Scalar  # [rad]
    reference: Memory  # [rad] near θ_ij

    def terms(self) -> Iterator[Term]:
        yield Term(-self.ratio, Argument(self.f_i, self.g_i, self.f_j))
        yield Term(1, Argument(self.f_k, self.g_k, self.f_l), 1)

    def Phi(self, x: Any) -> Array:
        _, second = self.terms()
        goal = self.ratio * self.remember(x)[0] + self.offset
        return single(second.function.near(second.of(x), goal) - goal)[0]

    def remember(self, x: Any) -> tuple[Scalar, ...]:
        """New values of the memory fields at an accepted state."""
        first, _ = self.terms()
        return (first.function.near(first.of(x), self.reference),)


class DisplacementAngle(Combination, Primitive, rows=1, bodies=4, derivatives="automatic", rare=True):
    """Rack and pinion, Φ = a_iᵀ d_ij - ratio θ_kl - offset [m]. The displacement determines the revolutions of θ_kl."""

    a_i: Vec3  # [-] of the displacement, as in `Displacement`
    s_i: Vec3  # [m]
    s_j: Vec3  # [m]
    f_k: Vec3  # [-] of the angle, as in `Angle`
    g_k: Vec3  # [-]
    f_l: Vec3  # [-]
    ratio: Scalar  # [m/rad]
    offset: Scalar  # [m]

    def terms(self) -> Iterator[Term]:
        yield Term(1, Dot2(self.a_i, self.s_i, self.s_j))
        yield Term(-self.ratio, Argument(self.f_k, self.g_k, self.f_l), 1)

    def Phi(self, x: Any) -> Array:
        rack, pinion = self.terms()
        displacement = rack.function.Phi(rack.of(x))[0] - self.offset
        return single(
            displacement - self.ratio * pinion.function.near(pinion.of(x), displacement / self.ratio)
        )[0]


class DisplacementDisplacement(Combination, Primitive, rows=1, bodies=4, derivatives="automatic", rare=True):
    """Slides, Φ = a_kᵀ d_kl - ratio a_iᵀ d_ij - offset [m]."""

    a_i: Vec3  # [-] of the first displacement, as in `Displacement`
    s_i: Vec3  # [m]
    s_j: Vec3  # [m]
    a_k: Vec3  # [-] of the second
    s_k: Vec3  # [m]
    s_l: Vec3  # [m]
    ratio: Scalar  # [-]
    offset: Scalar  # [m]

    def terms(self) -> Iterator[Term]:
        yield Term(-self.ratio, Dot2(self.a_i, self.s_i, self.s_j))
        yield Term(1, Dot2(self.a_k, self.s_k, self.s_l), 1)

    def Phi(self, x: Any) -> Array:
        first, second = self.terms()
        return second.function.Phi(second.of(x)) - self.ratio * first.function.Phi(first.of(x)) - self.offset
