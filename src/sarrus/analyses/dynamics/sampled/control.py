"""Controllers at work in a run.

A controlled input, and each number that a controller remembers, is a first-order state with the rate 0 during a run. A
controller changes it as an event changes velocities, so that outputs, plots and all methods have its values over time,
and derivatives go through a sample as through an event at a given time.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from ....algebra import Array
from ....model import Input, SarrusError, StateVariable
from ....model.tape import Traced
from ....outputs import Outputs
from ....results import Assembly, EventStep, State
from ....system import System
from ...position.initial_state import Start, start_of
from ..stepping.stepper import RunFailure
from .controllers import Controller
from .readings import Readings, SampledOutputs, outputs_at, readings_at, recorded_readings
from .stepper import refuse_inputs

NAMED = "Derivatives need the memory of a controller by name: pass memory={...} with its first values."
SAME = 1e-6  # of a period: two times that are the same sample


class Control:
    """The controllers of one run.

    Parameters
    ----------
    system : with the controlled inputs as states
    controllers : Sequence
    names : what each sets: inputs, and what it remembers
    begin : the state at the first sample, before it
    """

    def __init__(
        self, system: System, controllers: Sequence[Controller], names: Sequence[Sequence[str]], begin: State
    ) -> None:
        self.system, self.begin, self._first = system, begin, float(begin.t)
        self._own = list(zip(controllers, names, strict=True))
        self._outputs = SampledOutputs(system)

    def times(self, until: float) -> Array:
        """The times of samples between the start and the end."""
        begin = self._first
        found = [
            begin + one.period * np.arange(1, np.ceil((until - begin) / one.period - SAME))
            for one, _ in self._own
        ]
        return np.unique(np.concatenate(found))

    def due(self, t: float) -> Iterator[tuple[Controller, Sequence[str], float]]:
        """Yield the controllers with a sample at a time, what they set, and the time of the sample."""
        for controller, names in self._own:
            samples = (t - self._first) / controller.period
            if abs(samples - round(samples)) <= SAME:  # the loop stops just before it
                yield controller, names, self._first + round(samples) * controller.period

    def is_due(self, t: float) -> bool:
        """Return whether there is a sample at a time."""
        return any(self.due(t))

    def values(self, state: State) -> dict[str, float]:
        """The values that the controllers set at a sample."""
        readings, found = self._outputs.at(state), dict[str, float]()
        for controller, names, t in self.due(float(state.t)):
            values = controller.values(t, readings)
            if [*values] != [*names]:
                before, after = ", ".join(names), ", ".join(values)
                message = f"the controller {controller.title} set {before} before, but now {after}"
                raise SarrusError(f"{message}. Return values of the same inputs in the same order.")
            if any(isinstance(value, Traced) for value in values.values()):  # from a call for derivatives
                raise SarrusError(f"the controller {controller.title} has a memory of its own. {NAMED}")
            found |= {name: float(value) for name, value in values.items()}
        return found

    def after(self, state: State, values: Mapping[str, float]) -> Array:
        """The velocities after a sample (nq,)."""
        v = np.array(state.v)
        for name, value in values.items():
            v[self.system.states[name].place] = value
        return v

    def event_step(self, state: State, values: Mapping[str, float]) -> EventStep:
        """The record of a sample, for derivatives."""
        sample, t = Sample(self, state, values), float(state.t)
        return EventStep(
            name=f"sample of {sample.title}", t=t, function=f"t - ({t!r})", along=None, restitution=None,
            reset=sample, q=np.array(state.q), v=np.array(state.v), after=self.after(state, values),
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Sample:
    """One sample of a run.

    Attributes
    ----------
    control : Control
    state : before the sample
    values : that the controllers gave
    """

    control: Control
    state: State
    values: Mapping[str, float]

    @property
    def title(self) -> str:
        """The controllers."""
        return " and ".join(one.title for one, _, _ in self.control.due(float(self.state.t)))

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
        for controller, _, t in self.control.due(float(self.state.t)):
            for name, value in self._recorded(controller, t, readings).items():
                v[system.states[name].place] = value
        return v

    def _recorded(self, controller: Controller, t: float, readings: Readings) -> dict[str, Any]:
        try:
            found = controller.values(t, readings)
            return {
                name: value if isinstance(value, Traced) else float(value) for name, value in found.items()
            }
        except SarrusError:
            raise
        except Exception as error:  # foreign code: whatever it raises
            raise SarrusError(
                f"the controller {controller.title} cannot be differentiated: {str(error).rstrip('.')}. Write it with "
                "arithmetic and NumPy's functions of numbers, or leave out store_steps and error."
            ) from error

    def _refuse_other_values(self) -> None:
        """Refuse a function with a memory of its own: after a call at the start it returns other values."""
        self.control.values(self.control.begin)
        again = self.control.values(self.state)
        for name, value in self.values.items():
            if again[name] != value:
                message = f"the controller {self.title} returned {value:.9g} for {name} at t = {self.state.t:.6g} s in "
                raise SarrusError(
                    f"{message}the run, but {again[name]:.9g} when it was called again. {NAMED}"
                )


class Controlled(NamedTuple):
    """A system whose controlled inputs are states, its start, the controllers, and the values of the first sample.

    The start has these values already, unless derivatives are wanted.
    """

    system: System
    start: State
    control: Control
    first: Mapping[str, float]


def controlled(
    system: System, start: Start | None, controllers: Sequence[Controller], differentiated: bool = False
) -> Controlled:
    """The system of a run with controllers, and their first samples.

    Raises
    ------
    SarrusError
        If a controller sets what is no input, or what another one sets, or if it is to be differentiated, and cannot.
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
    own = [one.values(float(now.t), readings_at(plain, now, one.memory)) for one in controllers]
    names = [name for found in own for name in found]
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise SarrusError(f"two controllers set the input {twice}. Let one of them set it.")
    memory = {name: float(value) for one in controllers for name, value in one.memory.items()}
    inputs = [name for name in names if name not in memory]
    refuse_inputs(system, inputs, unset)
    first = {name: float(value) for found in own for name, value in found.items()}
    before = memory | {name: float(plain.b[plain.inputs[name].places[0]]) for name in inputs}
    held = _held(plain, before if differentiated else first, memory)
    moved = _moved(plain, held, now)
    control = Control(held, controllers, [[*found] for found in own], moved)
    if differentiated:
        Sample(control, moved, first).record(outputs_at(held, moved))
    return Controlled(held, moved, control, first)


def _state(system: System, begin: Assembly) -> State:
    """The state at a start."""
    b = system.b.copy()
    if len(begin.memory):
        b[system.memory_places] = begin.memory
    system.remember(begin.q, b, begin.t)
    revolutions = begin.revolutions if len(begin.revolutions) else np.zeros(system.joint_coordinates.m)
    zero = np.zeros(system.nq), np.zeros(system.m)
    return State(begin.t, begin.q, begin.v, *zero, b[system.memory_places], revolutions)


def _held(system: System, values: Mapping[str, float], memory: Mapping[str, float]) -> System:
    """The system with inputs, and with what controllers remember, as states that stay as they are."""
    forces = [
        StateVariable(one.name, rate=0.0, initial=values[one.name], unit=one.unit)
        if isinstance(one, Input) and one.name in values
        else one
        for one in system.model.forces
    ]
    forces += [StateVariable(name, rate=0.0, initial=values[name]) for name in memory]
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
