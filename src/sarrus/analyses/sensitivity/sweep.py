"""A run differentiated step by step: forward with columns of derivatives, or backward with gradients of responses."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from ..._jit.driver import compiled_function, compiled_part
from ...algebra import Array
from ...results import Steps
from ...system import System
from ..dynamics import alpha_loop
from ..dynamics.newton_matrix import NUMBERS, alpha_parts, weigh
from ..dynamics.placed import Numbers, compiled_solver, entries_of
from ..linear import SingularMatrix
from . import sweep_loop as loop
from .kernels import GROUPS, calls, flat, operators_by_b
from .step_matrix import StepMatrix, solvers, unsigned

BY_NUMBERS = loop.Entries._fields[5:]
FUNCTIONS = ("times", "by_numbers", "by_numbers_transposed", "add_gradients", "remember", "linearize", "defect_change",
             "forward_step", "backward_step", "forward_rescale", "backward_rescale")  # fmt: skip
TRUSTED = (
    1e-8,
    1e-3,
)  # last relative change of a solution up to which pivots are kept: those by pairs, by size
NOWHERE = -1, 0, 0  # where pivots were chosen last
NOTHING_KEPT = loop.Kept(np.zeros((0, 0, 0)), np.zeros((0, 0, 0)), np.zeros((0, 0)))
NOTHING_MOVED = loop.Sources._make(np.zeros((0, 0, 0)) for _ in loop.Sources._fields)
NO_SOURCES = loop.Sources._make(np.zeros((0, 0)) for _ in loop.Sources._fields)


@cache
def _compiled() -> dict[str, Any]:
    """The loops: the same code for every system; drivers are called by their address."""
    known = calls(loop.Entries._fields)
    known |= {"leave_out": compiled_solver()["leave_out"], "weigh": compiled_part(weigh), **solvers()}
    for name in ("evaluate", "factor", "weights_of"):
        known[name] = compiled_part(getattr(alpha_loop, name), **known)
    for name in FUNCTIONS:
        known[name] = compiled_part(getattr(loop, name), **known)
    for name in ("forward", "backward"):
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
        self._matrix = StepMatrix(Numbers(system, NUMBERS), system.nq + system.m, alpha_parts(system.nq))
        self._numbers = self._matrix.numbers
        self._groups = {name: system.group(*GROUPS[name][0]) for name in loop.Entries._fields}
        self._entries = loop.Entries._make(group.entry() for group in self._groups.values())
        self.record = _record(steps)
        self._blocks, self._views = self._make_blocks(b_dot)
        self._work = self._make_work()
        self._shown: Any = None

    def over(self, steps: Steps) -> None:
        """Go on with other steps of the same run, those before."""
        self.steps, self.record = steps, _record(steps)

    def _make_blocks(self, b_dot: Array | None) -> tuple[loop.Blocks, loop.Views]:
        rows, columns, segments = flat([entries_of(self.system, name) for name in NUMBERS])
        of_b = operators_by_b(self.system, BY_NUMBERS, b_dot)
        turned = entries_of(self.system, "gamma_v")
        more = (*turned, np.array([0, len(turned[0])]))
        own = unsigned((rows, columns, segments))
        fields = [
            self._numbers.values,
            *own,
            of_b.values,
            *unsigned(of_b[2:]),
            np.zeros(len(turned[0])),
            *unsigned(more),
        ]
        blocks = loop.Blocks._make(fields)
        return blocks, loop.Views._make(
            [*self._numbers.of(NUMBERS), *(of_b.values[start:end] for start, end in of_b.cuts)]
        )

    def _make_work(self) -> loop.Work:
        nq, m, k = self.system.nq, self.system.m, self.columns
        wide = [np.zeros((nq + m, k)), np.zeros((nq + m, k)), np.zeros((3, nq + m, k))]
        wide += [np.zeros((nq, k)) for _ in range(3)]
        vectors = [np.zeros(length) for length in (nq, m, m, m)]
        return loop.Work._make([*wide, *vectors, np.zeros((5, nq + m, 1)), np.zeros(1)])

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
        n, stage, tried = last - 1, loop.GRADIENTS, NOWHERE
        if n >= first and self._shown is None:
            tried = self._choose_pivots(n, stage, tried)
        while n >= first:
            n, stage = self._run(
                "backward", n, first, stage, bars, given, kept or NOTHING_KEPT, sources or NO_SOURCES
            )
            if n >= first:
                tried = self._choose_pivots(n, stage, tried)

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
        n, stage, tried = first, loop.RESCALE, NOWHERE
        if n < last and self._shown is None:
            tried = self._choose_pivots(n, stage, tried)
        while n < last:
            n, stage = self._run(
                "forward", n, last, stage, bars, given, kept or NOTHING_KEPT, sources or NOTHING_MOVED
            )
            if n < last:
                tried = self._choose_pivots(n, stage, tried)

    def _run(self, name: str, n: int, to: int, stage: int, *arrays: Any) -> tuple[int, int]:
        found = _compiled()[name](
            self.steps.scheme, self._entries, self.b, self.record, n, to, stage, self._shown, self._blocks,
            self._views, self._work, *arrays,
        )  # fmt: skip
        return int(found[0]), int(found[1])

    def _choose_pivots(self, n: int, stage: int, tried: tuple[int, int, int]) -> tuple[int, int, int]:
        """A pivot order for the matrix that is factored next; where it was chosen, and how often before."""
        times = tried[2] + 1 if tried[:2] == (n, stage) else 0
        if times > 1:
            raise SingularMatrix(f"the equations of the step to t = {self.steps.t[n + 1]:.6g} s are singular")
        self._evaluate(n, stage)
        self._shown = alpha_loop.matrix_of(self._matrix)._replace(placed=self._matrix.in_panels())
        self._work.trusted[0] = TRUSTED[times]
        return n, stage, times

    def _evaluate(self, n: int, stage: int) -> None:
        """The numbers of the matrix that is factored next."""
        steps, views = self.steps, self._views
        if stage == loop.RESCALE and steps.removed[n] == 0.0:
            stage = loop.STEP
        at = n if stage == loop.RESCALE else n + 1
        loop.remember(self.record, n, views, self.b)
        operands = {"t": float(steps.t[at])} | {k: getattr(steps, k)[at] for k in ("q", "v", "a", "lam")}
        for kind in ("jacobian", "inertia", "stiffness"):
            self._numbers.evaluate(GROUPS[kind][0], self.b, operands)
        h = 0.0 if stage == loop.RESCALE else float(steps.h[n])
        weigh(self._matrix.weights, *alpha_loop.weights_of(steps.scheme, h))


def _record(steps: Steps) -> loop.Record:
    """The steps as contiguous arrays of floats."""
    fields = {name: getattr(steps, name) for name in loop.Record._fields}
    fields["left_out"] = steps.left_out.astype(float)
    return loop.Record(**fields)
