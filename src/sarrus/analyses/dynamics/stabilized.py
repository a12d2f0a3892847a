"""HHT and generalized-α on the stabilized index-2 equations at work: `AlphaStepper` with another loop and matrix."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from ..._jit.driver import compiled_function, compiled_part
from . import alpha_loop, radau_loop
from . import stabilized_loop as loop
from .alpha import KINDS, AlphaStepper, compiled_parts
from .implicit import GROUPS, Implicit, calls, entries
from .placed import compiled_solver
from .stabilized_matrix import START, stabilized_matrix, weigh

PLAIN = (
    "update",
    "residual",
    "predict",
    "accept",
    "evaluate",
)  # of the index-3 equations, called by those here


@cache
def compiled_advance() -> Any:
    """The time loop, compiled once for all systems."""
    plain, made = compiled_parts(), calls() | compiled_solver()
    made |= {f"plain_{name}": plain[name] for name in PLAIN}
    shared = (
        "size",
        "weights_of",
        "round_off",
        "ignored_round_off",
        "replace",
        "stretch",
        "keep",
        "remember",
    )
    made |= {name: plain[name] for name in shared}
    made["weigh"] = compiled_part(weigh)
    made["evaluate"] = compiled_part(radau_loop.evaluate, **made)
    order = "update residual factor scaled correct renew newton multiplier_change settled polish predict accept rescale"
    for name in order.split():
        source = loop if hasattr(loop, name) else alpha_loop
        made[name] = compiled_part(getattr(source, name), **made)
    return compiled_function(alpha_loop.advance, **made)


class StabilizedStepper(AlphaStepper):
    """HHT or generalized-α at work on the stabilized equations of one system, see `AlphaStepper`."""

    host = None  # M and Φ_q stand elsewhere than in the equations of motion
    _motion = Implicit._motion

    def _make(self) -> None:
        system, nq, m = self.system, self.system.nq, self.system.m
        self.matrix = stabilized_matrix(system)
        self.matrix.numbers.keep(self.independence.kept)
        self._advance, self._weigh = compiled_advance(), weigh
        self._entries = loop.Entries(**entries(system, (*KINDS, "TURNING")))
        whole = 2 * (nq + m)
        rows = (m, nq, nq, nq, nq, m, m, nq + m, whole, nq, m, nq, whole)
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
