"""A function of one variable given by pieces of cubics, stored among the numbers of a system."""

from __future__ import annotations

from typing import Any

from .._jit.expression import Expression
from .._jit.functions import curve, curve_slope, real


class StoredCurve:
    """The curve stored at ``numbers[at:]``: count, count + 1 knots, then 4 coefficients (highest power first) a piece.

    Called with x it gives the value, `slope` gives the first derivative. `at` may be recorded: then so is the call.
    """

    def __init__(self, numbers: Any, at: Any) -> None:
        self.numbers, self.at = numbers, at

    def _evaluate(self, name: str, function: Any, x: Any) -> Any:
        if isinstance(self.at, Expression):
            return self.at.call(name, x)
        return function(self.numbers, int(real(self.at)), x)

    def __call__(self, x: Any) -> Any:
        return self._evaluate("curve", curve, x)

    def slope(self, x: Any) -> Any:
        return self._evaluate("curve_slope", curve_slope, x)
