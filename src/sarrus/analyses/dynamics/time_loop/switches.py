"""Switches of a run: whatever ends a segment of steps is a `Hit`, corners of forces among them, and may crowd."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ....results import EventStep
from ....system import System
from ..dense_output.sampler import Sampler
from ..events.events import Crowd
from ..events.switching_functions import SwitchingFunctions
from ..inputs.force_arguments import that_jump
from ..step_loop.crossing import FIRST, width
from ..stepping.nodes import Nodes
from ..stepping.stepper import RunPart, Stepper
from .recording import Plan

SLIDES = (
    "since its force jumps and pushes the motion back to the jump from both sides",
    "Let it change within a width, such as tanh(x/width).",
)


class Hit(NamedTuple):
    """What ends a segment of steps, and the state from which the motion goes on.

    Attributes
    ----------
    t, q, v : that state, with its velocities
    record : for derivatives; None where they go on through it
    b : the numbers of the elements there, if they are not those after the last step
    longest : the step behind it at most, so that it does not pass over what follows [s]
    is_event : whether functions of events that are zero there have just crossed
    message : why the run ends there, if it does
    behind : the state at a corner of a force as a node behind the last one; accelerations that jump there change it by
        a part of 1e-10 of the step
    """

    t: float
    q: Array
    v: Array
    record: EventStep | None = None
    b: Array | None = None
    longest: float = np.inf
    is_event: bool = False
    message: str = ""
    behind: Nodes | None = None


class Switches(RunPart):
    """The switches of one run.

    Parameters
    ----------
    system : System
    stepper : the method at work
    plan : what is wanted
    sampler : for states at corners
    """

    VARIABLES = ("_crowd",)

    def __init__(self, system: System, stepper: Stepper, plan: Plan, sampler: Sampler) -> None:
        self._stepper, self._stored, self._sampler = stepper, plan.stored, sampler
        self._crowd, self._jumping = Crowd(), that_jump(system)
        functions = SwitchingFunctions(system) if plan.free else None
        self._all = functions.all if functions else []
        if functions and self._all:
            corners = plan.stored or bool(self._jumping)
            stepper.end_at(
                functions.compiled(
                    lambda one: one.table is None and (corners or stepper.has_history), corners
                )
            )

    def advance(self, stop: float, most: int) -> tuple[Nodes, Hit | None]:
        """Some steps, up to the first corner of a force behind which a run begins anew.

        Raises
        ------
        RunFailure
            If the motion slides along a jump, or if the method cannot go on.
        """
        nodes = self._stepper.advance(stop, most)
        if (crossing := self._stepper.switched) is None:
            return nodes, None
        last = nodes.part(slice(-1, None))
        corner, t = self._all[int(crossing.number)].corner, float(last.t[0])
        if corner.owner in self._jumping:
            self._crowd.add(t)
            self._crowd.refuse(corner.owner, None, *SLIDES)
        record, name = None, f"corner of {corner.owner}"
        if self._stored:
            before = self._sampler.state_at(t, last.q[0], last.v[0], last.memory[0])
            known = {"q": before.q[0].copy(), "v": before.v[0].copy(), "after": before.v[0].copy()}
            record = EventStep(name=name, t=t, function=corner, named=False, **known)
        gap, longest = float(crossing.left) + width(t, t - float(nodes.t[-2])), FIRST * float(crossing.stays)
        behind = last._replace(t=last.t + gap, q=last.q + gap * last.v, v=last.v + gap * last.a)
        return nodes, Hit(t, behind.q[0], behind.v[0], record, longest=longest, behind=behind)
