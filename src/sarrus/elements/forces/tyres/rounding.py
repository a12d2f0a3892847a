"""Corners of tyre laws, rounded: at least twice continuously differentiable, and exact outside of a band.

Steps end where a law has a corner. Slips and inclinations that stay near zero must not have one there.
"""

from __future__ import annotations

from typing import Any

from ...._jit.formulas.functions import minimum, tanh
from ..laws import soft_ramp

EDGE = 1e-4  # [rad or -] inclination below which |γ|, and slip below which its sign, are rounded
LOCKED = 1e-2  # [-] the least 1 + κ d: a wheel that is locked slides with the slip 100
SMALLEST = 1e-6  # the number that keeps quotients of the books finite, in their units


def rounded_absolute(x: Any, width: Any) -> Any:
    """x tanh(x/width): zero, and level, at zero, and |x| to round-off from 20 widths on. It has no corner."""
    return x * tanh(x / width)


def fading(x: Any, width: Any) -> Any:
    """1 at x = 0, zero for |x| ≥ width, between them 1 - s³ (10 - 15 s + 6 s²) with s = (x/width)²."""
    s = minimum(x * x / (width * width), 1)
    return 1 - s * s * s * (10 - s * (15 - 6 * s))


def limited(x: Any, low: Any, high: Any) -> Any:
    """x from low to high; beyond them constant, after a transition over a tenth of the range."""
    width = (high - low) / 10
    return x - soft_ramp(x - high - width / 2, width) + soft_ramp(low - width / 2 - x, width)


def at_least(x: Any, low: Any) -> Any:
    """x where it is at least 3/2 low; falls towards low below, which it does not pass."""
    return low + soft_ramp(x - low, low)
