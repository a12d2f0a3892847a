"""Angle drivers whose motion seems to be written in degrees, although it is in radians."""

from __future__ import annotations

from collections.abc import Iterator
from math import radians, tau

import numpy as np

from ... import elements
from ..errors import ModelError
from ..laws.curve import Curve, Formula
from ..quantity import Array
from .blueprint import Blueprint

# [rad/s] constant rates that are a number of quarter revolutions in degrees
WHOLE = (90.0, 180.0, 360.0, 720.0)
ROUND = 15.0  # [rad] ranges of bounded motions that are multiples of it suggest degrees, from `LEAST` on
LEAST, MOST = 45.0, 720.0  # [rad]
DURATION, SAMPLES = 10.0, 2001  # [s], times at which motions are evaluated
EXACT, NEARLY = 1e-9, 1e-4  # [-] relative errors of values, and of ranges that samples miss


def motions_in_degrees(plan: Blueprint) -> Iterator[str]:
    """Yield a message for each angle driver that seems to rotate by 360 degrees per second, or to swing by 90."""
    for one in plan.placed:
        if issubclass(one.element, elements.AngleDriver):
            *_, scale, motion = one.values
            if not np.isfinite(scale):
                continue  # an input that is not set yet
            times = _times(motion)
            angle, each = _round_in_degrees(times, scale * _values(motion, times))
            if angle:
                yield (
                    f"{one.owner}: its motion of {angle:g} rad{each} is {angle / tau:.3g} revolutions. Give radians: "
                    f"{angle:g} degrees are {radians(angle):.6g} rad."
                )


def _times(motion: Curve | Formula) -> Array:
    if isinstance(motion, Curve):
        return np.array([x for x, _ in motion.pairs] or motion.knots)
    return np.linspace(0.0, DURATION, SAMPLES)


def _values(motion: Curve | Formula, times: Array) -> Array:
    """The motion at some times; zeros if it is not defined at all of them."""
    if isinstance(motion, Curve):
        return np.array([motion(t) for t in times])
    try:
        with np.errstate(all="ignore"):
            found = np.broadcast_to(np.asarray(motion.function(times), dtype=float), times.shape)
    except (ModelError, ArithmeticError, ValueError, TypeError, AttributeError):
        return np.zeros_like(times)
    return found if np.all(np.isfinite(found)) else np.zeros_like(times)


def _round_in_degrees(times: Array, angles: Array) -> tuple[float, str]:
    """The angle per second of a uniform rotation, or the range of a bounded motion, if round in degrees; else 0."""
    changes, extent = np.diff(angles), float(np.ptp(angles))
    rate = abs(angles[-1] - angles[0]) / (times[-1] - times[0])
    if np.allclose(changes, changes[0], rtol=EXACT, atol=EXACT * extent):
        return next((value for value in WHOLE if abs(rate - value) <= EXACT * value), 0.0), " per second"
    returns = np.any(changes > 0) and np.any(changes < 0)
    rests = np.ptp(angles[-2:]) <= EXACT * extent
    for swing in (extent / 2, extent) if returns else (extent,):
        whole = ROUND * round(swing / ROUND)
        if (returns or rests) and LEAST <= whole <= MOST and abs(swing - whole) <= NEARLY * whole:
            return whole, ""
    return 0.0, ""
