"""Integrals and extremes of responses within long steps of high order, by Lobatto's rule.

Four points of each step, its ends among them, integrate polynomials up to degree five exactly.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from ....algebra import Array
from .panels import INNER
from .responses import Integral, Maximum, Minimum, Peak, Response

PARTS = (0.0, INNER, 1 - INNER)  # [-] of a step: where it is sampled
SHARES = np.array([1.0, 5.0, 5.0]) / 12  # [-] of a step: weights of its start and inner points


class Fine(Response):
    """A response whose times are those at `PARTS` of all steps, and the end."""

    def times(self, t: Array) -> Array:
        h = np.diff(t)
        return np.append(np.column_stack([t[:-1], t[:-1] + INNER * h, t[1:] - INNER * h]), t[-1])

    def rule_by_times(self, g: Array) -> Array:
        means = g[:-1].reshape(-1, 3) @ SHARES + g[3::3] * SHARES[0]
        found = np.zeros_like(g)
        found[3::3] += means
        found[:-1:3] -= means
        return found

    def rule(self, t: Array) -> Array:
        own = np.append(np.outer(np.diff(t[::3]), SHARES), 0.0)
        own[3::3] += np.diff(t[::3]) * SHARES[0]
        return np.asarray(own)


class FineIntegral(Fine, Integral):
    """The integral by Lobatto's rule."""


class FinePeak(Fine, Peak):
    """The rounded maximum, its mean by Lobatto's rule."""


class FineMaximum(Fine, Maximum):
    """The maximum with three times as many samples."""


class FineMinimum(Fine, Minimum):
    """The minimum with three times as many samples."""


FINE: dict[type[Response], type[Fine]] = {
    Integral: FineIntegral,
    Peak: FinePeak,
    Maximum: FineMaximum,
    Minimum: FineMinimum,
}


def fine(response: Response) -> Response:
    """The same response, taken within the steps, too, if it is one over the whole run."""
    return _of_kind(FINE, response)


def at_nodes(response: Response) -> Response:
    """The same response, taken at the ends of steps only."""
    return _of_kind({own: kind for kind, own in FINE.items()}, response)


def _of_kind(kinds: Mapping[Any, Any], response: Response) -> Response:
    kind = kinds.get(type(response))
    if kind is None:
        return response
    given = {f.name: getattr(response, f.name) for f in fields(response)} | {"name": response.title}
    found: Response = kind(**given)
    return found
