"""Sampled controllers in Python: functions that set inputs at equal intervals, with a zero-order hold.

A controlled input is a first-order state with the rate 0 during a run. A controller changes it as an event changes
velocities, so that outputs, plots and all methods have its values over time.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from ....algebra import Array
from ....model import Input, SarrusError, StateVariable
from ....model.checks.arguments import Number
from ....outputs import Level, find_output
from ....outputs.motion import motion_outputs, over
from ....results import Assembly, State
from ....system import System
from ...position.initial_state import Start, start_of
from ..stepping.stepper import RunFailure
from .stepper import refuse_inputs

SAME = 1e-6  # of a period: two times that are the same sample


@dataclass(frozen=True, eq=False)
class Controller:
    """A sampled controller of a simulation.

    Parameters
    ----------
    function
        f(t, o) at every sample, which returns the values of inputs by name, ``{"u": 2.0}``, always of the same ones.
        They are held until the next sample. ``o["pin.angle"]`` is an output of positions, velocities, states and
        inputs.
    period
        Time between samples [s]; the first is at the start.
    name
        For messages; by default the function's name.
    """

    function: Callable[[float, Any], Mapping[str, float]]
    period: float
    name: str = ""

    def __post_init__(self) -> None:
        if not callable(self.function):
            raise TypeError(
                "a controller needs a function f(t, o). Give one that returns values of inputs by name."
            )
        Number(positive=True)("period", self.period)

    @property
    def title(self) -> str:
        """The name, or that of the function."""
        return self.name or getattr(self.function, "__name__", "controller")

    def values(self, system: System, state: State) -> dict[str, float]:
        """The values of its inputs at a state.

        Raises
        ------
        RunFailure
            If one is not finite.
        SarrusError
            If it returns something else than values by name.
        """
        found: Any = self.function(float(state.t), Readings(system, state))
        if not isinstance(found, Mapping):
            message = f"the controller {self.title} returned {found!r:.60}, no values by name"
            raise SarrusError(f"{message}. Return a mapping, such as {{'u': 2.0}}.")
        for name, value in found.items():
            if not np.isfinite(value):
                message = f"the controller {self.title} returned {value} for {name} at t = {state.t:.6g} s"
                raise RunFailure("controller", message)
        return {name: float(value) for name, value in found.items()}


class Readings:
    """Argument of a controller: outputs at a sample, ``o["pin.angle"]``."""

    def __init__(self, system: System, state: State) -> None:
        self._system = system
        rows = {name: np.asarray(value)[None] for name, value in state._asdict().items()}
        self._outputs = motion_outputs(system, SimpleNamespace(**rows))
        self._t = rows["t"]

    def __getitem__(self, name: str) -> float:
        """The value of an output."""
        output = find_output(self._system, name, Level.VELOCITY, "a controller")
        return float(over(output.record(self._outputs), self._t)[0])


class Control:
    """The controllers of one run, at work.

    Parameters
    ----------
    system : with the controlled inputs as states
    controllers : Sequence
    first : the inputs of each
    begin : time of the first sample [s]
    """

    def __init__(
        self, system: System, controllers: Sequence[Controller], first: Sequence[Sequence[str]], begin: float
    ) -> None:
        self._system, self._begin = system, begin
        self._own = list(zip(controllers, first, strict=True))

    def times(self, until: float) -> Array:
        """The times of samples between the start and the end."""
        found = [
            self._begin + one.period * np.arange(1, np.ceil((until - self._begin) / one.period - SAME))
            for one, _ in self._own
        ]
        return np.unique(np.concatenate(found))

    def __call__(self, state: State) -> Array:
        """The velocities after a sample, with the new values of the inputs (nq,)."""
        v = np.array(state.v)
        for controller, names in self._own:
            samples = (float(state.t) - self._begin) / controller.period
            if abs(samples - round(samples)) > SAME:
                continue
            t = self._begin + round(samples) * controller.period  # the loop stops just before it
            values = controller.values(self._system, state._replace(t=t))
            if [*values] != [*names]:
                before, after = ", ".join(names), ", ".join(values)
                message = f"the controller {controller.title} set {before} before, but now {after}"
                raise SarrusError(f"{message}. Return values of the same inputs in the same order.")
            for name, value in values.items():
                v[self._system.states[name].place] = value
        return v


class Controlled(NamedTuple):
    """A system whose controlled inputs are states, its start, and the controllers at work."""

    system: System
    start: State
    control: Control


def controlled(system: System, start: Start | None, controllers: Sequence[Controller]) -> Controlled:
    """The system of a run with controllers, after their first samples.

    Raises
    ------
    SarrusError
        If a controller sets what is no input, or what another one sets.
    RunFailure
        If the start is inconsistent, or a value is not finite.
    """
    if not all(isinstance(one, Controller) for one in controllers):
        raise TypeError(
            "controllers must be a list of sarrus.Controller. Pass [sr.Controller(f, period=0.01)]."
        )
    unset = [name for name, one in system.inputs.items() if not one.is_set]
    plain = system.with_inputs(dict.fromkeys(unset, 0.0))
    begin = start_of(plain, start)
    if not begin.success:
        raise RunFailure("inconsistent", begin.message)
    now = _state(plain, begin)
    values = [one.values(plain, now) for one in controllers]
    names = [name for own in values for name in own]
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise SarrusError(f"two controllers set the input {twice}. Let one of them set it.")
    refuse_inputs(system, names, unset)
    held = _held(plain, {name: value for own in values for name, value in own.items()})
    control = Control(held, controllers, [[*own] for own in values], float(now.t))
    return Controlled(held, _moved(plain, held, now), control)


def _state(system: System, begin: Assembly) -> State:
    """The state at a start."""
    b = system.b.copy()
    if len(begin.memory):
        b[system.memory_places] = begin.memory
    system.remember(begin.q, b, begin.t)
    revolutions = begin.revolutions if len(begin.revolutions) else np.zeros(system.joint_coordinates.m)
    zero = np.zeros(system.nq), np.zeros(system.m)
    return State(begin.t, begin.q, begin.v, *zero, b[system.memory_places], revolutions)


def _held(system: System, values: Mapping[str, float]) -> System:
    """The system with inputs as states that stay as they are."""
    forces = [
        StateVariable(one.name, rate=0.0, initial=values[one.name], unit=one.unit)
        if isinstance(one, Input) and one.name in values
        else one
        for one in system.model.forces
    ]
    return System(replace(system.model, forces=forces))


def _moved(system: System, held: System, state: State) -> State:
    """A state of a system as one of the system with further states."""
    q, v, moving = held.q0.copy(), held.v0.copy(), system.moving
    q[:moving], v[:moving] = state.q[:moving], state.v[:moving]
    for name, one in system.states.items():
        q[held.states[name].place], v[held.states[name].place] = state.q[one.place], state.v[one.place]
    memory: dict[str, list[float]] = {}
    for owner, value in zip(system.remembered.owners, state.memory, strict=True):
        memory.setdefault(owner, []).append(value)
    own = np.array([memory[owner].pop(0) for owner in held.remembered.owners])
    return State(state.t, q, v, np.zeros(held.nq), np.zeros(held.m), own, state.revolutions)
