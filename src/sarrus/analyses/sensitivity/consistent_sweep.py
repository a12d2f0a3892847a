"""Consistent states differentiated, one after another: forward along a direction, or backward with gradients."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..._jit.link import link
from ..._jit.vector import LANES
from ...algebra import Array
from ...linalg.sparse_solver import SingularMatrix
from ...system import System
from ...system.lane_room import aligned, room
from ..dynamics.methods.equations import OPERATOR
from ..dynamics.newton_matrix import motion_parts
from ..equations.block_matrix import LEFT_OUT, Numbers, Part, entries_of
from . import consistent_loop as loop
from . import node_loop
from .columns_loop import ByRows
from .kernels import GROUPS, operators_by_b
from .lagrangian import lagrangian
from .row_order import no_rows
from .step_matrix import StepMatrix
from .steps.sweep import TRUSTED

BY_NUMBERS = ("Phi_b", "Phi_qT_lam_b", "Phi_q_xi_b", "Phi_t_b", "M_a_b", "S_b", "Q_b", "gamma_b")
NOTHING = np.zeros((0, 0, 0))
UNTURNED = loop.Turned._make(NOTHING for _ in loop.Turned._fields)
NO_SOURCES = loop.Solved._make(NOTHING for _ in loop.Solved._fields)
OPERATORS = {"Phi_q0": "Phi_q", "M_dq_q": "M_a_q", "M_dv_q": "M_a_q", "sigma_q": "Phi_qT_lam_q",
             "rho_q": "Phi_qT_lam_q", "again": "Phi_qT_lam_q"}  # fmt: skip


class ConsistentSweep:
    """The derivatives of some consistent states, which do not depend on each other; one column.

    Parameters
    ----------
    system : System
    b : the numbers of the elements
    record : the states; σ and ρ are written into it
    """

    def __init__(self, system: System, b: Array, record: loop.Record) -> None:
        self.system, self.record, self.b = system, record, b.copy()
        nq, m = system.nq, system.m
        names = [name for name in node_loop.Node._fields if name not in ("M", "Phi_q")]
        self._node_numbers = Numbers(system, ("M", LEFT_OUT, "Phi_q"))
        self._numbers = Numbers(system, ("M", LEFT_OUT, "Phi_q", "Phi_q0"), {"Phi_q0": "Phi_q"})
        parts = [Part("M", 0, 0), Part(LEFT_OUT, nq, nq), Part("Phi_q", nq, 0)]
        self._projection = StepMatrix(self._numbers, nq + m, [*parts, Part("Phi_q0", 0, nq, transposed=True)])
        self._node = StepMatrix(self._node_numbers, nq + m, motion_parts(nq))
        self._entries = node_loop.Entries._make(
            system.group(*GROUPS[n]).entry() for n in node_loop.Entries._fields
        )
        at_node = {name: self._room(OPERATOR.get(name, name)) for name in names} | self._node_numbers.views
        at_both = {name: self._room(OPERATORS.get(name, name)) for name in loop.Projection._fields}
        at_both |= self._numbers.views
        places = [np.array(entries_of(system, OPERATOR.get(n, n))) for n in node_loop.Node._fields]
        found = operators_by_b(system, BY_NUMBERS, None)
        by_b = node_loop.ByNumbers._make(found.values[start:end] for start, end in found.cuts)
        vectors = [aligned(nq + m, 1) for _ in range(2)]
        self._tables = loop.Tables._make([
            None, self._node_numbers.values, self._node_numbers.left_out, ByRows(no_rows(), no_rows()),
            None, self._numbers.values, self._numbers.left_out,
            node_loop.Node._make(at_node[name] for name in node_loop.Node._fields),
            loop.Projection._make(at_both[name] for name in loop.Projection._fields),
            node_loop.Node._make(places), node_loop.Numbers(found.values, *found[2:]), by_b, node_loop.Trust.zeros(),
            *vectors, aligned(4, nq + m), *(aligned(nq + m, 1) for _ in range(2)), aligned(nq, 1),
        ])  # fmt: skip
        self._go(loop.find_multipliers, False)

    def _room(self, operator: str) -> Array:
        return np.zeros(len(entries_of(self.system, operator)[0]))

    def states(self) -> node_loop.Given:
        """Room for changes of states, or gradients by them."""
        count, nq, m = len(self.record.t), self.system.nq, self.system.m
        return node_loop.Given._make(np.zeros((count, width, 1)) for width in (nq, nq, nq, m))

    def solved(self) -> loop.Solved:
        """Room for what is solved for."""
        shape = len(self.record.t), self.system.nq + self.system.m, 1
        return loop.Solved._make(np.zeros(shape) for _ in loop.Solved._fields)

    def forward(
        self, given: node_loop.Given, b_dot: Array, sources: loop.Solved | None = None
    ) -> tuple[node_loop.Given, loop.Solved]:
        """The changes of the consistent states for those of q₀, v₀ and the numbers; what was solved for."""
        found, solved = self.states(), self.solved()
        self._go(loop.forward, True, self._bars(b_dot), given, found, sources or NO_SOURCES, solved)
        return found, solved

    def backward(
        self, given: node_loop.Given, kept: loop.Solved | None = None, turned: loop.Turned | None = None
    ) -> tuple[node_loop.Given, Array]:
        """Gradients by q₀ and v₀ of those by consistent states, and by the numbers (len(b), 1); see `loop.Turned`."""
        bars, found = self._bars(np.zeros((len(self.b), 1))), self.states()
        self._go(loop.backward, True, bars, given, found, kept or NO_SOURCES, turned or UNTURNED)
        return found, bars.b

    def _bars(self, b: Array) -> node_loop.Bars:
        nq = self.system.nq
        return node_loop.Bars(np.zeros((nq, 1)), np.zeros((nq, 1)), np.array(b, dtype=float, order="C"))

    def _go(self, sweep: Callable[..., Any], staged: bool, *arrays: Any) -> None:
        """Through all states, with other pivots where they do not fit."""
        n, stage, tried, count = 0, loop.NODE, 0, len(self.record.t)
        size = self.system.nq + self.system.m
        arranged = aligned(3, size, 1) if sweep is loop.backward else aligned(4, size)
        self._tables = self._tables._replace(node_arranged=arranged)
        while n < count and self.record.defined.any():
            if tried > len(TRUSTED):
                raise SingularMatrix(f"the equations at t = {self.record.t[n]:.6g} s are singular")
            if tried or self._tables.node is None:
                self._choose_pivots(n)
            self._tables.trust.change = TRUSTED[max(tried - 1, 0)]
            head = self._entries, self.b, self.record, n, *([stage] if staged else [])
            found, before = link(sweep)(*head, self._tables, *arrays), (n, stage)
            n, stage = (int(found[0]), int(found[1])) if staged else (int(found), stage)
            tried = tried + 1 if (n, stage) == before else 1

    def _choose_pivots(self, n: int) -> None:
        """Pivot orders for both matrices at the first state from n on that has equations."""
        record = self.record
        n += int(np.argmax(record.defined[n:] > 0.0))
        loop.remember_state(record, n, self._tables, self.b)
        before, now = ({"t": float(record.t[n]), "q": q[n]} for q in (record.q0, record.q))
        for numbers, at in ((self._numbers, before), (self._node_numbers, now)):
            for name in ("M", "Phi_q"):
                numbers.evaluate((name,), self.b, at)
        self._numbers.views["Phi_q0"][:] = self._numbers.views["Phi_q"]
        self._numbers.evaluate(("Phi_q",), self.b, now)
        if record.defined[n] > 0.0:
            node, projection = self._node.in_panels(), self._projection.in_panels()
            self._tables = self._tables._replace(node=node, projection=projection)

    def changes(self, kind: str, b_dot: Array, **given: Array) -> tuple[loop.Changes, Array]:
        """The changes of the gradients of ℓ (`shares`) at all states; those by the numbers (len(b),).

        `given` are operands (nt, …); those that are not are zero.
        """
        record, system = self.record, self.system
        count, none = len(record.t), np.zeros((len(record.t), max(system.nq, system.m)))
        widths = {"lam": system.m, "nu": system.m, "lam_dot": system.m}
        operands = {"t": record.t} | {name: none[:, : widths.get(name, system.nq)] for name in
                    loop.Operands._fields[1:]} | given  # fmt: skip
        x = loop.Operands._make(np.ascontiguousarray(operands[name]) for name in loop.Operands._fields)
        nq, m = system.nq, system.m
        found = loop.Changes._make(np.zeros((count, width)) for width in (nq, nq, nq, m))
        sizes = {"t": 1, "lam": m, "nu": m, "lam_dot": m, "by_lam": m, "by_b": len(system.b)}
        work = loop.Room._make(room(sizes.get(name, nq)) for name in loop.Room._fields)
        many = 1 if len(record.places) else LANES
        b, dots = self.b.copy(), np.array(b_dot, dtype=float)
        link(loop.of_states)(lagrangian(system, kind), b, dots, record, many, x, work, found)
        return found._replace(lam=found.lam * (1.0 - record.left_out)), work.by_b.reshape(-1, LANES).sum(
            axis=1
        )
