"""The steps of a run of Radau IIA differentiated twice: the way along a direction, and the way back."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ..._jit.link import link
from ..._jit.vector import LANES
from ...algebra import Array
from . import radau_hessian_loop as loop
from .chain import Nodes
from .curved_steps import Back
from .lagrangian import lagrangian, room
from .radau_chain import RadauChain, given_by
from .radau_sweep import RadauSweep
from .radau_sweep_loop import Bars, Beside, Given, Turned


class RadauCurvedSteps:
    """See `CurvedSteps`."""

    def __init__(self, chain: RadauChain) -> None:
        self._system, self._steps = chain.system, chain.steps

    @cached_property
    def _sweep(self) -> RadauSweep:
        return RadauSweep(self._system, self._steps, 1)

    def along(self, b: Array, q: Array, v: Array, nodes: Nodes) -> Array:
        """See `CurvedSteps`; the changes of the unknowns of all steps (n, 6 (nq + m), 1)."""
        bars = Bars(*(np.array(x, dtype=float, order="C") for x in (q, v, b)))
        stages: Array = self._sweep.kept().step
        RadauSweep(self._system, self._steps, 1, b).forward(bars, given_by(nodes), stages=stages)
        return stages

    def back(self, nodes: Nodes, turned: Turned | None) -> Back:
        """See `CurvedSteps`."""
        size = self._system.nq
        bars = Bars(np.zeros((size, 1)), np.zeros((size, 1)), np.zeros((len(self._system.b), 1)))
        kept = self._sweep.kept()
        self._sweep.backward(bars, given_by(nodes), kept, turned)
        return Back(bars.q, bars.v, bars.b, kept)

    def turned(self, b_dot: Array, moved: Nodes, solved: Array, adjoint: Beside) -> tuple[Turned, Array]:
        """See `CurvedSteps`."""
        system, steps, record = self._system, self._steps, self._sweep.record
        flat = [
            adjoint.step.shape[:2],
            steps.v[1:].shape,
            adjoint.node.shape[:2],
            steps.q.shape,
            steps.v.shape,
        ]
        found = Turned._make(np.zeros(shape) for shape in flat)
        dots = Given._make(np.ascontiguousarray(getattr(moved, k)[:, :, 0]) for k in Given._fields)
        step, rate, motion = (lagrangian(system, kind) for kind in ("step", "rate", "motion"))
        work, head = room(system), (steps.b.copy(), b_dot.copy())
        own, by_stages = solved[:, :, 0], adjoint.step[:, :, 0]
        link(loop.of_stages)(
            steps.scheme, step, rate, *head, record, dots.v, own, by_stages, work, found.step, found.v
        )
        link(loop.of_nodes)(motion, *head, record, dots, adjoint.node[:, :, 0], work, found)
        by_b = work.by_b.reshape(-1, LANES).sum(axis=1)
        return Turned._make(x[:, :, None] for x in found), by_b
