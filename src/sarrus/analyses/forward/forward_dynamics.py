"""Forward dynamics as a function: accelerations and multipliers at a state, with derivatives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from threading import Lock
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..._jit.kernels.bound import Bound
from ...algebra import Array
from ...model import SarrusError
from ...model.states.input_values import refuse_unknown_input
from ...system import System
from ..arguments import refuse_other_system
from ..dynamics.dense_output.sampler import motion_arrays, motion_entries, motion_work
from ..equations.block_matrix import PRECISE
from ..equations.minimum_norm import left_out
from ..equilibria.kernel_records import constraints, forces
from ..equilibria.motion_at import TRUSTED, loads_by_inputs, matrix_at, singular
from ..redundancy.redundant_constraints import Independence
from . import forward_loop as loop
from .independent_dynamics import IndependentDynamics
from .state_changes import StateChanges, parameter_changes

LESS = 0.1  # of the trust in pivots just chosen: below it they are chosen again


class Forward(NamedTuple):
    """Accelerations (nq,) and multipliers (m,)."""

    a: Array
    lam: Array


class ForwardDerivatives(NamedTuple):
    """Accelerations and multipliers, and their derivatives.

    By coordinates and velocities (…, nq), by inputs (…, nu), and by the parameters that were named (…, p).
    """

    a: Array
    lam: Array
    a_q: Array
    a_v: Array
    a_u: Array
    a_b: Array
    lam_q: Array
    lam_v: Array
    lam_u: Array
    lam_b: Array


class ForwardDynamics:
    """The function (q, v, t, u, b) -> a, λ of M a + Φ_qᵀ λ = Q + S, Φ_q a = γ, compiled.

    Coordinates and velocities should satisfy the constraints; they are not corrected. Redundant constraints are found
    at the first state; what elements remember is as in b. `system.forward_dynamics` is such a function.

    Other compiled code calls ``function(data, least, b, t, q, v, a, lam)``, which fills a and lam. It returns how far
    the order of the pivots can be trusted. Up to `least`, nothing else is done: a call from Python is needed, which
    chooses another order, and other `data`.

    Parameters
    ----------
    system : System

    Attributes
    ----------
    function, data : of Numba code, see above; after the first call
    derivative_function, derivative_data : the derivatives for Numba code,
        ``derivative_function(derivative_data, found, Q_u, b, t, q, v, a, lam)``, after a call of `function` with the
        same state; fills `found` (nq + m, 2 nq + nu) with the derivatives of a and λ by q, v and inputs, with the
        derivatives `Q_u` (nq, nu) of the forces by the inputs given. Multipliers are those of independent constraints
    """

    def __init__(self, system: System) -> None:
        refuse_other_system(system, "ForwardDynamics", unset=True)
        self.system, self._lock = system, Lock()
        self._entries, self._work = motion_entries(system), motion_work(system)
        self._forward: Bound | None = None
        self._derivatives: Bound | None = None
        self._rows: Array | None = None
        self._least = PRECISE

    @property
    def function(self) -> Any:
        """The compiled function."""
        return self._bound.function

    @property
    def data(self) -> Array:
        """The first argument of the compiled function."""
        return self._bound.data

    @property
    def derivative_function(self) -> Any:
        """The compiled derivatives."""
        return self._slopes.function

    @property
    def derivative_data(self) -> Array:
        """The first argument of the compiled derivatives."""
        return self._slopes.data

    @property
    def _slopes(self) -> Bound:
        if self._derivatives is None:
            raise SarrusError(f"{self.system.name}: call the function with a state first.")
        return self._derivatives

    @property
    def _bound(self) -> Bound:
        if self._forward is None:
            raise SarrusError(f"{self.system.name}: call the function with a state first.")
        return self._forward

    def __call__(
        self,
        q: ArrayLike,
        v: ArrayLike,
        t: float = 0.0,
        u: Mapping[str, float] | None = None,
        b: ArrayLike | None = None,
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
        with self._lock:
            self._solve(b, t, q, v, a, lam)
        return Forward(a, lam)

    def derivatives(
        self,
        q: ArrayLike,
        v: ArrayLike,
        t: float = 0.0,
        u: Mapping[str, float] | None = None,
        b: ArrayLike | None = None,
        *,
        wrt: Sequence[str] = (),
    ) -> ForwardDerivatives:
        """Return accelerations and multipliers with their exact derivatives, as `__call__`.

        The derivatives are those of the function: q and v change independently, also off the constraints. In
        independent coordinates `linearize` returns them. Inputs are in the order of ``system.inputs``. Redundant
        constraints have multipliers of minimum norm, whose derivatives are right for changes that satisfy them.

        Parameters
        ----------
        q, v, t, u, b : as of `__call__`
        wrt : names of parameters as for `sensitivity`, by which a and λ are differentiated at constant q and v; with
            `b`, those of elements, see ``system.parameter_names``

        Raises
        ------
        SarrusError
            As `__call__`; for inputs that drivers follow, and for unknown parameters.
        """
        system, nq, names = self.system, self.system.nq, list(self.system.inputs)
        changes = parameter_changes(system, wrt, own=b is not None)
        q, v, b = self.vectors(q, v, u, b)
        for name in names:
            self._places(name)
            if system.inputs[name].driving:
                raise SarrusError(
                    f"{system.name}: a driver follows the input {name}, whose rates act, too. Drive the joint by a "
                    "force."
                )
        a, lam, found = np.empty(nq), np.empty(system.m), np.zeros((nq + system.m, 2 * nq + len(names)))
        with self._lock:
            self._solve(b, t, q, v, a, lam)
            Q_u = loads_by_inputs(system, q, v, t, b, names)
            assert self._derivatives is not None
            self._derivatives(found, Q_u, b, float(t), q, v, a, lam)
            rows = self._rows
        by_b = np.zeros((len(found), 0))
        if rows is not None or len(wrt):
            state = StateChanges(system, (t, q, v, a, lam), b, rows)
            if len(wrt):
                by_b = state.by_parameters(changes)
            moved = np.zeros((len(b), found.shape[1]))
            for k, name in enumerate(names):
                moved[self._places(name), 2 * nq + k] = 1.0
            found[nq:] = state.reported(np.eye(nq, found.shape[1]), moved, found[nq:])
        of_a, of_lam, end = found[:nq], found[nq:], 2 * nq
        a_q, a_v, a_u = of_a[:, :nq], of_a[:, nq:end], of_a[:, end:]
        lam_q, lam_v, lam_u = of_lam[:, :nq], of_lam[:, nq:end], of_lam[:, end:]
        return ForwardDerivatives(a, lam, a_q, a_v, a_u, by_b[:nq], lam_q, lam_v, lam_u, by_b[nq:])

    def in_coordinates(self, coordinates: Sequence[str]) -> IndependentDynamics:
        """Return the function of the state whose values are the matrices of small changes, as of `linearize`.

        Parameters
        ----------
        coordinates : names of as many independent outputs of the position as there are degrees of freedom

        Raises
        ------
        UnknownOutput
            If one is no output of the position.
        """
        return IndependentDynamics(self, coordinates)

    def vectors(self, q: Any, v: Any, u: Mapping[str, float] | None, b: Any) -> tuple[Array, Array, Array]:
        """Return q, v and b as arrays, with the values of inputs in b; what is wrong is refused."""
        system = self.system
        q, v = np.ascontiguousarray(q, dtype=float), np.ascontiguousarray(v, dtype=float)
        numbers = system.b if b is None else np.ascontiguousarray(b, dtype=float)
        for name, x, size in (("q", q, system.nq), ("v", v, system.nq), ("b", numbers, len(system.b))):
            if x.shape != (size,):
                raise ValueError(
                    f"{name} must have shape ({size},), got {x.shape}. Pass a vector of this length."
                )
        for name, one in system.inputs.items():
            if not one.is_set and b is None and name not in (u or {}):
                raise SarrusError(f"{system.name}: the input {name} is not set. Pass u={{{name!r}: 0.0}}.")
        if u:
            numbers = numbers.copy()
            for name, value in u.items():
                numbers[self._places(name)] = value
        return _writeable(q), _writeable(v), numbers

    def _places(self, name: str) -> Array:
        system = self.system
        refuse_unknown_input(system.name, name, system.inputs)
        if system.inputs[name].varies:
            raise SarrusError(
                f"{system.name}: the input {name} varies with time. Use that of system.with_inputs({{{name!r}: 0.0}})."
            )
        return system.inputs[name].places

    def _solve(self, b: Array, t: float, q: Array, v: Array, a: Array, lam: Array) -> None:
        state = (b, float(t), q, v, a, lam)
        if self._forward is not None and self._forward(self._least, *state) > self._least:
            return
        self._renew(b, t, q)
        trust = self._bound(TRUSTED, *state)
        if not trust > TRUSTED:
            raise singular(self.system, t)
        self._least = min(PRECISE, LESS * trust)

    def _renew(self, b: Array, t: float, q: Array) -> None:
        """Choose pivots, and at the first state independent equations."""
        system = self.system
        if self._forward is None:
            self._rows = Independence(system, q, t).rows
        arrays = motion_arrays(matrix_at(system, q, t, b, self._rows))
        shape = (system.nq + system.m, 2 * system.nq + len(system.inputs))
        self._forward = Bound(loop.forward, self._entries, self._work, arrays, left_out(system, self._rows))
        records = constraints(system), forces(system), np.zeros(shape), np.zeros(shape)
        self._derivatives = Bound(loop.derivatives, arrays, *records)


def _writeable(x: Array) -> Array:
    """A read-only array as a copy: compiled code has one type of arrays."""
    return x if x.flags.writeable else x.copy()
