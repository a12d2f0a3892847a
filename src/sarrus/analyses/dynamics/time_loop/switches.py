"""Switches of forces during a run: steps end there, see `step_loop.crossing`, and warnings name those that crowd."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...._jit.linking.link import link
from ....model.announcement import announce
from ....system import System
from ..events.switching_functions import Corner, SwitchingFunctions
from ..inputs.force_arguments import that_jump
from ..step_loop.crossing import BESIDE, FIRST, HIGH, LOW, Crossing, Switching, passed_twice, width
from ..stepping.nodes import Nodes
from ..stepping.stepper import RunFailure, RunPart, Stepper

# Corners of a force that jumps: so many before they may follow each other ever faster
FREE = 200
LAST, FASTER = 20, 0.5  # intervals between them, and how much shorter than all: then they do
# Messages with a time and parts of the model
MEET = (
    "{1}: switches crowd at t = {0:.6g} s, where its ends meet and its force reverses. Derivatives past it are wrong. "
    "Let the ends pass beside each other."
)
TOGETHER = (
    "{1} and {2}: switches crowd at t = {0:.6g} s, where both forces switch and one jumps. Derivatives by what lets "
    "one of them switch earlier are those of one side. Move one of them."
)
SLIDES = (
    "{1}: switches crowd at t = {0:.6g} s, since its force jumps and pushes the motion back to the jump from both "
    "sides. Let it change within a width, such as tanh(x/width)."
)
TWICE = (
    "{1}: its law switches twice within one step near t = {0:.6g} s, so that steps may pass over it. Take shorter "
    "ones, or the default method, whose steps end there."
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
    free : whether its steps can end at them; else a warning names the first law that switches twice within one. None:
        switches are not looked for
    stored : whether all steps are stored for derivatives
    """

    VARIABLES = ("_ends",)

    def __init__(self, system: System, stepper: Stepper, free: bool | None, stored: bool) -> None:
        self._system, self._stepper, self._stored = system, stepper, stored
        self._functions = SwitchingFunctions(system, stored and free is not None)
        self._jumping, self._warned = that_jump(system), set[str]()
        self._ends = np.zeros(0)  # times of corners at which steps ended
        self._compiled: Switching | None = None
        self._passes = not free
        if free is not None and self._functions.all:
            corners = stored or bool(self._jumping)
            self._compiled = self._functions.compiled(
                lambda one: one.table is None and (corners or stepper.has_history), corners
            )
            if free:
                stepper.end_at(self._compiled)

    def advance(self, stop: float, most: int) -> tuple[Nodes, Cut | None]:
        """Some steps, up to the first corner behind which a run begins anew.

        Raises
        ------
        RunFailure
            If the motion slides along a jump, or if the method cannot go on.
        """
        stepper = self._stepper
        nodes = stepper.advance(stop, most)
        if found := self._functions.vanishing(nodes, stepper.b, stepper.apart):
            self._warn(MEET, *found)
        if self._passes and self._compiled:
            self._look_behind(nodes, self._compiled)
        if (crossing := stepper.switched) is None:
            return nodes, None
        switch = self._functions.all[int(crossing.number)]
        self._count(float(nodes.t[-1]), switch.corner.owner)
        gap = float(crossing.left) + width(float(nodes.t[-1]), float(nodes.t[-1] - nodes.t[-2]))
        if self._stored and self._jumping:
            self._look_beside(nodes, switch.corner.owner, gap)
        last = nodes.part(slice(-1, None))
        behind = last._replace(t=last.t + gap, q=last.q + gap * last.v, v=last.v + gap * last.a)
        return nodes, Cut(switch.corner, behind, FIRST * float(crossing.stays))

    def _look_behind(self, nodes: Nodes, switching: Switching) -> None:
        """Warn of the first law that switches twice within one of the steps."""
        found, b = Crossing.zeros(), self._stepper.b.copy()
        t = link(passed_twice)(switching, b, self._system.memory_places, nodes, self._stepper.apart, found)
        if t < np.inf:
            self._warn(TWICE, t, self._functions.all[int(found.number)].corner.owner)
            self._passes = False

    def _warn(self, message: str, *values: Any) -> None:
        """Announce something once."""
        announce([] if message in self._warned else [message.format(*values)])
        self._warned.add(message)

    def _count(self, t: float, owner: str) -> None:
        """Count a corner at which a step has ended.

        Raises
        ------
        RunFailure
            If corners of a force that jumps follow each other ever faster.
        """
        self._ends = np.append(self._ends, t)
        intervals = np.diff(self._ends)
        faster = len(intervals) >= FREE and bool(np.mean(intervals[-LAST:]) < FASTER * np.mean(intervals))
        if faster and owner in self._jumping:
            raise RunFailure("switches crowd", SLIDES.format(t, owner))

    def _look_beside(self, nodes: Nodes, owner: str, gap: float) -> None:
        """Warn if forces of several parts switch at the same time and one jumps: derivatives have that of one only."""
        own, h = self._compiled, float(nodes.t[-1] - nodes.t[-2])
        assert own
        with np.errstate(all="ignore"):
            left = BESIDE * h * own.value[HIGH] / (own.value[HIGH] - own.value[LOW])
        for n in np.flatnonzero((abs(left) < 4 * gap) & (own.period == 0)).tolist():
            other = self._functions.all[n].corner.owner
            if other != owner and not {owner, other}.isdisjoint(self._jumping):
                self._warn(TOGETHER, float(nodes.t[-1]), owner, other)
