"""Derivatives of the steps between two restarts, from their first state to the last, forward or backward."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ....algebra import Array
from ....results import Segments, StepsTaken
from ....results.motion.steps import segments_of
from ....system import System
from ....system.curves.curve_derivatives import CurveDerivatives
from ....system.curves.lanes import used
from ...equilibria.settled_derivatives import derivatives_of
from ...position.assembly_derivatives import AssemblyDerivatives
from ..lagrangians.changes import Change
from ..steps.curves import Curves, by_curves
from ..steps.record import ACCELERATIONS, Record
from ..steps.sweep import PerOperation, Sweep, unknowns_of
from ..steps.sweep_loop import NodeArrays
from .start import Start

STATES = ("q", "v", "a", "lam")
FIELDS = (*STATES, "shift")


@dataclass(frozen=True)
class Nodes:
    """For every node (start and ends of steps) arrays (n + 1, nq or m, k): derivatives of a state, or by it.

    `shift` (segments + 1, k) are those of the times at which segments between events begin, and of the end.
    """

    q: Array
    v: Array
    a: Array
    lam: Array
    shift: Array

    @classmethod
    def zeros(cls, steps: StepsTaken | Segments, k: int) -> Nodes:
        """Zero in k columns."""
        found = cls.unwritten(steps, k)
        for name in FIELDS:
            getattr(found, name)[...] = 0.0
        return found

    @classmethod
    def unwritten(cls, steps: StepsTaken | Segments, k: int) -> Nodes:
        """Buffers for k columns, of any value; `shift` is zero."""
        segments = segments_of(steps)
        nq, m = segments[0].q.shape[1], segments[0].lam.shape[1]
        count = sum(len(segment.t) for segment in segments)
        q, v, a, lam = (used(count, width, k) for width in (nq, nq, nq, m))
        return cls(q, v, a, lam, np.zeros((len(segments) + 1, k)))

    def part(self, rows: slice) -> Nodes:
        """Some of the nodes, as views."""
        q, v, a, lam = (getattr(self, name)[rows] for name in STATES)
        return Nodes(q, v, a, lam, np.zeros((2, self.q.shape[2])))

    def column(self, k: int) -> NodeArrays:
        """One column of the states (n + 1, nq or m, 1), as views."""
        return NodeArrays(*(getattr(self, name)[..., k : k + 1] for name in STATES))

    def copy(self) -> Nodes:
        """Arrays that do not share memory with these."""
        return Nodes(*(getattr(self, name).copy() for name in FIELDS))

    def inner(self, dots: Nodes) -> Array:
        """The change of each response (r, k), whose gradients these are, for changes of the states."""
        pairs = ((getattr(self, name), getattr(dots, name)) for name in STATES)
        states = sum(np.tensordot(bar, dot, axes=([0, 1], [0, 1])) for bar, dot in pairs)
        return np.asarray(states + self.shift.T @ dots.shift)

    def after_start(self) -> NodeArrays:
        """The ends of the steps."""
        return NodeArrays(self.q[1:], self.v[1:], self.a[1:], self.lam[1:])

    def asks_for_motion(self) -> Array:
        """The nodes after the first of which accelerations or multipliers have gradients."""
        asked = self.a[1:].any(axis=(1, 2)) | self.lam[1:].any(axis=(1, 2))
        return np.flatnonzero(asked) + 1


@dataclass(frozen=True)
class Gradients:
    """Gradients of k responses by the numbers (len(system.b), k), and by the guess of the assembly (nq, k).

    `c` are those by the parameters of the joints' coordinates, on which events and given rates depend.
    """

    b: Array
    q: Array
    v: Array
    c: Array = field(default_factory=lambda: np.zeros((0, 1)))


class SegmentChain:
    """The derivatives along one segment of a run: the steps between two restarts.

    Parameters
    ----------
    system, steps : the segment, of a run with ``store="steps"``
    moving : whether it begins at a time that moves: its change is behind those of all numbers
    """

    def __init__(self, system: System, steps: StepsTaken, moving: bool = False) -> None:
        self.system, self.steps, self.moving = system, steps, moving

    @cached_property
    def assembly(self) -> AssemblyDerivatives:
        """The derivatives of the assembly from which the run started."""
        return derivatives_of(self.system, self.steps.start)

    @cached_property
    def record(self) -> Record:
        """The operations of all steps."""
        return Record(self.system, self.steps)

    @cached_property
    def sweep(self) -> Sweep:
        """Sweeps of one column over all steps."""
        return Sweep(self.record, 1)

    @cached_property
    def start(self) -> Start:
        """The derivatives of the accelerations at the start."""
        return Start(self.system, self.steps, self.by_curves)

    @cached_property
    def by_curves(self) -> CurveDerivatives:
        """The derivatives of the operators by the numbers of curves."""
        return by_curves(self.system, self.moving)

    @cached_property
    def curves(self) -> Curves:
        """The derivatives by the numbers of curves."""
        return Curves(self.record, self.moving)

    def curves_of(self, record: Record) -> Curves:
        """The same of some operations of the steps."""
        return self.curves if record is vars(self).get("record") else Curves(record, self.moving)

    def along(
        self, q: Array, v: Array, db: Array, found: Nodes | None = None, stages: PerOperation | None = None
    ) -> Nodes:
        """The derivatives of all states for changes of the first one (nq, k) and of the numbers (width, k).

        They are written to `found`; `stages` takes the changes of the stages' quantities.
        """
        found = found or Nodes.unwritten(self.steps, db.shape[1])
        sweep, state, sources = self._initial(self.record, q, v, db)
        for name in STATES:
            getattr(found, name)[0] = sweep.block(state, name)
        sweep.forward(state, found.after_start(), stages, sources)
        return found

    def weighed(
        self, given: Nodes, q: Array, v: Array, db: Array, ends: bool = False
    ) -> tuple[Array, list[Array]]:
        """The changes (r, k) of responses whose gradients by the states are given; those of states are not stored.

        If `ends`, also those of q, v, a before and after the last step, six arrays (nq, k).
        """
        last = len(self.steps)
        record = self.record if ends else self.with_motion_at(given)
        sweep, state, sources = self._initial(record, q, v, db)
        pairs = ((name, sweep.block(state, name)) for name in STATES)
        total = np.asarray(sum(getattr(given, name)[0].T @ x for name, x in pairs))
        first, states = 0, list[Array]()
        for stop in [last - 1, last] if ends else [last]:
            if stop > first:
                by = NodeArrays(*(getattr(given, name)[first + 1 : stop + 1] for name in STATES))
                total = total + sweep.weighed(state, by, sources, first, stop)
            first = stop
            states += [sweep.block(state, name).copy() for name in ("q", "v", "a")]
        return total, states

    def with_motion_at(self, given: Nodes) -> Record:
        """The operations, with accelerations by the equations of motion only at nodes where they have gradients."""
        nodes = given.asks_for_motion()
        known: Record | None = vars(self).get("record")
        if known and len(known.operations[ACCELERATIONS]) in (0, len(nodes)):
            return known
        return Record(self.system, self.steps, nodes)

    def _initial(
        self, record: Record, q: Array, v: Array, db: Array
    ) -> tuple[Sweep, Array, PerOperation | None]:
        """A sweep, the derivatives of the first state, and what curves do besides."""
        curves = self.curves_of(record)
        sweep = Sweep(record, db.shape[1], db)
        a, lam = self.start.along(q, v, db)
        first = {"q": q, "v": v, "a": a, "lam": lam}
        for name, by in record.extra.items():
            first[name] = np.asarray(sum(factor * first[own] for own, factor in by.items()))
        return sweep, sweep.state(**first), curves.sources(db) if curves.moved_by(db) else None


class BackwardState:
    """Gradients of responses carried backwards over steps: by the state, and by the numbers (width, columns).

    Attributes
    ----------
    of_start : adjoint variables of the equations at the start
    """

    of_start: tuple[Array, Array]

    def __init__(self, width: int, columns: int) -> None:
        self.b = np.zeros((width, columns))
        self.state: Array | None = None

    def over(
        self,
        sweep: Sweep,
        curves: Curves | None,
        given: Nodes,
        first: int,
        adjoints: list[Array] | None = None,
        solved: PerOperation | None = None,
        sources: PerOperation | None = None,
    ) -> None:
        """Over the steps from `first` on; `given` are the gradients by their ends, and by the state before them.

        `adjoints` takes gradients by q and v before and after all steps (n, 2, 2 nq, columns), `solved` the adjoint
        variables; `sources` as for `Sweep.backward`.
        """
        self.sweep = sweep
        self.state = sweep.state() if self.state is None else self.state
        if curves and solved is None:
            solved = unknowns_of(sweep.record, sweep.columns)
        n, nq, k = given.q.shape
        stored = None if adjoints is None else np.zeros((n - 1, 2, 2 * nq, k))
        by_b = sweep.backward(self.state, given.after_start(), first, solved, sources, adjoints=stored)
        if adjoints is not None and stored is not None:
            adjoints.append(stored)
        self.b[: len(by_b)] += by_b
        if curves and solved is not None:
            self.b += curves.gradient(solved)

    def by_first(self, given: Nodes) -> dict[str, Array]:
        """Gradients by q, v, a and λ of the first state."""
        assert self.state is not None
        found = {name: self.sweep.block(self.state, name) + getattr(given, name)[0] for name in STATES}
        for name, by in self.sweep.record.extra.items():
            for own, factor in by.items():
                found[own] = found[own] + factor * self.sweep.block(self.state, name)
        return found

    def through_start(
        self, start: Start, given: Nodes, change: Change | None = None
    ) -> tuple[Array, Array, Array]:
        """Gradients by q and v of the first state, and by the numbers; `change` is that of its equations."""
        first = self.by_first(given)
        if change:
            first = {name: x - getattr(change, name)[:, None] for name, x in first.items()}
        self.of_start = start.adjoint(first["a"], first["lam"])
        by_q, by_v, by_b = start.transposed(*self.of_start)
        return by_q + first["q"], by_v + first["v"], by_b + self.b


def by_joints(explicit: Array, own: Array) -> Array:
    """Gradients by the parameters of joints' coordinates, and of restitutions behind these."""
    found = explicit.copy()
    found[: len(own)] += own
    return found


def through(assembly: AssemblyDerivatives, by_q: Array, by_v: Array) -> list[Array]:
    """Gradients by the parameters, the guess q₀, v₀ and the joints' parameters of those by the assembled state."""
    found = [assembly.adjoint(*pair) for pair in zip(by_q.T, by_v.T, strict=True)]
    return [np.array([one[n] for one in found]).T for n in range(4)]
