"""Derivatives of the operations of a run with respect to table values and constants of formulas.

The sweeps are compiled for the numbers of elements; a curve has as many numbers as it has points. So their part of all
equations is evaluated here for all occurrences at once: as what is added to the right sides forwards, and backwards
from what was solved for.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ....system import System
from ....system.curves.curve_derivatives import CurveDerivatives, Entries
from ....system.curves.time_derivatives import TimeDerivatives
from ...dynamics.methods.description import NONHOLONOMIC
from ...dynamics.methods.equations import KINDS
from .record import Occurrences, Operations
from .sweep import PerOperation, unknowns_of


class _Term(NamedTuple):
    """Derivatives of a part of an equation at all occurrences: operation, first row, rows, weights, derivatives."""

    operation: int
    row: int
    height: int
    weights: Array
    entries: Entries


def by_curves(system: System, moving: bool) -> CurveDerivatives:
    """The derivatives of a system's operators by the numbers of curves, and perhaps by the time at which it begins."""
    return TimeDerivatives(system) if moving else CurveDerivatives(system)


class Curves:
    """The derivatives of all operations of a run by the numbers of curves.

    Parameters
    ----------
    record : of the run
    moving : whether it begins at a time that moves: that has a place behind all numbers, like one more of them

    Attributes
    ----------
    of : the derivatives of the operators
    """

    def __init__(self, record: Operations, moving: bool = False) -> None:
        self._record = record
        self.of = by_curves(record.system, moving)

    def __bool__(self) -> bool:
        return bool(self.of)

    @property
    def width(self) -> int:
        """The number of parameters, including the time."""
        return self.of.width

    def moved_by(self, db: Array) -> bool:
        """Whether changes of the numbers (len(b), k) change a curve."""
        return bool(self.of) and bool(np.any(db[self._record.system.nb :]))

    def sources(self, db: Array, dt: Array | None = None) -> PerOperation:
        """The changes of the equations of all operations; dt (steps,) are those of the times of each step."""
        found = unknowns_of(self._record, db.shape[1])
        for term in self._terms:
            rows, moved = slice(term.row, term.row + term.height), term.entries.along(db, term.height)
            if dt is not None:
                own = dt[self._record.operations[term.operation].steps]
                moved = moved + term.entries.along_column(self.width - 1, own, term.height)[:, :, None]
            found.parts[term.operation][:, rows] += term.weights[:, None, None] * moved
        return found

    def gradient(self, solved: PerOperation) -> Array:
        """Return the gradients by the parameters (len(b), k) from the adjoint variables of all operations."""
        total = np.zeros((self.width, solved.parts[0].shape[2]))
        for term in self._terms:
            total -= term.entries.gradient(self._weighed(term, solved), self.width)
        return total

    def by_times(self, solved: PerOperation) -> Array:
        """The same for the gradient by the times of each step (steps,), of a single column."""
        total = np.zeros(len(self._record.steps))
        for term in self._terms:
            own = term.entries.by_column(self.width - 1, self._weighed(term, solved)[:, :, 0])
            np.subtract.at(total, self._record.operations[term.operation].steps, own)
        return total

    def _weighed(self, term: _Term, solved: PerOperation) -> Array:
        mu = solved.parts[term.operation][:, term.row : term.row + term.height]
        return np.asarray(term.weights[:, None, None] * mu)

    @cached_property
    def _terms(self) -> list[_Term]:
        operations = enumerate(self._record.operations)
        return [term for n, one in operations if len(one) for term in self._terms_of(n, one)]

    def _terms_of(self, n: int, one: Occurrences) -> Iterator[_Term]:
        record, memory = self._record, self._record.memory(one)
        values = {key: source.all(len(one)) for key, source in one.sources.items()}
        equations = zip(one.tables.structure.equations, one.tables.equations, one.scales.T, strict=True)
        for (kind, s, rows), row, scale in equations:
            if rows == NONHOLONOMIC:  # these have no curves
                continue
            height = one.tables.size(KINDS[kind].size)
            for name, operands, sign in KINDS[kind].curves:
                given = {operand: values[s, of] for operand, of in operands.items()}
                entries = self.of(name, record.steps.b, memory, q=values[s, "q"], t=one.times[:, s], **given)
                yield _Term(n, row, height, sign * scale, entries)
