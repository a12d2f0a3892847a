"""The chain of a run of Radau IIA differentiated: assembly, steps, and the accelerations of every node."""

from __future__ import annotations

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
    """The derivatives of one run that was simulated by Radau with ``keep_steps=True``; see `Chain`."""

    def __init__(self, system: System, steps: RadauSteps) -> None:
        self.system, self.steps = system, steps
        self.assembly = AssemblyDerivatives(system, steps.start)
        self.curves = RadauCurves(system, steps)

    def along(self, db: Array, dq: Array, dv: Array, dc: Array | None = None) -> Nodes:
        """The derivatives of all states for changes of the numbers and of the guess, (len(system.b), k), (nq, k)."""
        found, k = Nodes.zeros(self.steps, db.shape[1]), db.shape[1]
        q, v = (np.ascontiguousarray(x) for x in self.assembly.along(db, dq=dq, dv=dv))
        bars = Bars(q, v, np.ascontiguousarray(db, dtype=float))
        sources = self.curves.sources(db) if self.curves.moved_by(db) else None
        RadauSweep(self.system, self.steps, k, db).forward(bars, _given(found), sources)
        return found

    def gradients(self, given: Nodes) -> Gradients:
        """Gradients of responses whose gradients by the states are given."""
        k, nq = given.q.shape[2], self.system.nq
        bars = Bars(np.zeros((nq, k)), np.zeros((nq, k)), np.zeros((len(self.system.b), k)))
        sweep = RadauSweep(self.system, self.steps, k)
        kept = sweep.kept() if self.curves else None
        sweep.backward(bars, _given(given), kept)
        by_b = bars.b if kept is None else bars.b + self.curves.gradient(kept)
        b, q, v = through(self.assembly, bars.q, bars.v)
        return Gradients(by_b + b, q, v)


def _given(nodes: Nodes) -> Given:
    return Given(nodes.q, nodes.v, nodes.a, nodes.lam)
