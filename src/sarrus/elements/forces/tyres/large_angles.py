"""The Magic Formula with the tangent of the slip angle and the sine of the inclination, for large angles."""

from __future__ import annotations

from typing import Any

from ...._jit.formulas.functions import sin
from .law import Slip
from .magic_formula_52 import MagicFormula52
from .magic_formula_61 import MagicFormula61
from .turn_slip import TurnSlip


class LargeAngles:
    """α* = tan α sgn V_x and γ* = sin γ in place of the angles. [P12 4.E3, 4.E4]"""

    def alpha(self, slip: Slip) -> Any:
        """α* [-]."""
        return slip.tan_alpha

    def inclination(self, slip: Slip) -> Any:
        """γ* [-]."""
        return sin(slip.gamma)


class LargeAngles52(LargeAngles, MagicFormula52):
    """The Magic Formula 5.2 with large angles."""


class LargeAngles61(LargeAngles, MagicFormula61):
    """The Magic Formula 6.1 and 6.2 with large angles."""


class LargeAnglesTurnSlip(LargeAngles, TurnSlip):
    """The Magic Formula 6.1 and 6.2 with large angles and turn slip."""
