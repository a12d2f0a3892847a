"""Responses that have no value or no derivative."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from ....algebra import Array
from ....model.tape import Traced
from ....outputs import Outputs


class UndefinedResponse(ValueError):
    """A response of a run that is not a number, or whose derivative is infinite."""


def refuse_undefined(titles: Iterable[str], values: Array) -> None:
    """Raise for the first response that is not a number.

    Raises
    ------
    UndefinedResponse
        With its name.
    """
    for title, value in zip(titles, values, strict=True):
        if not np.isfinite(value):
            raise UndefinedResponse(
                f"{title} is {value}: its output leaves where it is defined, as the root of a negative number does"
            )


def gradient_of(
    title: str, outputs: Outputs, found: Traced, weights: Array, moves: bool = False
) -> list[Any]:
    """The gradient of a response by the entries of its tape.

    Parameters
    ----------
    title, outputs, found : of the response: its name, its tape with the inputs, and its output there
    weights : of the output at its times; infinite slopes do no harm where they are zero
    moves : whether it is differentiated by its times, too

    Raises
    ------
    UndefinedResponse
        If a derivative that is needed is not finite.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        bars = outputs.tape.gradient({found.at: weights})
    for variable in (*outputs.inputs.values(), *outputs.named.values(), *([outputs.t] if moves else [])):
        bar = bars[variable.at]
        if np.shape(bar) == np.shape(weights):
            bars[variable.at] = bar = np.where(weights == 0.0, 0.0, bar)
        if not np.isfinite(bar).all():
            raise UndefinedResponse(
                f"{title}: its derivative is infinite, as that of a root at 0. Use a smooth function, such as "
                "sqrt(x**2 + e**2), or leave the response out."
            )
    return bars
