"""Corners rounded by a polynomial: twice continuously differentiable, and exact outside a band of the given width."""

from __future__ import annotations

from typing import Any

from .._jit.functions import exp, log, minimum, ramp

TINY = 1e-100  # keeps the logarithm of zero and its slopes finite; below round-off of all that is not zero


def soft_step(x: Any, width: Any) -> Any:
    """0 for x ≤ -width/2, 1 for x ≥ width/2, between them u² (3 - 2u): the slope of `soft_ramp`."""
    u = _along(x, width)
    return u * u * (3 - 2 * u)


def soft_ramp(x: Any, width: Any) -> Any:
    """0 for x ≤ -width/2, x for x ≥ width/2, between them width (u³ - u⁴/2) with u = x/width + 1/2."""
    u = _along(x, width)
    return width * (u * u * u * (2 - u) / 2) + ramp(x - width / 2)


def power(x: Any, exponent: Any) -> Any:
    """x to an exponent of at least 1, for x ≥ 0; zero at zero, with all its derivatives along a `soft_ramp`."""
    return x * exp((exponent - 1) * log(x + TINY))


def _along(x: Any, width: Any) -> Any:
    """The way through the band, from 0 to 1."""
    return minimum(ramp(x / width + 1 / 2), 1)
