"""What numbers of curves do to the operations of a run: coefficients of tables, numbers in functions of time or length.

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
from ....system.curve_derivatives import CurveDerivatives, Entries
from ....system.time_derivatives import TimeDerivatives
from ...dynamics.methods.equations import KINDS
from .record import Occurrences, Record
from .sweep import PerOperation


class _Term(NamedTuple):
    """Derivatives of a part of an equation at all occurrences: operation, first row, rows, weights, derivatives."""

    operation: int
    row: int
    height: int
    weights: Array
    entries: Entries


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

    def __init__(self, record: Record, moving: bool = False) -> None:
        self._record = record
        self.of = TimeDerivatives(record.system) if moving else CurveDerivatives(record.system)

    def __bool__(self) -> bool:
        return bool(self.of)

    @property
    def width(self) -> int:
        """How many numbers there are, with the time."""
        return self.of.width

    def moved_by(self, db: Array) -> bool:
        """Whether changes of the numbers (len(b), k) change a curve."""
        return bool(self.of) and bool(np.any(db[self._record.system.nb :]))

    def sources(self, db: Array) -> PerOperation:
        """The changes of the equations of all operations."""
        sizes = [(len(one), one.tables.n, db.shape[1]) for one in self._record.operations]
        found = PerOperation.of([np.zeros(size) for size in sizes])
        for term in self._terms:
            rows = slice(term.row, term.row + term.height)
            moved = term.weights[:, None, None] * term.entries.along(db, term.height)
            found.parts[term.operation][:, rows] += moved
        return found

    def gradient(self, solved: PerOperation) -> Array:
        """What the adjoint variables of all operations give for the gradients by the numbers (len(b), k)."""
        total = np.zeros((self.width, solved.parts[1].shape[2]))
        for term in self._terms:
            mu = solved.parts[term.operation][:, term.row : term.row + term.height]
            total -= term.entries.gradient(term.weights[:, None, None] * mu, self.width)
        return total

    @cached_property
    def _terms(self) -> list[_Term]:
        operations = enumerate(self._record.operations)
        return [term for n, one in operations if len(one) for term in self._terms_of(n, one)]

    def _terms_of(self, n: int, one: Occurrences) -> Iterator[_Term]:
        record, memory = self._record, self._record.memory(one)
        values = {key: source.all(len(one)) for key, source in one.sources.items()}
        equations = zip(one.tables.structure.equations, one.tables.equations, one.scales.T, strict=True)
        for (kind, s), row, scale in equations:
            height = one.tables.size(KINDS[kind].size)
            for name, operands, sign in KINDS[kind].curves:
                given = {operand: values[s, of] for operand, of in operands.items()}
                entries = self.of(name, record.steps.b, memory, q=values[s, "q"], t=one.times[:, s], **given)
                yield _Term(n, row, height, sign * scale, entries)
