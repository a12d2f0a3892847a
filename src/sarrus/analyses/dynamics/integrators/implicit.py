"""Counters, failures and saved data of runs by implicit steps."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ....algebra import Array
from ....system import System
from ...redundancy.redundant_constraints import Independence
from ..step_loop import loop
from ..step_loop.records import Control, Matrix, State
from ..stepping.failures import failure_of, singular
from ..stepping.stepper import RunFailure, Tally

PATIENCE = 12  # calls of the loop without a step, after which the position is called singular


class Implicit:
    """An implicit method at work, see `Stepper`: the part that does not depend on the method."""

    passes_kinks = True
    system: System
    b: Array
    t: float
    independence: Independence
    tally: Tally
    evaluations: int  # of all equations of motion for each residual
    factorizations: int  # for each evaluation of the matrices
    _control: Control
    _state: State
    _arrays: Matrix | None
    _span: float
    _vain: int

    def shorten(self, longest: float) -> None:
        """See `Stepper`."""
        self._control.h = min(self._control.h, longest)

    def _why_small(self) -> str:
        """Why steps became too small."""
        raise NotImplementedError

    def _count(self, before: Control) -> None:
        """Add the counts of a call of the loop."""
        now = self._control
        matrices = int(now.matrices - before.matrices)
        self.tally.add(
            int(now.steps - before.steps),
            int(now.rejected - before.rejected),
            self.evaluations * int(now.residuals - before.residuals),
            matrices,
            self.factorizations * matrices,
        )

    def _forget_pivots(self) -> None:
        """The order of the pivots does not fit any more."""
        self._arrays = None

    def _look(self, status: int, taken: int) -> None:
        """Evaluate the result of a call of the loop."""
        self._vain = 0 if taken else self._vain + int(status == loop.REPIVOT)
        state = self._state
        if status == loop.REPIVOT:
            self._forget_pivots()
            if self._vain > 1:  # new pivots did not help: a shorter step may
                self._control.h *= 0.25
            if self._vain > PATIENCE:
                raise self._explained(state.q0, state.v0)
        if status == loop.TOO_SMALL and not taken:
            message = (
                f"steps become too small near t = {self.t:.6g} s: {self._why_small().removesuffix('.')}."
            )
            raise self._explained(state.q0, state.v0, RunFailure("step too small", message))

    def _explained(self, q: Array, v: Array, otherwise: RunFailure | None = None) -> RunFailure:
        """Why there are no further steps."""
        message = otherwise or singular(self.t, [])
        return failure_of(self.system, self.b, self.t, q, v, self.independence, self._span, message)

    def _saved(self) -> dict[str, Array]:
        """Return the data that a continued run needs, except the matrices."""
        found = {f"state_{name}": array for name, array in zip(self._state._fields, self._state, strict=True)}
        found |= {"control": self._control.as_array(), "b": self.b}
        found |= {"own": np.array([self.t, self._span, self._vain]), "tally": self.tally.counts()}
        return found | {"null": self.independence.state()}

    def _take_over(self, state: Mapping[str, Array]) -> None:
        """Take over such a state."""
        self.independence.resume(state["null"])
        for name, array in zip(self._state._fields, self._state, strict=True):
            array[:] = state[f"state_{name}"]
        self._control.assign(state["control"])
        self.b[:], self.tally, self._arrays = state["b"], Tally.of(state["tally"]), None
        self.t, self._span, self._vain = float(state["own"][0]), float(state["own"][1]), int(state["own"][2])
