"""The numbers of a unilateral contact, for stops and for a sphere on a plane."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from ..errors import ModelError
from ..measure import In, Length, Ratio
from ..quantity import not_negative, number, positive
from ..show import show


@dataclass(frozen=True, eq=False, kw_only=True)
class ContactLaw:
    """Normal force stiffness · depthⁿ (1 + damping · rate of the depth), after Hunt and Crossley.

    Parameters
    ----------
    stiffness
        Greater than 0 [N/mⁿ].
    exponent
        n, at least 1; 3/2 for two elastic spheres.
    damping
        [s/m] An impact at the small speed u comes back with about u (1 − ⅔ damping · u), at any speed with u' of
        damping · u − ln(1 + damping · u) = −damping · u' − ln(1 − damping · u').
    rounding
        Depth [m] over which the force sets in smoothly, centred on first touch; beyond half of it the law is exact, as
        long as the depth falls no faster than 7/8 of 1/damping. Faster, the force is rounded towards zero: up to
        damping · u = 2.4 (36 % of the speed comes back) nothing of this is met, at 5 u' is 1.1 % too large.
    """

    stiffness: Annotated[float, In("")]  # any unit: it depends on the exponent
    exponent: Ratio = 1.0
    damping: Annotated[float, In("s/m")] = 0.0
    rounding: Length = 1e-4

    def contact(self) -> tuple[float, float, float, float]:
        """Return the checked numbers in the elements' order."""
        stiffness = positive(self.stiffness, "stiffness", "give the stiffness in N/m")
        exponent = number(self.exponent, "exponent")
        if exponent < 1.0:
            raise ModelError(
                f"exponent must be at least 1, but is {show(exponent)}; 1 is linear", field="exponent"
            )
        damping = not_negative(self.damping, "damping", "give it in s/m")
        return stiffness, exponent, damping, positive(self.rounding, "rounding", "give a small depth")
