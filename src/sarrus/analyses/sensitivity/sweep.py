"""A run differentiated step by step: forward with columns of derivatives, or backward with gradients of responses."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from ..._jit.driver import compiled_function
from ..._jit.pointer import run
from ...algebra import Array
from ...results import Steps
from ...system import System
from ..dynamics import alpha_loop
from ..dynamics.newton_matrix import NUMBERS, newton_matrix, weigh
from ..dynamics.placed import compiled_solver, entries_of
from . import sweep_loop as loop

GROUPS: dict[
    str, tuple[tuple[str, ...], int, int]
] = {  # operators; scalars and arrays that their driver takes
    "velocity": (("Phi_q_xi", "Phi_t"), 1, 4),
    "jacobian": (("Phi_q", "Phi_qT_lam_q"), 1, 4),
    "inertia": (("M", "M_a_q", "S_q", "S_v"), 0, 7),
    "stiffness": (("Q_q", "Q_v"), 1, 4),
    "gamma_v": (("gamma_v",), 1, 3),
    "Phi_b": (("Phi_b",), 1, 2),
    "Phi_qT_lam_b": (("Phi_qT_lam_b",), 1, 3),
    "Phi_q_xi_b": (("Phi_q_xi_b",), 1, 3),
    "Phi_t_b": (("Phi_t_b",), 1, 2),
    "M_a_b": (("M_a_b",), 0, 3),
    "S_b": (("S_b",), 0, 3),
    "Q_b": (("Q_b",), 1, 3),
}
BY_NUMBERS = list(GROUPS)[5:]
FUNCTIONS = ("times", "times_transposed", "by_numbers", "solve_columns", "solve_columns_transposed", "add_gradients",
             "remember", "linearize", "defect_change", "forward_step", "backward_step", "forward_rescale",
             "backward_rescale", "forward", "backward")  # fmt: skip
NOTHING_KEPT = loop.Kept(np.zeros((0, 0, 0)), np.zeros((0, 0, 0)), np.zeros((0, 0)))
NOTHING_MOVED = loop.Sources._make(np.zeros((0, 0, 0)) for _ in loop.Sources._fields)
NO_SOURCES = loop.Sources._make(np.zeros((0, 0)) for _ in loop.Sources._fields)


@cache
def _compiled() -> dict[str, Any]:
    """The loops: the same code for every system; drivers are called by their address."""
    known: dict[str, Any] = {name.upper(): run(*counts) for name, (_, *counts) in GROUPS.items()}
    known |= compiled_solver() | {"weigh": compiled_function(weigh)}
    for name in ("evaluate", "factor", "weights_of"):
        known[name] = compiled_function(getattr(alpha_loop, name), **known)
    for name in FUNCTIONS:
        known[name] = compiled_function(getattr(loop, name), **known)
    return known


class Sweep:
    """The derivatives of the steps of one run.

    Parameters
    ----------
    system : System
    steps : kept by `simulate`
    b_dot : (len(system.b), k) changes of the numbers, for `forward`
    columns : how many derivatives or responses are swept at once
    """

    def __init__(self, system: System, steps: Steps, columns: int, b_dot: Array | None = None) -> None:
        self.system, self.steps, self.columns = system, steps, columns
        self.b = steps.b.copy()
        self._matrix = newton_matrix(system)
        self._numbers = self._matrix.numbers
        self._groups = {name: system.group(*operators) for name, (operators, *_) in GROUPS.items()}
        self._entries = loop.Entries._make(group.entry() for group in self._groups.values())
        self._record = _record(steps)
        self._blocks, self._views = self._make_blocks(b_dot)
        self._work = self._make_work()

    def _make_blocks(self, b_dot: Array | None) -> tuple[loop.Blocks, loop.Views]:
        rows, columns, segments = _flat([entries_of(self.system, name) for name in NUMBERS])
        b_rows, b_columns, cuts = _flat([entries_of(self.system, name) for name in BY_NUMBERS])
        values = np.zeros(len(b_rows))
        used = np.ones(len(self.system.b), dtype=bool) if b_dot is None else np.any(b_dot != 0, axis=1)
        chosen = np.flatnonzero(used[b_columns])
        turned = entries_of(self.system, "gamma_v")
        blocks = loop.Blocks(
            self._numbers.values, rows, columns, segments, values, b_rows, b_columns,
            np.searchsorted(chosen, cuts), chosen, np.zeros(len(turned[0])), *turned,
        )  # fmt: skip
        own = [self._numbers.views[name] for name in NUMBERS]
        return blocks, loop.Views._make([*own, *(values[start:end] for start, end in cuts)])

    def _make_work(self) -> loop.Work:
        nq, m, k = self.system.nq, self.system.m, self.columns
        wide = [np.zeros((nq + m, k)) for _ in range(3)] + [np.zeros((nq, k)) for _ in range(3)]
        vectors = [np.zeros(length) for length in (nq, m, m, m)]
        return loop.Work._make([*wide, *vectors, np.zeros((3, nq + m, 1))])

    def bars(self, b: Array | None = None) -> loop.Bars:
        """Room for derivatives of a state and of the numbers, all zero (or by the numbers, as given)."""
        nq, m, k = self.system.nq, self.system.m, self.columns
        by_b = np.zeros((len(self.system.b), k)) if b is None else np.ascontiguousarray(b, dtype=float)
        return loop.Bars._make([*(np.zeros((nq, k)) for _ in range(4)), np.zeros((m, k)), by_b])

    def given(self, count: int) -> loop.Given:
        """Room for derivatives at the ends of steps."""
        nq, m, k = self.system.nq, self.system.m, self.columns
        return loop.Given._make(np.zeros((count, width, k)) for width in (nq, nq, nq, m))

    def kept(self) -> loop.Kept:
        """Room for what is solved for in every step."""
        count, size = len(self.steps), self.system.nq + self.system.m
        wide = (np.zeros((count, size, self.columns)) for _ in range(2))
        return loop.Kept._make([*wide, np.zeros((count, size))])

    def backward(
        self,
        bars: loop.Bars,
        given: loop.Given,
        first: int,
        last: int,
        kept: loop.Kept | None = None,
        sources: loop.Sources | None = None,
    ) -> None:
        """From the ends of the steps first:last, whose gradients are given, to the start of the first, in place."""
        n, stage = last - 1, loop.GRADIENTS
        while n >= first:
            self._choose_pivots(n, stage)
            n, stage = self._run(
                "backward", n, first, stage, bars, given, kept or NOTHING_KEPT, sources or NO_SOURCES
            )

    def forward(
        self,
        bars: loop.Bars,
        given: loop.Given,
        first: int,
        last: int,
        kept: loop.Kept | None = None,
        sources: loop.Sources | None = None,
    ) -> None:
        """From the start of step `first` through the steps first:last; derivatives at their ends are written.

        `sources` are changes of the residuals (n, nq + m, k) besides those by the numbers of elements.
        """
        n, stage = first, loop.RESCALE
        while n < last:
            self._choose_pivots(n, stage)
            n, stage = self._run(
                "forward", n, last, stage, bars, given, kept or NOTHING_KEPT, sources or NOTHING_MOVED
            )

    def _run(self, name: str, n: int, to: int, stage: int, *arrays: Any) -> tuple[int, int]:
        found = _compiled()[name](
            self.steps.scheme, self._entries, self.b, self._record, n, to, stage, self._shown, self._blocks,
            self._views, self._work, *arrays,
        )  # fmt: skip
        return int(found[0]), int(found[1])

    def _choose_pivots(self, n: int, stage: int) -> None:
        """A pivot order for the matrix that is factored next."""
        steps, views = self.steps, self._views
        if stage == loop.RESCALE and steps.removed[n] == 0.0:
            stage = loop.STEP
        at = n if stage == loop.RESCALE else n + 1
        loop.remember(self._record, n, views, self.b)
        operands = {"t": float(steps.t[at])} | {k: getattr(steps, k)[at] for k in ("q", "v", "a", "lam")}
        for kind in ("jacobian", "inertia", "stiffness"):
            self._numbers.evaluate(GROUPS[kind][0], self.b, operands)
        h = 0.0 if stage == loop.RESCALE else float(steps.h[n])
        weigh(self._matrix.weights, *alpha_loop.weights_of(steps.scheme, h))
        self._matrix.choose_pivots()
        self._shown = alpha_loop.matrix_of(self._matrix)


def _flat(parts: list[tuple[Array, Array]]) -> tuple[Array, Array, Array]:
    """Rows and columns of several operators one after another, and where each begins and ends."""
    ends = np.cumsum([0, *(len(rows) for rows, _ in parts)])
    rows, columns = (np.concatenate([part[k] for part in parts]) for k in (0, 1))
    return rows, columns, np.column_stack([ends[:-1], ends[1:]])


def _record(steps: Steps) -> loop.Record:
    """The steps as contiguous arrays of floats."""
    fields = {name: getattr(steps, name) for name in loop.Record._fields}
    fields["left_out"] = steps.left_out.astype(float)
    return loop.Record(**fields)
