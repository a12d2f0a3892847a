"""The last steps before a corner at which second slopes of a force become infinite, as a section of their own.

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
from ..chain.chain import Chain, Nodes
from ..chain.curved_steps import CurvedSteps
from ..lagrangians.curves import CurveLagrangian
from .functions import Recorded, Slopes


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
    corner: Recorded
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
    def _chain(self) -> Chain:
        return Chain(self.system, self.steps, timed(self.system))

    @cached_property
    def _curved(self) -> CurvedSteps:
        return CurvedSteps(self._chain, CurveLagrangian(self.system, self.in_curves, timed(self.system)))

    def _at_end(self, q: Array, v: Array) -> Nodes:
        """Gradients (1, nq) by the state at the end of the steps."""
        nodes = Nodes.zeros(self.steps, 1)
        nodes.q[-1], nodes.v[-1] = q.T, v.T
        return nodes
