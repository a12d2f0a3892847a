"""Derivatives of a whole run: the chain rule from its assembly through its segments and the events between them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import cached_property
from typing import NamedTuple, TypeAlias

import numpy as np

from ...algebra import Array
from ...outputs.recording import Angles
from ...results import Segments, StepsTaken
from ...results.motion.steps import last_of, led, segments_of
from ...system import System
from ...system.curves.time_derivatives import timed
from ..position.assembly_derivatives import AssemblyDerivatives
from .chain.chain import STATES, BackwardState, Gradients, Nodes, SegmentChain, by_joints, through
from .events.first_order import EventDerivatives
from .sampling.sampling import angles_of
from .steps.record import Record
from .steps.sweep import PerOperation, Sweep, stages_of

KINDS = ("q", "v", "a")
# Goes over a segment: its number, q', v', b'; q', v', a' before and after its last step
Over: TypeAlias = Callable[[int, Array, Array, Array], Sequence[Array]]


class RunTangents(NamedTuple):
    """The change of a run along one direction: of the stages of each segment, and of what its events depend on."""

    steps: list[PerOperation]
    event_steps: list[Array]


class RunChain:
    """The derivatives of a run with ``store="steps"``.

    Parameters
    ----------
    system, steps : the run
    restitutions : names of those of impacts by which derivatives are taken
    before : number of events before these steps
    angles : the joints' coordinates along the run, with their revolutions; by default counted along these steps

    Attributes
    ----------
    chains : of its segments
    parts : the nodes of each segment
    """

    def __init__(
        self, system: System, steps: StepsTaken | Segments, restitutions: Iterable[str] = (), before: int = 0,
        angles: Angles | None = None,
    ) -> None:  # fmt: skip
        self.system, self.steps, self._restitutions = system, steps, list(restitutions)
        self._events, self._angles = steps.event_steps if isinstance(steps, Segments) else (), angles
        segments, moving = enumerate(segments_of(steps), before), timed(system)
        self.chains = [SegmentChain(system, own, moving and n > 0) for n, own in segments]
        sizes = [len(chain.steps) + 1 for chain in self.chains]
        self.parts = [slice(end - size, end) for end, size in zip(np.cumsum(sizes), sizes, strict=True)]

    @property
    def assembly(self) -> AssemblyDerivatives:
        """The derivatives of the assembly from which the run started."""
        return self.chains[0].assembly

    @property
    def _joints(self) -> int:
        """The number of parameters of joint coordinates, with the restitutions, on which events depend."""
        return len(self.system.joint_coordinates.b) + len(self._restitutions) if self._events else 0

    @cached_property
    def event_steps(self) -> list[EventDerivatives]:
        """The derivatives of all events."""
        return self._derivatives()

    def _derivatives(self, by_numbers: bool = True) -> list[EventDerivatives]:
        if not self._events:
            return []
        angles = self._angles or angles_of(self.system, self.steps)
        return [
            EventDerivatives(self.system, chain.steps, event_step, self._restitutions, angles, by_numbers)
            for chain, event_step in zip(self.chains, self._events, strict=False)
        ]

    def along(self, db: Array, dq: Array, dv: Array, dc: Array | None = None) -> Nodes:
        """The derivatives of all states for changes of the numbers and of the guess, (len(system.b), k), (nq, k).

        dc are those of the parameters of the joints' coordinates, which matter to events and given rates only. Changes
        that contradict redundant equations are left out or refused before, see `undefined`.
        """
        dc = self._held(db) if dc is None else dc
        return self.from_start(*self.assembly.unchecked_along(db, dq=dq, dv=dv, dc=dc), db, dc)

    def from_start(
        self, q: Array, v: Array, db: Array, dc: Array | None, tangents: RunTangents | None = None
    ) -> Nodes:
        """The same for changes of the assembled state; `tangents` takes those within the steps and at the events."""
        found = Nodes.unwritten(self.steps, db.shape[1])

        def over(p: int, q: Array, v: Array, b: Array) -> Sequence[Array]:
            stages = stages_of(self.chains[p].record, 1) if tangents else None
            own = self.chains[p].along(q, v, b, found.part(self.parts[p]), stages)
            if tangents and stages:
                tangents.steps.append(stages)
            return [getattr(own, kind)[e] for e in (-2, -1) for kind in KINDS]

        found.shift[:] = self._over_all(over, q, v, db, dc, tangents)
        return found

    def _held(self, db: Array) -> Array | None:
        """Numbers of joints' coordinates that do not change, where events depend on them."""
        return np.zeros((self._joints, db.shape[1])) if self._events else None

    def weighed(self, given: Nodes, db: Array, dq: Array, dv: Array, dc: Array | None = None) -> Array:
        """The changes (r, k) of responses whose gradients by the states and by the times of events are given.

        The changes of the states are not stored.
        """
        found = np.zeros((given.q.shape[2], db.shape[1]))

        def over(p: int, q: Array, v: Array, b: Array) -> Sequence[Array]:
            ends = p < len(self._events)
            change, states = self.chains[p].weighed(given.part(self.parts[p]), q, v, b, ends)
            found[:] += change
            return states

        dc = self._held(db) if dc is None else dc
        shift = self._over_all(over, *self.assembly.unchecked_along(db, dq=dq, dv=dv, dc=dc), db, dc)
        return np.asarray(found + given.shift.T @ shift)

    def _over_all(
        self, over: Over, q: Array, v: Array, db: Array, dc: Array | None, tangents: RunTangents | None = None
    ) -> Array:
        """Over one segment after another; the changes of the times at which they begin, and of the end."""
        nq, shift = self.system.nq, np.zeros((len(self.chains) + 1, db.shape[1]))
        for p, chain in enumerate(self.chains):
            moving = chain.by_curves.width > len(db)
            ends = over(p, q, v, np.concatenate([db, shift[p : p + 1]]) if moving else db)
            if p < len(self._events):
                given = np.concatenate([*ends, db, dc, shift[p : p + 1]])
                moved = self.event_steps[p].matrix @ given
                q, v = moved[:nq], moved[nq:-1]
                if tangents:
                    tangents.event_steps.append(given[:, 0])
                shift[p + 1] = shift[p] + moved[-1]
        return shift

    def gradients(self, given: Nodes, adjoints: list[Array] | None = None) -> Gradients:
        """Gradients of responses whose gradients by the states and by the times of events are given.

        `adjoints` as for `BackSweep`, of all segments in their order.
        """
        back = BackSweep(self.system, given.q.shape[2], self._joints, adjoints)
        self.over(back, given)
        if adjoints is not None:
            adjoints.reverse()
        return back.gradients(self.assembly)

    def adjoints(self, given: Nodes) -> list[Array]:
        """Gradients by q and v before and after all steps, see `BackSweep`, as exactly as defects need."""
        found = list[Array]()
        back = BackSweep(self.system, given.q.shape[2], self._joints, found, len(self.steps))
        back.over(self.chains, given, self._derivatives(by_numbers=False))
        return found[::-1]

    def over(self, back: BackSweep, given: Nodes, lead: StepsTaken | None = None) -> None:
        """Go over all segments, see `BackSweep.over`."""
        back.over(self.chains, given, self.event_steps, lead=lead)


