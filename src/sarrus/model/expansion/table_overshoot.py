"""Tables whose spline swings far beyond their values between two of their points, as next to the corners of a ramp."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np

from ..laws.curve import Curve
from ..measure import measures_of
from ..model import Model
from ..quantity import is_list

SWING = 0.3  # of the range of a table's values, by which its spline is beyond two neighbouring ones
SLIGHT = 0.1  # of the largest value: the range of a table that is nearly constant
SAMPLES = 17  # of a segment


def overshooting_tables(model: Model) -> Iterator[str]:
    """Yield a message for each table of a law whose spline overshoots."""
    for parts in model.sections().values():
        for part in parts:
            for field, measure in measures_of(part).items():
                if measure.over != "1" or measure.outputs:
                    for curve in _tables(getattr(part, field, None)):
                        yield from _overshoot(f"{part.name}: the spline through the table of {field}", curve)


def _tables(value: Any) -> Iterator[Curve]:
    """The tables of a law, or of each component of a load."""
    if isinstance(value, Curve):
        if value.pairs:
            yield value
    elif is_list(value) and len(value) and all(is_list(row) and len(row) == 2 for row in value):
        yield Curve.table(value)
    elif is_list(value):
        for one in value:
            yield from _tables(one)


def _overshoot(what: str, curve: Curve) -> Iterator[str]:
    pairs, y = curve.pairs, [value for _, value in curve.pairs]
    size, worst, text = max(max(y) - min(y), SLIGHT * max(map(abs, y))), SWING, ""
    for (a, before), (b, after) in pairwise(pairs):
        for x in np.linspace(a, b, SAMPLES).tolist():
            beyond = max(curve(x) - max(before, after), min(before, after) - curve(x))
            if beyond > worst * size:
                worst, text = beyond / size, f"is {curve(x):.3g} at {x:.3g}, between {before:g} and {after:g}"
    if text:
        yield (
            f"{what} {text}. Add points next to its corners, or give a formula with step(x, x0, h0, x1, h1)."
        )
