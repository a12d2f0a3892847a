"""Panels of a run: steps, or the parts of steps between kinks of an output, with the samples of each and their rule."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ....algebra import Array

# [-] of a step: the first inner point of Lobatto's rule, as far from the start as the other from the end
INNER = 0.5 - 0.5 / np.sqrt(5)


class Rule(NamedTuple):
    """Quadrature rule of a panel: relative positions of the samples, and their weights. [-] of its length"""

    parts: tuple[float, ...]
    shares: tuple[float, ...]


TRAPEZOIDAL = Rule((0.0, 1.0), (0.5, 0.5))
LOBATTO = Rule((0.0, INNER, 1 - INNER, 1.0), (1 / 12, 5 / 12, 5 / 12, 1 / 12))


class Panels(NamedTuple):
    """Samples of each panel. For smooth outputs, neighbouring panels share a sample.

    Attributes
    ----------
    first : (panels,) the first sample of each
    shares : weights of its samples
    joints : (kinks,) the last sample before each kink; the sample just behind it has the same time
    """

    first: Array
    shares: Sequence[float]
    joints: Array

    @property
    def last(self) -> Array:
        """The last sample of each."""
        return np.asarray(self.first + len(self.shares) - 1)

    def weights(self, t: Array) -> Array:
        """The weights of the samples in an integral over time (nt,)."""
        found, h = np.zeros(len(t)), t[self.last] - t[self.first]
        for n, share in enumerate(self.shares):
            np.add.at(found, self.first + n, share * h)
        return found

    def by_times(self, g: Array) -> Array:
        """The derivatives by the times of the integral of an output (nt,)."""
        means = sum(share * g[self.first + n] for n, share in enumerate(self.shares))
        found = np.zeros(len(g))
        np.add.at(found, self.last, means)
        np.add.at(found, self.first, -means)
        return found
