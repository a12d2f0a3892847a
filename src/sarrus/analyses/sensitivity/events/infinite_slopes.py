"""Corners at which slopes of a force by the states become infinite, as of max(0, x)^1.5 and of its root.

The last step before a corner ends at it, within 1e-10 of its length, and its end counts as a stage. The first slope of
a root there, and the second one of a power 1.5, are 1e5 times as large as in the middle of the step. They multiply the
change of the state at the end of the step, which is that at a constant time, not that at the corner, which moves.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ....algebra import Array
from ....results import StepsTaken
from ....system import System
from ..sampling.sampling import apart, interpolation

NEAR = 1e-9  # of the step before its end, where slopes are compared; the end may be on the other side of the corner
MIDDLE = 0.5  # with those at this part
# Instead of 1e-9 for first slopes, also in runs whose states are moved a little to estimate errors
CLOSE = 1e-3
FAR = 1e-2  # the largest, where round-off of positions enlarges 1e-9
ROUND_OFF = 1e4 * np.finfo(float).eps
GROWS = 3.0  # factor from the middle of a step to its end, from which slopes become infinite
EXPONENT = 0.9  # of changes of slopes over the distance, below which second slopes become infinite


class EndOfLaw:
    """Whether slopes of forces become infinite at a corner.

    Parameters
    ----------
    system, steps, b : those before the corner, with the numbers of the last one
    q, v : state at the corner
    """

    def __init__(self, system: System, steps: StepsTaken, b: Array, q: Array, v: Array) -> None:
        self._system, self._steps, self._b, self._corner = system, steps, b, np.array([q, v])

    @cached_property
    def first(self) -> bool:
        """Whether first slopes do."""
        close, middle = self._slopes(CLOSE), self._slopes(MIDDLE)
        return bool(np.any(abs(close) > GROWS * np.maximum(abs(middle), _round_off(close, middle))))

    @cached_property
    def second(self) -> bool:
        """Whether second slopes do."""
        steps = self._steps
        moved = float(steps.h[-1]) * abs(steps.v[-2:]).max(initial=0.0)
        near = max(NEAR, ROUND_OFF * abs(steps.q[-1]).max() / moved) if moved > 0 else np.inf
        if near > FAR:
            return False
        end, close, middle = (self._slopes(s) for s in (0.0, near, MIDDLE))
        change, least = abs(close - end), _round_off(close, middle)
        return bool(np.any((change > least) & (change > abs(middle - end) * (near / MIDDLE) ** EXPONENT)))

    def _slopes(self, before: float) -> Array:
        """The slopes of all forces by q and v at a part of the last step before the corner."""
        steps, h = self._steps, self._steps.h[-1:]
        values = interpolation(np.array([1.0 - before, 1.0]), np.repeat(h, 2), apart(steps)).values[:, :2]
        nodes = np.array([[getattr(steps, kind)[e] for kind in ("q", "v", "a")] for e in (-2, -1)])
        there, end = np.einsum("skel,eln->skn", values, nodes)
        q, v = self._corner + there - end
        t = float(steps.t[-1] - before * h[0])
        return np.concatenate(
            [getattr(self._system, name)(q, v, t, b=self._b).data for name in ("Q_q", "Q_v")]
        )


def _round_off(close: Array, middle: Array) -> float:
    """That of the largest slopes."""
    return float(ROUND_OFF * max(abs(close).max(initial=0.0), abs(middle).max(initial=0.0)))
