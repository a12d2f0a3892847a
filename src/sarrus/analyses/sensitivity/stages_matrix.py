"""The matrix of all stages of a step of Radau IIA, and in which order are its pivots taken?

Each unknown of one stage, and each of its equations, stands for three. So the pivots of the matrix of one stage, which
is that of a Newton iteration (`dynamics.stabilized_matrix`), are those of blocks (3, 3): entries of M and of unit
matrices are full there, all others diagonal. With Markowitz's rule for all stages at once the vehicle's factors have
three times as many numbers, made by ten times as many products.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..._jit.link import link
from ..dynamics import stabilized_matrix
from ..dynamics.placed import LEFT_OUT, UNIT, Numbers, Part, Placed, PlacedMatrix, refactor
from ..linear import SingularMatrix, SparseLU
from . import radau_sweep_loop
from .step_matrix import StepMatrix

STAGES = 3
LEAST = 1e-10  # pivot over column, below which pivots are chosen among all stages


class StagesMatrix(StepMatrix):
    """The matrix of all stages; numbers of operators at stage i have names with "@i".

    Attributes
    ----------
    in_blocks : whether the order of one stage is tried
    """

    in_blocks = True

    def __init__(self, numbers: Numbers, nq: int, m: int) -> None:
        super().__init__(numbers, 2 * STAGES * (nq + m), stage_parts(nq, m))
        plain = stabilized_matrix.newton_parts(nq, m)
        last = [
            part if part.name in (UNIT, LEFT_OUT) else part._replace(name=f"{part.name}@2") for part in plain
        ]
        self._one = PlacedMatrix(numbers, 2 * (nq + m), last)

    def weigh(self, scheme: Any, h: float) -> None:
        """The weights of a step of this length."""
        radau_sweep_loop.step_weights(scheme, h, self.weights)
        part = h / scheme.gamma
        stabilized_matrix.weigh(self._one.weights, part * part, part)

    def choose_pivots(self) -> Placed:
        """In the order of those of the last stage; where they are too small, in one of their own.

        Raises
        ------
        SingularMatrix
            If the matrix is singular.
        """
        return (self.in_blocks and self._in_order_of_one()) or super().choose_pivots()

    def _in_order_of_one(self) -> Placed | None:
        """In the order of the last stage's pivots, if these can be trusted."""
        try:
            found = self._expanded()
        except SingularMatrix:
            return None
        return found if link(refactor)(self.numbers.values, found) > LEAST else None

    def _expanded(self) -> Placed:
        one, layout = self._one.choose_pivots(), self._layout
        rows = [STAGES * one.row_place.astype(np.int64) + i for i in range(STAGES)]
        columns = one.column_order.astype(np.int64)[:, None] + self._one.n * np.arange(STAGES)
        return self._show(
            SparseLU.ordered(layout.indptr, layout.indices, np.concatenate(rows), columns.ravel())
        )


def stage_parts(nq: int, m: int) -> list[Part]:
    """Where operators stand, in the order of `radau_sweep_loop.step_weights`."""
    found, size = [], 2 * (nq + m)
    for i in range(3):
        at = i * size
        v, lam, mu, second, third, fourth = (
            at + nq,
            at + 2 * nq,
            at + 2 * nq + m,
            at + nq,
            at + 2 * nq,
            at + 2 * nq + m,
        )
        for j in range(3):
            found += [Part(UNIT, at, j * size), Part(f"M@{i}", second, j * size + nq)]
        found += [
            Part(UNIT, at, v),
            Part(f"Phi_qT_mu_q@{i}", at, at),
            Part(f"Phi_q@{i}", at, mu, transposed=True),
        ]
        found += [Part(f"{name}@{i}", second, at) for name in ("M_a_q", "Phi_qT_lam_q", "S_q", "Q_q")]
        found += [Part(f"{name}@{i}", second, v) for name in ("S_v", "Q_v")]
        found += [Part(f"Phi_q@{i}", second, lam, transposed=True), Part(f"Phi_q@{i}", third, at)]
        found += [Part(f"gamma_v@{i}", fourth, at), Part(f"Phi_q@{i}", fourth, v)]
        found += [Part(LEFT_OUT, third, lam), Part(LEFT_OUT, fourth, mu)]
    return found
