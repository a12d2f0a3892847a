"""Forward dynamics as a function: accelerations and multipliers at a state, with derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...algebra import Array
from ...model import SarrusError
from ...model.states.input import refuse_unknown_input
from ...system import System
from ..arguments import refuse_other_system
from ..equilibria.settled_derivatives import CompiledFunction, LastingFunction
from ..sensitivity.parameters.parameters import listed
from . import forward_loop as loop
from .forward_derivatives import DifferentiatedDynamics, ForwardDerivatives
from .forward_hessian import ForwardHessian
from .forward_loop import PivotedFunction, PivotOrder
from .independent_dynamics import IndependentDynamics
from .state_arguments import InputValues, number, refuse_no_inputs, vector

FLOAT = np.dtype(float)
MOST = 8  # functions with derivatives that are stored, each with its arrays


class Forward(NamedTuple):
    """Accelerations (nq,) and multipliers (m,)."""

    a: Array
    lam: Array


class ForwardDynamics(CompiledFunction):
    """The function (q, v, t, u, b) -> a, λ of M a + Φ_qᵀ λ = Q + S, Φ_q a = γ, compiled.

    Coordinates and velocities should satisfy the constraints; they are not corrected. Redundant constraints are found
    at the first state; what elements remember is as in b. `system.forward_dynamics` is such a function. Calls from
    Python return new arrays, which later calls do not change.

    Other compiled code calls ``function(data, least, b, t, q, v, a, lam)``, which fills a and lam. It returns how far
    the order of the pivots can be trusted. Up to `least`, nothing else is done: a call from Python is needed, which
    chooses another order, and other `data`. Old `data` owns the arrays that it refers to, with the old order.

    Parameters
    ----------
    system : System

    Attributes
    ----------
    function, data : of Numba code, see above; after the first call
    """

    def __init__(self, system: System) -> None:
        refuse_other_system(system, "ForwardDynamics", unset=True)
        self.system, self.order = system, PivotOrder(system)
        self._compiled = PivotedFunction(self.order, loop.forward)
        self._differentiated = dict[tuple[str, ...], DifferentiatedDynamics]()
        self._places = dict[str, Array]()
        self._unset = [name for name, quantity in system.inputs.items() if not quantity.is_set]
        self._shape, self._b_shape = (system.nq,), system.b.shape

    def _bound(self) -> LastingFunction:
        return self._compiled.bound

    def __call__(
        self, q: ArrayLike, v: ArrayLike, t: float = 0.0, u: InputValues = None, b: ArrayLike | None = None
    ) -> Forward:
        """Return accelerations and multipliers.

        Parameters
        ----------
        q, v : (nq,)
        t : time [s]
        u : values of inputs by name; others as in the system
        b : (nb,) parameters of the elements, by default the system's

        Raises
        ------
        SarrusError
            In a singular configuration, and for an input that is unknown, not set, or varies with time.
        """
        q, v, b = self.vectors(q, v, u, b)
        a, lam = np.empty(self.system.nq), np.empty(self.system.m)
        with self.order.lock:
            self._compiled(b, number("t", t), q, v, a, lam)
        return Forward(a, lam)

    def differentiated(self, wrt: str | Sequence[str] = ()) -> DifferentiatedDynamics:
        """Return the function with its exact derivatives, by the state, inputs and parameters, for Numba code, too.

        Parameters
        ----------
        wrt : names of parameters as for `sensitivity`, by which a and λ are differentiated at constant q and v

        Raises
        ------
        SarrusError
            For inputs that drivers follow or that vary with time, and for unknown parameters.
        """
        names = wrt if isinstance(wrt, tuple) else tuple(listed(wrt))
        dynamics = self._differentiated.get(names)
        if dynamics is None:
            while len(self._differentiated) >= MOST:
                self._differentiated.pop(next(iter(self._differentiated)), None)
            dynamics = self._differentiated[names] = DifferentiatedDynamics(self, names)
        return dynamics

    def derivatives(
        self,
        q: ArrayLike,
        v: ArrayLike,
        t: float = 0.0,
        u: InputValues = None,
        b: ArrayLike | None = None,
        *,
        wrt: str | Sequence[str] = (),
    ) -> ForwardDerivatives:
        """Return accelerations and multipliers with their exact derivatives, as `__call__`.

        The derivatives are those of the function: q and v change independently, also off the constraints. In
        independent coordinates `linearize` returns them. Inputs are in the order of ``system.inputs``. Redundant
        constraints have multipliers of minimum norm, whose derivatives are right for changes that satisfy them.

        Parameters
        ----------
        q, v, t, u, b : as of `__call__`
        wrt : names of parameters, see `differentiated`; with `b`, those of elements, see ``system.parameter_names``

        Raises
        ------
        SarrusError
            As `__call__` and `differentiated`.
        """
        return self.differentiated(wrt)(q, v, t, u, b)

    @cached_property
    def hessian(self) -> ForwardHessian:
        """The function whose values are contracted second derivatives, ``hessian(q, v, weights, t, u, b)``.

        ``differentiated(wrt).hessian`` has those by parameters, too.

        Raises
        ------
        SarrusError
            For inputs that drivers follow or that vary with time.
        """
        return self.differentiated().hessian

    def in_coordinates(
        self, coordinates: Sequence[str], wrt: str | Sequence[str] = ()
    ) -> IndependentDynamics:
        """Return the function of the state whose values are the matrices of small changes, as of `linearize`.

        Parameters
        ----------
        coordinates : names of as many independent outputs of the position as there are degrees of freedom
        wrt : names of parameters, by which the rates of the states are differentiated at constant coordinates

        Raises
        ------
        UnknownOutput
            If one is no output of the position.
        SarrusError
            For unknown parameters, those of tables and formulas, and coordinates that no joint or body has with them.
        """
        return IndependentDynamics(self, coordinates, wrt)

    def vectors(self, q: Any, v: Any, u: InputValues, b: Any) -> tuple[Array, Array, Array]:
        """Return q, v and b as arrays, with the values of inputs in b; what is wrong is refused."""
        if not (isinstance(q, np.ndarray) and q.dtype is FLOAT and q.flags.carray and q.shape == self._shape):
            q = vector("q", q, self._shape)
        if not (isinstance(v, np.ndarray) and v.dtype is FLOAT and v.flags.carray and v.shape == self._shape):
            v = vector("v", v, self._shape)
        numbers = self.system.b if b is None else vector("b", b, self._b_shape)
        if u:
            refuse_no_inputs(u)
            numbers = numbers.copy()
            for name, value in u.items():
                numbers[self.places(name)] = number(name, value)
        for name in self._unset:
            if not (u and name in u) and (b is None or not np.isfinite(numbers[self.places(name)]).all()):
                raise SarrusError(
                    f"{self.system.name}: the input {name} is not set. Pass u={{{name!r}: 0.0}}."
                )
        return q, v, numbers

    def places(self, name: str) -> Array:
        """Return the places of the value of an input in b.

        Raises
        ------
        SarrusError
            For an input that is unknown, or varies with time.
        """
        places = self._places.get(name)
        if places is None:
            system = self.system
            refuse_unknown_input(system.name, name, system.inputs)
            if system.inputs[name].varies:
                raise SarrusError(
                    f"{system.name}: the input {name} varies with time. Use that of "
                    f"system.with_inputs({{{name!r}: 0.0}})."
                )
            places = self._places[name] = np.asarray(system.inputs[name].places)
        return places
