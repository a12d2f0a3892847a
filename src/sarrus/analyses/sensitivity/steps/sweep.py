"""A run differentiated operation by operation: forward with columns of derivatives, or backward with gradients."""

from __future__ import annotations

from contextlib import suppress
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from ...._jit.linking.link import link
from ....algebra import Array
from ....linalg.sparse_solver import SingularMatrix
from ....system.curves.lanes import aligned
from . import sweep_loop as loop
from .block_loop import Matrices
from .blocks import OPERATIONS, Blocks
from .maps import maps_of
from .matrix import OperationMatrix, Placement
from .record import STEP, Occurrences, Operations, RecordData
from .stacked import Series, parts_of, series

# Relative error left in a solution with which pivots stay: those of a very short step, those chosen for this one
TRUSTED = (1e-14, 1e-3)
Order = tuple[list[Placement | None], Matrices]  # of pivots of all operations
# With which the sweeps of a run begin
ORDERS: WeakKeyDictionary[RecordData, dict[tuple[bool, ...], Order]] = WeakKeyDictionary()
NOTHING = Series(np.zeros(0), np.zeros(OPERATIONS, np.int64), np.zeros(OPERATIONS, np.int64))
NO_STATES, NO_ADJOINTS = np.zeros((0, 0, 0)), np.zeros((0, 0, 0, 0))
NO_NODES = loop.NodeArrays._make(np.zeros((0, 0, 0)) for _ in loop.NodeArrays._fields)
NOT_WEIGHED = loop.Weighing(
    NO_NODES, np.zeros(0, np.uint64), np.zeros(0, np.uint64), np.zeros(0), np.zeros((0, 0))
)


class PerOperation(NamedTuple):
    """Arrays with a row for each occurrence of each operation, and the same as compiled code takes them."""

    parts: list[Array]
    series: Series

    @classmethod
    def of(cls, parts: list[Array]) -> PerOperation:
        """Of arrays (occurrences, entries, columns)."""
        stacked = series([x.reshape(len(x), -1) if x.size else np.zeros((0, 1)) for x in parts])
        return cls(parts_of(stacked, [x.shape for x in parts]), stacked)


def unknowns_of(record: Operations, columns: int) -> PerOperation:
    """Zeros for the unknowns of all operations."""
    return PerOperation.of([np.zeros((len(one), one.tables.n, columns)) for one in record.operations])


def stages_of(record: Operations, columns: int) -> PerOperation:
    """Zeros for the stages' quantities of all operations."""
    sizes = [(len(one), one.tables.stage_size, columns) for one in record.operations]
    return PerOperation.of([np.zeros(size) for size in sizes])