class BackSweep:
    """Gradients of responses that are carried backwards over a run, through the events in it.

    Parameters
    ----------
    system : System
    columns : responses
    joints : how many numbers the joints' coordinates have, with the restitutions
    adjoints : takes those by q and v before and after all steps of a segment (n, 2, 2 nq, columns), the last one first
    weighing : number of steps of the run if adjoints only weigh their defects, as for `Record`; gradients by
        the parameters of elements and by the start are then not computed, those by times of events always are

    Attributes
    ----------
    q, v : (nq, columns) by the state that follows an event, or by that of the start
    b, c : by the numbers of the elements, and of the joints' coordinates with the restitutions
    """

    def __init__(
        self,
        system: System,
        columns: int,
        joints: int,
        adjoints: list[Array] | None = None,
        weighing: int = 0,
    ) -> None:
        self._system, self._columns, self._adjoints, self._weighing = system, columns, adjoints, weighing
        self.q, self.v = np.zeros((system.nq, columns)), np.zeros((system.nq, columns))
        self.b, self.c = np.zeros((len(system.b), columns)), np.zeros((joints, columns))
        self._shift = np.zeros(columns)  # by the time of the event
        self._ahead: dict[str, Array] = {}  # by nodes before the steps gone over
        self._sweep: Sweep | None = None
        self._back: BackwardState | None = None  # within a segment
        self._last: Nodes | None = None  # gradients by the nodes of the steps gone over

    def over(
        self,
        chains: Sequence[SegmentChain],
        given: Nodes,
        events: Sequence[EventDerivatives],
        *,
        lead: StepsTaken | None = None,
    ) -> None:
        """Go over some segments, the gradients by whose states, and by those of the nodes that lead them, are given.

        `events` are those that end segments. `lead` are the last steps before, None at the start and after an event.
        """
        if len(events) == len(chains):
            self._shift = self._shift + given.shift[-1]
        end = len(given.q)
        self._hand_over(given, end - sum(len(chain.steps) + 1 for chain in chains))
        for p in range(len(chains) - 1, -1, -1):
            rows = slice(end - len(chains[p].steps) - 1, end)
            own, end = given.part(rows), rows.start
            if p < len(events):
                own, bars = own.copy(), np.concatenate([self.q, self.v, self._shift[None]])
                self._to_nodes(self._through(events[p], bars), own)
            self._shift = self._shift + given.shift[p]
            ahead = None if p else lead
            self._over_steps(chains[p], own, ahead)
            if ahead is None and (p or not self._weighing):
                self._begin(chains[p])

    def _through(self, event: EventDerivatives, bars: Array) -> Array:
        """Gradients by what an event depends on, of those by q, v and the time (2 nq + 1, columns)."""
        return np.asarray(event.matrix.T @ bars)

    def gradients(self, assembly: AssemblyDerivatives) -> Gradients:
        """Gradients by the numbers and by the guess, through the assembly from which the run started."""
        by_b, by_q, by_v, by_c = through(assembly, self.q, self.v)
        return Gradients(self.b + by_b, by_q, by_v, by_joints(self.c, by_c) if len(self.c) else by_c)

    def _hand_over(self, given: Nodes, lead: int) -> None:
        """Add the gradients by nodes that led the segment gone over before; keep those by the nodes that lead this."""
        for kind, bars in self._ahead.items():
            getattr(given, kind)[-1 - len(bars) : -1] += bars
        self._ahead = {kind: getattr(given, kind)[:lead] for kind in STATES}

    def _to_nodes(self, bars: Array, own: Nodes) -> None:
        """From an event to the two nodes between which it lies."""
        nq, size = self._system.nq, len(self._system.b)
        ends = bars[: 6 * nq].reshape(2, 3, nq, -1)
        for e in (0, 1):
            for place, kind in enumerate(KINDS):
                getattr(own, kind)[e - 2] += ends[e, place]
        self.b += bars[6 * nq : 6 * nq + size]
        self.c += bars[6 * nq + size : -1]
        self._shift = self._shift + bars[-1]

    def _over_steps(self, chain: SegmentChain, nodes: Nodes, lead: StepsTaken | None) -> None:
        """Over a segment, or a part of one with some of the steps before it.

        A step's change of size belongs to it, and so the step before matters.
        """
        whole = led(lead and last_of(lead, 1), chain.steps)
        before = len(whole) - len(chain.steps)
        if self._back is not None and self._last is not None:
            for kind in STATES:
                getattr(nodes, kind)[-1] += getattr(self._last, kind)[0]
        if before or self._weighing:
            record = Record(self._system, whole, before + nodes.asks_for_motion(), self._weighing)
        else:
            record = chain.with_motion_at(nodes)
        exact = not self._weighing
        sweep = (
            Sweep(record, self._columns, by_parameters=exact)
            if self._sweep is None
            else self._sweep.over(record)
        )
        if self._back is None:
            self._back = BackwardState(chain.by_curves.width, self._columns)
        curves = chain.curves_of(record) if exact or chain.moving else None
        self._back.over(sweep, curves, nodes, before, self._adjoints)
        self._sweep, self._last = sweep, nodes

    def _begin(self, chain: SegmentChain) -> None:
        """To the state with which a segment begins."""
        assert self._back is not None
        assert self._last is not None
        self._to_start(*self._back.through_start(chain.start, self._last))
        self._back = None

    def _to_start(self, q: Array, v: Array, by_b: Array) -> None:
        """To the state with which a segment begins, with the gradients by its numbers."""
        self.q, self.v, size = q, v, len(self._system.b)
        self.b += by_b[:size]
        self._shift = self._shift + by_b[size:].sum(axis=0)
