"""Step control of integration methods: tolerances of the local error, and lengths of steps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from ....defaults import ATOL, RTOL
from ....model.checks.arguments import CHECKS, TEXTS, as_numbers
from .tolerance import Absolute, Given

Method = TypeVar("Method", bound="StepControl")
CONTROL = ("rtol", "atol", "max_step", "first_step")  # options of every method


@dataclass(frozen=True, kw_only=True)
class StepControl:
    """Base class of integration methods: the control of their steps.

    Parameters
    ----------
    rtol : relative tolerance of the local error, 1e-9, of HHT, generalized-α and descriptions 1e-6. Without `atol` it
        is relative to the size of the motion of each body so far, independent of units, and decreases with the fourth
        root of the number of periods, and in very long runs by more (not for methods of order 2), because errors
        accumulate
    atol : absolute tolerances, which replace those that follow the motion; `rtol` is then relative to the
        coordinates. Both are a number, an array for all coordinates, or by kind, e.g.
        ``{"position": 1e-6, "orientation": 1e-8}``, and "velocity" and "rotation" (rates of Euler parameters), which
        are controlled by HHT and generalized-α only if they are given [m, 1, m/s, 1/s]; `atol` by kind takes texts
        with units, too: ``{"position": "1 um", "orientation": "0.01 deg", "velocity": "1 mm/s"}``
    max_step, first_step : the longest step, and the first one, by default automatic [s]

    Raises
    ------
    ValueError
        For a length that is not positive; for tolerances when a run begins, as they may be arrays (nq,).
    """

    rtol: Given = RTOL
    atol: Absolute = ATOL
    max_step: float = np.inf
    first_step: float | None = None

    def __post_init__(self) -> None:
        for name in ("rtol", "atol"):
            object.__setattr__(self, name, _as_value(name, getattr(self, name)))
        for name in ("max_step", "first_step"):
            value = TEXTS[name](name, getattr(self, name))
            object.__setattr__(self, name, value)
            if value is not None or name == "max_step":
                CHECKS[name](name, value)


class ByKind(dict[str, Any]):
    """Tolerances by kind of coordinate; with a hash, as methods are values."""

    def __hash__(self) -> int:  # type: ignore[override]
        return hash(frozenset(self.items()))


def _as_value(name: str, tolerance: Any) -> Any:
    """A tolerance without arrays, so that methods can be compared and saved."""
    if not isinstance(tolerance, np.ndarray | list):
        return ByKind(tolerance) if isinstance(tolerance, Mapping) else tolerance
    values = as_numbers(
        tolerance, lambda: f"{name} must be a number, or one for each coordinate. Give such a list."
    )
    return tuple(values.tolist()) if values.ndim else values.item()


def with_control(method: Method, **control: Any) -> Method:
    """A method with other options of its step control; those that are None remain."""
    return replace(method, **{name: value for name, value in control.items() if value is not None})
