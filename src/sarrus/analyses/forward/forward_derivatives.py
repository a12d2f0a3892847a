"""Derivatives of forward dynamics by the state, inputs and parameters, as a compiled function."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from sys import getrefcount
from types import SimpleNamespace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ...algebra import Array
from ...model import SarrusError
from ..equilibria.balance import input_changes
from ..equilibria.linearization_loop import by_parameters, constraints, forces
from ..equilibria.settled_derivatives import CompiledFunction, LastingFunction
from . import forward_loop as loop
from .forward_hessian import ForwardHessian
from .forward_loop import PivotedFunction, PivotOrder
from .parameter_changes import ParameterChanges, curve_changes, minimum_norm_changes
from .state_arguments import InputValues, number

if TYPE_CHECKING:
    from .forward_dynamics import ForwardDynamics

State = tuple[float, Array, Array]  # t, q, v


def _own_references() -> int:
    """References to the last array that are no user's: `_last`, a variable, and an argument; Python 3.14 borrows it."""
    owner = SimpleNamespace(last=np.empty(0))
    every = owner.last
    return getrefcount(every)


OURS = _own_references()


class ForwardDerivatives:
    """Accelerations and multipliers, and their derivatives: parts of one array, which are made when they are read.

    Attributes
    ----------
    every : (nq + m, 1 + 2 nq + nu + p) a and λ, and both by q, v, inputs and parameters
    a, lam : (nq,), (m,)
    a_q, a_v, a_u, a_b : (nq, nq), (nq, nq), (nq, nu), (nq, p) by coordinates, velocities, inputs and named parameters
    lam_q, lam_v, lam_u, lam_b : of the multipliers (m, ...)
    """

    __slots__ = ("_nq", "_nu", "every")

    def __init__(self, every: Array, nq: int, nu: int) -> None:
        self.every, self._nq, self._nu = every, nq, nu

    def __repr__(self) -> str:
        return f"ForwardDerivatives(nq={self._nq}, m={len(self.lam)}, nu={self._nu}, p={self.a_b.shape[1]})"

    @property
    def a(self) -> Array:
        return self.every[: self._nq, 0]

    @property
    def lam(self) -> Array:
        return self.every[self._nq :, 0]

    @property
    def a_q(self) -> Array:
        return self.every[: self._nq, 1 : self._nq + 1]

    @property
    def a_v(self) -> Array:
        return self.every[: self._nq, self._nq + 1 : 2 * self._nq + 1]

    @property
    def a_u(self) -> Array:
        return self.every[: self._nq, 2 * self._nq + 1 : 2 * self._nq + 1 + self._nu]

    @property
    def a_b(self) -> Array:
        return self.every[: self._nq, 2 * self._nq + 1 + self._nu :]

    @property
    def lam_q(self) -> Array:
        return self.every[self._nq :, 1 : self._nq + 1]

    @property
    def lam_v(self) -> Array:
        return self.every[self._nq :, self._nq + 1 : 2 * self._nq + 1]

    @property
    def lam_u(self) -> Array:
        return self.every[self._nq :, 2 * self._nq + 1 : 2 * self._nq + 1 + self._nu]

    @property
    def lam_b(self) -> Array:
        return self.every[self._nq :, 2 * self._nq + 1 + self._nu :]


class DifferentiatedDynamics(CompiledFunction):
    """The function (q, v, t, u, b) -> a, λ and their derivatives by q, v, inputs and parameters, compiled.

    Other compiled code calls ``function(data, least, b, t, q, v, every)``, which fills `every` (nq + m, 1 + 2 nq + nu +
    p): a and λ, and the derivatives of both by q, v, inputs and parameters. It returns how far the pivots can be
    trusted, as `ForwardDynamics.function` does. Multipliers are differentiated as those of independent constraints.

    Parameters
    ----------
    dynamics : of the system
    wrt : names of parameters

    Attributes
    ----------
    inputs, parameters : names, in the order of the columns
    function, data : of Numba code, see above; after the first call
    """

    def __init__(self, dynamics: ForwardDynamics, wrt: Sequence[str] = ()) -> None:
        system, nq = dynamics.system, dynamics.system.nq
        self._dynamics, self._system = dynamics, system
        self._parameters = ParameterChanges.of(system, wrt)
        self.parameters = self._parameters.names
        self.inputs = tuple(system.inputs)
        for name in self.inputs:
            dynamics.places(name)
            if system.inputs[name].driving:
                raise SarrusError(
                    f"{system.name}: a driver follows the input {name}, whose rates act, too. Drive the joint by a "
                    "force."
                )
        self._changes = np.hstack([input_changes(system, self.inputs), self._parameters.b])
        self._curved = bool(self._changes[system.nb :].any())
        self._shape = nq + system.m, 1 + 2 * nq + self._changes.shape[1]
        arrays = (np.zeros(shape) for shape in (nq, system.m, self._shape, self._shape))
        kernels = constraints(system), forces(system), by_parameters(system, self._changes)
        self._compiled = PivotedFunction(dynamics.order, loop.derivatives, *kernels, *arrays)
        self._last = np.empty(self._shape)  # used again when nobody refers to it: new memory is slow

    @cached_property
    def hessian(self) -> ForwardHessian:
        """The function whose values are contracted second derivatives, ``hessian(q, v, weights, t, u, b)``.

        Raises
        ------
        SarrusError
            For parameters of tables and formulas.
        """
        return ForwardHessian(self._dynamics, self.inputs, self._parameters)

    def _bound(self) -> LastingFunction:
        self._parameters.refuse_curves(self._system)
        return self._compiled.bound

    def __call__(
        self, q: ArrayLike, v: ArrayLike, t: float = 0.0, u: InputValues = None, b: ArrayLike | None = None
    ) -> ForwardDerivatives:
        """Return accelerations and multipliers with their derivatives, in new arrays; see `ForwardDynamics`.

        Raises
        ------
        SarrusError
            As `ForwardDynamics`; with `b`, for parameters of the model, which are known for those of the system only.
        """
        self._parameters.refuse_other(self._system, b)
        q, v, b = self._dynamics.vectors(q, v, u, b)
        order, t = self._dynamics.order, number("t", t)
        with order.lock:
            every = self._last
            if getrefcount(every) > OURS:
                every = self._last = np.empty(self._shape)
            self._compiled(b, t, q, v, every)
            if self._curved:
                self._add_curves(order, (t, q, v), b, every)
        if order.rows is not None:
            self._shorten(order.rows, (t, q, v), b, every)
        return ForwardDerivatives(every, self._system.nq, len(self.inputs))

    def _add_curves(self, order: PivotOrder, state: State, b: Array, every: Array) -> None:
        """Add what comes from changes of tables and formulas, with the factors at hand."""
        nq = self._system.nq
        solved = *state, every[:nq, 0].copy(), every[nq:, 0].copy()
        every[:, 1 + 2 * nq :] += curve_changes(self._system, order, solved, b, self._changes)

    def _shorten(self, rows: Array, state: State, b: Array, every: Array) -> None:
        """Turn changes of multipliers of independent constraints into those of minimum norm."""
        nq = self._system.nq
        solved = *state, every[:nq, 0].copy(), every[nq:, 0].copy()
        every[nq:, 1:] = minimum_norm_changes(self._system, rows, solved, b, self._changes, every[nq:, 1:])
