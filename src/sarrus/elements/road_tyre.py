"""A tyre as a vertical spring and damper that lifts off, over a road with a profile and a bump in time.

The road under the wheel centre (x, ., z) is road + profile(x) + bump(t). With the compression δ = radius - (z - road),
its rate δ̇ and the width w of the rounding, the force upwards is

    F = σ(δ) (k δ + c δ̇)₊

σ is `soft_step` of width w, the subscript `soft_ramp` of width k w: exactly k δ + c δ̇, as in `Tyre`, from δ = w/2 and
F = k w/2 on; exactly zero for δ ≤ -w/2, and never a pull. Its derivatives are made by differentiating Q.
"""

from __future__ import annotations

from ..algebra import Row
from ..euler import B, rotate
from .element import Curve, Force, Scalar, Single, Vec3
from .output import output
from .smooth import soft_ramp, soft_step
from .tyre import UP


class RoadTyre(Force, bodies=1, derivatives="automatic", rare=True):
    """F = σ(δ) (k δ + c δ̇)₊ upwards at the wheel centre."""

    s: Vec3  # [m] wheel centre in the body
    k: Scalar  # [N/m]
    c: Scalar  # [N s/m]
    radius: Scalar  # [m] unloaded
    road: Scalar  # [m] height that is added to both curves
    width: Scalar  # [m] of the rounding
    profile: Curve  # [m] over the global x [m]
    bump: Curve  # [m] over time [s]

    @output("m")
    def compression(self, x: Single, v: Single, t: Scalar) -> Scalar:
        """δ, negative where the tyre is off the road."""
        place = x.r + rotate(x.p, self.s)
        return self.radius - (place[2] - (self.road + self.profile(place[0]) + self.bump(t)))

    def Q(self, x: Single, v: Single, t: Scalar) -> Row:
        B_s = B(x.p, self.s)
        place, velocity = x.r + rotate(x.p, self.s), v.r + B_s @ v.p
        rise = self.profile.slope(place[0]) * velocity[0] + self.bump.slope(t)
        depth, rate = self.compression(x, v, t), rise - velocity[2]
        touching = soft_step(depth, self.width)
        F = touching * soft_ramp(self.k * depth + self.c * rate, self.k * self.width)
        return F * UP, F * B_s[2]
