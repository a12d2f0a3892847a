"""Initial states of analyses: an assembly, a state of a run, an equilibrium, coordinates, or a mapping by names."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array

from ... import deferred
from ...algebra import Array
from ...linalg.rank import with_data
from ...model import Model, ModelError, SarrusError
from ...model.announcement import announce
from ...model.checks.arguments import as_numbers, in_si
from ...model.quantity import number
from ...model.show import show
from ...results import Assembly, AssemblyRequest, Equilibrium, State, Trajectory, load_run
from ...results.saving.saved import UNFINISHED
from ...system import System
from ..arguments import kind, refuse_other_system
from ..equations.length import extent, row_sizes
from ..equations.projection import metric
from .assembly import assemble
from .assembly_changes import position_changes, velocity_changes, warning
from .coordinate_set import of_names
from .joint_space import followed_coordinates, held_coordinates
from .prescribed_angles import prescribed_memory

Start: TypeAlias = Assembly | State | Equilibrium | ArrayLike | Mapping[str, Any] | Callable[[System], Any]
# Of the size of the mechanism, and of |Φ_q| |v|: states farther off the constraints are projected
CONSISTENT = 1e-6


def start_of(system: System, start: Start | None, analysis: str = "simulate") -> Assembly:
    """The start of a motion, on the constraints; what that changes visibly is a warning.

    Raises
    ------
    TypeError
        For a system or a start that is none.
    ValueError
        For coordinates of another system, or that are not finite.
    """
    refuse_other_system(system, analysis)
    if start is None:
        return assemble(system)
    start = meant(system, start)
    if isinstance(start, Assembly) and not start.success:
        return start
    if isinstance(start, Equilibrium) and not start.success:
        about = f"{system.name}: the start is a failed search for an equilibrium, so the motion does not start at rest"
        announce([f"{about}. Check `success`, or give another start."])
    q, v, t, *_ = state_of(system, start)
    if isinstance(start, Assembly | State):
        return _consistent(system, start, q, v, t)
    assembly = assemble(system, q, v, t=t)
    announce(warning(system, tuple(position_changes(system, q, assembly.q)) if assembly.success else ()))
    return settled(assembly, start) if isinstance(start, Equilibrium) else assembly


def settled(assembly: Assembly, rest: Equilibrium) -> Assembly:
    """An assembly in an equilibrium that was found, which its derivatives go through."""
    assembly = replace(assembly, memory=rest.memory, revolutions=rest.revolutions)
    return replace(assembly, settled=True, lam=rest.lam) if rest.success and assembly.success else assembly


def start_by(function: Callable[[System], Any], system: System) -> Any:
    """Return the start of a system from a user's function.

    Raises
    ------
    SarrusError
        If it is a function of something else.
    """
    try:
        return function(system)
    except TypeError as error:
        name = getattr(function, "__name__", "start")
        message = f"start: the function {name} cannot be called with a system, {error}"
        raise SarrusError(
            f"{message}. Give a state, an assembly, an equilibrium, or a function of the system."
        ) from error


def meant(system: System, start: Start | None) -> Any:
    """A start, where it is given by names as the assembly or the state that they mean; see `named_start`.

    A function of the system is called.
    """
    start = start_by(start, system) if callable(start) else start
    return named_start(system, start) if isinstance(start, Mapping) else start


KEYS = ("rates", "equilibrium", "run", "t")


def named_start(system: System, entries: Mapping[str, Any]) -> Assembly | State:
    """The start that ``{"rates": {"pin": 5.0}, "t": 0.0}`` or ``{"run": "drop.sarrus", "t": 2.0}`` means.

    Parameters
    ----------
    system : System
    entries : `rates` of joints and coordinates, with which the model's own state is assembled at the time `t`, or, with
        ``{"equilibrium": True}``, the equilibrium near it; or a `run`, the folder of a saved run, whose final state or
        state at the time `t` is taken

    Raises
    ------
    ModelError
        For other keys, unknown joints, and rates that are no numbers or in another unit.
    SarrusError
        If there is no such run, or no state at that time was saved.
    """
    for key in entries:
        if key not in KEYS:
            raise ModelError(f"start: there is no key {key!r}. Give rates, equilibrium, run or t.")
    if "run" in entries:
        return _saved(entries)
    rates = entries.get("rates", {})
    if not isinstance(rates, Mapping):
        raise ModelError(f'start: rates must be a mapping such as {{"pin": 5.0}}, but is {show(rates)}.')
    values = {str(name): _rate(system, str(name), value) for name, value in rates.items()}
    if not _is_settled(entries):
        return assemble(system, t=_time(entries), rates=values)
    rest: Equilibrium = deferred.equilibrium()(system, t=_time(entries))
    start = assemble(system, rest.q, rest.v, t=rest.t, rates=values)
    return settled(start, rest) if rest.success else replace(start, success=False, message=rest.message)


def _is_settled(entries: Mapping[str, Any]) -> bool:
    value = entries.get("equilibrium", False)
    if not isinstance(value, bool) and value not in ("true", "false"):
        raise ModelError(f"start: equilibrium must be true or false, but is {show(value)}.")
    return value in (True, "true")


def _saved(entries: Mapping[str, Any]) -> State:
    """The final state of a saved run, or that at the time t."""
    if "rates" in entries:
        raise ModelError("start: run and rates contradict each other. Give one of them.")
    run = load_run(str(entries["run"]))
    if "t" in entries:
        try:
            return run.state(_time(entries))
        except ValueError as wrong:
            raise ModelError(f"start: {wrong}") from None
    if run.final is None or run.status in UNFINISHED:
        raise SarrusError(f"start: the run {entries['run']} has not ended. Give the time t of a saved state.")
    return run.final


def _time(entries: Mapping[str, Any]) -> float:
    value = entries.get("t", 0.0)
    return float(in_si("start: t", value, "s")) if isinstance(value, str) else number(value, "start: t")


def _rate(system: System, name: str, value: Any) -> float:
    """A given rate in SI units."""
    try:
        (unit,) = of_names(system, (name,), "a given rate").labels()[2]
    except KeyError as wrong:
        raise ModelError(f"start: {wrong.args[0]}") from None
    if isinstance(value, str):
        return float(in_si(f"start: {name}", value, f"{unit}/s"))
    return number(value, f"start: rates: {name}")


class PartialState(NamedTuple):
    """A state: coordinates, velocities (None if unknown), time; what elements remember and revolutions, if known."""

    q: Array
    v: Array | None
    t: float
    memory: Array
    revolutions: Array

    def parameters(self, system: System) -> Array:
        """The parameters of the elements, with what they remember."""
        b = system.b.copy()
        if len(self.memory):
            b[system.memory_places] = self.memory
        system.remember(self.q, b, self.t)
        b[system.memory_places] = prescribed_memory(system, self.t, b)
        return b


def state_of(
    system: System, start: Start, v: ArrayLike | None = None, t: float | None = None
) -> PartialState:
    """The state that a start means; `v` and `t` count where they are given.

    Raises
    ------
    TypeError
        For a start that is none.
    ValueError
        For coordinates of another system, or that are not finite.
    """
    if isinstance(start, Trajectory):
        raise TypeError(
            f"a start is one state, not a Trajectory. Give run.final or run.state(t) of {start.name}."
        )
    if isinstance(start, System | Model | str) or start is None:
        raise TypeError(
            f"a start must be an Assembly, a State, an Equilibrium or coordinates, got {kind(start)}. "
            "Pass sr.assemble(...)."
        )
    start = meant(system, start)
    v_of_start, t_of_start, history = None, 0.0, (np.zeros(0), np.zeros(0))
    if isinstance(start, Assembly | State):
        v_of_start, t_of_start, history = start.v, float(start.t), (start.memory, start.revolutions)
    elif isinstance(start, Equilibrium):
        v_of_start, t_of_start = (np.zeros(system.nq) if start.v is None else start.v), start.t
        history = start.memory, start.revolutions
    q: Any = start.q if isinstance(start, Assembly | State | Equilibrium) else start
    rates = v_of_start if v is None else v
    velocity = None if rates is None else finite(system, "v", rates)
    position = finite(system, "q", q)
    refuse_no_orientation(system, position)
    return PartialState(position, velocity, t_of_start if t is None else float(t), *history)


def refuse_no_orientation(system: System, q: Array) -> None:
    """Refuse Euler parameters that are all zero: they are the orientation of no body.

    Raises
    ------
    ValueError
    """
    none = np.flatnonzero(~q[system.layout.rotations].any(axis=1))
    if len(none):
        reason = f"the Euler parameters of {system.bodies[none[0]]} in q are all 0"
        raise ValueError(f"{system.name}: {reason}. Give [1, 0, 0, 0] for a body that is not rotated.")


def finite(system: System, name: str, values: ArrayLike) -> Array:
    """Coordinates or velocities as an array.

    Raises
    ------
    TypeError
        If they are no numbers.
    ValueError
        If they are not as many as the system's, or not finite.
    """
    expected = f"{system.nq} numbers, an Assembly, a State or an Equilibrium"
    vector = as_numbers(values, lambda: f"{name} must be {expected}, got {kind(values)}.")
    if vector.shape != (system.nq,):
        raise ValueError(
            f"{name} must be {system.nq} finite numbers, the coordinates of {system.name}, got shape "
            f"{vector.shape}. Pass a vector."
        )
    wrong = np.flatnonzero(~np.isfinite(vector))
    if len(wrong):
        which = system.coordinate_names[wrong[0]]
        raise ValueError(
            f"{name} must be {system.nq} finite numbers, but {which} is {vector[wrong[0]]}. Replace it."
        )
    return vector


def _consistent(system: System, state: Assembly | State, q: Array, v: Array | None, t: float) -> Assembly:
    """A start whose state was given, on the constraints."""
    assert v is not None
    if isinstance(state, Assembly):
        start = replace(state, q=q, v=v)
    else:
        weight = metric(system, "unit", q)
        request = AssemblyRequest(
            q, v, weight, weight, held_coordinates(system, ()), followed_coordinates(system), {}, t,
            unit_metric=True,
        )  # fmt: skip
        start = Assembly(
            q, v, True, "a given state", 0.0, 0, lam=np.zeros(system.m), mu=np.zeros(system.m), nearest=True,
            asked=request, memory=state.memory, revolutions=state.revolutions, bodies=system.bodies,
        )  # fmt: skip
    system = system.with_memory(start.memory)
    if not is_off(system, q, v, t):
        return start
    assembly = assemble(system, q, v, t=t)
    if assembly.success:
        moved = position_changes(system, q, assembly.q)
        announce(warning(system, (*moved, *velocity_changes(system, q, v, assembly.q, assembly.v))))
    return replace(assembly, memory=start.memory, revolutions=start.revolutions)


Rows = tuple[csr_array, Array]  # the constraint Jacobian and the sizes of its rows


def _rows(system: System, q: Array, t: float) -> Rows:
    J = system.Phi_q(q, t)
    return J, row_sizes(J, system.layout, extent(system, q))


def contradicting(system: System, q: Array, v: Array, t: float, rows: Rows | None = None) -> Array:
    """Whether a velocity violates a constraint by more than round-off and tolerances of solvers (m,)."""
    (J, sizes), Phi_t = rows or _rows(system, q, t), system.Phi_t(q, t)
    largest = float(((with_data(J, abs(J.data)) @ abs(v) + abs(Phi_t)) / sizes).max(initial=0.0))
    return np.asarray(abs(J @ v + Phi_t) / sizes > CONSISTENT * largest)


def violated(system: System, q: Array, v: Array, t: float) -> Array:
    """Whether a state violates a constraint by more than round-off and tolerances of solvers (m,)."""
    rows = _rows(system, q, t)
    return np.asarray(off_in_position(system, q, t, rows) | contradicting(system, q, v, t, rows))


def off_in_position(system: System, q: Array, t: float, rows: Rows | None = None) -> Array:
    """Whether a position violates a constraint by more than round-off and tolerances of solvers (m,)."""
    sizes = (rows or _rows(system, q, t))[1]
    return np.asarray(abs(system.Phi(q, t)) / sizes > CONSISTENT)


def is_off(system: System, q: Array, v: Array, t: float) -> bool:
    """Whether a state violates the constraints by more than round-off and tolerances of solvers."""
    return bool(violated(system, q, v, t).any())


def consistent_state_of(
    system: System, start: Start, v: ArrayLike | None = None, t: float | None = None
) -> PartialState:
    """The state that a start means, at rest if its velocities are unknown; see `state_of`.

    Raises
    ------
    ModelError
        If it violates the constraints.
    """
    state = state_of(system, start, v, t)
    velocity = np.zeros(system.nq) if state.v is None else state.v
    with_memory = system.with_memory(state.parameters(system)[system.memory_places])
    if isinstance(start, Equilibrium):  # at rest, whatever the rates of drivers at its time
        rows = off_in_position(with_memory, state.q, state.t)
    else:
        rows = violated(with_memory, state.q, velocity, state.t)
    if rows.any():
        names = ", ".join(system.row_names[n] for n in np.flatnonzero(rows)[:3])
        raise ModelError(
            f"{system.name}: at t = {state.t:g} s the given state violates the constraints {names}. "
            "Pass sr.assemble(system, q, v, t=t), or what equilibrium returns."
        )
    return state._replace(v=velocity)
