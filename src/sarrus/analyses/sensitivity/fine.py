"""Responses over a whole run on long steps of a high order: taken within the steps, too, by Lobatto's rule.

Four points of each step, its ends among them, integrate polynomials up to degree five exactly.
"""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from ...algebra import Array
from .responses import Integral, Maximum, Minimum, Peak, Response

INNER = 0.5 - 0.5 / np.sqrt(
    5
)  # [-] of a step: the first inner point, as far from the start as the other from the end
SHARES = np.array([1.0, 5.0, 5.0]) / 12  # [-] of a step: weights of its start and inner points


class _Fine(Response):
    def times(self, t: Array) -> Array:
        h = np.diff(t)
        return np.append(np.column_stack([t[:-1], t[:-1] + INNER * h, t[1:] - INNER * h]), t[-1])

    def rule(self, t: Array) -> Array:
        own = np.append(np.outer(np.diff(t[::3]), SHARES), 0.0)
        own[3::3] += np.diff(t[::3]) * SHARES[0]
        return np.asarray(own)


class FineIntegral(_Fine, Integral):
    """The integral by Lobatto's rule."""


class FinePeak(_Fine, Peak):
    """The rounded maximum, its mean by Lobatto's rule."""


class FineMaximum(_Fine, Maximum):
    """The maximum with three times as many samples."""


class FineMinimum(_Fine, Minimum):
    """The minimum with three times as many samples."""


FINE: dict[type[Response], type[_Fine]] = {
    Integral: FineIntegral,
    Peak: FinePeak,
    Maximum: FineMaximum,
    Minimum: FineMinimum,
}


def fine(response: Response) -> Response:
    """The same response, taken within the steps, too, if it is one over the whole run."""
    kind = FINE.get(type(response))
    if kind is None:
        return response
    return kind(**{f.name: getattr(response, f.name) for f in fields(response)} | {"name": response.title})
