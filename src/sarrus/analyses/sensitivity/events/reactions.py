"""Events of accelerations and reactions, which solve the equations of motion at the state of the event."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np

from ....algebra import Array
from ....model.tape import Tracer
from ....outputs import Level, find_output
from ....outputs.output import formula_of
from ....outputs.recording import Angles, Key
from ....results import EventStep, StepsTaken
from ....system import System
from ..chain.chain import FIELDS, Nodes
from ..sampling.consistent import ConsistentSampling
from ..sampling.sampling import READ, Sampling
from .functions import Copies, Slopes, TapeValues, of_formula, unknown

NO_NODES = Nodes(*(np.zeros((0, 0, 0)) for _ in FIELDS))


class EventState(Sampling):
    """The state at an event, and the gradients by it that are spread to it.

    Attributes
    ----------
    by_q, by_v, by_t : gradients (nq,), (nq,), (1,)
    moved : the changes of q, v and the time
    """

    moves = True

    def __init__(self, event_step: EventStep) -> None:
        self._event_step = event_step
        self.by_q, self.by_v, self.by_t = (
            np.zeros(len(event_step.q)),
            np.zeros(len(event_step.q)),
            np.zeros(1),
        )
        self.q, self.v = event_step.q[None], event_step.v[None]
        self.moved: Slopes | None = None

    def cleared(self) -> None:
        """Set the gradients to zero."""
        for gradient in (self.by_q, self.by_v, self.by_t):
            gradient[:] = 0.0

    @property
    def t(self) -> Array:
        """The time of the event (1,). [s]"""
        return np.array([self._event_step.t])

    @property
    def between_nodes(self) -> Array:
        """None: the coordinates of the event satisfy the constraints."""
        return np.zeros(1, dtype=bool)

    def spread(self, kind: str, places: Array, bar: Array, nodes: Nodes, column: int) -> None:
        """Add the gradients by some coordinates or velocities."""
        (self.by_q if kind == "q" else self.by_v)[places] += bar[0]

    def spread_along(self, bars: Mapping[Key, Array], dots: Nodes, nodes: Nodes) -> None:
        """Nothing, as the state is not interpolated between nodes."""

    def spread_time(self, bar: Array, nodes: Nodes, column: int) -> None:
        """Add the gradient by the time."""
        self.by_t += bar

    def gathered(self, kind: str, places: Array, nodes: Nodes, column: int) -> Array:
        """The changes of some coordinates or velocities."""
        assert self.moved is not None
        return np.asarray(getattr(self.moved, kind)[None, places])

    def gathered_time(self, nodes: Nodes, column: int) -> Array:
        """The change of the time."""
        assert self.moved is not None
        return np.array(self.moved.t)


@dataclass(frozen=True, kw_only=True)
class SolvedRecorded(TapeValues):
    """Numbers on a tape that depend on accelerations or multipliers.

    Attributes
    ----------
    event, solved : the state at the event, and what solves the equations of motion there
    """

    event: EventState
    solved: ConsistentSampling

    @property
    def _place(self) -> int:
        number = self.found[0]
        assert isinstance(number, Tracer)  # it contains an acceleration or a multiplier
        return number.at

    @cached_property
    def slopes(self) -> Slopes:
        """Their derivatives, those through accelerations and multipliers included."""
        bars = self.tape.gradient({self._place: 1.0})
        self.event.cleared()
        found = self._spread(bars)
        return Slopes._make(x[None] for x in found)

    def _spread(self, bars: list[Any], *turned: Any) -> Slopes:
        """Gradients by everything of those by what is on the tape."""
        own = {key: bars[place] * np.ones(1) for key, place in self.places.items() if key[0] in READ}
        b = self.solved.spread_all(own, NO_NODES, 0, *turned)[:, 0]
        c, t, by_b = (self.gathered(bars, kind)[0] for kind in ("c", "t", "b"))
        return Slopes(self.event.by_q.copy(), self.event.by_v.copy(), c, t + self.event.by_t, by_b + b)

    def along(self, dots: Slopes) -> Array:
        return np.array([self._tape_along(dots)[1][self._place]])

    def _tape_along(self, dots: Slopes) -> tuple[Any, list[Any]]:
        """The motion of the state, and the change of everything on the tape."""
        self.event.moved = dots
        motion = self.solved.along(NO_NODES, dots.b[:, None], 0)
        change = {
            place: getattr(motion.found, kind)[:, n, 0] if kind in READ else float(getattr(dots, kind)[n])
            for (kind, n), place in self.places.items()
        }
        return motion, self.tape.along(change)

    def turned(self, weights: Array, changes: Array, dots: Slopes) -> Slopes:
        motion, along = self._tape_along(dots)
        at = self._place
        bars, change = self.tape.gradient_along({at: float(weights[0])}, {at: float(changes[0])}, along)
        own = {key: bars[place] * np.ones(1) for key, place in self.places.items() if key[0] in READ}
        self.event.cleared()
        sources, by_b = self.solved.turned(own, motion, NO_NODES, NO_NODES)
        found = self._spread(change, sources)
        return found._replace(b=found.b - by_b)


def solves(system: System, text: str) -> bool:
    """Whether a formula depends on accelerations or multipliers."""
    return any(
        find_output(system, name).level == Level.ACCELERATION for name in formula_of(system, text).names()
    )


def recorded_solved(
    system: System, steps: StepsTaken, event_step: EventStep, text: str, b: Array, angles: Angles
) -> SolvedRecorded:
    """The formula of an event, in the last of some steps, with accelerations and multipliers."""
    event = EventState(event_step)
    solved = ConsistentSampling(system, steps, event)
    found = of_formula(Copies(system, solved, b, unknown, angles), text)
    return SolvedRecorded(*(getattr(found, f.name) for f in fields(TapeValues)), event=event, solved=solved)
