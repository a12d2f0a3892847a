"""HHT and generalized-α on the stabilized index-2 equations at work: `AlphaStepper` with another loop and matrix."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from ..._jit.driver import compiled_function
from . import alpha_loop, radau_loop
from . import stabilized_loop as loop
from .alpha import GROUPS, AlphaStepper, calls, compiled_parts
from .entries import entry_of
from .stabilized_matrix import MATRICES, START, StabilizedMatrix, compiled_solver, weigh

TURNING = ("gamma_v",)
PLAIN = ("update", "residual", "predict", "accept")  # of the index-3 equations, called by those here


@cache
def compiled_advance() -> Any:
    """The time loop, compiled once for all systems."""
    plain, made = compiled_parts(), calls() | compiled_solver()
    made |= {f"plain_{name}": plain[name] for name in PLAIN}
    made |= {name: plain[name] for name in ("size", "stretch", "keep", "remember")}
    made["weigh"] = compiled_function(weigh)
    made["evaluate"] = compiled_function(radau_loop.evaluate, **made)
    order = "update residual factor scaled correct newton polish predict accept rescale advance"
    for name in order.split():
        source = loop if hasattr(loop, name) else alpha_loop
        made[name] = compiled_function(getattr(source, name), **made)
    return made["advance"]


class StabilizedStepper(AlphaStepper):
    """HHT or generalized-α at work on the stabilized equations of one system, see `AlphaStepper`."""

    matrix: StabilizedMatrix

    def _make(self) -> None:
        system, nq, m = self.system, self.system.nq, self.system.m
        self.matrix = StabilizedMatrix(system, self.independence.kept)
        self._advance = compiled_advance()
        entries = [entry_of(system, *names) for names in (*GROUPS.values(), TURNING, ("remembered",))]
        self._entries = loop.Entries._make(entries)
        whole = 2 * (nq + m)
        rows = (m, nq, nq, nq, nq, m, m, nq + m, whole, nq, nq, whole)
        self._memory = loop.Memory(*(np.zeros(length) for length in rows))
        widths = (nq, nq, nq, nq, m, nq, nq, nq, nq, m, nq, m, m, m, nq, nq)
        self._state = loop.State(*(np.zeros(length) for length in widths))

    def _evaluate(self, operands: dict[str, Any]) -> None:
        super()._evaluate(operands)
        views, group = self.matrix.views, self.system.group(*TURNING)
        group.run(self.b, *(operands[k] for k in group.operands), views["gamma_v"])
        views[START][:] = views["Phi_q"]

    def _show_matrix(self) -> None:
        matrix, views = self.matrix, self.matrix.views
        numbers = [views[name] for name in (*MATRICES, START)]
        rest = (self._state.q0, matrix.row_of, matrix.left_out, matrix.placed)
        self._arrays = loop.Matrix._make([matrix.values, *numbers, *rest])
