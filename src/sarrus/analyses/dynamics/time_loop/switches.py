"""Switches of forces during a run: steps end there, see `step_loop.crossing`; those of a jump may crowd."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....system import System
from ..events.switching_functions import Corner, SwitchingFunctions
from ..inputs.force_arguments import that_jump
from ..step_loop.crossing import FIRST, width
from ..stepping.nodes import Nodes
from ..stepping.stepper import RunFailure, RunPart, Stepper

# Corners of a force that jumps: so many before they may follow each other ever faster
FREE = 200
LAST, FASTER = 20, 0.5  # intervals between them, and how much shorter than all: then they do
SLIDES = (
    "{1}: switches crowd at t = {0:.6g} s, since its force jumps and pushes the motion back to the jump from both "
    "sides. Let it change within a width, such as tanh(x/width)."
)


class Cut(NamedTuple):
    """Where steps have ended at a corner.

    Attributes
    ----------
    behind : the state behind the corner; accelerations that jump there change it by a part of 1e-10 of their step
    longest : the next step at most, so that it does not pass over what follows [s]
    """

    corner: Corner
    behind: Nodes
    longest: float


class Switches(RunPart):
    """The switches of one run.

    Parameters
    ----------
    system : System
    stepper : the method at work
    free : whether its steps can end at them
    stored : whether all steps are stored for derivatives
    """

    VARIABLES = "_corners", "_first", "_recent"

    def __init__(self, system: System, stepper: Stepper, free: bool, stored: bool) -> None:
        self._stepper, self._jumping = stepper, that_jump(system)
        self._corners, self._first, self._recent = 0, 0.0, np.zeros(0)  # where steps ended: count, times
        functions = SwitchingFunctions(system) if free else None
        self._all = functions.all if functions else []
        if functions and self._all:
            corners = stored or bool(self._jumping)
            stepper.end_at(
                functions.compiled(
                    lambda one: one.table is None and (corners or stepper.has_history), corners
                )
            )

    def advance(self, stop: float, most: int) -> tuple[Nodes, Cut | None]:
        """Some steps, up to the first corner behind which a run begins anew.

        Raises
        ------
        RunFailure
            If the motion slides along a jump, or if the method cannot go on.
        """
        stepper = self._stepper
        nodes = stepper.advance(stop, most)
        if (crossing := stepper.switched) is None:
            return nodes, None
        corner = self._all[int(crossing.number)].corner
        self._refuse_sliding(float(nodes.t[-1]), corner.owner)
        gap = float(crossing.left) + width(float(nodes.t[-1]), float(nodes.t[-1] - nodes.t[-2]))
        last = nodes.part(slice(-1, None))
        behind = last._replace(t=last.t + gap, q=last.q + gap * last.v, v=last.v + gap * last.a)
        return nodes, Cut(corner, behind, FIRST * float(crossing.stays))

    def _refuse_sliding(self, t: float, owner: str) -> None:
        """Count a corner at which a step has ended.

        Raises
        ------
        RunFailure
            If corners of a force that jumps follow each other ever faster.
        """
        self._first = self._first if self._corners else t
        self._corners, self._recent = self._corners + 1, np.append(self._recent, t)[-LAST - 1 :]
        if self._corners > FREE and owner in self._jumping:
            recent, mean = (t - self._recent[0]) / LAST, (t - self._first) / (self._corners - 1)
            if recent < FASTER * mean:
                raise RunFailure("switches crowd", SLIDES.format(t, owner))
