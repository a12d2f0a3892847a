"""The steps of a run differentiated twice: the way along a direction, and the way back.

A step backwards whose adjoint changes has the contracted second derivatives of its equations as sources.
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..._jit.link import link
from ..._jit.vector import LANES
from ...algebra import Array
from ...results import StepsTaken
from ...system.lane_room import room
from .chain import BackwardState, Chain, Nodes
from .lagrangian import Change, change_at, lagrangian
from .steps import second_order_loop as loop
from .steps.blocks import Blocks, run_of
from .steps.changes import joined
from .steps.layout import kinds_of
from .steps.sweep import PerOperation, Sweep


class Solved(NamedTuple):
    """The adjoint variables of all operations, and of the start."""

    operations: PerOperation
    start: tuple[Array, Array]


class Back(NamedTuple):
    """The way back through all steps: gradients by the first state and by the numbers, and what was solved for."""

    q: Array
    v: Array
    b: Array
    solved: Solved


class Turned(NamedTuple):
    """The changes of the Lagrangians of all operations, and of the start."""

    sources: PerOperation
    start: Change


class CurvedSteps:
    """The steps of one run, differentiated twice."""

    def __init__(self, chain: Chain) -> None:
        self._chain, self._system, self._steps = chain, chain.system, chain.steps

    @cached_property
    def _sweep(self) -> Sweep:
        return Sweep(self._chain.record, 1)

    def along(self, b: Array, q: Array, v: Array, nodes: Nodes) -> PerOperation:
        """Write the changes of all nodes, with those of the numbers and of the first state; those of all stages."""
        stages = self._sweep.stages()
        self._chain.swept(q, v, b, nodes, stages)
        return stages

    def back(self, nodes: Nodes, turned: Turned | None) -> Back:
        """Back through all steps, with the changes of their equations where an adjoint changes."""
        back, sweep, start = BackwardState(len(self._system.b), 1), self._sweep, self._chain.start
        back.state, solved = sweep.state(), sweep.unknowns()
        by_b = sweep.backward(back.state, nodes.after_start(), 0, solved, turned.sources if turned else None)
        back.b[: len(by_b)] += by_b
        back.sweep = sweep
        first = back.by_first(nodes)
        if turned:
            for name in ("q", "v", "a", "lam"):
                first[name] = first[name] - getattr(turned.start, name)[:, None]
        of_start = start.adjoint(first["a"], first["lam"])
        by_q, by_v, by_b = start.transposed(*of_start)
        return Back(first["q"] + by_q, first["v"] + by_v, back.b + by_b, Solved(solved, of_start))

    def turned(
        self, b_dot: Array, moved: Nodes, stages: PerOperation, adjoint: Solved
    ) -> tuple[Turned, Array]:
        """The changes of the equations of all steps, and what they add to the gradient by the numbers.

        With the changes of the numbers, of the nodes and of the stages, and the adjoint variables.
        """
        system, record = self._system, self._chain.record
        structures = [one.tables.structure for one in record.operations if len(one)]
        entries = [lagrangian(system, kind) for kind in kinds_of(structures, system)]
        ends = np.cumsum([0, *(len(entry.addresses) for entry in entries)]).astype(np.int64)
        sizes = {"lam_dot": system.m, "nu": system.m, "by_lam": system.m, "by_b": len(system.b)}
        work = loop.Operands._make(room(sizes.get(name, system.nq)) for name in loop.Operands._fields)
        blocks, found = Blocks(record, 0, None), self._sweep.stages()
        link(loop.change)(
            blocks.layout, joined(entries), ends, self._steps.b.copy(), b_dot.copy(), run_of(record, 0), stages.series,
            adjoint.operations.series, blocks.block, work, found.series,
        )  # fmt: skip
        start = self._start(b_dot, moved, adjoint.start)
        return Turned(found, start), work.by_b.reshape(-1, LANES).sum(axis=1) + start.b

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
