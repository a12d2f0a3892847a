"""A function of two variables, stored among the numbers of a system."""

from __future__ import annotations

from typing import Any

from .._jit.formulas.expression import Expression
from .._jit.formulas.functions import real
from .._jit.formulas.surfaces import surface_name, surface_value


class StoredSurface:
    """The surface stored at ``numbers[at:]``, see `_jit.formulas.surfaces`. If `at` is recorded, so is the call."""

    def __init__(self, numbers: Any, at: Any) -> None:
        self.numbers, self.at = numbers, at

    def __call__(self, x: Any, y: Any) -> Any:
        return self.derivative(x, y, 0, 0)

    def derivative(self, x: Any, y: Any, i: int, j: int) -> Any:
        """∂ⁱ⁺ʲz/∂xⁱ∂yʲ."""
        if isinstance(self.at, Expression):
            return self.at.call(surface_name(i, j), x, y)
        return surface_value(self.numbers, int(real(self.at)), x, y, i, j)
