"""Derivatives of a workspace with respect to design variables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ..result import Result


@dataclass(frozen=True)
class ShapeDerivative(Result):
    """Derivatives of an area, a volume or an end of a range with respect to parameters.

    Attributes
    ----------
    of : the differentiated quantity, "area", "volume" or "link.x"
    value : its value
    by : derivatives by parameter name
    kinked : length (area) of the boundary on which several curves with different causes coincide; there the derivatives
        are those of one of them
    error : estimated errors of the derivatives, if an integration gives them
    """

    of: str
    value: float
    by: Mapping[str, float]
    kinked: float = 0.0
    error: Mapping[str, float] = field(default_factory=dict)

    def __getitem__(self, name: str) -> float:
        return self.by[name]

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.by)

    def summary(self) -> str:
        """The result in words."""
        lines = [f"{self.of} = {self.value:.9g}"]
        return "\n".join([*lines, *(f"  by {name:<32} {rate:+.9g}" for name, rate in self.by.items())])
