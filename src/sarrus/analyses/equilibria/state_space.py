"""Linearization of the equations of motion in independent coordinates: a state space with names and units."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from threading import Lock
from typing import Any, NamedTuple, NoReturn

import numpy as np
from numpy.typing import ArrayLike

from ...algebra import Array
from ...model import SarrusError
from ...model.announcement import reports_warnings
from ...model.checks.arguments import CHECKS
from ...model.states.input import refuse_repeated_inputs, refuse_unknown_input
from ...model.tape import Tracer
from ...outputs import Outputs
from ...outputs.motion import motion_outputs
from ...outputs.output import Level, components, find_output
from ...results import Assembly, Equilibrium
from ...results.state_space import StateSpace
from ...system import System
from ...system.cached import once
from ..arguments import refuse_other_system
from ..dynamics.dense_output.sampler import motion_arrays, motion_entries, motion_work
from ..equations.block_matrix import PRECISE
from ..equations.length import units
from ..equations.minimum_norm import least_multipliers
from ..equations.nullspace import NullSpace, pivoted_rows
from ..equations.states_at_rest import places
from ..position.coordinate_set import CoordinateSet, of_names
from ..position.initial_state import PartialState, Start, consistent_state_of, meant
from . import linear_loop as loop
from .balance import TRUSTED, independent_at, input_changes, matrix_at, refuse_not_finite, unsolved
from .independent_coordinates import chosen, of_joints
from .linearization_loop import by_parameters, constraints, displacing, forces, linearized
from .settled_derivatives import LastingFunction

NONHOLONOMIC = "positions have more freedoms than velocities. Use `sr.modes`, whose `matrix` is that of A."


@reports_warnings
def linearize(
    system: System,
    q: Start,
    v: ArrayLike | None = None,
    *,
    t: float | None = None,
    coordinates: Sequence[str] | None = None,
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] | None = None,
) -> StateSpace:
    """Linearize the equations of motion about a state: ẋ = A x + B u, y = C x + D u for small changes.

    The states x are independent coordinates, their rates, and the first-order states of the model. With the exact
    K = (M a)_q + (Φ_qᵀ lam)_q - Q_q - S_q and D = -(Q_v + S_v), changes obey

        M δa + D δv + K δq + Φ_qᵀ δlam = Q_u δu,    Φ_q δa = (γ_q - (Φ_q a)_q) δq + γ_v δv,
        Φ_q δv = -(Φ_q v + Φ_t)_q δq,               Φ_q δq = 0.

    Any state on the constraints may be given; along a motion the matrices are those of its linear variational equations
    at that time. For steady motions in a rotating frame, see `modes`.

    Parameters
    ----------
    system : System
    q, v : (nq,) an equilibrium (v = 0), or any state; both must satisfy the constraints. `q` may also be an `Assembly`,
        a `State` or an `Equilibrium`, which has its own velocities and time
    t : time [s]; by default that of the state, or 0
    coordinates : names of as many independent outputs of the position as there are degrees of freedom, such as
        ``["pin.angle", "cart.x"]``; by default coordinates of joints, and of bodies where these are not enough
    inputs : names of inputs of the model, by default all; an input that varies with time has its value at that time
    outputs : names of outputs, by default the coordinates

    Returns
    -------
    StateSpace

    Raises
    ------
    TypeError
        For names that are no list of them.
    SarrusError
        For coordinates that are dependent or not as many as the degrees of freedom, an input that drivers follow, a
        singular configuration, and reactions as outputs where constraints are redundant.
    UnknownOutput
        If there is no such output.
    """
    refuse_other_system(system, "linearize", nonholonomic=NONHOLONOMIC)
    for word, listed in (("coordinates", coordinates), ("inputs", inputs), ("outputs", outputs)):
        if listed is not None:
            CHECKS["variables"](word, listed)
    names = _inputs(system, inputs)
    q = meant(system, q)
    state = consistent_state_of(system, q, v, t)
    system = _with_numbers(system, names, state)
    solved, independent = _solved(system, state, coordinates, names, outputs is not None)
    start = q if isinstance(q, Assembly | Equilibrium) and v is None and state.t == q.t else None
    return _result(system, state, solved, independent, names, outputs, start)


def _inputs(system: System, names: Iterable[str] | None) -> tuple[str, ...]:
    """The inputs by which derivatives are taken.

    Raises
    ------
    SarrusError
        For an unknown one, one that is named twice, and one that a driver follows.
    """
    inputs = tuple(system.inputs) if names is None else tuple(names)
    refuse_repeated_inputs(system.name, inputs)
    for name in inputs:
        refuse_unknown_input(system.name, name, system.inputs)
        if names is not None and system.inputs[name].driving:
            raise SarrusError(
                f"{system.name}: a driver follows the input {name}, so that its rates act, too. Drive the joint by a "
                "force or torque instead."
            )
    return tuple(name for name in inputs if not system.inputs[name].driving)


def _with_numbers(system: System, names: tuple[str, ...], state: PartialState) -> System:
    """The system in which inputs that vary with time are numbers: their values at the time."""
    varying = [name for name in names if system.inputs[name].varies]
    if not varying:
        return system
    none = np.zeros(system.nq)
    at = OneState.of(state.t, state.q, none, none, np.zeros(system.m), state.memory, state.revolutions)
    values = output_slopes(system, varying, at).values
    return system.with_inputs(dict(zip(varying, values.tolist(), strict=True)))


class StateArrays(NamedTuple):
    """What the compiled linearization computes: A with B, changes of q and v by x, of a and λ by x and u; a, λ."""

    A: Array
    q: Array
    v: Array
    motion: Array
    a: Array
    lam: Array
    redundant: bool
    labels: tuple[tuple[str, ...], ...]


class DependentCoordinates(SarrusError):
    """Coordinates that do not describe the position; with those of them that are independent, by name."""

    def __init__(self, message: str, independent: tuple[str, ...]) -> None:
        super().__init__(message)
        self.independent = independent


def _solved(
    system: System,
    state: PartialState,
    coordinates: Sequence[str] | None,
    inputs: tuple[str, ...],
    whole: bool,
) -> tuple[StateArrays, CoordinateSet]:
    """The linearization in coordinates that are named, or chosen: all of joints and floating bodies, if independent."""
    names = of_joints(system, state.q) if coordinates is None else tuple(coordinates)
    try:
        plan = plan_of(system, names, inputs)
        return plan.solved(system, state, whole), plan.independent
    except DependentCoordinates as all_of_joints:
        if coordinates is not None:
            raise
        freedom, refused, names = plan.freedom(system), names, all_of_joints.independent
    if len(names) < freedom or names == refused:
        names = chosen(system, state.q, state.t, state.parameters(system))
    plan = plan_of(system, names, inputs)
    return plan.solved(system, state, whole), plan.independent


@once
def plan_of(system: System, names: tuple[str, ...], inputs: tuple[str, ...]) -> Plan:
    """The plan of some coordinates and inputs; cached."""
    return Plan(system, of_names(system, names), input_changes(system, inputs))


class Plan:
    """Arrays of the compiled linearization of a system in given coordinates.

    Parameters
    ----------
    system : System
    independent : the coordinates
    changes : (len(b), k) of the elements' parameters, by inputs and other combinations
    c_changes : (len(measured.b), k) of those of the coordinates; by default none

    Attributes
    ----------
    A : (nx, nx + k) rates of x by x and combinations
    a, lam : accelerations and multipliers
    calls : the compiled function without and with changes of a and λ, after the first state
    """

    calls: tuple[LastingFunction, LastingFunction] | None = None

    def bound(self, system: System) -> LastingFunction:
        """Return the compiled function without changes of a and λ.

        Raises
        ------
        SarrusError
            Before the first state.
        """
        if self.calls is None:
            raise SarrusError(f"{system.name}: call the function with a state first.")
        return self.calls[0]

    def __init__(
        self, system: System, independent: CoordinateSet, changes: Array, c_changes: Array | None = None
    ) -> None:
        self.independent, self._lock = independent, Lock()
        n, states, nq, m = len(independent.row), places(system), system.nq, system.m
        free = n + len(states)
        nx, every = n + free, n + free + changes.shape[1]
        of = loop.Coordinates(independent.row, independent.place, np.arange(n), states)
        size = nq + m
        shapes = [(nq, every), (nq, every), (size, free), (free, free + 1), (free, free), (size, n)]
        shapes += [(size, every), (size, every), (size, free), (size, n)]
        shapes += [(size, every), (size, free), (size, n)]
        self._maps, self.A = loop.Maps._make(np.zeros(shape) for shape in shapes), np.zeros((nx, every))
        self.a, self.lam = np.zeros(nq), np.zeros(m)
        self._entries, self._work = motion_entries(system), motion_work(system)
        none = np.zeros((len(independent.measured.b), changes.shape[1]))
        moved = displacing(system, independent, changes, none if c_changes is None else c_changes)
        self._own = (
            constraints(system), constraints(independent.measured), forces(system), of,
            by_parameters(system, changes), moved, self._maps, self.A, self.a, self.lam,
        )  # fmt: skip
        names, rates, units = independent.labels()
        self._labels = names, rates, units, tuple(f"{unit}/s" for unit in units)
        self._matrix: Any = None
        self._redundant = self._wrong_count = False

    def solved(self, system: System, state: PartialState, whole: bool) -> StateArrays:
        """The linearization about a state; changes of a and λ only if it is `whole`.

        Raises
        ------
        Dependent
            If the coordinates are dependent, or not as many as the degrees of freedom.
        SarrusError
            In a singular configuration.
        """
        v = np.zeros(system.nq) if state.v is None else state.v
        with self._lock:
            self.evaluate(system, state.parameters(system), state.t, state.q, v, whole, self._redundant)
            nx = len(self.A)
            motion = self._maps.motion if whole else self._maps.motion[:0]
            every = self.A, self._maps.q[:, :nx], self._maps.v[:, :nx], motion, self.a, self.lam
            return StateArrays._make([*(x.copy() for x in every), self._redundant, self._labels])

    def evaluate(
        self,
        system: System,
        b: Array,
        t: float,
        q: Array,
        v: Array,
        whole: bool = False,
        renewed: bool = False,
        *others: Array,
    ) -> None:
        """Fill all maps, a and λ for a state. With `renewed`, independent equations are chosen again.

        `others` are passed to the compiled function.

        Raises
        ------
        Dependent
            If the coordinates are dependent, or not as many as the degrees of freedom.
        SarrusError
            In a singular configuration.
        """
        call, trust, dependent = self.calls[whole] if self.calls else None, -1.0, loop.FOUND
        if call is not None and not renewed:
            trust, dependent = call.function(call.fast, PRECISE, b, t, q, v, *others)
        if not trust > PRECISE:
            refuse_not_finite(q=q, v=v, t=t)
            self._renew(system, b, t, q)
            assert self.calls is not None
            trust, dependent = self.calls[whole](TRUSTED, b, t, q, v, *others)
            if not trust > TRUSTED:
                raise unsolved(system, t, trust)
            self._wrong_count = len(self._labels[0]) != self.freedom(system)
        if dependent != loop.FOUND or self._wrong_count:
            self._refuse(system, q, dependent)

    def _renew(self, system: System, b: Array, t: float, q: Array) -> None:
        """Choose independent equations and pivots for a state."""
        rows = independent_at(system, q, t)
        self._redundant = rows is not None
        self._matrix = motion_arrays(matrix_at(system, q, t, b, rows))
        self.calls = self._bind(self._entries, self._work, self._matrix, *self._own)

    def _bind(self, *arguments: Any) -> tuple[LastingFunction, LastingFunction]:
        without, whole = (LastingFunction(linearized, *arguments, motion) for motion in (False, True))
        return without, whole

    def freedom(self, system: System) -> int:
        """Return the degrees of freedom."""
        return system.nq - system.m + int(self._matrix.left_out.sum()) - len(system.states)

    def _refuse(self, system: System, q: Array, dependent: int) -> NoReturn:
        """Refuse coordinates that are dependent, or not as many as the degrees of freedom."""
        freedom, names = self.freedom(system), self._labels[0]
        if len(names) == freedom:
            message = f"{[*names, *system.states][dependent]} is not independent of the coordinates before it at this"
            message += " position. Name another"
        else:
            message = f"{freedom} degrees of freedom need as many coordinates, got {', '.join(names) or 'none'}. Name"
            message += f" {freedom}"
        raise DependentCoordinates(f"{system.name}: {message}, or leave `coordinates` out.", self._best(q))

    def _best(self, q: Array) -> tuple[str, ...]:
        """Names of as many independent coordinates as there are, by their projections in the metric of M."""
        gradients, names = self.independent.gradients(q), self._labels[0]
        gram = gradients @ self._maps.free[: len(q), : len(names)]
        return tuple(names[k] for k in pivoted_rows(gram))


def _result(
    system: System,
    given: PartialState,
    solved: StateArrays,
    independent: CoordinateSet,
    inputs: tuple[str, ...],
    outputs: Sequence[str] | None,
    start: Assembly | Equilibrium | None,
) -> StateSpace:
    """The matrices with names, units and values."""
    v = np.zeros(system.nq) if given.v is None else given.v
    nx, n, states = len(solved.A), len(independent.row), places(system)
    c, rates = independent.values(given.q, v)
    names, rate_names, units, rate_units = solved.labels
    places_of_inputs = [system.inputs[name].places for name in inputs]
    if outputs is None:
        C, D, y = np.eye(n, nx), np.zeros((n, len(inputs))), (names, units, c)
    else:
        single = OneState.of(given.t, given.q, v, solved.a, solved.lam, given.memory, given.revolutions)
        slopes = output_slopes(system, outputs, single)
        if solved.redundant and np.any(slopes.lam):
            raise SarrusError(
                f"{system.name}: reactions as outputs are not supported where constraints are redundant. Remove "
                f"{slopes.names[int(np.flatnonzero(slopes.lam.any(axis=1))[0])]} or the redundant constraints."
            )
        every = np.hstack([slopes.a, slopes.lam]) @ solved.motion
        C = slopes.q @ solved.q + slopes.v @ solved.v + every[:, :nx]
        by_u = [slopes.b[:, at].sum(axis=1) for at in places_of_inputs]
        D = every[:, nx:] + np.reshape(by_u, (len(inputs), len(C))).T
        y = (slopes.names, slopes.units, slopes.values)
    still = np.concatenate([solved.a[: system.moving], solved.a[states]])
    return StateSpace(
        system.name,
        *(solved.A[:, :nx], solved.A[:, nx:], C, D),
        states=(*names, *rate_names, *system.states),
        inputs=inputs,
        outputs=y[0],
        state_units=(*units, *rate_units, *(one.unit for one in system.states.values())),
        input_units=tuple(system.inputs[name].unit for name in inputs),
        output_units=y[1],
        x0=np.concatenate([c, rates, v[states]]),
        u0=np.array([system.b[at[0]] if len(at) else np.nan for at in places_of_inputs]),
        y0=y[2],
        t=given.t,
        q=given.q,
        v=v,
        a=solved.a,
        lam=_reported(system, given, solved),
        q_x=solved.q,
        v_x=solved.v,
        unsteady=float(abs(still).max(initial=0.0)),
        system=system.with_memory(given.parameters(system)[system.memory_places]),
        start=start,
    )


def _reported(system: System, state: PartialState, solved: StateArrays) -> Array:
    """The multipliers, those of least norm where constraints are redundant."""
    if not solved.redundant:
        return solved.lam
    b = state.parameters(system)
    J = system.Phi_q(state.q, state.t, b=b)
    return least_multipliers(system, NullSpace(J, units(system, state.q, J)), J, state.q, b, J.T @ solved.lam)


class OneState(NamedTuple):
    """A state as a motion with one time: (1,), (1, nq), …; `memory` and `revolutions` as of `State`."""

    t: Array
    q: Array
    v: Array
    a: Array
    lam: Array
    memory: Array
    revolutions: Array

    @classmethod
    def of(cls, t: float, *arrays: Array) -> OneState:
        """A state of single vectors; empty ones are unknown."""
        return cls(np.array([t]), *(x[None] if len(x) else x for x in arrays))


class OutputSlopes(NamedTuple):
    """Names, units and values of outputs (ny,), and their derivatives (ny, …)."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Array
    q: Array
    v: Array
    a: Array
    lam: Array
    b: Array


