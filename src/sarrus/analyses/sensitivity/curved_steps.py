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
from .curve_lagrangian import CurveLagrangian
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
    """The changes of the Lagrangians of all operations, and of the start; those of the gradient by the numbers."""

    sources: PerOperation
    start: Change
    b: Array


class CurvedSteps:
    """The steps of one run, differentiated twice.

    Parameters
    ----------
    chain : of the run
    curves : second derivatives by parameters of curves that change, and by the time at which it begins
    """

    def __init__(self, chain: Chain, curves: CurveLagrangian) -> None:
        self._chain, self._system, self._steps, self._curves = chain, chain.system, chain.steps, curves

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
        chain, sweep = self._chain, self._sweep
        back = BackwardState(chain.curves.width, 1)
        back.state, solved = sweep.state(), sweep.unknowns()
        by_b = sweep.backward(back.state, nodes.after_start(), 0, solved, turned.sources if turned else None)
        back.b[: len(by_b)] += by_b
        if self._curves:
            back.b += chain.curves.gradient(solved)
        back.sweep = sweep
        first = back.by_first(nodes)
        if turned:
            for name in ("q", "v", "a", "lam"):
                first[name] = first[name] - getattr(turned.start, name)[:, None]
        of_start = chain.start.adjoint(first["a"], first["lam"])
        by_q, by_v, by_b = chain.start.transposed(*of_start)
        found = Back(first["q"] + by_q, first["v"] + by_v, back.b + by_b, Solved(solved, of_start))
        return found._replace(b=found.b - turned.b[:, None]) if turned else found

    def turned(self, b_dot: Array, moved: Nodes, stages: PerOperation, adjoint: Solved) -> Turned:
        """The changes of the equations of all steps.

        With the changes of the numbers, of the nodes and of the stages, and the adjoint variables.
        """
        system, record, size = self._system, self._chain.record, len(self._system.b)
        structures = [one.tables.structure for one in record.operations if len(one)]
        entries = [lagrangian(system, kind) for kind in kinds_of(structures, system)]
        ends = np.cumsum([0, *(len(entry.addresses) for entry in entries)]).astype(np.int64)
        sizes = {"lam_dot": system.m, "nu": system.m, "by_lam": system.m, "by_b": size}
        work = loop.Operands._make(room(sizes.get(name, system.nq)) for name in loop.Operands._fields)
        blocks, found = Blocks(record, 0, None), self._sweep.stages()
        link(loop.change)(
            blocks.layout, joined(entries), ends, self._steps.b.copy(), b_dot[:size].copy(), run_of(record, 0),
            stages.series, adjoint.operations.series, blocks.block, work, found.series,
        )  # fmt: skip
        start, by_b = self._start(b_dot, moved, adjoint.start), np.zeros(len(b_dot))
        by_b[:size] = work.by_b.reshape(-1, LANES).sum(axis=1) + start.b
        by_b[size:] += start.t
        for n in [n for n, one in enumerate(record.operations) if self._curves and len(one)]:
            self._add_curves(
                n, b_dot, stages.parts[n][:, :, 0], adjoint.operations.parts[n][:, :, 0], found, by_b
            )
        return Turned(found, start, by_b)

    def _add_curves(
        self, n: int, b_dot: Array, stages: Array, mu: Array, found: PerOperation, by_b: Array
    ) -> None:
        """Add what parameters of curves and the time do in all occurrences of an operation."""
        record, system, size = self._chain.record, self._system, len(self._system.b)
        one = record.operations[n]
        sizes, t_dot = {"lam": system.m}, np.full(len(one), b_dot[size:].sum())
        for group in one.tables.groups:
            s, kind = group.stage, group.kind
            names = {"q": "q", "v": "v", "a": kind.acceleration or "", "lam": kind.multipliers}
            given = {x: one.sources[s, of].all(len(one)) for x, of in names.items() if (s, of) in one.sources}
            at = {x: one.tables.stages[s, of] for x, of in names.items() if (s, of) in one.tables.stages}
            rows = {x: slice(first, first + sizes.get(x, system.nq)) for x, first in at.items()}
            given |= {f"{x}_dot": stages[:, own] for x, own in rows.items()}
            if group.xi >= 0:
                given["xi"] = mu[:, group.xi : group.xi + system.nq] * one.scales[:, group.xi_equation, None]
            if group.nu >= 0:
                scale = kind.sign * one.scales[:, group.nu_equation, None]
                given["nu"] = mu[:, group.nu : group.nu + system.m] * scale
            given |= {"t": one.times[:, s], "t_dot": t_dot}
            added = self._curves.change(kind.kind, self._steps.b, b_dot[:size], record.memory(one), **given)
            for x, own in rows.items():
                found.parts[n][:, own, 0] += getattr(added, x)
            by_b[:size] += added.b
            by_b[size:] += added.t.sum()

    def _start(self, b_dot: Array, moved: Nodes, adjoint: tuple[Array, Array]) -> Change:
        """The changes of the equations of motion at the start."""
        steps, (y, z), size = self._steps, (x[:, 0] for x in adjoint), len(self._system.b)
        dots = {f"{name}_dot": getattr(moved, name)[0, :, 0] for name in ("q", "v", "a")}
        return change_at(
            self._system, "motion", float(steps.t[0]), remembered(steps, 0), b_dot[:size], steps.lam[0], z,
            moved.lam[0, :, 0], self._curves, float(b_dot[size:].sum()), q=steps.q[0], v=steps.v[0], a=steps.a[0],
            xi=y, **dots,
        )  # fmt: skip


def remembered(steps: StepsTaken, n: int) -> Array:
    """The numbers of the elements, with what they remembered during a step."""
    b = steps.b.copy()
    b[steps.places] = steps.memory[n]
    return b
