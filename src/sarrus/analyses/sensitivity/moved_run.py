"""A long run of which some states are stored, moved by a small multiple of its changes with the parameters.

The changes of the states are carried forward over the stretches of the run, and stored at its checkpoints. From there
they are computed again whenever the steps of a stretch are.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np

from ...algebra import Array
from ...results import EventStep, Pieces, StepsTaken
from ...results.motion.steps import last_of, led, stretches
from ...system.curves.time_derivatives import timed
from ..equilibria.settled_derivatives import derivatives_of
from .accuracy.derivatives.moved_steps import Extremes, extremes, moved_event, moved_piece, small_multiple
from .accuracy.derivatives.random_changes import Directions
from .chain.chain import STATES, Chain, Nodes
from .long_run import LongRun, Place, Stretch
from .sampling.pieces import Course
from .sampling.sampling import HIGH, KINDS
from .steps.record import STEP
from .steps.sweep import stages_of

Report: TypeAlias = Callable[[float], None]
Matrices: TypeAlias = Callable[
    [int, Stretch], Callable[[int], Array]
]  # of the events of a stretch by its number


class Reached(NamedTuple):
    """Changes (..., k) where a stretch of a long run begins.

    Attributes
    ----------
    state : of the sweep; where the run begins or follows an event those of q and v, one after the other
    shift : (k,) of the time at which the last event was
    before : of the last nodes up to the first one, or None
    """

    state: Array
    shift: Array
    before: Nodes | None


class StretchChanges(NamedTuple):
    """Changes (..., k) of the states in a stretch of a long run.

    Attributes
    ----------
    nodes, stages : of the steps between events
    shifts : of the times of the last event before the stretch, and of those in it
    after : of the velocities after the events in it
    end : where the next stretch begins
    """

    nodes: list[Nodes]
    stages: list[Array]
    shifts: list[Array]
    after: list[Array]
    end: Reached


class LongChanges:
    """Changes of the states of a long run along k changes of the parameters.

    Parameters
    ----------
    run : LongRun
    directions : changes of the parameters
    matrices : of the events of a stretch
    report : called after each stretch, where a time limit may have passed

    Attributes
    ----------
    small : the multiple of the changes that is as small as differences need
    shifts : of the times at which the run begins, of all events, and of the end (pieces + 1, k)
    """

    def __init__(self, run: LongRun, directions: Directions, matrices: Matrices, report: Report) -> None:
        self.run, self.directions, self._matrices = run, directions, matrices
        db, dq, dv, dc = directions
        start = derivatives_of(run.system, run.start)
        state = np.concatenate(start.unchecked_along(db, dq=dq, dv=dv, dc=dc))
        self._reached = [Reached(state, np.zeros(db.shape[1]), None)]
        self.shifts = np.zeros((len(run.course.t) + 1, db.shape[1]))
        largest = Extremes(*np.zeros((4, run.system.nq)))
        for n in range(len(run)):
            stretch = run.stretch(n)
            found = self.of(n, stretch)
            for piece, nodes in zip(stretches(stretch.steps), found.nodes, strict=True):
                largest = Extremes(*map(np.maximum, largest, extremes(piece, nodes)))
            for p, shift in enumerate(found.shifts[1:], start=stretch.first + 1):
                self.shifts[p] = shift
            self._reached.append(found.end)
            report(0.0)
        self.small = small_multiple(run.system, [largest], run.start)

    def of(self, n: int, stretch: Stretch) -> StretchChanges:
        """Those in a stretch."""
        state, shift, before = self._reached[n]
        db, _, _, dc = self.directions
        found, event_step = StretchChanges([], [], [shift], [], self._reached[n]), self._matrices(n, stretch)
        events = len(stretch.steps.event_steps) if isinstance(stretch.steps, Pieces) else 0
        for p, piece in enumerate(stretches(stretch.steps)):
            lead = None if p else stretch.lead
            moving = timed(self.run.system) and stretch.first + p > 0
            numbers = np.concatenate([db, shift[None]]) if moving else db
            nodes, state = self._over(piece, lead, state, numbers, moving, found.stages)
            found.nodes.append(nodes)
            before = _last(before, nodes)
            if p < events:
                ends = [getattr(nodes, kind)[e] for e in (-2, -1) for kind in KINDS]
                moved = event_step(p) @ np.concatenate([*ends, db, dc, shift[None]])
                state, shift, before = moved[:-1], shift + moved[-1], None
                found.after.append(state[len(state) // 2 :])
                found.shifts.append(shift)
        return found._replace(end=Reached(state, shift, before))

    def before(self, n: int) -> Nodes | None:
        """Those of the last nodes before a stretch."""
        return self._reached[n].before

    def _over(
        self, steps: StepsTaken, lead: StepsTaken | None, state: Array, db: Array, moving: bool, stages: list[Array]
    ) -> tuple[Nodes, Array]:  # fmt: skip
        """Changes of the nodes of some steps, and of the last state, with those of the numbers."""
        whole = led(lead and last_of(lead, 1), steps)
        chain, first = Chain(self.run.system, whole, moving), len(whole) - len(steps)
        nodes, stored = Nodes.unwritten(steps, db.shape[1]), stages_of(chain.record, db.shape[1])
        if lead is None:
            q, v = np.split(state, 2)
            end = chain.swept(q, v, db, nodes, stored)
        else:
            end = chain.swept_on(state, db, nodes, stored, first)
        stages.append(stored.parts[STEP][first:])
        return nodes, end


def _last(before: Nodes | None, nodes: Nodes) -> Nodes:
    """The last nodes, as many as states at a node depend on."""
    pairs = ((getattr(before, name)[:-1] if before else (), getattr(nodes, name)) for name in STATES)
    joined = (np.concatenate([first, own]) if len(first) else own for first, own in pairs)
    q, v, a, lam = (own[1 - HIGH :].copy() for own in joined)
    return Nodes(q, v, a, lam, nodes.shift)


class MovedRun:
    """A long run moved by a small multiple of its changes with one change of the parameters; see `LongRun`."""

    def __init__(self, changes: LongChanges) -> None:
        self._changes, self._run = changes, changes.run
        run = self._run
        self.system, self.start, self.plan, self.late = run.system, run.start, run.plan, run.late
        self.course = self._moved_course()

    def __len__(self) -> int:
        """Number of stretches."""
        return len(self._run)

    def begin(self, n: int) -> Place:
        """See `LongRun.begin`."""
        return self._run.begin(n)

    def lead(self, n: int) -> StepsTaken | None:
        """The steps before a stretch, not moved."""
        return self._run.lead(n)

    def stretch(self, n: int) -> Stretch:
        """The steps between two checkpoints, taken again and moved."""
        own, small = self._run.stretch(n), self._changes.small
        found, db = self._changes.of(n, own), self._changes.directions[0]
        shifts, pieces = small * np.array(found.shifts)[:, 0], stretches(own.steps)
        each = zip(pieces, found.nodes, shifts[: len(pieces)], found.stages, strict=True)
        moved = [
            moved_piece(self.system, piece, small, nodes, db, shift, stages)
            for piece, nodes, shift, stages in each
        ]
        events, lead = list[EventStep](), self._moved_lead(n, own.lead, float(shifts[0]))
        for p, event in enumerate(own.steps.event_steps if isinstance(own.steps, Pieces) else ()):
            after = small * found.after[p][:, 0]
            events.append(moved_event(self.system, event, shifts[p + 1], (pieces[p], moved[p]), after))
        return self._run.joined(moved, events, lead, own.first)

    def _moved_lead(self, n: int, lead: StepsTaken | None, shift: float) -> StepsTaken | None:
        before = self._changes.before(n)
        if lead is None or before is None:
            return lead
        q, v, a, lam = (getattr(before, name)[-len(lead.t) :] for name in STATES)
        last = Nodes(q, v, a, lam, before.shift)
        return moved_piece(self.system, lead, self._changes.small, last, self._changes.directions[0], shift)

    def _moved_course(self) -> Course:
        """The nodes of each piece move with the event before it, and the last one with that at its end."""
        course, shifts = self._run.course, self._changes.small * self._changes.shifts[:, 0]
        if not course.event_steps:
            return course
        pairs = zip(course.t, shifts[:-1], shifts[1:], strict=True)
        return course._replace(t=[np.append(t[:-1] + a, t[-1] + b) for t, a, b in pairs])
