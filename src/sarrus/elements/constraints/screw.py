"""Screw: displacement along an axis is proportional to the angle about it; an equation beside those of a cylinder."""

from __future__ import annotations

from collections.abc import Iterator

from ...algebra import Array, single
from ..element import Pair, Primitive, Scalar, Vec3
from .argument import Argument
from .combination import Combination, Term
from .dot2 import Dot2


class Screw(Combination, Primitive, rows=1, derivatives="automatic", rare=True):
    """Φ = h_iᵀ d - lead (θ - angle) - displacement [m]; right-handed where the lead is positive.

    The displacement determines the revolutions: θ is taken nearest to the angle that corresponds to it, so no
    revolutions are stored. The paper has no formula for it; derivatives with respect to the parameters are generated
    from the recorded formula.
    """

    f_i: Vec3  # [-] fixed in body i; f_i, g_i, h_i right-handed
    g_i: Vec3  # [-]
    h_i: Vec3  # [-] the axis in body i
    f_j: Vec3  # [-] fixed in body j
    s_i: Vec3  # [m] P_i in body i
    s_j: Vec3  # [m] P_j in body j
    lead: Scalar  # [m/rad] displacement for one radian
    angle: Scalar  # [rad] where the displacement is `displacement`
    displacement: Scalar  # [m]

    def terms(self) -> Iterator[Term]:
        yield Term(1, Dot2(self.h_i, self.s_i, self.s_j))
        yield Term(-self.lead, Argument(self.f_i, self.g_i, self.f_j))

    def Phi(self, x: Pair) -> Array:
        displacement, theta = (term.function for term in self.terms())
        moved = displacement.Phi(x)[0] - self.displacement
        turned = theta.near(x, self.angle + moved / self.lead) - self.angle
        return single(moved - self.lead * turned)[0]
