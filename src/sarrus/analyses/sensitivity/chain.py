"""The whole chain of a run differentiated: assembly, start, steps; forward or backward, on stored states."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...algebra import Array
from ...results import Steps, StepsTaken
from ...system import System
from ..assembly_derivatives import AssemblyDerivatives
from .curves import Curves
from .start import Start
from .sweep import Sweep
from .sweep_loop import Given


@dataclass(frozen=True)
class Nodes:
    """For every node (start and ends of steps) arrays (n + 1, nq or m, k): derivatives of a state, or by it."""

    q: Array
    v: Array
    a: Array
    lam: Array

    @classmethod
    def zeros(cls, steps: StepsTaken, k: int) -> Nodes:
        """Room for k columns."""
        count, nq, m = len(steps) + 1, steps.q.shape[1], steps.lam.shape[1]
        return cls(*(np.zeros((count, width, k)) for width in (nq, nq, nq, m)))

    def after_start(self) -> Given:
        """The ends of the steps."""
        return Given(self.q[1:], self.v[1:], self.a[1:], self.lam[1:])


@dataclass(frozen=True)
class Gradients:
    """Gradients of k responses by the numbers (len(system.b), k), and by the guess of the assembly (nq, k)."""

    b: Array
    q: Array
    v: Array


class Chain:
    """The derivatives of one run that was simulated with ``keep_steps=True``."""

    def __init__(self, system: System, steps: Steps) -> None:
        self.system, self.steps = system, steps

    @cached_property
    def assembly(self) -> AssemblyDerivatives:
        """The derivatives of the assembly from which the run started."""
        return AssemblyDerivatives(self.system, self.steps.start)

    @cached_property
    def start(self) -> Start:
        """The derivatives of the accelerations at the start."""
        return Start(self.system, self.steps)

    @cached_property
    def curves(self) -> Curves:
        """The derivatives by the numbers of curves."""
        return Curves(self.system, self.steps)

    def along(self, db: Array, dq: Array, dv: Array) -> Nodes:
        """The derivatives of all states for changes of the numbers and of the guess, (len(system.b), k), (nq, k)."""
        k = db.shape[1]
        sweep, found = Sweep(self.system, self.steps, k, db), Nodes.zeros(self.steps, k)
        bars = sweep.bars(db)
        bars.q[:], bars.v[:] = self.assembly.along(db, dq=dq, dv=dv)
        bars.a[:], bars.lam[:] = self.start.along(bars.q, bars.v, db)
        bars.x[:] = bars.a
        found.q[0], found.v[0], found.a[0], found.lam[0] = bars.q, bars.v, bars.a, bars.lam
        sources = self.curves.sources(db) if self.curves.moved_by(db) else None
        sweep.forward(bars, found.after_start(), 0, len(self.steps), sources=sources)
        return found

    def gradients(self, given: Nodes) -> Gradients:
        """Gradients of responses whose gradients by the states are given."""
        k = given.q.shape[2]
        sweep = Sweep(self.system, self.steps, k)
        bars, kept = sweep.bars(), sweep.kept() if self.curves else None
        sweep.backward(bars, given.after_start(), 0, len(self.steps), kept)
        by_q, by_v, by_b = self.start.transposed(bars.a + bars.x + given.a[0], given.lam[0])
        by_q += bars.q + given.q[0]
        by_v += bars.v + given.v[0]
        by_b += bars.b if kept is None else bars.b + self.curves.gradient(kept)
        found = [self.assembly.gradient(by_q[:, n], by_v[:, n]) for n in range(k)]
        b, q, v = (np.array([one[n] for one in found]).T for n in range(3))
        return Gradients(by_b + b, q, v)
