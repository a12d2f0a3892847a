"""Sampled controllers of one run.

A controlled input, and each number that a controller remembers, is a first-order state with the rate 0 during a run. A
controller changes it as an event changes velocities, so that outputs, plots and all methods have its values over time,
and derivatives go through a sample as through an event at a given time.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from ....algebra import Array
from ....model import Input, Model, SarrusError, StateVariable
from ....model.tape import Tracer
from ....outputs import Outputs
from ....results import Assembly, EventStep, State
from ....system import System
from ...position.initial_state import Start, start_of
from ..inputs.laws_of_time import ROUND
from ..stepping.stepper import RunFailure
from .controllers import Controller
from .readings import Readings, SampledOutputs, outputs_at, readings_at, recorded_readings
from .stepper import refuse_inputs

NAMED = "Derivatives need the memory of a controller by name: pass memory={...} with its first values."
SAME = 10 * ROUND  # [-] of the end time: how far from its sample the loop stops at the most


class Hold(float):
    """The rate of a state that is an input or the memory of a controller, unlike those of the user's states."""


class DueSample(NamedTuple):
    """A controller with a sample, what it sets, and the time of the sample [s]."""

    controller: Controller
    names: Sequence[str]
    t: float


class Control:
    """The controllers of one run.

    Parameters
    ----------
    system : with the controlled inputs as states
    controllers : Sequence
    names : what each sets: inputs, and what it remembers
    begin : the state at the first sample, before it
    until : end of the run [s]
    known : the values of all names there
    """

    def __init__(
        self, system: System, controllers: Sequence[Controller], names: Sequence[Sequence[str]],
        begin: State, until: float, known: Mapping[str, float],
    ) -> None:  # fmt: skip
        self.system, self.begin, self._until, first = system, begin, until, float(begin.t)
        self.at_start = [DueSample(one, own, first) for one, own in zip(controllers, names, strict=True)]
        self.known_at_start, self._known = known, dict(known)
        self._outputs, self._same = SampledOutputs(system), SAME * max(abs(first), abs(until))
        self._taken = [0] * len(self.at_start)

    def times(self) -> Array:
        """The times of samples between the start and the end."""
        found = [
            first + one.period * np.arange(1, np.ceil((self._until - first - self._same) / one.period))
            for one, _, first in self.at_start
        ]
        return np.unique(np.concatenate(found))

    def due(self, t: float) -> list[DueSample]:
        """Take the samples at a time, each once: the loop stops just before it, and may stop again beside it."""
        found = []
        for n, (controller, names, first) in enumerate(self.at_start):
            index = round((t - first) / controller.period)
            sample = DueSample(controller, names, first + index * controller.period)
            if index > self._taken[n] and abs(t - sample.t) <= self._same:
                self._taken[n] = index
                found.append(sample)
        return found

    def sample(self, state: State, due: Sequence[DueSample]) -> Sample:
        """Call the controllers of a sample."""
        known = dict(self._known)
        values = self.values(state, due, known)
        self._known |= values
        return Sample(self, state, due, known, values)

    def first_sample(self, q: Array, v: Array) -> Sample:
        """The sample at the start, before which derivatives need a step; it is recorded once to see that it can be."""
        sample = self.sample(self.begin._replace(q=q, v=v), self.at_start)
        sample.record(outputs_at(self.system, sample.state))
        return sample

    def reset(self, before: Array, after: Array) -> None:
        """Take the values that an event has changed, from the velocities before and after it."""
        for name in self._known:
            place = self.system.states[name].place
            if after[place] != before[place]:
                self._known[name] = float(after[place])

    def values(self, state: State, due: Sequence[DueSample], known: Mapping[str, float]) -> dict[str, float]:
        """The values that the controllers set at a sample; they read known values without round-off."""
        readings, found = self._outputs.at(state, known), dict[str, float]()
        for controller, names, t in due:
            values = controller.values(t, readings)
            if [*values] != [*names]:
                before, after = ", ".join(names), ", ".join(values)
                message = f"controller {controller.title}: it returned {before} before, but now {after}"
                raise SarrusError(f"{message}. Return values of the same inputs in the same order.")
            if any(isinstance(value, Tracer) for value in values.values()):  # from a call for derivatives
                raise SarrusError(f"controller {controller.title}: it has a memory of its own. {NAMED}")
            found |= {name: float(value) for name, value in values.items()}
        return found


