"""Forward dynamics in independent coordinates as functions: rates of states, and matrices of small changes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from threading import Lock
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..._jit.kernels.pointer import NONE, KernelTable, call_kernels
from ..._jit.linking.link import compiled
from ...algebra import Array
from ...model.checks.arguments import CHECKS
from ..arguments import refuse_other_system
from ..dynamics.dense_output.sample_loop import Entries, Matrix, Work
from ..dynamics.stepping.entries import entry_of
from ..equations.minimum_norm import Omissions
from ..equations.states_at_rest import places
from ..equilibria.balance import input_changes
from ..equilibria.linear_loop import Coordinates
from ..equilibria.settled_derivatives import CompiledFunction, LastingFunction
from ..equilibria.state_space import NONHOLONOMIC, Plan
from ..position.coordinate_set import CoordinateSet, of_names
from .forward_loop import PivotedFunction, forward
from .independent_hessian import IndependentHessian
from .parameter_changes import ParameterChanges
from .state_arguments import InputValues, number

if TYPE_CHECKING:
    from .forward_dynamics import ForwardDynamics


class Matrices:
    """The matrices of ẋ = A x + B u + E b for small changes, also of parameters: parts of one array.

    They can be unpacked, ``A, B, E = matrices``.

    Attributes
    ----------
    every : (nx, nx + nu + p)
    A, B, E : (nx, nx), (nx, nu), (nx, p)
    """

    __slots__ = ("_nu", "every")

    def __init__(self, every: Array, nu: int) -> None:
        self.every, self._nu = every, nu

    def __iter__(self) -> Iterator[Array]:
        yield from (self.A, self.B, self.E)

    @property
    def A(self) -> Array:
        return self.every[:, : len(self.every)]

    @property
    def B(self) -> Array:
        return self.every[:, len(self.every) : len(self.every) + self._nu]

    @property
    def E(self) -> Array:
        return self.every[:, len(self.every) + self._nu :]


class IndependentDynamics(CompiledFunction):
    """The function (q, v, t, u, b) -> A, B, E of small changes in independent coordinates, compiled; see `linearize`.

    E has the derivatives by parameters at constant coordinates, rates, states and inputs: where a parameter moves the
    mechanism, its other coordinates follow. Results are new arrays, which later calls do not change.

    Other compiled code calls ``function(data, least, b, t, q, v)``, which fills `matrices`: A is the left part, then B
    and E. It returns how far the order of the pivots can be trusted, as that of `ForwardDynamics`, and the place of a
    coordinate that is dependent, or -1. The rates of the states have ``rates.function(rates.data, least, b, t, q, v,
    x_rate)``, which fills `x_rate` (nx,).

    Parameters
    ----------
    dynamics : of the system
    coordinates : names of independent outputs of the position
    wrt : names of parameters

    Attributes
    ----------
    states, inputs, parameters : names of the entries of x and u, and of the columns of E
    matrices : (nx, nx + nu + p) the array that compiled code fills
    function, data : of Numba code, after the first call
    rates : the function (q, v, t, u, b) -> ẋ, see `StateRates`
    """

    def __init__(
        self, dynamics: ForwardDynamics, coordinates: Sequence[str], wrt: Sequence[str] = ()
    ) -> None:
        system = dynamics.system
        refuse_other_system(system, "in_coordinates", nonholonomic=NONHOLONOMIC, unset=True)
        CHECKS["variables"]("coordinates", coordinates)
        self._dynamics, self._system, self._lock = dynamics, system, Lock()
        self.inputs = tuple(name for name, u in system.inputs.items() if not u.driving and not u.varies)
        independent, changes = of_names(system, tuple(coordinates)), ParameterChanges.of(system, wrt)
        changes.refuse_curves(system)
        self._changes, self.parameters = changes, changes.names
        by_b = np.hstack([input_changes(system, self.inputs), changes.b])
        by_c = changes.of_coordinates(system, independent)
        none = np.zeros((len(by_c), len(self.inputs)))
        self._independent = independent
        self._plan = Plan(system, independent, by_b, np.hstack([none, by_c]))
        names, rates, _ = independent.labels()
        self.states = (*names, *rates, *system.states)
        self.matrices, self.rates = self._plan.A, StateRates(dynamics, independent)

    @cached_property
    def hessian(self) -> IndependentHessian:
        """The function whose values are contracted second derivatives, ``hessian(q, v, weights, t, u, b)``."""
        return IndependentHessian(self._dynamics, self._independent, self.inputs, self._changes)

    def _bound(self) -> LastingFunction:
        return self._plan.bound(self._system)

    def __call__(
        self, q: ArrayLike, v: ArrayLike, t: float = 0.0, u: InputValues = None, b: ArrayLike | None = None
    ) -> Matrices:
        """Return A, B and E at a state on the constraints; for arguments see `ForwardDynamics`.

        Raises
        ------
        SarrusError
            In a singular configuration; for coordinates that are dependent or not as many as the degrees of freedom;
            with `b`, for parameters of the model, which are known for those of the system only.
        """
        self._changes.refuse_other(self._system, b)
        q, v, b = self._dynamics.vectors(q, v, u, b)
        with self._lock:
            self._plan.evaluate(self._system, b, number("t", t), q, v)
            matrices = self.matrices.copy()
        return Matrices(matrices, len(self.inputs))


class StateRates(CompiledFunction):
    """The function (q, v, t, u, b) -> ẋ of the states in independent coordinates: ċ, c̈ and ṡ, compiled."""

    def __init__(self, dynamics: ForwardDynamics, independent: CoordinateSet) -> None:
        system, measured = dynamics.system, independent.measured
        self._dynamics = dynamics
        state_places, n = places(system), len(independent.row)
        of = Coordinates(independent.row, independent.place, np.arange(n), state_places)
        self._compiled = PivotedFunction(
            dynamics.order, state_rates, _measured(measured), of, np.zeros(system.nq), np.zeros(system.m)
        )
        self._size = 2 * n + len(state_places)

    def _bound(self) -> LastingFunction:
        return self._compiled.bound

    def __call__(
        self, q: ArrayLike, v: ArrayLike, t: float = 0.0, u: InputValues = None, b: ArrayLike | None = None
    ) -> Array:
        """Return the rates (nx,); for arguments and errors see `ForwardDynamics`."""
        q, v, b = self._dynamics.vectors(q, v, u, b)
        rates = np.empty(self._size)
        with self._dynamics.order.lock:
            self._compiled(b, number("t", t), q, v, rates)
        return rates


def _measured(of: Any) -> Measures:
    """Coordinates that elements measure, for compiled code."""
    kernels = (entry_of(of, "Phi_q_xi"), entry_of(of, "gamma")) if of.m else (NONE, NONE)
    return Measures(*kernels, of.b, *(np.zeros(of.m) for _ in range(3)))


class Measures(NamedTuple):
    """Kernels of c_q ξ and γ = c_q a - c̈ of coordinates that elements measure, their parameters, and work arrays."""

    along: KernelTable
    gamma: KernelTable
    b: Array
    rate: Array
    acceleration: Array
    bend: Array


@compiled
def state_rates(
    entries: Entries, work: Work, matrix: Matrix, others: Omissions, measured: Measures, of: Coordinates, a: Array,
    lam: Array, least: float, b: Array, t: float, q: Array, v: Array, rates: Array,
) -> float:  # fmt: skip
    """Fill a, λ, and the rates of the states (nx,): ċ, c̈ = c_q a - γ, ṡ; if the pivots are trusted more than `least`.

    Returns
    -------
    how far the pivots can be trusted, -1 if vectors have other sizes
    """
    if len(rates) != 2 * len(of.row) + len(of.states):
        return -1.0
    trust = forward(entries, work, matrix, others, least, b, t, q, v, a, lam)
    if trust > least:
        n = len(of.row)
        call_kernels(measured.along, measured.b, t, q, v, measured.rate)
        call_kernels(measured.along, measured.b, t, q, a, measured.acceleration)
        call_kernels(measured.gamma, measured.b, t, q, v, measured.bend)
        for k in range(n):
            row, place = of.row[k], of.place[k]
            if row >= 0:
                rates[k], rates[n + k] = measured.rate[row], measured.acceleration[row] - measured.bend[row]
            else:
                rates[k], rates[n + k] = v[place], a[place]
        for k in range(len(of.states)):
            rates[2 * n + k] = a[of.states[k]]
    return trust
