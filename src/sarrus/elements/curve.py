"""A function of one variable, stored among the numbers of a system."""

from __future__ import annotations

from typing import Any

from .._jit.formulas.curves import curve_bend, curve_slope, curve_twist, curve_value
from .._jit.formulas.expression import Expression
from .._jit.formulas.functions import real


class StoredCurve:
    """The curve stored at ``numbers[at:]``, see `_jit.formulas.curves`. `at` may be recorded: then so is the call.

    Called with x it gives the value; `slope`, `bend` and `twist` give the first three derivatives, `moment` an
    integral, which is recorded only.
    """

    def __init__(self, numbers: Any, at: Any) -> None:
        self.numbers, self.at = numbers, at

    def _evaluate(self, name: str, function: Any, *x: Any) -> Any:
        if isinstance(self.at, Expression):
            return self.at.call(name, *x)
        return function(self.numbers, int(real(self.at)), *x)

    def __call__(self, x: Any) -> Any:
        return self._evaluate("curve", curve_value, x)

    def slope(self, x: Any) -> Any:
        return self._evaluate("curve_slope", curve_slope, x)

    def bend(self, x: Any) -> Any:
        return self._evaluate("curve_bend", curve_bend, x)

    def twist(self, x: Any) -> Any:
        return self._evaluate("curve_twist", curve_twist, x)

    def moment(self, a: Any, b: Any) -> Any:
        """The integral from a to b of the curve times x - a: the work of a stiffness. For potentials only."""
        return self.at.call("curve_moment", a, b)
