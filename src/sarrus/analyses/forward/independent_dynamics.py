"""Forward dynamics in independent coordinates as a function: the matrices of small changes at a state."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from threading import Lock
from typing import TYPE_CHECKING, Any, NamedTuple

from numpy.typing import ArrayLike

from ...algebra import Array
from ...model.checks.arguments import CHECKS
from ..arguments import refuse_other_system
from ..equilibria.independent_coordinates import of_names
from ..equilibria.state_space import NONHOLONOMIC, Plan

if TYPE_CHECKING:
    from .forward_dynamics import ForwardDynamics


class Matrices(NamedTuple):
    """The matrices of ẋ = A x + B u for small changes (nx, nx), (nx, nu)."""

    A: Array
    B: Array


class IndependentDynamics:
    """The function (q, v, t, u, b) -> A, B of small changes in independent coordinates, compiled; see `linearize`.

    Other compiled code calls ``function(data, b, t, q, v, a, lam, least, False)``, which fills a, lam and `matrices`: A
    is the left part, B the right. It returns how far the order of the pivots can be trusted, as that of
    `ForwardDynamics`, and the place of a coordinate that is dependent, or -1. There the derivatives of forces by inputs
    are those of the last call from Python.

    Parameters
    ----------
    dynamics : of the system
    coordinates : names of independent outputs of the position

    Attributes
    ----------
    states, inputs : names of the entries of x and u
    matrices : (nx, nx + nu) the array that compiled code fills
    function, data : of Numba code, after the first call
    """

    def __init__(self, dynamics: ForwardDynamics, coordinates: Sequence[str]) -> None:
        system = dynamics.system
        refuse_other_system(system, "in_coordinates", nonholonomic=NONHOLONOMIC, unset=True)
        CHECKS["variables"]("coordinates", coordinates)
        self._dynamics, self._system, self._lock = dynamics, system, Lock()
        self.inputs = tuple(name for name, one in system.inputs.items() if not one.driving and not one.varies)
        independent = of_names(system, coordinates)
        self._plan = Plan(system, independent, len(self.inputs))
        names, rates, _ = independent.labels()
        self.states = (*names, *rates, *system.states)
        self.matrices = self._plan.A

    @property
    def function(self) -> Any:
        """The compiled function."""
        return self._plan.bound(self._system).function

    @property
    def data(self) -> Array:
        """The first argument of the compiled function."""
        return self._plan.bound(self._system).data

    def __call__(
        self,
        q: ArrayLike,
        v: ArrayLike,
        t: float = 0.0,
        u: Mapping[str, float] | None = None,
        b: ArrayLike | None = None,
    ) -> Matrices:
        """Return A and B at a state on the constraints; for arguments see `ForwardDynamics`.

        Raises
        ------
        SarrusError
            In a singular configuration, and for coordinates that are dependent or not as many as the degrees of
            freedom.
        """
        q, v, b = self._dynamics.vectors(q, v, u, b)
        nx = len(self.states)
        with self._lock:
            self._plan.evaluate(self._system, (b, float(t), q, v), self.inputs)
            found = self.matrices.copy()
        return Matrices(found[:, :nx], found[:, nx:])
