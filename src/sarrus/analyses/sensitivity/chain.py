"""The whole chain of a run differentiated: assembly, start, steps; forward or backward, on stored states."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ...algebra import Array
from ...results import Pieces, Steps, StepsTaken
from ...system import System
from ...system.lane_room import used
from ..assembly_derivatives import AssemblyDerivatives
from .curves import Curves
from .start import Start
from .sweep import Sweep
from .sweep_loop import Bars, Given, Sources

FIELDS = ("q", "v", "a", "lam", "shift")


@dataclass(frozen=True)
class Nodes:
    """For every node (start and ends of steps) arrays (n + 1, nq or m, k): derivatives of a state, or by it.

    `shift` (stretches + 1, k) are those of the times at which stretches between events begin, and of the end.
    """

    q: Array
    v: Array
    a: Array
    lam: Array
    shift: Array

    @classmethod
    def zeros(cls, steps: StepsTaken | Pieces, k: int) -> Nodes:
        """Zero in k columns."""
        found = cls.unwritten(steps, k)
        for name in FIELDS:
            getattr(found, name)[...] = 0.0
        return found

    @classmethod
    def unwritten(cls, steps: StepsTaken | Pieces, k: int) -> Nodes:
        """Room for k columns; but for `shift`, which is zero, of any value."""
        pieces = steps.pieces if isinstance(steps, Pieces) else (steps,)
        nq, m = pieces[0].q.shape[1], pieces[0].lam.shape[1]
        count = sum(len(piece) + 1 for piece in pieces)
        q, v, a, lam = (used(count, width, k) for width in (nq, nq, nq, m))
        return cls(q, v, a, lam, np.zeros((len(pieces) + 1, k)))

    def part(self, rows: slice) -> Nodes:
        """Some of the nodes, as arrays of their own."""
        q, v, a, lam = (np.ascontiguousarray(x[rows]) for x in (self.q, self.v, self.a, self.lam))
        return Nodes(q, v, a, lam, np.zeros((2, self.q.shape[2])))

    def inner(self, dots: Nodes) -> Array:
        """The change of each response (r, k), whose gradients these are, for changes of the states."""
        pairs = ((getattr(self, name), getattr(dots, name)) for name in ("q", "v", "a", "lam"))
        states = sum(np.tensordot(bar, dot, axes=([0, 1], [0, 1])) for bar, dot in pairs)
        return np.asarray(states + self.shift.T @ dots.shift)

    def after_start(self) -> Given:
        """The ends of the steps."""
        return Given(self.q[1:], self.v[1:], self.a[1:], self.lam[1:])


@dataclass(frozen=True)
class Gradients:
    """Gradients of k responses by the numbers (len(system.b), k), and by the guess of the assembly (nq, k).

    `c` are those by the parameters of the joints' coordinates, on which events and given rates depend.
    """

    b: Array
    q: Array
    v: Array
    c: Array = field(default_factory=lambda: np.zeros((0, 1)))


class Chain:
    """The derivatives of one run that was simulated with ``store_steps=True``.

    Parameters
    ----------
    system, steps : the run
    moving : whether it begins at a time that moves: its change stands behind those of all numbers
    """

    def __init__(self, system: System, steps: Steps, moving: bool = False) -> None:
        self.system, self.steps, self._moving = system, steps, moving

    @cached_property
    def assembly(self) -> AssemblyDerivatives:
        """The derivatives of the assembly from which the run started."""
        return AssemblyDerivatives(self.system, self.steps.start)

    @cached_property
    def start(self) -> Start:
        """The derivatives of the accelerations at the start."""
        return Start(self.system, self.steps, self.curves.of)

    @cached_property
    def curves(self) -> Curves:
        """The derivatives by the numbers of curves."""
        return Curves(self.system, self.steps, self._moving)

    def along(self, db: Array, dq: Array, dv: Array, dc: Array | None = None) -> Nodes:
        """The derivatives of all states for changes of the numbers and of the guess, (len(system.b), k), (nq, k).

        dc are those of the parameters of the joints' coordinates, which matter to events and given rates only.
        """
        return self.along_from(*self.assembly.along(db, dq=dq, dv=dv, dc=dc), db)

    def along_from(self, q: Array, v: Array, db: Array) -> Nodes:
        """The same for changes of the first state."""
        found, (sweep, bars, sources) = Nodes.unwritten(self.steps, db.shape[1]), self._begun(q, v, db)
        found.q[0], found.v[0], found.a[0], found.lam[0] = bars.q, bars.v, bars.a, bars.lam
        sweep.forward(bars, found.after_start(), 0, len(self.steps), sources=sources)
        return found

    def weighed(self, given: Nodes, db: Array, dq: Array, dv: Array, dc: Array | None = None) -> Array:
        """The changes (r, k) of responses whose gradients by the states are given; those of states are not kept."""
        found = self._weighed(given, *self.assembly.along(db, dq=dq, dv=dv, dc=dc), db, [len(self.steps)])
        return found[0]

    def weighed_from(self, given: Nodes, q: Array, v: Array, db: Array) -> tuple[Array, Array]:
        """The same for changes of the first state; and those of q, v, a at both ends of the last step (6 nq, k)."""
        last = len(self.steps)
        found, ends = self._weighed(given, q, v, db, [last - 1, last])
        return found, np.concatenate(ends)

    def _weighed(
        self, given: Nodes, q: Array, v: Array, db: Array, stops: list[int]
    ) -> tuple[Array, list[Array]]:
        """By a sweep with some stops, at which q', v', a' are told."""
        sweep, bars, sources = self._begun(q, v, db)
        pairs = ((given.q, bars.q), (given.v, bars.v), (given.a, bars.a), (given.lam, bars.lam))
        told: list[Array] = []
        total, at = np.asarray(sum(by[0].T @ bar for by, bar in pairs)), 0
        for stop in stops:
            by = Given(*(x[at + 1 : stop + 1] for x in (given.q, given.v, given.a, given.lam)))
            total = total + sweep.weighed(bars, by, at, stop, sources)
            at, told = stop, [*told, bars.q.copy(), bars.v.copy(), bars.a.copy()]
        return total, told

    def _begun(self, q: Array, v: Array, db: Array) -> tuple[Sweep, Bars, Sources | None]:
        """A sweep, the derivatives of the first state, and what curves do besides."""
        sweep = Sweep(self.system, self.steps, db.shape[1], db)
        bars = sweep.bars(db)
        bars.q[:], bars.v[:] = q, v
        bars.a[:], bars.lam[:] = self.start.along(bars.q, bars.v, db)
        bars.x[:] = bars.a
        return sweep, bars, self.curves.sources(db) if self.curves.moved_by(db) else None

    def gradients(self, given: Nodes) -> Gradients:
        """Gradients of responses whose gradients by the states are given."""
        by_q, by_v, by_b = self.by_start(given)
        b, q, v, c = through(self.assembly, by_q, by_v)
        return Gradients(by_b + b, q, v, c)

    def by_start(self, given: Nodes) -> tuple[Array, Array, Array]:
        """Gradients by the first state (nq, k), and by the numbers without their way through that state."""
        sweep = Sweep(self.system, self.steps, given.q.shape[2])
        bars = sweep.bars(np.zeros((self.curves.width, given.q.shape[2])))
        kept = sweep.kept() if self.curves else None
        sweep.backward(bars, given.after_start(), 0, len(self.steps), kept)
        by_q, by_v, by_b = self.through_start(given, bars)
        return by_q, by_v, by_b if kept is None else by_b + self.curves.gradient(kept)

    def through_start(self, given: Nodes, bars: Bars) -> tuple[Array, Array, Array]:
        """The same, where those by the start of the first step are known."""
        solved = self.start.adjoint(bars.a + bars.x + given.a[0], given.lam[0])
        by_q, by_v, by_b = self.start.transposed(*solved)
        return by_q + bars.q + given.q[0], by_v + bars.v + given.v[0], by_b + bars.b


def by_joints(explicit: Array, own: Array) -> Array:
    """Gradients by the parameters of joints' coordinates, and of restitutions behind these."""
    found = explicit.copy()
    found[: len(own)] += own
    return found


def through(assembly: AssemblyDerivatives, by_q: Array, by_v: Array) -> list[Array]:
    """Gradients by the parameters, the guess q₀, v₀ and the joints' parameters of those by the assembled state."""
    found = [assembly.adjoint(*pair) for pair in zip(by_q.T, by_v.T, strict=True)]
    return [np.array([one[n] for one in found]).T for n in range(4)]