@dataclass(frozen=True, eq=False)
class Sample:
    """One sample of a run.

    Attributes
    ----------
    control : Control
    state : before the sample
    due : controllers that were called
    known : the values that all controllers had set before
    values : that the controllers gave
    """

    control: Control
    state: State
    due: Sequence[DueSample]
    known: Mapping[str, float]
    values: Mapping[str, float]

    def after(self) -> Array:
        """The velocities after it (nq,)."""
        v = np.array(self.state.v)
        for name, value in self.values.items():
            v[self.control.system.states[name].place] = value
        return v

    def event_step(self) -> EventStep:
        """The record of it, for derivatives."""
        t, title = float(self.state.t), " and ".join(one.controller.title for one in self.due)
        return EventStep(
            name=f"sample of {title}", t=t, function=f"t - ({t!r})", reset=self, named=False,
            q=np.array(self.state.q), v=np.array(self.state.v), after=self.after(),
        )  # fmt: skip

    def record(self, outputs: Outputs) -> list[Any]:
        """The velocities after it as recorded numbers.

        Raises
        ------
        SarrusError
            If a controller cannot be recorded, or returns other values than in the run.
        """
        self._refuse_other_values()
        system, readings = self.control.system, recorded_readings(outputs)
        v: list[Any] = [outputs.input("v", n) for n in range(system.nq)]
        for controller, _, t in self.due:
            for name, value in self._recorded(controller, t, readings).items():
                v[system.states[name].place] = value
        return v

    def _recorded(self, controller: Controller, t: float, readings: Readings) -> dict[str, Any]:
        try:
            found = controller.values(t, readings)
            return {
                name: value if isinstance(value, Tracer) else float(value) for name, value in found.items()
            }
        except SarrusError:
            raise
        except Exception as error:  # foreign code: whatever it raises
            raise SarrusError(
                f"controller {controller.title}: it cannot be differentiated: {str(error).rstrip('.')}. Write it with "
                "arithmetic and NumPy's functions of numbers, or leave out store_steps and error."
            ) from error

    def _refuse_other_values(self) -> None:
        """Refuse a function with a memory of its own: after a call at the start it returns other values.

        Others return the same ones to the last bit, as outputs are evaluated in the same way.
        """
        control = self.control
        control.values(control.begin, control.at_start, control.known_at_start)
        again = control.values(self.state, self.due, self.known)
        for one in self.due:
            for name in one.names:
                if again[name] != self.values[name]:
                    message = (
                        f"controller {one.controller.title}: it returned {self.values[name]!r} for {name} at"
                    )
                    raise SarrusError(
                        f"{message} t = {one.t:.6g} s in the run, but {again[name]!r} when it was called again. {NAMED}"
                    )


class ControlledSystem(NamedTuple):
    """A system whose controlled inputs are states, its start, and the controllers.

    The start has the values of the first sample already, unless derivatives are wanted.
    """

    system: System
    start: State | Assembly
    control: Control


def controlled(
    system: System, start: Start | None, controllers: Sequence[Controller], until: float, differentiated: bool
) -> ControlledSystem:
    """The system of a run with controllers, and their first samples.

    Raises
    ------
    SarrusError
        If a controller sets what is no input, or what another one sets, or if its memory has the name of an input.
    RunFailure
        If the start is inconsistent, or a value is not finite.
    """
    for one in controllers:
        for name in (name for name in one.memory if name in system.inputs):
            raise SarrusError(f"controller {one.title}: its memory {name} is also an input. Rename it.")
    memory = {name: float(value) for one in controllers for name, value in one.memory.items()}
    unset = [name for name, one in system.inputs.items() if not one.is_set]
    plain = system.with_inputs(dict.fromkeys(unset, 0.0))
    begin = start_of(plain, start)
    if not begin.success:
        raise RunFailure("inconsistent", begin.message)
    now = _state(plain, begin)
    own = [one.values(float(now.t), readings_at(plain, now, memory)) for one in controllers]
    names = [name for found in own for name in found]
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise SarrusError(f"two controllers return {twice}. Let one of them return it.")
    first = {name: float(value) for found in own for name, value in found.items()}
    returned = [[*found] for found in own]
    if names and set(names) <= held_names(system.model):
        before = {name: float(now.v[system.states[name].place]) for name in names}
        known, v = (before if differentiated else first), now.v.copy()
        v[[system.states[name].place for name in names]] = [known[name] for name in names]
        moved = now._replace(v=v)
        control = Control(system, controllers, returned, moved, until, known)
        return ControlledSystem(system, begin if differentiated else moved, control)
    inputs = [name for name in names if name not in memory]
    refuse_inputs(system, inputs, unset)
    before = memory | {name: float(plain.b[plain.inputs[name].places[0]]) for name in inputs}
    known = before if differentiated else first
    held = _held(plain, known, memory)
    moved = _moved(plain, held, now)
    return ControlledSystem(held, moved, Control(held, controllers, returned, moved, until, known))


def _state(system: System, begin: Assembly) -> State:
    """The state at a start."""
    b = system.b.copy()
    if len(begin.memory):
        b[system.memory_places] = begin.memory
    system.remember(begin.q, b, begin.t)
    revolutions = begin.revolutions if len(begin.revolutions) else np.zeros(system.counted_coordinates.m)
    zero = np.zeros(system.nq), np.zeros(system.m)
    return State(begin.t, begin.q, begin.v, *zero, b[system.memory_places], revolutions)


def _held(system: System, values: Mapping[str, float], memory: Mapping[str, float]) -> System:
    """The system with inputs, and with what controllers remember, as states that stay as they are."""
    forces = [
        StateVariable(one.name, rate=Hold(), initial=values[one.name], unit=one.unit)
        if isinstance(one, Input) and one.name in values
        else one
        for one in system.model.forces
    ]
    forces += [StateVariable(name, rate=Hold(), initial=values[name]) for name in memory]
    return System(replace(system.model, forces=forces))


def held_names(model: Model) -> set[str]:
    """The states of a model that controllers set."""
    return {one.name for one in model.forces if isinstance(one, StateVariable) and isinstance(one.rate, Hold)}


def without_held(model: Model, plain: Model) -> Model:
    """A model with the inputs that a plain one has in the place of held states, and without what is remembered."""
    own = {one.name: one for one in plain.forces}
    held = held_names(model) - held_names(plain)
    forces = [own[one.name] if one.name in held else one for one in model.forces if one.name in own]
    return replace(model, forces=forces)


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
