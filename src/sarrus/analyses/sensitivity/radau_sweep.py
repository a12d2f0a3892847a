"""A run of Radau IIA differentiated step by step: forward with columns of derivatives, or backward with gradients."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..._jit.link import link
from ...algebra import Array
from ...results import RadauSteps
from ...system import System
from ...system.lane_room import aligned
from ..dynamics.newton_matrix import constraint_parts
from ..dynamics.placed import (
    LEFT_OUT,
    UNIT,
    Numbers,
    Part,
    entries_of,
    leave_out,
)
from ..linear import SingularMatrix
from . import radau_sweep_loop as loop
from .columns_loop import COLUMNS, ByRows
from .kernels import GROUPS, operators_by_b
from .row_order import by_rows, no_rows
from .stages_matrix import StagesMatrix
from .step_matrix import StepMatrix
from .sweep import TRUSTED

BY_NUMBERS = ("Phi_b", "Phi_qT_lam_b", "Phi_q_xi_b", "Phi_t_b", "M_a_b", "S_b", "Q_b", "gamma_b")
OPERATOR = {
    "Phi_qT_mu_q": "Phi_qT_lam_q",
    "Phi_q_a_q": "Phi_q_xi_q",
}  # what else an operator's numbers are called
NO_STAGES = np.zeros((0, 0, 0))
NOTHING_BESIDE = loop.Beside(NO_STAGES, NO_STAGES)
NOT_TURNED = loop.Turned._make(NO_STAGES for _ in loop.Turned._fields)


class RadauSweep:
    """The derivatives of the steps of one run.

    Parameters
    ----------
    system : System
    steps : kept by `simulate`
    columns : how many derivatives or responses are swept at once
    b_dot : (len(system.b), k) changes of the numbers, for `forward`
    """

    def __init__(self, system: System, steps: RadauSteps, columns: int, b_dot: Array | None = None) -> None:
        self.system, self.steps = system, steps
        self.b, self._columns = steps.b.copy(), columns
        self._groups = {name: system.group(*GROUPS[name]) for name in loop.Entries._fields}
        self._entries = loop.Entries._make(group.entry() for group in self._groups.values())
        self.record = _record(steps)
        nq, m = system.nq, system.m
        stages = [f"{name}@{i}" for i in range(3) for name in loop.Stage._fields]
        self._step_numbers = Numbers(system, (*stages, UNIT, LEFT_OUT), {n: _operator(n) for n in stages})
        own = {name: _operator(name) for name in loop.Node._fields}
        self._node_numbers = Numbers(system, (*own, UNIT, LEFT_OUT), own)
        self._step = StagesMatrix(self._step_numbers, nq, m)
        self._node = StepMatrix(self._node_numbers, nq + m, [Part("M", 0, 0), *constraint_parts(nq)])
        self._panels = b_dot is not None and columns > 1
        self._tables = self._make_tables(b_dot)

    def over(self, steps: RadauSteps) -> None:
        """Go on with other steps of the same run, those before."""
        self.steps, self.record = steps, _record(steps)
        for left_out in (self._tables.left_out, self._tables.node_left_out):
            left_out[:] = 0.0  # a record may tell of none

    def forward(
        self,
        bars: loop.Bars,
        given: loop.Given,
        sources: loop.Beside | None = None,
        stages: Array | None = None,
    ) -> None:
        """From the start to the end; the derivatives at all nodes are written.

        `sources` are changes of the equations besides those by the numbers of elements; `stages` takes those of the
        unknowns of all steps (n, 6 (nq + m), k).
        """
        room = NO_STAGES if stages is None else stages
        self._go(loop.forward, 0, loop.NODE, bars, given, sources or NOTHING_BESIDE, room)

    def backward(
        self,
        bars: loop.Bars,
        given: loop.Given,
        kept: loop.Beside | None = None,
        turned: loop.Turned | None = None,
    ) -> None:
        """From the end, whose gradients and those of all other nodes are given, to the start.

        `kept` takes what is solved for; `turned` is what the change of an adjoint takes besides.
        """
        last = len(self.steps)
        self._go(loop.backward, last, loop.NODE, bars, given, kept or NOTHING_BESIDE, turned or NOT_TURNED)

    def kept(self) -> loop.Beside:
        """Room for what is solved for in every step and at every node."""
        count, size, k = len(self.steps), self.system.nq + self.system.m, self._columns
        return loop.Beside(np.zeros((count, 6 * size, k)), np.zeros((count + 1, size, k)))

    def _go(self, sweep: Callable[..., Any], n: int, stage: int, *arrays: Any) -> None:
        """One sweep, begun with the pivots of a step in its midst: the first ones may be very short."""
        failed, place = 0, (len(self.steps) + 1) // 2
        while 0 <= n <= len(self.steps):
            if failed > 2:
                raise SingularMatrix(f"the equations at t = {self.steps.t[n]:.6g} s are singular")
            self._tables.trust.change = TRUSTED[min(failed, 1)]
            self._step.in_blocks = failed < 2
            self._choose_pivots(sweep is loop.forward, place, stage)
            before, (n, stage) = (n, stage), (int(x) for x in self._run(sweep, n, stage, *arrays))
            failed, place = (failed + 1 if (n, stage) == before else 0), n

    def _run(self, sweep: Callable[..., Any], n: int, stage: int, *arrays: Any) -> Any:
        scheme = self.steps.scheme
        return link(sweep)(scheme, self._entries, self.b, self.record, n, stage, self._tables, *arrays)

    def _choose_pivots(self, forward: bool, n: int, stage: int) -> None:
        """Pivot orders for the matrices that are factored next."""
        step = min(n if forward else max(n - 1, 0), len(self.steps) - 1)
        tables, scheme = self._tables, self.steps.scheme
        loop.remember(self.record, step, tables, self.b)
        h, record = float(self.steps.h[step]), self.record
        for i in range(3):
            t = float(self.steps.t[step] + scheme.c[i] * h)
            stages = {k: getattr(record, f"stage_{k}")[step, i] for k in ("q", "v", "a", "lam", "mu")}
            self._evaluate(tables.stages[i], {"t": t, **stages})
        at = {k: np.ascontiguousarray(getattr(self.steps, k)[n]) for k in ("q", "v", "a", "lam")}
        self._evaluate(tables.at_node, {"t": float(self.steps.t[n]), **at})
        self._step.weigh(scheme, h)
        whole, small = self._step.in_panels(), self._node.in_panels()
        self._tables = tables._replace(step=whole, node=small)
        if self._panels:
            self._tables = self._tables._replace(step_by_rows=by_rows(whole), node_by_rows=by_rows(small))

    def _evaluate(self, views: Any, operands: dict[str, Any]) -> None:
        for kind in ("jacobian", "inertia", "stiffness", "gamma_v"):
            group = self._groups[kind]
            out = (getattr(views, name) for name in group.names)
            group.run(self.b, *(operands[k] for k in group.operands), *out)
        if hasattr(views, "Phi_qT_mu_q"):
            group, again = self._groups["jacobian"], self._tables.Phi_q_again
            operands = operands | {"lam": operands["mu"]}
            group.run(self.b, *(operands[k] for k in group.operands), again, views.Phi_qT_mu_q)
        leave_out(views.Phi_q, self._tables.places.Phi_q[0], self._tables.left_out)

    def _make_tables(self, b_dot: Array | None) -> loop.Tables:
        nq, m, k, system = self.system.nq, self.system.m, self._columns, self.system
        step, node = self._step_numbers, self._node_numbers
        stages = tuple(
            loop.Stage._make(step.views[f"{name}@{i}"] for name in loop.Stage._fields) for i in range(3)
        )
        places = loop.Node._make(np.array(entries_of(system, _operator(name))) for name in loop.Node._fields)
        numbers, by_b = _numbers(system, b_dot)
        width = COLUMNS if self._panels else k
        room = []
        for n in (6 * (nq + m), nq + m):
            solving = (3, n, k) if b_dot is None else (4, n * width)
            room += [aligned(n, k), aligned(n, k), aligned(*solving)]
        views = (step.left_out, node.left_out, np.zeros_like(stages[0].Phi_q), loop.Trust.zeros())
        at_node = loop.Node._make(node.views[name] for name in loop.Node._fields)
        return loop.Tables._make(
            (
                None,
                step.values,
                None,
                node.values,
                stages,
                at_node,
                places,
                numbers,
                by_b,
                *views,
                *room,
                *[ByRows(no_rows(), no_rows())] * 2,
            )
        )


def _operator(name: str) -> str:
    base = name.partition("@")[0]
    return OPERATOR.get(base, base)


def _numbers(system: System, b_dot: Array | None) -> tuple[loop.Numbers, loop.ByNumbers]:
    """The operators by b; `b_dot`: those numbers only that change."""
    found = operators_by_b(system, BY_NUMBERS, b_dot)
    parts = (found.values[start:end] for start, end in found.cuts)
    return loop.Numbers(found.values, *found[2:]), loop.ByNumbers._make(parts)


def _record(steps: RadauSteps) -> loop.Record:
    """The steps as contiguous arrays of floats, with the accelerations of the stages."""
    moved = steps.stage_v - steps.v[:-1, None]
    stage_a = np.einsum("ij,njk->nik", steps.scheme.inverse, moved) / steps.h[:, None, None]
    fields = {name: getattr(steps, name) for name in loop.Record._fields if name != "stage_a"}
    fields |= {"stage_a": stage_a, "left_out": steps.left_out.astype(float)}
    return loop.Record(**{name: np.ascontiguousarray(value) for name, value in fields.items()})
