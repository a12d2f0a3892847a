"""The chain of a run of Radau IIA differentiated: assembly, steps, and the accelerations of every node."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ...algebra import Array
from ...results import RadauSteps
from ...system import System
from ..assembly_derivatives import AssemblyDerivatives
from .chain import Gradients, Nodes, through
from .radau_curves import RadauCurves
from .radau_sweep import RadauSweep
from .radau_sweep_loop import Bars, Given


class RadauChain:
    """The derivatives of one run that was simulated by Radau with ``store_steps=True``; see `Chain`."""

    def __init__(self, system: System, steps: RadauSteps, moving: bool = False) -> None:
        self.system, self.steps = system, steps
        self.curves = RadauCurves(system, steps, moving)

    @cached_property
    def assembly(self) -> AssemblyDerivatives:
        """The derivatives of the assembly from which the run started."""
        return AssemblyDerivatives(self.system, self.steps.start)

    def along(self, db: Array, dq: Array, dv: Array, dc: Array | None = None) -> Nodes:
        """The derivatives of all states for changes of the numbers and of the guess, (len(system.b), k), (nq, k)."""
        return self.along_from(*self.assembly.along(db, dq=dq, dv=dv, dc=dc), db)

    def along_from(self, q: Array, v: Array, db: Array) -> Nodes:
        """The same for changes of the first state."""
        found, k = Nodes.unwritten(self.steps, db.shape[1]), db.shape[1]
        bars = Bars(*(np.array(x, dtype=float, order="C") for x in (q, v, db)))
        sources = self.curves.sources(db) if self.curves.moved_by(db) else None
        RadauSweep(self.system, self.steps, k, db).forward(bars, given_by(found), sources)
        return found

    def weighed(self, given: Nodes, db: Array, dq: Array, dv: Array, dc: Array | None = None) -> Array:
        """The changes (r, k) of responses whose gradients by the states are given."""
        return self.weighed_from(given, *self.assembly.along(db, dq=dq, dv=dv, dc=dc), db)[0]

    def weighed_from(self, given: Nodes, q: Array, v: Array, db: Array) -> tuple[Array, Array]:
        """The same for changes of the first state; and those of q, v, a at both ends of the last step (6 nq, k)."""
        found = self.along_from(q, v, db)
        return given.inner(found), np.concatenate(
            [x[e] for e in (-2, -1) for x in (found.q, found.v, found.a)]
        )

    def gradients(self, given: Nodes) -> Gradients:
        """Gradients of responses whose gradients by the states are given."""
        by_q, by_v, by_b = self.by_start(given)
        b, q, v, c = through(self.assembly, by_q, by_v)
        return Gradients(by_b + b, q, v, c)

    def by_start(self, given: Nodes) -> tuple[Array, Array, Array]:
        """Gradients by the first state (nq, k), and by the numbers without their way through that state."""
        k, nq = given.q.shape[2], self.system.nq
        bars = Bars(np.zeros((nq, k)), np.zeros((nq, k)), np.zeros((self.curves.width, k)))
        sweep = RadauSweep(self.system, self.steps, k)
        kept = sweep.kept() if self.curves else None
        sweep.backward(bars, given_by(given), kept)
        return bars.q, bars.v, bars.b if kept is None else bars.b + self.curves.gradient(kept)


def given_by(nodes: Nodes) -> Given:
    """What the sweeps take or give, of all nodes."""
    return Given(nodes.q, nodes.v, nodes.a, nodes.lam)
