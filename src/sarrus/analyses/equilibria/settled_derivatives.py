"""Exact derivatives of an equilibrium, and of velocities that are assembled there, by the implicit function theorem.

Φ_qᵀλ - Q(q, x, t, b) = 0,    Φ(q, b) = 0,    with the first-order states x at rest
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from scipy.sparse import csr_array

from ..._jit.kernels.bound import Bound
from ...algebra import Array
from ...results import Assembly
from ...system import System
from ..equations.block_matrix import Numbers
from ..equations.length import units
from ..equations.nullspace import NullSpace
from ..equations.states_at_rest import at_rest, by_position, places, undetermined, with_states
from ..position.assembly_derivatives import AssemblyDerivatives, Conditions, NoDerivative
from .balance import Balance


def derivatives_of(system: System, start: Assembly) -> AssemblyDerivatives:
    """The derivatives of the start of a run: of an equilibrium, or of the least change of a guess."""
    return (SettledDerivatives if start.settled else AssemblyDerivatives)(system, start)


class SettledDerivatives(AssemblyDerivatives):
    """The derivatives of an equilibrium, see `AssemblyDerivatives`: its coordinates do not depend on the guess.

    First-order states are unknowns in the places of their integrals, see `states_at_rest`.

    Raises
    ------
    NoDerivative
        If a motion has no stiffness, so that the forces do not determine the equilibrium.
    """

    further: ClassVar[tuple[str, ...]] = ("Q_q", "Q_v", "Q_b")
    lagrangian: ClassVar[str] = "step"  # with v = `rest` and a = 0

    @property
    def rest(self) -> Array:
        """Velocities (nq,) in the equations: first-order states alone."""
        return at_rest(self._system, self._unknowns)

    @property
    def _unknowns(self) -> Array:
        return with_states(self._system, self._assembly.q, self._assembly.v)

    def _evaluated(self) -> Numbers:
        numbers, system = super()._evaluated(), self._system
        at = {"t": self._request.t, "q": self._assembly.q, "v": self.rest}
        for name in self.further:
            numbers.evaluate((name,), system.b, at)
        return numbers

    def _position_block(self, numbers: Numbers, J: csr_array) -> Conditions:
        def matrix(name: str) -> csr_array:
            return self._system.matrix(name, numbers.views[name])

        A = csr_array(matrix("Phi_qT_lam_q").toarray() - by_position(self._system, matrix))
        weight, none = self._request.weight, np.zeros(self._system.nq)
        return Conditions(self._determined(A, J), J, weight, none.astype(bool), W=none)

    def _determined(self, A: csr_array, J: csr_array) -> csr_array:
        """The matrix of an equilibrium that the forces determine; others are refused."""
        system, why = self._system, ""
        if system.states:
            Z = NullSpace(J, units(system, self._assembly.q, J)).Z
            loose = undetermined(system, Z, Z.T @ (A @ Z))
            why = f"the equilibrium does not determine {', '.join(loose)}" if loose else ""
            remedy = "Give a rate that depends on the state, or assemble the start."
        elif np.any(self.balance.spectrum.neutral):
            why = "a motion has no stiffness in the equilibrium"
            remedy = "Add a spring, or assemble the start."
        if why:
            raise NoDerivative(f"{system.name}: {why}, so that its derivatives are not determined. {remedy}")
        return A

    @cached_property
    def balance(self) -> Balance:
        """The forces in the equilibrium."""
        system = self._system
        return Balance(system, self._unknowns, self._request.t, system.b)

    def with_constraints(self, g: Array) -> tuple[Array, Array]:
        """The change of q and λ where drivers change Φ, so that Φ_q q' = g (m,)."""
        none = np.zeros(self._system.nq)
        return self._position.solve(none, g, none)

    def adjoint_variables(self, q_bar: Array) -> tuple[Array, Array]:
        """The adjoint variables of both conditions, of what has this gradient by q."""
        return self._position.transposed(q_bar)[:2]

    def _with_states(self, q_dot: Array, dv: Array) -> tuple[Array, Array]:
        states = places(self._system)
        q_dot, dv = q_dot.copy(), dv.copy()
        dv[states], q_dot[states] = q_dot[states], 0.0
        return q_dot, dv

    def _by_unknowns(self, q_bar: Array, by_v: Array) -> tuple[Array, Array]:
        by_v, q_bar = self._with_states(by_v, q_bar)
        return q_bar, by_v


class Addresses(np.ndarray):
    """The `data` of a compiled function. It and its copies own the arrays at these addresses."""

    owned: Any = None

    def __array_finalize__(self, source: Any) -> None:
        self.owned = getattr(source, "owned", None)


class LastingFunction(Bound):
    """A compiled function with fixed arguments, see `Bound`; `data` owns them.

    Attributes
    ----------
    fast : data without this, which numpy and Numba take faster
    """

    def __init__(self, function: Callable[..., Any], *fixed: Any) -> None:
        super().__init__(function, *fixed)
        self.fast: Array = self.data
        owner = Addresses(self.fast.shape, self.fast.dtype)  # with memory of its own: views refer to it
        owner[:], owner.owned = self.fast, fixed
        self.data = owner


class CompiledFunction:
    """Base class of functions that other compiled code calls by `function` and `data`, after the first call."""

    def _bound(self) -> LastingFunction:
        """The function with its fixed arguments.

        Raises
        ------
        SarrusError
            Before the first state.
        """
        raise NotImplementedError

    @property
    def function(self) -> Any:
        return self._bound().function

    @property
    def data(self) -> Array:
        """The first argument of the compiled function."""
        return self._bound().data
