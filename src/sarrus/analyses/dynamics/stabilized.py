"""HHT and generalized-α on the stabilized index-2 equations at work: `AlphaStepper` with another loop and matrix."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from ..._jit.link import link
from ...results import StabilizedSteps
from . import alpha_loop
from . import stabilized_loop as loop
from .alpha import KINDS, AlphaStepper
from .implicit import GROUPS, Implicit, entries
from .radau_loop import evaluate
from .stabilized_matrix import START, stabilized_matrix, weigh


@cache
def _advance() -> Any:
    """The time integration loop of `alpha_loop` with the step of `stabilized_loop`."""
    return link(
        alpha_loop.advance,
        update=loop.update,
        residual=loop.residual,
        evaluate=evaluate,
        factor=loop.factor,
        correct=loop.correct,
        multiplier_change=loop.multiplier_change,
        predict=loop.predict,
        accept=loop.accept,
        rescale=loop.rescale,
        keep=loop.keep,
    )


class StabilizedStepper(AlphaStepper):
    """HHT or generalized-α at work on the stabilized equations of one system, see `AlphaStepper`."""

    kind = StabilizedSteps
    host = None  # M and Φ_q stand elsewhere than in the equations of motion
    _motion = Implicit._motion

    def _make(self) -> None:
        system, nq, m = self.system, self.system.nq, self.system.m
        self.matrix = stabilized_matrix(system)
        self.matrix.numbers.keep(self.independence.kept)
        self._advance, self._weigh = _advance(), weigh
        self._entries = loop.Entries(**entries(system, (*KINDS, "TURNING")))
        whole = 2 * (nq + m)
        rows = (m, nq, nq, nq, nq, m, m, nq + m, whole, nq, m, 0, nq, whole)
        self._memory = loop.Memory(*(np.zeros(length) for length in rows))
        widths = (nq, nq, nq, nq, m, nq, nq, nq, nq, m, nq, m, m, m, nq, nq)
        self._state = loop.State(*(np.zeros(length) for length in widths))

    def _evaluate(self, operands: dict[str, Any]) -> None:
        super()._evaluate(operands)
        numbers = self.matrix.numbers
        numbers.evaluate(GROUPS["TURNING"], self.b, operands)
        numbers.views[START][:] = numbers.views["Phi_q"]

    def _show_matrix(self) -> None:
        numbers, names = self.matrix.numbers, loop.Matrix._fields[1:-4]
        rest = (self._state.q0, numbers.row_of, numbers.left_out, self.matrix.placed)
        self._arrays = loop.Matrix._make([numbers.values, *numbers.of(names), *rest])
