"""Constraints that are linear combinations of scalar functions: so are their derivatives to q."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from ...algebra import Array, Block, Row, scaled, total
from ..element import Grid, Pair, Scalar


class Term(NamedTuple):
    """A factor, a function with the kernels of a constraint of one row, and which pair of bodies it is of."""

    factor: Scalar
    function: Any
    pair: int = 0

    def of(self, x: Any) -> Pair:
        """The coordinates (or a direction) of its own two bodies."""
        return Pair(*x[4 * self.pair : 4 * self.pair + 4])


class Combination:
    """Kernels of Φ = Σ factor · function + terms without q. A subclass gives `terms` and Φ itself."""

    def terms(self) -> Iterator[Term]:
        raise NotImplementedError

    def Phi_q(self, x: Any) -> Row:
        blocks: list[list[Block]] = [[] for _ in x]
        for term in self.terms():
            for n, block in enumerate(term.function.Phi_q(term.of(x))):
                blocks[4 * term.pair + n].append(scaled(term.factor, block))
        return tuple(total(parts) for parts in blocks)

    def Phi_qT_lam_q(self, x: Any, lam: Array) -> Grid:
        blocks: list[list[list[Block]]] = [[[] for _ in x] for _ in x]
        for term in self.terms():
            for m, line in enumerate(term.function.Phi_qT_lam_q(term.of(x), term.factor * lam)):
                for n, block in enumerate(line):
                    blocks[4 * term.pair + m][4 * term.pair + n].append(block)
        return tuple(tuple(total(parts) for parts in line) for line in blocks)
