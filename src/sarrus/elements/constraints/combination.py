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

    def _row(self, name: str, x: Any, *directions: Any) -> Row:
        blocks: list[list[Block]] = [[] for _ in x]
        for term in self.terms():
            found = getattr(term.function, name)(term.of(x), *(term.of(d) for d in directions))
            for n, block in enumerate(found):
                blocks[4 * term.pair + n].append(scaled(term.factor, block))
        return tuple(total(parts) for parts in blocks)

    def Phi_q(self, x: Any) -> Row:
        return self._row("Phi_q", x)

    def Phi_q_xi_q(self, x: Any, xi: Any) -> Row:
        return self._row("Phi_q_xi_q", x, xi)

    def Phi_q_xi_q_eta_q(self, x: Any, xi: Any, eta: Any) -> Row:
        return self._row("Phi_q_xi_q_eta_q", x, xi, eta)

    def Phi_qT_lam_q(self, x: Any, lam: Array) -> Grid:
        blocks: list[list[list[Block]]] = [[[] for _ in x] for _ in x]
        for term in self.terms():
            for m, line in enumerate(term.function.Phi_qT_lam_q(term.of(x), term.factor * lam)):
                for n, block in enumerate(line):
                    blocks[4 * term.pair + m][4 * term.pair + n].append(block)
        return tuple(tuple(total(parts) for parts in line) for line in blocks)
