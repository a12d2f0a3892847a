"""Size of the derivatives of a response beside those of its output within the run.

An error of the states changes a derivative by a part of what such derivatives are within the run. Those of a response
may be much smaller: of an angle at the end, where the motion reverses just then, or of a velocity that has decayed.
Their relative error is larger by so much, at most: random sums of states give the size of derivatives within the run,
but of all states, and some may depend on the parameters far more than others. The estimate is therefore multiplied by
the root of the ratio.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from .....algebra import Array
from ...chain.chain import STATES, Nodes
from ..state_errors import MOMENTS
from .growth import NONE

MOST = 100.0  # times smaller than those within the run


def small_derivatives(taken: Array, weights: Array, found: Array, of_sums: Array) -> Array:
    """Factors of the relative errors of responses whose derivatives are smaller than those within the run (k,).

    Parameters
    ----------
    taken : by responses from states, see `Taken`
    weights : changes of the parameters that are compared (p,)
    found, of_sums : derivatives of responses (k, p) and of random sums by the parameters
    """
    within = np.linalg.norm(of_sums * weights) / np.sqrt(len(of_sums) * MOMENTS)
    sizes = np.linalg.norm(found * weights, axis=1)
    ratio = np.divide(taken * within, sizes, out=np.ones_like(sizes), where=sizes > 0)
    return np.asarray(np.sqrt(np.clip(ratio, 1.0, MOST)))


def untouched(found: Array, of_sums: Array, relative_errors: Array) -> Array:
    """Whether derivatives are exactly zero and have no error (k,), as parameters move the run, but not the response.

    Parameters that do not act at all may do so in the exact motion, as a stop that is not met; and states that have no
    correct digit do not show what acts on what.
    """
    return np.asarray(~found.any(axis=1) & of_sums.any() & (relative_errors < NONE))


class Taken:
    """Responses' share of states that vary independently at the moments of the sums, part by part, the last one first.

    Parameters
    ----------
    span : start and end of the run [s]
    """

    def __init__(self, span: tuple[float, float]) -> None:
        self._span, self._moment = span, MOMENTS
        self._sums = dict.fromkeys(STATES, np.zeros(1))  # of gradients at the earliest moment so far
        self._squares = dict.fromkeys(STATES, np.zeros(1))  # of the sums at those after it

    def take(self, t: Array, given: Nodes) -> None:
        """A part of the run: times of its nodes, and gradients of responses by their states."""
        begin, end = self._span
        moment = np.clip(
            (MOMENTS * (t - begin) / (end - begin)).astype(int), 0, min(self._moment, MOMENTS - 1)
        )
        for name in STATES:
            by = getattr(given, name)
            own = np.zeros((self._moment - moment[0] + 1, *by.shape[1:]))
            own[-1] = self._sums[name] if self._moment < MOMENTS else 0.0
            np.add.at(own, moment - moment[0], by)
            self._squares[name] = self._squares[name] + (own[1:] ** 2).sum(axis=0)
            self._sums[name] = own[0]
        self._moment = int(moment[0])

    def values(self, ranges: Mapping[str, Array]) -> Array:
        """The share of each response (k,), by how much states vary."""
        squares = (
            (self._squares[name] + self._sums[name] ** 2) * ranges[name][:, None] ** 2 for name in STATES
        )
        return np.asarray(np.sqrt(sum(own.sum(axis=0) for own in squares)))
