"""Events of accelerations and reactions, which solve the equations of motion at the state of the event."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from ...algebra import Array
from ...model.expression import parse
from ...outputs import Level, find_output
from ...outputs.recording import Angles, States
from ...results import StepsTaken, Turn
from ...system import System
from .chain import FIELDS, Nodes
from .consistent import READ, ConsistentSampling
from .event_functions import Copies, Recorded, Slopes, of_formula, unknown
from .sampling import Sampling

NO_NODES = Nodes(*(np.zeros((0, 0, 0)) for _ in FIELDS))


class EventState(Sampling):
    """The state at an event, and the gradients by it that are spread to it.

    Attributes
    ----------
    by_q, by_v, by_t : gradients (nq,), (nq,), (1,)
    """

    moves = True

    def __init__(self, turn: Turn) -> None:
        self._turn = turn
        self.by_q, self.by_v, self.by_t = np.zeros(len(turn.q)), np.zeros(len(turn.q)), np.zeros(1)

    @property
    def t(self) -> Array:
        """The time of the event (1,). [s]"""
        return np.array([self._turn.t])

    @property
    def between_nodes(self) -> Array:
        """None: the coordinates of the event satisfy the constraints."""
        return np.zeros(1, dtype=bool)

    @property
    def states(self) -> States:
        """The state there."""
        turn = self._turn
        return States(self.t, turn.q[None], turn.v[None], 0 * turn.q[None], lambda: np.zeros((1, 0)))

    def spread(self, kind: str, n: int, bar: Array, nodes: Nodes, column: int) -> None:
        """Add the gradient by a coordinate or velocity."""
        (self.by_q if kind == "q" else self.by_v)[n] += bar[0]

    def spread_time(self, bar: Array, nodes: Nodes, column: int) -> None:
        """Add the gradient by the time."""
        self.by_t += bar


@dataclass(frozen=True, kw_only=True)
class SolvedRecorded(Recorded):
    """Numbers on a tape that depend on accelerations or multipliers.

    Attributes
    ----------
    event, solved : the state at the event, and what solves the equations of motion there
    """

    event: EventState
    solved: ConsistentSampling

    @property
    def slopes(self) -> Slopes:
        """Their derivatives, those through accelerations and multipliers included."""
        bars, event = self.tape.gradient({self.found[0].at: 1.0}), self.event
        for gradient in (event.by_q, event.by_v, event.by_t):
            gradient[:] = 0.0
        own = {key: bars[place] * np.ones(1) for key, place in self.places.items() if key[0] in READ}
        b = self.solved.spread_all(own, NO_NODES, 0)[:, 0]
        c, t, by_b = (self.gathered(bars, kind)[0] for kind in ("c", "t", "b"))
        every = (event.by_q.copy(), event.by_v.copy(), c, t + event.by_t, by_b + b)
        return Slopes._make(x[None] for x in every)


def solves(system: System, text: str) -> bool:
    """Whether a formula depends on accelerations or multipliers."""
    return any(find_output(system, name).level == Level.ACCELERATION for name in parse(text).names())


def recorded_solved(
    system: System, steps: StepsTaken, turn: Turn, text: str, b: Array, angles: Angles
) -> SolvedRecorded:
    """The formula of an event, in the last of some steps, with accelerations and multipliers."""
    event = EventState(turn)
    solved = ConsistentSampling(system, steps, event)
    found = of_formula(Copies(system, solved.states, b, unknown, angles), text)
    return SolvedRecorded(*(getattr(found, f.name) for f in fields(Recorded)), event=event, solved=solved)
