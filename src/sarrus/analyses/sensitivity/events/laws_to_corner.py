"""Corners at which slopes of a force by the states become infinite, as of max(0, x)^1.5 and of its root.

The last step before a corner ends at it, within 1e-10 of its length, and its end counts as a stage. The first slope of
a root there, and the second one of a power 1.5, are 1e5 times as large as in the middle of the step. They multiply the
change of the state at the end of the step, which is that at a constant time, not that at the corner, which moves.

The last steps before a corner at which second slopes of a force become infinite, as a section of their own.

It begins at the time at which its end is at the corner, for all parameters: the function ψ of the corner, as one of the
state before these steps, is that of an event. The state at their end does not leave the corner then, and slopes there
multiply changes that are zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ....algebra import Array
from ....results import StepsTaken
from ....system import System
from ....system.curves.time_derivatives import timed
from ..chain.chain import Nodes, SegmentChain
from ..chain.curved_steps import CurvedSteps
from ..lagrangians.curves import CurveLagrangian
from ..sampling.sampling import apart, interpolation
from .functions import Slopes, TapeValues

# Before such a corner, which move with it: errors of second derivatives decrease from 1 % of four steps to 1e-4
STEPS = 16
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


@dataclass(frozen=True, eq=False)
class StepsToCorner:
    """ψ of the state before the steps that end at a corner.

    Attributes
    ----------
    steps : those up to the corner
    corner : ψ, recorded at the corner
    in_curves : whether parameters of curves change
    """

    system: System
    steps: StepsTaken
    corner: TapeValues
    in_curves: bool

    @cached_property
    def slopes(self) -> Slopes:
        """The derivatives of ψ by the state before the steps."""
        own, size = self.corner.slopes, len(self.system.b)
        q, v, b = self._chain.by_start(self._at_end(own.q, own.v))
        b, shift = b[:size], b[size:].sum(axis=0)
        return Slopes(q.T, v.T, own.c, own.t + shift[:, None], own.b + b.T)

    def turned(self, weights: Array, _: Array, dots: Slopes) -> Slopes:
        """The change of the gradient of ψ, with a weight, along changes of the state before the steps."""
        steps, own, nodes = self._curved, self.corner.slopes, Nodes.zeros(self.steps, 1)
        moved = dots.b if self._chain.by_curves.width == len(dots.b) else np.append(dots.b, dots.t)
        stages = steps.along(moved[:, None], dots.q[:, None], dots.v[:, None], nodes)
        solved = steps.back(self._at_end(weights * own.q, weights * own.v), None).solved
        at_end = dots._replace(q=nodes.q[-1, :, 0], v=nodes.v[-1, :, 0])
        psi = self.corner.turned(weights, np.zeros(1), at_end)
        back = steps.back(self._at_end(psi.q[None], psi.v[None]), steps.turned(moved, nodes, stages, solved))
        b, shift = np.split(back.b[:, 0], [len(psi.b)])
        return Slopes(back.q[:, 0], back.v[:, 0], psi.c, psi.t + shift.sum(), psi.b + b)

    @cached_property
    def _chain(self) -> SegmentChain:
        return SegmentChain(self.system, self.steps, timed(self.system))

    @cached_property
    def _curved(self) -> CurvedSteps:
        return CurvedSteps(self._chain, CurveLagrangian(self.system, self.in_curves, timed(self.system)))

    def _at_end(self, q: Array, v: Array) -> Nodes:
        """Gradients (1, nq) by the state at the end of the steps."""
        nodes = Nodes.zeros(self.steps, 1)
        nodes.q[-1], nodes.v[-1] = q.T, v.T
        return nodes
