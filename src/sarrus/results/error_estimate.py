"""The estimated error of a response."""

from __future__ import annotations

from dataclasses import dataclass
from math import copysign, isfinite, log10

from ..console import printable
from ..model.deprecated import with_former_names

MOST_DIGITS = 16.0


@with_former_names
@dataclass(frozen=True)
class ErrorEstimate:
    """A response of a run, and an estimate of its error. Units are those of the response.

    Attributes
    ----------
    response : its title
    value : of the run
    estimate : of value minus exact value, with its sign
    spread : the sum of the absolute contributions of all steps: how large the error would be if none cancelled
    round_off : what round-off of the states amounts to in the response
    """

    response: str
    value: float
    estimate: float
    spread: float
    round_off: float

    @property
    def error(self) -> float:
        """The size of the error: that of the estimate, at least what round-off makes."""
        return max(abs(self.estimate), self.round_off)

    @property
    def corrected(self) -> float:
        """The value without the estimated error."""
        return self.value - self.estimate

    @property
    def digits(self) -> float:
        """Digits of the value that are right, between 0 and 16."""
        if not isfinite(self.error):
            return 0.0
        if not self.error:
            return MOST_DIGITS
        return min(max(log10(abs(self.value) / self.error), 0.0), MOST_DIGITS) if self.value else 0.0

    def __float__(self) -> float:
        return copysign(self.error, self.estimate)

    def __str__(self) -> str:
        return printable(f"{self.response}: {self.value:.8g} ± {self.error:.1g} ({self.digits:.1f} digits)")