def output_slopes(system: System, names: Sequence[str], state: OneState) -> OutputSlopes:
    """Return the outputs of some names, those of a vector by components, with their exact derivatives at a state.

    Raises
    ------
    UnknownOutput
        If there is none of a name, or it depends on more than the state.
    """
    single = [component for name in names for component in components(system, name)]
    every = [find_output(system, name, Level.ACCELERATION, "a linearization") for name in single]
    recording = motion_outputs(system, state, Outputs)
    recorded = [output.record(recording) for output in every]
    widths = {"q": system.nq, "v": system.nq, "a": system.nq, "lam": system.m, "b": len(system.b)}
    slopes: dict[str, Any] = {kind: np.zeros((len(every), width)) for kind, width in widths.items()}
    for row, value in enumerate(recorded):
        if isinstance(value, Tracer):
            bars = recording.tape.gradient({value.at: 1.0})
            for (kind, n), variable in recording.inputs.items():
                if kind in slopes:
                    slopes[kind][row, n] = np.ravel(bars[variable.at])[0]
    values = np.array([np.ravel(x.value if isinstance(x, Tracer) else x)[0] for x in recorded], dtype=float)
    labels = (tuple(output.name for output in every), tuple(output.unit for output in every))
    return OutputSlopes(*labels, values, **slopes)
