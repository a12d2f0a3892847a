"""The steps of a run of HHT or generalized-α differentiated twice: the way along a direction, and the way back.

A step backwards whose adjoint changes has the contracted second derivatives of its equations as sources.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple, Protocol

import numpy as np

from ..._jit.link import link
from ..._jit.vector import LANES
from ...algebra import Array
from ...results import StepsTaken
from ...system.lane_room import aligned
from . import hessian_loop
from .chain import Chain, Nodes
from .lagrangian import Change, change_at, lagrangian, room
from .sweep import Sweep
from .sweep_loop import Given, Kept, Sources


class Back(NamedTuple):
    """The way back through all steps: gradients by the first state and by the numbers, and what was solved for."""

    q: Array
    v: Array
    b: Array
    solved: Any


class CurvedSteps(Protocol):
    """The steps of one run, differentiated twice."""

    def along(self, b: Array, q: Array, v: Array, nodes: Nodes) -> Any:
        """Write the changes of all nodes, with those of the numbers and of the first state; what was solved for."""

    def back(self, nodes: Nodes, turned: Any | None) -> Back:
        """Back through all steps, with the changes of their equations where an adjoint changes."""

    def turned(self, b_dot: Array, moved: Nodes, solved: Any, adjoint: Any) -> tuple[Any, Array]:
        """The changes of the equations of all steps, and what they add to the gradient by the numbers.

        With the changes of the numbers and of the nodes, and with what was solved for along them and on the way back.
        """


class Solved(NamedTuple):
    """What was solved for in the steps, and at the start."""

    kept: Kept
    start: tuple[Array, Array]


class Turned(NamedTuple):
    """The changes of the equations of all steps, and of the start."""

    sources: Sources
    start: Change


class AlphaCurvedSteps:
    """See `CurvedSteps`."""

    def __init__(self, chain: Chain) -> None:
        self._chain, self._system, self._steps = chain, chain.system, chain.steps

    @cached_property
    def _sweep(self) -> Sweep:
        return Sweep(self._system, self._steps, 1)

    def along(self, b: Array, q: Array, v: Array, nodes: Nodes) -> Kept:
        """See `CurvedSteps`."""
        sweep, start = Sweep(self._system, self._steps, 1, b), self._chain.start
        bars, kept = sweep.bars(b), sweep.kept()
        bars.q[:], bars.v[:] = q, v
        bars.a[:], bars.lam[:] = start.along(bars.q, bars.v, b)
        bars.x[:] = bars.a
        nodes.q[0], nodes.v[0], nodes.a[0], nodes.lam[0] = bars.q, bars.v, bars.a, bars.lam
        sweep.forward(bars, nodes.after_start(), 0, len(self._steps), kept)
        return kept

    def back(self, nodes: Nodes, turned: Turned | None) -> Back:
        """See `CurvedSteps`."""
        sweep, start = self._sweep, self._chain.start
        bars, kept = sweep.bars(), sweep.kept()
        sources = turned.sources if turned else None
        sweep.backward(bars, nodes.after_start(), 0, len(self._steps), kept, sources)
        a_bar, lam_bar = bars.a + bars.x + nodes.a[0], nodes.lam[0].copy()
        q_bar, v_bar, b_bar = bars.q + nodes.q[0], bars.v + nodes.v[0], bars.b
        if turned:
            change = turned.start
            a_bar, lam_bar = a_bar - change.a[:, None], lam_bar - change.lam[:, None]
            q_bar, v_bar = q_bar - change.q[:, None], v_bar - change.v[:, None]
        solved = start.adjoint(a_bar, lam_bar)
        by_q, by_v, by_b = start.transposed(*solved)
        return Back(q_bar + by_q, v_bar + by_v, b_bar + by_b, Solved(kept, solved))

    def turned(self, b_dot: Array, moved: Nodes, solved: Kept, adjoint: Solved) -> tuple[Turned, Array]:
        """See `CurvedSteps`."""
        steps, nq, m = self._steps, self._system.nq, self._system.m
        widths = (nq + m, nq, nq) * 2
        sources = Sources._make(aligned(len(steps), width) for width in widths)
        dots = Given._make(np.ascontiguousarray(getattr(moved, k)[:, :, 0]) for k in Given._fields)
        operands = (np.ascontiguousarray(x[:, :, 0]) for x in adjoint.kept[:2])
        own = Kept._make([*operands, adjoint.kept.s])
        changed = np.ascontiguousarray(solved.rescale[:, :, 0])
        work, head, record = room(self._system), (steps.b.copy(), b_dot.copy()), self._sweep.record
        entries = [lagrangian(self._system, kind) for kind in ("step", "rate")]
        link(hessian_loop.of_steps)(steps.scheme, entries[0], *head, record, dots, own, work, sources)
        link(hessian_loop.of_rescales)(entries[1], *head, record, dots, own, changed, work, sources)
        start = self._start(b_dot, moved, adjoint.start)
        return Turned(sources, start), work.by_b.reshape(-1, LANES).sum(axis=1) + start.b

    def _start(self, b_dot: Array, moved: Nodes, adjoint: tuple[Array, Array]) -> Change:
        """The changes of the equations of motion at the start."""
        steps, (y, z) = self._steps, (x[:, 0] for x in adjoint)
        dots = {f"{name}_dot": getattr(moved, name)[0, :, 0] for name in ("q", "v", "a")}
        return change_at(
            self._system, "motion", float(steps.t[0]), remembered(steps, 0), b_dot, steps.lam[0], z,
            moved.lam[0, :, 0], q=steps.q[0], v=steps.v[0], a=steps.a[0], xi=y, **dots,
        )  # fmt: skip


def remembered(steps: StepsTaken, n: int) -> Array:
    """The numbers of the elements, with what they remembered during a step."""
    b = steps.b.copy()
    b[steps.places] = steps.memory[n]
    return b
