"""The range of one output of a mechanism: intervals between critical values."""

from __future__ import annotations

from dataclasses import dataclass, field

from ...algebra import Array
from ..result import Result
from .workspace import Status


@dataclass(frozen=True)
class CriticalValue:
    """A value at which the output is stationary for all admissible motions, or that could be crossed.

    Attributes
    ----------
    value : of the output
    side : +1: motion keeps above it. -1: below. 0: it can be crossed.
    active : limits that are reached, e.g. "q1 lowest"
    singular : whether the mechanism itself loses a direction there
    q : (nq,)
    sure : false where further limits are reached by coincidence, so that `side` may be wrong
    """

    value: float
    side: int
    active: tuple[str, ...]
    singular: bool
    q: Array = field(repr=False)
    sure: bool = True

    @property
    def cause(self) -> str:
        """The cause of the limit as text."""
        return ", ".join((*(("singularity",) if self.singular else ()), *self.active))


@dataclass(frozen=True)
class WorkspaceRange(Result):
    """Result of `workspace_range`: the values that one output can reach.

    Attributes
    ----------
    name : of the system; `output` of the function, `unit` "m" or "rad"
    intervals : (lowest, highest) of each part, increasing
    critical : all critical values, increasing
    search : data for `sarrus.end_gradient`
    """

    name: str
    output: str
    unit: str
    intervals: tuple[tuple[float, float], ...]
    critical: tuple[CriticalValue, ...] = field(repr=False)
    status: Status
    message: str
    search: object = field(default=None, repr=False, compare=False)

    @property
    def success(self) -> bool:
        """Whether the result is complete."""
        return self.status == "mapped"

    def headline(self) -> str:
        """The intervals, without causes and tests."""
        return self.summary().partition(". ")[0]

    def summary(self) -> str:
        """The result in words."""
        message = (
            " and ".join(f"{low:.9g} to {high:.9g} {self.unit}" for low, high in self.intervals) or "nowhere"
        )
        if not self.success:
            return f"{self.name}: the values that {self.output} can take are not known. {self.message}."
        ends = {end for pair in self.intervals for end in pair}
        causes = [f"{one.value:.9g} by {one.cause}" for one in self.critical if one.value in ends]
        different = "; ".join(dict.fromkeys(causes))  # many positions may have the same end
        return f"{self.name}: {self.output} can be from {message}. Ends: {different}. {self.message}."
