"""The steps of a run differentiated twice: the way along a direction, and the way back.

A step backwards whose adjoint changes has the contracted second derivatives of its equations as sources.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ....results import StepsTaken
from ..lagrangians.changes import Change, change_at
from ..lagrangians.curves import CurveLagrangian
from ..steps.second_order import changes_along
from ..steps.sweep import PerOperation
from .chain import BackwardState, Nodes, SegmentChain


class AdjointVariables(NamedTuple):
    """The adjoint variables of all operations, and of the start."""

    operations: PerOperation
    start: tuple[Array, Array]


class AdjointChange(NamedTuple):
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

    def __init__(self, chain: SegmentChain, curves: CurveLagrangian) -> None:
        self._chain, self._system, self._steps, self._curves = chain, chain.system, chain.steps, curves

    def back(
        self, nodes: Nodes, change: AdjointChange | None
    ) -> tuple[tuple[Array, Array, Array], AdjointVariables]:
        """Gradients by the first q and v and by the numbers, and what was solved for, with changes of the equations."""
        chain, sweep = self._chain, self._chain.sweep
        back, solved = BackwardState(chain.by_curves.width, 1), sweep.unknowns()
        curves, sources = chain.curves if self._curves else None, change.sources if change else None
        back.over(sweep, curves, nodes, 0, solved=solved, sources=sources)
        if change:
            back.b -= change.b[:, None]
        found = back.through_start(chain.start, nodes, change.start if change else None)
        return found, AdjointVariables(solved, back.of_start)

    def turned(
        self, b_dot: Array, moved: Nodes, stages: PerOperation, adjoint: AdjointVariables
    ) -> AdjointChange:
        """The changes of the equations of all steps.

        With the changes of the numbers, of the nodes and of the stages, and the adjoint variables.
        """
        record, size = self._chain.record, len(self._system.b)
        t_dot = np.full(len(self._steps), b_dot[size:].sum())
        found = changes_along(record, b_dot[:size], stages, adjoint.operations, self._curves, t_dot)
        start, by_b = self._start(b_dot, moved, adjoint.start), np.zeros(len(b_dot))
        by_b[:size] = found.b + start.b
        by_b[size:] += start.t + found.t.sum()
        return AdjointChange(found.sources, start, by_b)

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
