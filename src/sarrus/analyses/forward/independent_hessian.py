"""Second derivatives of forward dynamics in independent coordinates, contracted, as a compiled function."""

from __future__ import annotations

from collections.abc import Sequence
from threading import Lock
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ...algebra import Array
from ...model import SarrusError
from ...system import System
from ..equilibria.linear_loop import Maps
from ..equilibria.settled_derivatives import CompiledFunction, LastingFunction
from ..equilibria.state_space import Plan
from ..position.coordinate_set import CoordinateSet
from . import independent_hessian_loop as loop
from .contraction_loop import CurvedParameters, equations_of, state_of
from .forward_hessian import Weights
from .parameter_changes import ParameterChanges
from .state_arguments import InputValues, number

if TYPE_CHECKING:
    from .forward_dynamics import ForwardDynamics


class HessianPlan(Plan):
    """Arrays of the compiled second derivatives in given coordinates, with those of the linearization.

    Parameters
    ----------
    system, independent, changes, c_changes : see `Plan`
    more : arguments of the compiled function behind those of `linearized`

    Attributes
    ----------
    maps : changes of the state
    of_multipliers : weights of multipliers, which are refused where constraints are redundant
    """

    of_multipliers: Array

    def __init__(
        self,
        system: System,
        independent: CoordinateSet,
        changes: Array,
        c_changes: Array,
        more: tuple[Any, ...],
    ) -> None:
        super().__init__(system, independent, changes, c_changes)
        self._more, self.of_multipliers = more, np.zeros(0)

    def _bind(self, *arguments: Any) -> tuple[LastingFunction, LastingFunction]:
        function = LastingFunction(loop.hessian, *arguments, *self._more)
        return function, function

    @property
    def maps(self) -> Maps:
        return self._maps

    def _renew(self, system: System, b: Array, t: float, q: Array) -> None:
        super()._renew(system, b, t, q)
        if self._redundant and self.of_multipliers.any():
            raise SarrusError(
                f"{system.name}: second derivatives of multipliers are not unique where constraints are redundant. "
                "Pass weights of the rates alone, or remove the redundant constraints."
            )


class IndependentHessian(CompiledFunction):
    """The function (q, v, weights, t, u, b) -> second derivatives of weighted rates ẋ, compiled.

    The states x are independent coordinates, their rates and first-order states. With weights w of ẋ and ω of the
    multipliers, the result is the Hessian of wᵀẋ + ωᵀλ by [x; u] and the parameters; with a parameter, the mechanism
    moves as for E of `IndependentDynamics`.

    Other compiled code calls ``function(data, least, b, t, q, v, weights, H)``, which fills H (size, size) with size =
    nx + nu + p, for weights (nx + m,). It returns what that of `IndependentDynamics` does.

    Parameters
    ----------
    dynamics : of the system
    independent : coordinates
    inputs : names
    parameters : changes of b by parameters; by default none

    Attributes
    ----------
    function, data : of Numba code, see above; after the first call
    plan : with the changes of the state by x, u and parameters
    adjoint : with constant weights of q, v and a, which are added to the sum
    """

    def __init__(
        self,
        dynamics: ForwardDynamics,
        independent: CoordinateSet,
        inputs: Sequence[str],
        parameters: ParameterChanges | None = None,
    ) -> None:
        system = self._system = dynamics.system
        self._dynamics, self._lock, size = dynamics, Lock(), system.nq + system.m
        self._parameters = parameters or ParameterChanges.of(system, ())
        self._nx = 2 * len(independent.row) + len(system.states)
        self._count = self._nx + len(inputs) + len(self._parameters.names)
        changes = CurvedParameters.of(system, inputs, self._parameters, self._nx, independent)
        self.adjoint = loop.Adjoint._make(
            np.zeros(n) for n in (*[system.nq] * 5, independent.measured.m, size, size)
        )
        equations = equations_of(system), equations_of(independent.measured)
        more = (*changes[2:], *equations, state_of(system), self.adjoint)
        self.plan = HessianPlan(system, independent, changes.b, changes.c, more)
        self._weights = Weights(self._nx, self._nx + system.m)

    def _bound(self) -> LastingFunction:
        return self.plan.bound(self._system)

    def __call__(
        self,
        q: ArrayLike,
        v: ArrayLike,
        weights: ArrayLike,
        t: float = 0.0,
        u: InputValues = None,
        b: ArrayLike | None = None,
    ) -> Array:
        """Return the second derivatives (nx + nu + p, nx + nu + p) at a state on the constraints.

        They are exact, and symmetric to round-off.

        Parameters
        ----------
        q, v, t, u, b : see `ForwardDynamics`
        weights : (nx + m,) of the rates of states and of the multipliers, or (nx,) of the rates alone

        Raises
        ------
        SarrusError
            As `IndependentDynamics`, and for weights of multipliers where constraints are redundant.
        """
        self._parameters.refuse_other(self._system, b)
        q, v, b = self._dynamics.vectors(q, v, u, b)
        H, every = np.empty((self._count, self._count)), self._weights(weights)
        with self._lock:
            self.plan.of_multipliers = every[self._nx :]
            self.plan.evaluate(self._system, b, number("t", t), q, v, False, False, every, H)
        return H
