"""The matrix of an operation at one occurrence: where pivots are chosen."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ....algebra import Array
from ....system import System
from ....system.once import once_alike
from ...dynamics.methods.equations import OF_CONSTRAINTS
from ...dynamics.methods.tables import Structure, Tables, at_stage, operator_of, tables_of
from ...equations.block_matrix import Numbers, entries_of
from ..kernels import GROUPS
from ..stages_matrix import StagesMatrix
from ..step_matrix import StepMatrix


class OperationMatrix:
    """Numbers of the operators of an operation at one occurrence, and its matrix."""

    def __init__(self, system: System, tables: Tables) -> None:
        self._system, self._tables = system, tables
        self.numbers = Numbers(system, tables.names, tables.like)
        stages = tables.alike_stages
        self.matrix = (
            StagesMatrix(self.numbers, tables.n, tables.parts, stages)
            if stages > 1
            else StepMatrix(self.numbers, tables.n, tables.parts)
        )

    @cached_property
    def constrained(self) -> Array:
        """Places of numbers in rows of constraints, and the constraint (entries, 2)."""
        return constrained(self._system, self._tables.structure)

    def evaluate(self, b: Array, left_out: Array, at: list[dict[str, Array | float]]) -> None:
        """The numbers at given stages."""
        numbers = self.numbers
        for s, call in self._tables.calls:
            group = self._system.group(*GROUPS[call.group])
            none = np.zeros(max(self._system.nq, self._system.m))
            operands = (at[s].get(name, none) for name in call.operands)
            group.run(b, *operands, *numbers.of([at_stage(name, s) for name in call.outputs]))
        numbers.left_out[:] = left_out
        places, rows = self.constrained.T
        numbers.values[places] *= 1.0 - left_out[rows]


@once_alike
def constrained(system: System, structure: Structure) -> Array:
    """See `OperationMatrix.constrained`."""
    tables = tables_of(system, structure)
    numbers, found = Numbers(system, tables.names, tables.like), [np.zeros((0, 2), np.int64)]
    for name in tables.names:
        if name.partition("@")[0] in OF_CONSTRAINTS:
            rows = entries_of(system, operator_of(name))[0]
            found.append(np.column_stack([numbers.start[name] + np.arange(len(rows)), rows]))
    return np.concatenate(found).astype(np.int64)
