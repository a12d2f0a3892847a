"""A run differentiated step by step: forward with columns of derivatives, or backward with gradients of responses."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from ..._jit.link import link
from ...algebra import Array
from ...results import Steps
from ...system import System
from ...system.lane_room import aligned, used
from ..dynamics import alpha_loop
from ..dynamics.newton_matrix import weigh
from ..linear import SingularMatrix
from . import block_loop
from . import sweep_loop as loop
from .blocks import Blocks
from .kernels import GROUPS
from .panel_loop import Factors

# Last relative change of a solution up to which pivots are kept: those by pairs, by size
TRUSTED = (1e-8, 1e-3)
NOWHERE = -1, 0, 0  # where pivots were chosen last
ORDERS: WeakKeyDictionary[Steps, Factors] = WeakKeyDictionary()  # of pivots, with which sweeps of a run begin
NOTHING_KEPT = loop.Kept(np.zeros((0, 0, 0)), np.zeros((0, 0, 0)), np.zeros((0, 0)))
NOTHING_GIVEN = loop.Given._make(np.zeros((0, 0, 0)) for _ in loop.Given._fields)
NOTHING_WEIGHED = loop.Weighed(
    NOTHING_GIVEN, np.zeros(0, np.uint64), np.zeros(0, np.uint64), np.zeros(0), np.zeros((0, 0))
)
NOTHING_MOVED = loop.Sources._make(np.zeros((0, 0, 0)) for _ in loop.Sources._fields)
NO_SOURCES = loop.Sources._make(np.zeros((0, 0)) for _ in loop.Sources._fields)


class Sweep:
    """The derivatives of the steps of one run.

    Parameters
    ----------
    system : System
    steps : kept by `simulate`
    columns : how many derivatives or responses are swept at once
    b_dot : (len(system.b), k) changes of the numbers, for `forward`
    """

    def __init__(self, system: System, steps: Steps, columns: int, b_dot: Array | None = None) -> None:
        self.system, self.steps, self.columns = system, steps, columns
        self.b = steps.b.copy()
        self._blocks = Blocks(system, columns, b_dot)
        self.record = _record(steps)
        self._work = self._make_work()
        self._shown: Factors | None = None

    def over(self, steps: Steps) -> None:
        """Go on with other steps of the same run, those before."""
        self.steps, self.record = steps, _record(steps)
        for block in (self._blocks.steps, self._blocks.rescales):
            block.left_out[:] = 0.0  # a record may tell of none

    def _make_work(self) -> loop.Work:
        nq, size, k = self.system.nq, self.system.nq + self.system.m, self._blocks.width
        wide = [aligned(size, k), aligned(size, k), aligned(3, size, k), aligned(2 * nq * k), aligned(nq * k)]
        return loop.Work._make([*wide, np.zeros((5, size, 1)), loop.Progress.zeros()])

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
        """Room for what is solved for in every step; a sweep backwards writes zero for those before its first."""
        count, size = len(self.steps), self.system.nq + self.system.m
        wide = (used(count, size, self.columns) for _ in range(2))
        return loop.Kept._make([*wide, used(count, size)])

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
        n, stage, tried = last - 1, loop.GRADIENTS, NOWHERE
        for solved in kept or ():
            solved[:first] = 0.0
        if n >= first and self._shown is None:
            self._begin()
        while n >= first:
            n, stage = self._run(
                loop.backward, n, first, stage, bars, given, kept or NOTHING_KEPT, sources or NO_SOURCES
            )
            if n >= first:
                tried = self._choose_pivots(n, stage, tried)
        bars.b[: self.system.nb] += self._blocks.gradient()

    def forward(
        self,
        bars: loop.Bars,
        given: loop.Given,
        first: int,
        last: int,
        kept: loop.Kept | None = None,
        sources: loop.Sources | None = None,
    ) -> None:
        """From the start of step `first` through the steps first:last, in place; derivatives at their ends are written.

        `sources` are changes of the residuals (n, nq + m, k) besides those by
        the numbers of elements.
        """
        besides = kept or NOTHING_KEPT, sources or NOTHING_MOVED
        self._forward(bars, first, last, given, NOTHING_WEIGHED, *besides)

    def weighed(
        self, bars: loop.Bars, by: loop.Given, first: int, last: int, sources: loop.Sources | None = None
    ) -> Array:
        """The same, but given their gradients by the states at the ends of the steps, the changes of responses (r, k).

        No derivatives of states are kept but those at the last end, in `bars`.
        """
        count, size = by.q.shape[2], 3 * self.system.nq + self.system.m
        width, panels = self._blocks.width, -(-self.columns // self._blocks.width)
        ends, rows = (np.zeros(n, np.uint64) for n in (count + 1, count * size))
        weighed = loop.Weighed(by, ends, rows, np.zeros(count * size), aligned(panels, count * width))
        self._forward(bars, first, last, NOTHING_GIVEN, weighed, NOTHING_KEPT, sources or NOTHING_MOVED)
        return self._from_panels(weighed.total)

    def _forward(self, bars: loop.Bars, first: int, last: int, *arrays: Any) -> None:
        n, stage, tried = first, loop.RESCALE, NOWHERE
        if n < last and self._shown is None:
            self._begin()
        state = self._in_panels(bars)
        while n < last:
            n, stage = self._run(loop.forward, n, last, stage, state, *arrays)
            if n < last:
                tried = self._choose_pivots(n, stage, tried)
        ends = np.cumsum([len(x) for x in _state(bars)])[:-1]
        for x, own in zip(_state(bars), np.split(self._from_panels(state), ends), strict=True):
            x[:] = own

    def _in_panels(self, bars: loop.Bars) -> Array:
        """The derivatives of q, v, a, λ and x of a panel one after another; those missing in the last are zero."""
        rows, width = np.concatenate(_state(bars)), self._blocks.width
        found = aligned(-(-self.columns // width), len(rows) * width)
        for p, panel in enumerate(found.reshape(-1, len(rows), width)):
            own = rows[:, p * width : (p + 1) * width]
            panel[:, : own.shape[1]] = own
        return found

    def _from_panels(self, found: Array) -> Array:
        """Rows with all columns."""
        panels, width = len(found), self._blocks.width
        rows = found.reshape(panels, -1, width).swapaxes(0, 1).reshape(-1, panels * width)
        return rows[:, : self.columns]

    def _run(self, sweep: Callable[..., Any], n: int, to: int, stage: int, *arrays: Any) -> tuple[int, int]:
        blocks = self._blocks
        found = link(sweep)(
            self.steps.scheme, blocks.entries, self.b, self.record, n, to, stage, self._shown, blocks.by_rows,
            blocks.steps, blocks.rescales, self._work, *arrays,
        )  # fmt: skip
        return int(found[0]), int(found[1])

    def _choose_pivots(self, n: int, stage: int, tried: tuple[int, int, int]) -> tuple[int, int, int]:
        """A pivot order for the matrix that is factored next; where it was chosen, and how often before."""
        times = tried[2] + 1 if tried[:2] == (n, stage) else 0
        if times > 1:
            raise SingularMatrix(f"the equations of the step to t = {self.steps.t[n + 1]:.6g} s are singular")
        if stage == loop.RESCALE and self.steps.removed[n] != 0.0:
            self._choose_pivots_at(n, n, 0.0)
        else:
            self._choose_pivots_at(n, n + 1, float(self.steps.h[n]))
        self._work.progress.trusted = TRUSTED[times]
        return n, stage, times

    def _begin(self) -> None:
        """The pivot order of a vanishing step at the end of the run, which serves most steps; chosen once for a run."""
        known, n = ORDERS.get(self.steps), len(self.steps) - 1
        if known is None:
            self._evaluate_at(n, n, 0.0)
        self._shown = ORDERS[self.steps] = self._blocks.arrange(known)
        self._work.progress.trusted = TRUSTED[0]

    def _choose_pivots_at(self, n: int, node: int, h: float) -> None:
        """A pivot order for a matrix of step n at a node."""
        self._evaluate_at(n, node, h)
        self._shown = self._blocks.arrange()
        self._work.progress.trusted = TRUSTED[0]

    def _evaluate_at(self, n: int, node: int, h: float) -> None:
        """The numbers and weights of a matrix."""
        steps, matrix = self.steps, self._blocks.matrix
        self.b[steps.places] = steps.memory[n]
        matrix.numbers.left_out[:] = steps.left_out[n + 1] if len(steps.left_out) else 0.0
        operands = {"t": float(steps.t[node])} | {k: getattr(steps, k)[node] for k in ("q", "v", "a", "lam")}
        for kind in ("jacobian", "inertia", "stiffness"):
            matrix.numbers.evaluate(GROUPS[kind], self.b, operands)
        weigh(matrix.weights, *alpha_loop.weights_of(steps.scheme, h))


def _state(bars: loop.Bars) -> tuple[Array, ...]:
    """In the order of a panel."""
    return bars.q, bars.v, bars.a, bars.lam, bars.x


def _record(steps: Steps) -> block_loop.Record:
    """The steps as contiguous arrays of floats."""
    fields = {name: getattr(steps, name) for name in block_loop.Record._fields}
    fields["left_out"] = steps.left_out.astype(float)
    return block_loop.Record(**fields)
