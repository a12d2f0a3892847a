"""Exact derivatives of an equilibrium, and of velocities that are assembled there, by the implicit function theorem.

Φ_qᵀλ - Q(q, 0, t, b) = 0,    Φ(q, b) = 0
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from scipy.sparse import csr_array

from ...algebra import Array
from ...linalg.kkt import KKT
from ...results import Assembly
from ...system import System
from ..equations.block_matrix import Numbers
from ..position.assembly_derivatives import AssemblyDerivatives, NoDerivative
from .balance import Balance


def derivatives_of(system: System, start: Assembly) -> AssemblyDerivatives:
    """The derivatives of the start of a run: of an equilibrium, or of the least change of a guess."""
    return (SettledDerivatives if start.settled else AssemblyDerivatives)(system, start)


class SettledDerivatives(AssemblyDerivatives):
    """The derivatives of an equilibrium, see `AssemblyDerivatives`: its coordinates do not depend on the guess.

    Raises
    ------
    NoDerivative
        If a motion has no stiffness, so that the forces do not determine the equilibrium.
    """

    further: ClassVar[tuple[str, ...]] = ("Q_q", "Q_b")
    lagrangian: ClassVar[str] = "step"  # with v = 0 and a = 0

    def _evaluated(self) -> Numbers:
        numbers, system = super()._evaluated(), self._system
        at = {"t": self._asked.t, "q": self._found.q, "v": np.zeros(system.nq)}
        for name in self.further:
            numbers.evaluate((name,), system.b, at)
        return numbers

    def _position_block(self, numbers: Numbers, J: csr_array) -> _Balanced:
        system, q, t = self._system, self._found.q, self._asked.t
        if system.states:
            message = f"{', '.join(system.states)}: derivatives of an equilibrium with first-order states are not known"
            raise NoDerivative(
                f"{system.name}: {message}. Assemble the start, or give the states' initial values."
            )
        if np.any(Balance(system, q, t, system.b).spectrum.neutral):
            message = (
                "a motion has no stiffness in the equilibrium, so that its derivatives are not determined"
            )
            raise NoDerivative(f"{system.name}: {message}. Add a spring, or assemble the start.")
        H, K = (system.matrix(name, numbers.views[name]) for name in ("Phi_qT_lam_q", "Q_q"))
        return _Balanced(csr_array(H - K), J, self._asked.weight)


class _Balanced:
    """A x + Jᵀ y = f, J x = g with a matrix A of any symmetry; weights are the metric in which it is scaled."""

    def __init__(self, A: csr_array, J: csr_array, weight: Array) -> None:
        self.J = J
        self._kkt, self._transposed = KKT(A, J, weight), KKT(csr_array(A.T), J, weight)

    def solve(self, f: Array, g: Array, d: Array) -> tuple[Array, Array]:
        """The change of the equilibrium; `d`, of the guess, does not matter."""
        return self._kkt.solve(f, g)

    def transposed(self, x_bar: Array, y_bar: Array | None = None) -> tuple[Array, Array, Array]:
        """The adjoint variables, and no gradient by the guess."""
        none = np.zeros(self.J.shape[0])
        x, y = self._transposed.solve(x_bar, none if y_bar is None else y_bar)
        return x, y, np.zeros(len(x_bar))
