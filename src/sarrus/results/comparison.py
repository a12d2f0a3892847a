"""The result of a verification: values and derivatives of an analysis beside those of a finer one."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import isfinite, isnan, log10
from typing import Any

from ..console import printable
from ..outputs.output import labelled
from .error_estimate import MOST_DIGITS
from .result import Result


@dataclass(frozen=True)
class ComparedValue:
    """A number of an analysis, and of a finer one.

    Attributes
    ----------
    name, unit : of the number
    value, finer : the numbers
    scale : size of which digits are counted
    """

    name: str
    unit: str
    value: float
    finer: float
    scale: float

    @property
    def difference(self) -> float:
        """The finer value minus the value."""
        return self.finer - self.value

    @property
    def digits(self) -> float:
        """Digits in which both agree, between 0 and 16; 16 if both are undefined."""
        if self.value == self.finer or (isnan(self.value) and isnan(self.finer)):
            return MOST_DIGITS
        if not isfinite(self.difference):
            return 0.0
        return min(log10(max(self.scale / abs(self.difference), 1.0)), MOST_DIGITS)


@dataclass(frozen=True, eq=False)
class Comparison(Result):
    """Result of `verify`: an analysis, a finer one, and the digits in which they agree.

    Attributes
    ----------
    name : of the system
    values, derivatives : the numbers that were compared
    digits : in how many digits all must agree
    finer : the result of the finer analysis
    refinement : how it is finer
    message : empty, or why the analyses cannot agree, such as another end
    """

    name: str
    values: tuple[ComparedValue, ...]
    derivatives: tuple[ComparedValue, ...]
    digits: float
    finer: Any = field(repr=False)
    refinement: str = ""
    message: str = ""

    @property
    def agree(self) -> bool:
        """Whether all numbers agree in the digits asked for, and the finer analysis came to the same end."""
        return not self.message and all(
            one.digits >= self.digits for one in (*self.values, *self.derivatives)
        )

    def summary(self) -> str:
        """A table of the numbers: value, finer value, difference, digits."""
        worst = min((one.digits for one in (*self.values, *self.derivatives)), default=0.0)
        outcome = "agrees with" if self.agree else "does not agree with"
        head = f"{self.name}: {outcome} an analysis with {self.refinement}; {worst:.1f} digits"
        lines = [f"{head} ({self.digits:g} wanted)", *([self.message] if self.message else [])]
        tables = zip(("value", "derivative"), (self.values, self.derivatives), strict=True)
        return printable("\n".join([*lines, *(text for kind, rows in tables for text in _table(kind, rows))]))


def _table(kind: str, rows: tuple[ComparedValue, ...]) -> list[str]:
    if not rows:
        return []
    names = [labelled(one.name, one.unit) for one in rows]
    width = max(map(len, names))
    lines = [f"  {'':<{width}}{kind:>18}{'finer':>18}{'difference':>12}{'digits':>8}"]
    for name, one in zip(names, rows, strict=True):
        numbers = f"{one.value:>18.10g}{one.finer:>18.10g}{one.difference:>12.1e}{one.digits:>8.1f}"
        lines.append(f"  {name:<{width}}{numbers}")
    return lines
