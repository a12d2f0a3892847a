"""Initial states of analyses: an assembly, a state of a run, an equilibrium, coordinates, or a mapping by names."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array

from ...algebra import Array
from ...linalg.rank import with_data
from ...model import Model, SarrusError
from ...model.announcement import announce
from ...model.checks.arguments import as_numbers
from ...results import Assembly, AssemblyRequest, Equilibrium, State, Trajectory
from ...system import System
from ..arguments import kind, refuse_other_system
from ..equations.length import extent, row_sizes
from ..equations.projection import metric
from .assembly import assemble
from .assembly_changes import position_changes, velocity_changes, warning
from .joint_space import followed_coordinates, held_coordinates
from .named_start import named_start
from .prescribed_angles import prescribed_memory

Start: TypeAlias = Assembly | State | Equilibrium | ArrayLike | Mapping[str, Any] | Callable[[System], Any]
# Of the size of the mechanism, and of |Φ_q| |v|: states farther off the constraints are projected
CONSISTENT = 1e-6


def start_of(system: System, given: Start | None, analysis: str = "simulate") -> Assembly:
    """The start of a motion, on the constraints; what that changes visibly is a warning.

    Raises
    ------
    TypeError
        For a system or a start that is none.
    ValueError
        For coordinates of another system, or that are not finite.
    """
    refuse_other_system(system, analysis)
    if given is None:
        return assemble(system)
    given = meant(system, given)
    if isinstance(given, Assembly) and not given.success:
        return given
    if isinstance(given, Equilibrium) and not given.success:
        about = f"{system.name}: the start is a failed search for an equilibrium, so the motion does not start at rest"
        announce([f"{about}. Check `success`, or give another start."])
    q, v, t, *_ = state_of(system, given)
    if isinstance(given, Assembly | State):
        return _consistent(system, given, q, v, t)
    found = assemble(system, q, v, t=t)
    announce(warning(system, tuple(position_changes(system, q, found.q)) if found.success else ()))
    return settled(found, given) if isinstance(given, Equilibrium) else found


def settled(found: Assembly, rest: Equilibrium) -> Assembly:
    """An assembly in an equilibrium that was found, which its derivatives go through."""
    found = replace(found, memory=rest.memory, revolutions=rest.revolutions)
    return replace(found, settled=True, lam=rest.lam) if rest.success and found.success else found


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


def meant(system: System, given: Start | None) -> Any:
    """A start, where it is given by names as the assembly or the state that they mean; see `named_start`.

    A function of the system is called.
    """
    given = start_by(given, system) if callable(given) else given
    return named_start(system, given) if isinstance(given, Mapping) else given


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
    system: System, given: Start, v: ArrayLike | None = None, t: float | None = None
) -> PartialState:
    """The state that a start means; `v` and `t` count where they are given.

    Raises
    ------
    TypeError
        For a start that is none.
    ValueError
        For coordinates of another system, or that are not finite.
    """
    if isinstance(given, Trajectory):
        raise TypeError(
            f"a start is one state, not a Trajectory. Give run.final or run.state(t) of {given.name}."
        )
    if isinstance(given, System | Model | str) or given is None:
        raise TypeError(
            f"a start must be an Assembly, a State, an Equilibrium or coordinates, got {kind(given)}. "
            "Pass sr.assemble(...)."
        )
    given = meant(system, given)
    own_v, own_t, own = None, 0.0, (np.zeros(0), np.zeros(0))
    if isinstance(given, Assembly | State):
        own_v, own_t, own = given.v, float(given.t), (given.memory, given.revolutions)
    elif isinstance(given, Equilibrium):
        own_v, own_t = (np.zeros(system.nq) if given.v is None else given.v), given.t
        own = given.memory, given.revolutions
    q: Any = given.q if isinstance(given, Assembly | State | Equilibrium) else given
    rates = own_v if v is None else v
    found = None if rates is None else finite(system, "v", rates)
    where = finite(system, "q", q)
    refuse_no_orientation(system, where)
    return PartialState(where, found, own_t if t is None else float(t), *own)


def refuse_no_orientation(system: System, q: Array) -> None:
    """Refuse Euler parameters that are all zero: they are the orientation of no body.

    Raises
    ------
    ValueError
    """
    none = np.flatnonzero(~q.reshape(-1, 7)[:, 3:].any(axis=1))
    if len(none):
        reason = f"the Euler parameters of {system.bodies[none[0]]} in q are all 0"
        raise ValueError(f"{system.name}: {reason}. Give [1, 0, 0, 0] for a body that is not rotated.")


def finite(system: System, name: str, given: ArrayLike) -> Array:
    """Coordinates or velocities as an array.

    Raises
    ------
    TypeError
        If they are no numbers.
    ValueError
        If they are not as many as the system's, or not finite.
    """
    wanted = f"{system.nq} numbers, an Assembly, a State or an Equilibrium"
    found = as_numbers(given, lambda: f"{name} must be {wanted}, got {kind(given)}.")
    if found.shape != (system.nq,):
        raise ValueError(
            f"{name} must be {system.nq} finite numbers, the coordinates of {system.name}, got shape "
            f"{found.shape}. Pass a vector."
        )
    wrong = np.flatnonzero(~np.isfinite(found))
    if len(wrong):
        which = system.coordinate_names[wrong[0]]
        raise ValueError(
            f"{name} must be {system.nq} finite numbers, but {which} is {found[wrong[0]]}. Replace it."
        )
    return found


def _consistent(system: System, given: Assembly | State, q: Array, v: Array | None, t: float) -> Assembly:
    """A start whose state was given, on the constraints."""
    assert v is not None
    if isinstance(given, Assembly):
        start = given
    else:
        weight = metric(system, "unit", q)
        asked = AssemblyRequest(
            q, v, weight, weight, held_coordinates(system, ()), followed_coordinates(system), {}, t,
            unit_metric=True,
        )  # fmt: skip
        start = Assembly(
            q, v, True, "a given state", 0.0, 0, lam=np.zeros(system.m), mu=np.zeros(system.m), nearest=True,
            asked=asked, memory=given.memory, revolutions=given.revolutions, bodies=system.bodies,
        )  # fmt: skip
    system = system.with_memory(start.memory)
    if not is_off(system, q, v, t):
        return start
    found = assemble(system, q, v, t=t)
    if found.success:
        moved, turned = position_changes(system, q, found.q), velocity_changes(system, q, v, found.q, found.v)
        announce(warning(system, (*moved, *turned)))
    return replace(found, memory=start.memory, revolutions=start.revolutions)


def contradicting(system: System, q: Array, v: Array, t: float) -> Array:
    """Whether a velocity violates a constraint by more than round-off and tolerances of solvers (m,)."""
    return _contradicting(J := system.Phi_q(q, t), row_sizes(J, extent(system, q)), v, system.Phi_t(q, t))


def _contradicting(J: csr_array, sizes: Array, v: Array, Phi_t: Array) -> Array:
    largest = float(((with_data(J, abs(J.data)) @ abs(v) + abs(Phi_t)) / sizes).max(initial=0.0))
    return np.asarray(abs(J @ v + Phi_t) / sizes > CONSISTENT * largest)


def is_off(system: System, q: Array, v: Array, t: float) -> bool:
    """Whether a state violates the constraints by more than round-off and tolerances of solvers."""
    sizes = row_sizes(J := system.Phi_q(q, t), extent(system, q))
    moved = abs(system.Phi(q, t)) / sizes
    return bool(moved.max(initial=0.0) > CONSISTENT or _contradicting(J, sizes, v, system.Phi_t(q, t)).any())
