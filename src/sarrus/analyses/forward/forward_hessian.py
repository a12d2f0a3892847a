"""Second derivatives of forward dynamics by the state, inputs and parameters, contracted, as a compiled function."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ...algebra import Array
from ...model import SarrusError
from ..equilibria.linearization_loop import by_parameters, constraints, forces
from ..equilibria.settled_derivatives import CompiledFunction, LastingFunction
from . import hessian_loop as loop
from .contraction_loop import CurvedParameters, equations_of, state_of
from .forward_loop import PivotedFunction
from .parameter_changes import ParameterChanges
from .state_arguments import InputValues, number, vector

if TYPE_CHECKING:
    from .forward_dynamics import ForwardDynamics

FLOAT = np.dtype(float)


class ForwardHessian(CompiledFunction):
    """The function (q, v, weights, t, u, b) -> second derivatives of weighted a and λ, compiled.

    With constant weights w and ω, the result is the Hessian of wᵀa + ωᵀλ by q, v, inputs and parameters, in this
    order. All change independently.

    Other compiled code calls ``function(data, least, b, t, q, v, weights, H)``, which fills H (size, size) with
    size = 2 nq + nu + p, for weights (nq + m,). It returns how far the pivots can be trusted, as
    `ForwardDynamics.function` does.

    Parameters
    ----------
    dynamics : of the system
    inputs : names
    parameters : changes of b by parameters

    Attributes
    ----------
    inputs, parameters : names
    function, data : of Numba code, see above; after the first call
    """

    def __init__(
        self, dynamics: ForwardDynamics, inputs: tuple[str, ...], parameters: ParameterChanges
    ) -> None:
        self._dynamics, system, self._parameters = dynamics, dynamics.system, parameters
        self.inputs, self.parameters = inputs, parameters.names
        size = system.nq + system.m
        self._count = 2 * system.nq + len(self.inputs) + len(self.parameters)
        self._weights = Weights(system.nq, size)
        changes = CurvedParameters.of(system, inputs, parameters, 2 * system.nq)
        shape = size, 1 + 2 * system.nq + changes.b.shape[1]
        kernels = constraints(system), forces(system), by_parameters(system, changes.b)
        arrays = [np.zeros(one) for one in (system.nq, system.m, shape, shape)]
        lagrangian = changes.by_b, changes.curved, equations_of(system, ("motion",)), state_of(system)
        work = (np.zeros(one) for one in (shape, size, size))
        self._compiled = PivotedFunction(dynamics.order, loop.hessian, *kernels, *arrays, *lagrangian, *work)

    def _bound(self) -> LastingFunction:
        self._refuse_redundant()
        return self._compiled.bound

    def __call__(
        self,
        q: ArrayLike,
        v: ArrayLike,
        weights: ArrayLike,
        t: float = 0.0,
        u: InputValues = None,
        b: ArrayLike | None = None,
    ) -> Array:
        """Return the second derivatives (2 nq + nu + p, 2 nq + nu + p), exact, and symmetric to round-off.

        Parameters
        ----------
        q, v, t, u, b : see `ForwardDynamics`
        weights : (nq + m,) of accelerations and multipliers, or (nq,) of accelerations alone

        Raises
        ------
        SarrusError
            As `ForwardDynamics`; where constraints are redundant; with `b`, for parameters of the model, which are
            known for those of the system only.
        """
        self._parameters.refuse_other(self._dynamics.system, b)
        q, v, b = self._dynamics.vectors(q, v, u, b)
        H, every = np.empty((self._count, self._count)), self._weights(weights)
        with self._dynamics.order.lock:
            self._compiled(b, number("t", t), q, v, every, H)
        self._refuse_redundant()
        return H

    def _refuse_redundant(self) -> None:
        order = self._dynamics.order
        if order.rows is not None:
            raise SarrusError(
                f"{order.system.name}: second derivatives by all coordinates are not unique where constraints are "
                "redundant. Use in_coordinates(names).hessian, or remove the redundant constraints."
            )


class Weights:
    """Weights of rates or accelerations, and of multipliers behind them, as compiled code takes them.

    Parameters
    ----------
    first, every : how many there are without multipliers, and in all
    """

    def __init__(self, first: int, every: int) -> None:
        self._shapes = (first,), (every,)

    def __call__(self, w: ArrayLike) -> Array:
        """The weights (every,); those of multipliers are zero if they are left out.

        Raises
        ------
        ValueError
            If there are others.
        """
        first, every = self._shapes
        if type(w) is np.ndarray and w.dtype == FLOAT and w.flags.carray and w.shape == every:
            return w
        padded, some = np.zeros(every), vector("weights", w, first, every)
        padded[: len(some)] = some
        return padded
