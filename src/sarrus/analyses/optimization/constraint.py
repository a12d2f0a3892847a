"""Constraints of an optimization: responses between limits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...algebra import Array
from ...model.checks.arguments import Number
from ...model.checks.calls import CallCheck
from ...model.quantity import is_list
from ..sensitivity.combined import Part


@dataclass(frozen=True, eq=False)
class Within(metaclass=CallCheck):
    """Constraint of an optimization: limits of a response; equal limits make an equation.

    Parameters
    ----------
    response : a response, or an output, which means its final value
    lower, upper : None for no limit
    """

    response: Part
    lower: float | None = None
    upper: float | None = None

    def __post_init__(self) -> None:
        if self.lower is None and self.upper is None:
            raise ValueError("constraint: it needs a lower or an upper limit. Give one.")
        for name in ("lower", "upper"):
            if (limit := getattr(self, name)) is not None:
                Number(infinite=True)(f"{name} limit of a constraint", limit)
        if self.ends[0] > self.ends[1]:
            raise ValueError(
                f"the limits of a constraint must rise, but are {self.lower:g} and {self.upper:g}. Exchange them."
            )

    @property
    def ends(self) -> tuple[float, float]:
        """Both limits, infinite if not given."""
        return (
            -np.inf if self.lower is None else float(self.lower),
            np.inf if self.upper is None else float(self.upper),
        )

    @property
    def size(self) -> float:
        """The larger of its limits, or 1."""
        return max((abs(end) for end in self.ends if np.isfinite(end)), default=0.0) or 1.0


def constraints_of(given: Within | Sequence[Within]) -> tuple[Within, ...]:
    """The constraints of an option.

    Raises
    ------
    TypeError
        For something else among them.
    """
    listed: Any = given
    constraints: Sequence[object] = listed if is_list(listed) else [listed]
    for constraint in constraints:
        if not isinstance(constraint, Within):
            raise TypeError(
                f"constraints: {constraint!r} is no constraint. Give Within(response, lower=..., upper=...)."
            )
    return tuple(one for one in constraints if isinstance(one, Within))


def excess(values: Array, constraints: Sequence[Within]) -> Array:
    """How far values are beyond their limits, relative to the limits (c,); 0 between them."""
    low, high = np.array([constraint.ends for constraint in constraints]).reshape(-1, 2).T
    sizes = np.array([constraint.size for constraint in constraints])
    return np.asarray((values - np.clip(values, low, high)) / sizes)


def gap(values: Array, constraints: Sequence[Within]) -> float:
    """Return the largest violation of constraints, relative to their limits; 0 if they are satisfied."""
    return float(abs(excess(values, constraints)).max(initial=0.0))