class Sweep:
    """The derivatives of the operations of one run.

    Parameters
    ----------
    record : of the run
    columns : how many derivatives or responses are swept at once
    b_dot : (len(system.b), k) changes of the numbers, for `forward`
    by_parameters : whether `backward` returns the gradient by the parameters, or zeros
    """

    def __init__(
        self, record: Operations, columns: int, b_dot: Array | None = None, by_parameters: bool = True
    ) -> None:
        self.record, self.columns, self._by_parameters = record, columns, by_parameters
        self.b = record.steps.b.copy()
        self._blocks = Blocks(record, columns, b_dot, by_parameters)
        self.rows = next(one for one in self._blocks.tables if one).state
        self.state_size = next(one for one in self._blocks.tables if one).state_size
        self._work = self._make_work(b_dot is not None)
        self._order: Order | None = None
        self._splits = record.split is not None and not self._blocks.panels
        self._inherited: list[Placement | None] = []

    def over(self, record: Operations) -> Sweep:
        """Go on with other steps of the same run, those before; the sweep for them."""
        if [len(one) > 0 for one in record.operations] != [one is not None for one in self._blocks.tables]:
            found = Sweep(record, self.columns, by_parameters=self._by_parameters)
            found._inherited = self._order[0] if self._order else []
            return found
        self.record, self._work.left[0] = record, record.left
        return self

    def _make_work(self, forward: bool) -> loop.Work:
        layout, width = self._blocks.layout, self._blocks.width
        n, stages = int(layout.n.max()), int(layout.stages.max())
        left = np.full(1, self.record.left)
        vectors = [aligned(n, width), aligned(n, width), aligned(3, n + -(-n // 3), width), np.zeros(width)]
        maps = maps_of(self.record.system, self._blocks.structures, width, forward)
        return loop.Work._make(
            [*vectors, aligned(stages * width), maps, np.zeros(1), left, np.zeros(1, np.int64)]
        )

    def state(self, **blocks: Array) -> Array:
        """Derivatives of the state, or by it (entries, columns), of some blocks; the others are zero."""
        found = np.zeros((self.state_size, self.columns))
        for name, x in blocks.items():
            found[self.rows[name] : self.rows[name] + len(x)] = x
        return found

    def block(self, state: Array, name: str) -> Array:
        """A block of the state."""
        first, system = self.rows[name], self.record.system
        return state[first : first + (system.m if name == "lam" else system.nq)]

    def backward(
        self,
        state: Array,
        given: loop.NodeArrays,
        first: int = 0,
        stored: PerOperation | None = None,
        sources: PerOperation | None = None,
        initial: Array | None = None,
        adjoints: Array | None = None,
    ) -> Array:
        """Sweep backward to the start of step `first`, in place; return the gradient by the parameters (nb, k).

        Parameters
        ----------
        state : gradients by the state at the end (entries, columns)
        given : gradients of responses by the ends of the steps from `first` on
        stored : takes the adjoint variables
        sources : changes of the gradients of the Lagrangians by the stages' quantities, where an adjoint changes
        initial : (steps, entries, columns) takes the gradients by the states before the steps, if these are states that
            do not depend on each other
        adjoints : (steps, 2, 2 nq, columns) takes the gradients by q and v before and after each step
        """
        timeline, run = self._timeline(first, None, initial, adjoints), self.record.run(first)
        zero = sources is None and not state.any()
        e, self._work.done[0] = _last(timeline, given) if zero else len(timeline.operations) - 1, 0
        bars = aligned(len(state), self._blocks.width)
        bars[:, : self.columns] = state
        beside = (stored.series if stored else NOTHING), (sources.series if sources else NOTHING)
        tried = (-1, 0)
        while e >= 0:
            matrices = self._arranged()
            e = int(link(loop.backward)(
                self._blocks.layout, self._blocks.kernels, self.b, run, timeline, e, 0, matrices, self._blocks.block,
                self._work, bars, given, *beside,
            ))  # fmt: skip
            if e >= 0:
                tried = self._choose_pivots(timeline, e, tried)
        state[:] = bars[:, : self.columns]
        return self._blocks.gradient()

    def forward(
        self,
        state: Array,
        given: loop.NodeArrays | None = None,
        stored: PerOperation | None = None,
        sources: PerOperation | None = None,
        initial: Array | None = None,
    ) -> None:
        """Through all steps, in place; derivatives at their ends are written to `given`.

        `sources` are changes of the equations besides those by the numbers of elements; `stored` takes the changes of
        the stages' quantities. `initial` are those of the states before the steps (steps, entries, 1), if these are
        states that do not depend on each other.
        """
        self._forward(state, given or NO_NODES, NOT_WEIGHED, stored, sources, 0, None, initial)

    def weighed(
        self,
        state: Array,
        by: loop.NodeArrays,
        sources: PerOperation | None = None,
        first: int = 0,
        last: int | None = None,
    ) -> Array:
        """The same, but given their gradients by the states at the ends of the steps, the changes of responses (r, k).

        No derivatives of states are stored but those at the last end, in `state`.
        """
        count, size = by.q.shape[2], self.state_size
        width, panels = self._blocks.width, -(-self.columns // self._blocks.width)
        ends, rows = (np.zeros(n, np.uint64) for n in (count + 1, count * size))
        weighed = loop.Weighing(by, ends, rows, np.zeros(count * size), aligned(panels, count * width))
        self._forward(state, NO_NODES, weighed, None, sources, first, last, None)
        return self._from_panels(weighed.total)

    def _forward(
        self, state: Array, given: loop.NodeArrays, weighed: loop.Weighing, stored: PerOperation | None,
        sources: PerOperation | None, first: int, last: int | None, initial: Array | None,
    ) -> None:  # fmt: skip
        states = None if initial is None else initial.reshape(len(initial), 1, -1)
        timeline, run, e = self._timeline(first, last, states), self.record.run(first), 0
        panels, tried = self._in_panels(state), (-1, 0)
        self._work.done[0] = 0
        beside = (stored.series if stored else NOTHING), (sources.series if sources else NOTHING)
        while e < len(timeline.operations):
            matrices = self._arranged()
            e = int(link(loop.forward)(
                self._blocks.layout, self._blocks.kernels, self.b, run, timeline, e, self.columns, matrices,
                self._blocks.block, self._work, panels, given, weighed, *beside,
            ))  # fmt: skip
            if e < len(timeline.operations):
                tried = self._choose_pivots(timeline, e, tried)
        state[:] = self._from_panels(panels)

    def _timeline(
        self, first: int, last: int | None = None, states: Array | None = None, adjoints: Array | None = None
    ) -> loop.Timeline:
        """The operations of some steps."""
        end = len(self.record.steps) if last is None else last
        operations = np.concatenate([np.full(len(one), n) for n, one in enumerate(self.record.operations)])
        occurrences = np.concatenate([np.arange(len(one)) for one in self.record.operations])
        steps = np.concatenate([one.steps for one in self.record.operations])
        order = np.argsort(steps * OPERATIONS + operations, kind="stable")
        order = order[(steps[order] >= first) & (steps[order] < end)]
        own = steps[order]
        ends = np.append(own[1:] != own[:-1], True)[-len(own) :]
        nodes = np.where(ends, own - first, -1)
        initial = np.full(len(own), -1)
        if states is not None:
            initial[np.append(True, ends[:-1])[: len(own)]] = nodes[ends]
        return loop.Timeline(
            operations[order], occurrences[order], nodes, initial, NO_STATES if states is None else states,
            NO_ADJOINTS if adjoints is None else adjoints, np.where(operations[order] == STEP, own - first, -1),
        )  # fmt: skip

    def _in_panels(self, state: Array) -> Array:
        """The derivatives of the state of a panel one after another; those missing in the last are zero."""
        width = self._blocks.width
        found = aligned(-(-self.columns // width), len(state) * width)
        for p, panel in enumerate(found.reshape(-1, len(state), width)):
            own = state[:, p * width : (p + 1) * width]
            panel[:, : own.shape[1]] = own
        return found

    def _from_panels(self, found: Array) -> Array:
        """Rows with all columns."""
        panels, width = len(found), self._blocks.width
        rows = found.reshape(panels, -1, width).swapaxes(0, 1).reshape(-1, panels * width)
        return rows[:, : self.columns]

    def _arranged(self) -> Matrices:
        """The matrices, at first in the orders of pivots of a very short step, chosen once for a run."""
        if self._order is None:
            present = tuple(one is not None for one in self._blocks.tables)
            orders = ORDERS.setdefault(self.record.steps, {})
            key = (*present, self._blocks.panels, self._splits)
            known = None if self._inherited else orders.get(key)
            if known is None:
                typical = enumerate(self.record.typical())
                factors = [self._pivots(n, *one, split=self._splits and n == STEP) for n, one in typical]
                pairs = zip(factors, self._inherited, strict=False)
                factors[: len(self._inherited)] = [own and (before or own) for own, before in pairs]
                known = orders[key] = factors, self._blocks.matrices(factors)
            self._order, self._work.trusted[0] = known, TRUSTED[0]
            self._blocks.arrange(known[0])
        return self._order[1]

    def _choose_pivots(self, timeline: loop.Timeline, e: int, tried: tuple[int, int]) -> tuple[int, int]:
        """An order of pivots for the matrix that is factored next; where it was chosen, and how often before."""
        times = tried[1] + 1 if tried[0] == e else 0
        op, k = int(timeline.operations[e]), int(timeline.occurrences[e])
        one = self.record.operations[op]
        if times > 1:
            t = one.times[k].max()
            raise SingularMatrix(f"the equations of the step to t = {t:.6g} s are singular")
        assert self._order is not None
        before = self._order[0]
        own = before[op]
        split = own is not None and own.split is not None
        if split and times > 0:  # solutions do not converge
            split, times = False, 0
        factors = [self._pivots(n, one, k, times == 0, split) if n == op else x for n, x in enumerate(before)]
        self._order = factors, self._blocks.matrices(factors)
        self._blocks.arrange(factors)
        self._work.trusted[0] = TRUSTED[times]
        return e, times

    def _pivots(
        self, op: int, of: Occurrences, k: int, in_blocks: bool = True, split: bool = False
    ) -> Placement | None:
        """The order of the pivots for an occurrence of an operation; None where there is none."""
        if self._blocks.tables[op] is None:
            return None
        record, n = self.record, int(of.steps[k])
        own = OperationMatrix(record.system, of.tables, record.split)
        left_out = (
            record.steps.left_out[of.nodes[k]] if len(record.steps.left_out) else np.zeros(record.system.m)
        )
        at, weights = of.stages_at(k), of.weights(of.tables.weights)[k]
        own.evaluate(record.numbers(n), left_out.astype(float), at, weights)
        if split and record.split:
            with suppress(SingularMatrix):  # then the matrix of all stages is factored
                return own.split(of.split_weights(record.split)[k])
        return own.arranged(in_blocks)


def _last(timeline: loop.Timeline, given: loop.NodeArrays) -> int:
    """The last operation before whose end there are gradients of responses; those behind it change nothing."""
    nodes = np.any([x.any(axis=(1, 2)) for x in given], axis=0)
    return int(np.max(np.flatnonzero((timeline.nodes >= 0) & nodes[timeline.nodes]), initial=-1))
