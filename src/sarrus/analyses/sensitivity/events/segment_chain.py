"""Derivatives of a run with events: segments of steps, connected by the events."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import TypeAlias

import numpy as np

from ....algebra import Array
from ....results import Segments, StepsTaken
from ....system import System
from ....system.curves.time_derivatives import timed
from ..chain.chain import Chain, Gradients, Nodes, SegmentSweep, by_joints, through
from ..sampling.segments import angles_of
from .first_order import EventDerivatives

KINDS = ("q", "v", "a")
Over: TypeAlias = Callable[
    [int, Array, Array, Array], Array
]  # goes over a segment: its number, q', v', b'; its ends


class SegmentChain:
    """The derivatives of one run with events that was simulated with ``store_steps=True``; see `Chain`.

    Parameters
    ----------
    system, steps : the run
    chains : of its segments
    restitutions : names of those of impacts by which derivatives are taken

    Attributes
    ----------
    parts : the nodes of each segment
    """

    def __init__(
        self,
        system: System,
        steps: Segments,
        chains: Sequence[Chain],
        restitutions: Sequence[str],
    ) -> None:
        self.system, self.steps, self.chains, self._restitutions = system, steps, chains, restitutions
        ends = steps.first + [len(segment) for segment in steps.segments]
        self.parts = [slice(first, end + 1) for first, end in zip(steps.first, ends, strict=True)]

    @property
    def _joints(self) -> int:
        """Return the number of parameters of joint coordinates, with the restitutions."""
        return len(self.system.joint_coordinates.b) + len(self._restitutions)

    @cached_property
    def event_steps(self) -> list[EventDerivatives]:
        """The derivatives of all events."""
        return self._derivatives()

    def _derivatives(self, by_numbers: bool = True) -> list[EventDerivatives]:
        pairs = zip(self.chains, self.steps.event_steps, strict=False)
        angles = angles_of(self.system, self.steps)
        return [
            EventDerivatives(self.system, chain.steps, event_step, self._restitutions, angles, by_numbers)
            for chain, event_step in pairs
        ]

    def along(
        self,
        db: Array,
        dq: Array,
        dv: Array,
        dc: Array | None = None,
        stages: list[Array] | None = None,
    ) -> Nodes:
        """The derivatives of all states for changes of the numbers and of the guess, and of joints' numbers.

        `stages` as for `Chain.along`, of all segments in their order.
        """
        found = Nodes.unwritten(self.steps, db.shape[1])

        def over(p: int, q: Array, v: Array, b: Array) -> Array:
            own = self.chains[p].along_from(q, v, b, stages)
            for name in (*KINDS, "lam"):
                getattr(found, name)[self.parts[p]] = getattr(own, name)
            return np.concatenate([getattr(own, kind)[e] for e in (-2, -1) for kind in KINDS])

        found.shift[:] = self._over_all(over, db, dq, dv, dc)
        return found

    def weighed(self, given: Nodes, db: Array, dq: Array, dv: Array, dc: Array | None = None) -> Array:
        """The changes (r, k) of responses whose gradients by the states and by the times of events are given."""
        found = np.zeros((given.q.shape[2], db.shape[1]))

        def over(p: int, q: Array, v: Array, b: Array) -> Array:
            change, ends = self.chains[p].weighed_from(given.part(self.parts[p]), q, v, b)
            found[:] += change
            return ends

        shift = self._over_all(over, db, dq, dv, dc)
        return np.asarray(found + given.shift.T @ shift)

    def _over_all(self, over: Over, db: Array, dq: Array, dv: Array, dc: Array | None) -> Array:
        """Over one segment after another; the changes of the times at which they begin, and of the end."""
        nq, shift = self.system.nq, np.zeros((len(self.chains) + 1, db.shape[1]))
        held = np.zeros((self._joints, db.shape[1])) if dc is None else dc
        q, v = self.chains[0].assembly.unchecked_along(db, dq=dq, dv=dv, dc=held)
        for p, chain in enumerate(self.chains):
            moving = chain.by_curves.width > len(db)
            ends = over(p, q, v, np.concatenate([db, shift[p : p + 1]]) if moving else db)
            if p < len(self.event_steps):
                moved = self.event_steps[p].matrix @ np.concatenate([ends, db, held, shift[p : p + 1]])
                q, v = moved[:nq], moved[nq:-1]
                shift[p + 1] = shift[p] + moved[-1]
        return shift

    def gradients(self, given: Nodes, adjoints: list[Array] | None = None) -> Gradients:
        """Gradients of responses whose gradients by the states and by the times of events are given.

        `adjoints` as for `BackwardState.over`, of all segments in their order.
        """
        back = self._back_over(given, adjoints)
        by_b, by_q, by_v, by_c = through(self.chains[0].assembly, back.q, back.v)
        return Gradients(back.b + by_b, by_q, by_v, by_joints(back.c, by_c))

    def adjoints(self, given: Nodes) -> list[Array]:
        """Those of all segments, as `Chain.adjoints`."""
        found = list[Array]()
        self._back_over(given, found, weighing=len(self.steps))
        return found

    def _back_over(self, given: Nodes, adjoints: list[Array] | None, weighing: int = 0) -> BackSweep:
        k, events = given.q.shape[2], self._derivatives(by_numbers=False) if weighing else self.event_steps
        sweep = SegmentSweep(self.system, k, adjoints, weighing)
        back = BackSweep(self.system, sweep, k, self._joints)
        back.over(self.steps, given, lambda p: events[p].matrix)
        if adjoints is not None:
            adjoints.reverse()
        return back


class BackSweep:
    """Gradients of responses that go backwards over a run, through the events in it.

    Parameters
    ----------
    system : System
    sweep : the sweep over the steps
    columns : responses
    joints : how many numbers the joints' coordinates have, with the restitutions

    Attributes
    ----------
    q, v : (nq, columns) by the state that follows an event, or by that of the start
    b, c : by the numbers of the elements, and of the joints' coordinates with the restitutions
    """

    def __init__(self, system: System, sweep: SegmentSweep, columns: int, joints: int) -> None:
        self._system, self._sweep, self._timed = system, sweep, timed(system)
        self.q, self.v = np.zeros((system.nq, columns)), np.zeros((system.nq, columns))
        self.b, self.c = np.zeros((len(system.b), columns)), np.zeros((joints, columns))
        self._shift = np.zeros(columns)  # by the time of the event
        self._ahead: dict[str, Array] = {}  # by nodes before the steps gone over

    def over(
        self,
        steps: StepsTaken | Segments,
        given: Nodes,
        event_step: Callable[[int], Array],
        *,
        lead: StepsTaken | None = None,
        first: int = 0,
    ) -> None:
        """Go over some steps, the gradients by whose states, and by those of the nodes that lead them, are given.

        `event_step` gives the matrix of each event; `lead` are the last steps before, None at the start and after an
        event; `first` is the number of events before.
        """
        segments, event_steps = (
            (steps.segments, steps.event_steps) if isinstance(steps, Segments) else ((steps,), ())
        )
        if len(event_steps) == len(segments):
            self._shift = self._shift + given.shift[-1]
        end = len(given.q)
        self._hand_over(given, end - sum(len(segment) + 1 for segment in segments))
        for p in range(len(segments) - 1, -1, -1):
            own = given.part(slice(end - len(segments[p]) - 1, end))
            end -= len(own.q)
            if p < len(event_steps):
                self._through(event_step(p), own)
            self._shift = self._shift + given.shift[p]
            ahead = None if p else lead
            self._sweep.over(segments[p], ahead, own, self._timed and first + p > 0)
            if ahead is None:
                self._begin()

    def _hand_over(self, given: Nodes, lead: int) -> None:
        """Add the gradients by nodes that led the segment gone over before; keep those by the nodes that lead this."""
        for kind, bars in self._ahead.items():
            getattr(given, kind)[-1 - len(bars) : -1] += bars
        self._ahead = {kind: getattr(given, kind)[:lead] for kind in (*KINDS, "lam")}

    def _through(self, event_step: Array, own: Nodes) -> None:
        """Through an event, to the two nodes between which it lies."""
        nq, size = self._system.nq, len(self._system.b)
        bars = event_step.T @ np.concatenate([self.q, self.v, self._shift[None]])
        ends = bars[: 6 * nq].reshape(2, 3, nq, -1)
        for e in (0, 1):
            for place, kind in enumerate(KINDS):
                getattr(own, kind)[e - 2] += ends[e, place]
        self.b += bars[6 * nq : 6 * nq + size]
        self.c += bars[6 * nq + size : -1]
        self._shift = self._shift + bars[-1]

    def _begin(self) -> None:
        """To the state with which a segment begins."""
        self.q, self.v, by_b = self._sweep.by_start()
        size = len(self._system.b)
        self.b += by_b[:size]
        self._shift = self._shift + by_b[size:].sum(axis=0)
