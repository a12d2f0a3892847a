"""Stepper: a motion sample by sample, with inputs that are set in between."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...._jit.kernels.bound import Bound
from ....algebra import Array
from ....linalg.threads import one_thread_if_small
from ....model import SarrusError
from ....model.checks.arguments import Number
from ....model.show import suggest
from ....model.states.input import refuse_repeated_inputs, refuse_unknown_input
from ....system import System
from ...arguments import refuse_other_system
from ...position.initial_state import Start, start_of
from ..former_options import accepts_former_options
from ..inputs.laws_of_time import points_of_tables
from ..integrators.described import Radau
from ..integrators.differentiable import Differentiable, differentiable
from ..step_loop import loop
from ..stepping.stepper import RunFailure, Settings, state_of, take_over
from ..stepping.tolerance import Tolerances
from .named_outputs import NamedOutputs
from .sample_loop import Inputs, Sampling, take_sample

HORIZON = 1000  # samples, over which the first step and the number of periods are estimated
VARIABLES = "_method", "_inputs", "_named.loop.b", "_named.loop.out", "_count", "steps"
OF_SAMPLES = Radau(rtol=1e-6)  # [-] errors of a sample are small against those of its inputs


class Stepper:
    """A motion sample by sample: `advance` sets inputs, integrates to the next sample and returns outputs.

    Inputs are constant over a sample (zero-order hold). Within a sample the method takes as many steps as the
    tolerances need; its step size and factors continue from sample to sample.

    Parameters
    ----------
    system : System
    start : as for `simulate`, at any time; by default the model's state
    step : length of a sample [s]
    inputs : names of the inputs that are set, in the order of the values of `advance`; by default those without a
        value. Others follow their values in the model
    outputs : names of outputs of positions, velocities, states, forces and inputs, in the order of the results; by
        default all angles and displacements of joints
    method : ``Radau(rtol=1e-6)`` (the default), `HHT`, `GeneralizedAlpha`, or the `Description` of another method

    Attributes
    ----------
    t : the time reached [s]
    q, v : (nq,) the state reached
    steps : number of steps taken
    values : (k,) outputs at the time reached

    Raises
    ------
    SarrusError
        For an input or output that does not exist or cannot be set, an input without a value that is not among
        `inputs`, or a start that is inconsistent.

    Notes
    -----
    Points of tables over time within a sample are hit exactly, other features of laws over time are not looked for:
    take samples that are short against them.
    """

    @accepts_former_options
    @one_thread_if_small
    def __init__(
        self,
        system: System,
        start: Start | None = None,
        *,
        step: float,
        inputs: Sequence[str] | None = None,
        outputs: Sequence[str] | None = None,
        method: Differentiable | None = OF_SAMPLES,
    ) -> None:
        refuse_other_system(system, "Stepper", unset=True)
        Number(positive=True)("step", step)
        unset = [name for name, one in system.inputs.items() if not one.is_set]
        self.inputs = tuple(unset if inputs is None else inputs)
        refuse_inputs(system, self.inputs, unset)
        self.outputs = tuple(system.joint_coordinates.names if outputs is None else outputs)
        self.system = system.with_inputs(dict.fromkeys(unset, 0.0))
        self.step = float(step)
        self._start = start_of(self.system, start, "Stepper")
        if not self._start.success:
            raise SarrusError(f"{system.name}: {self._start.message}")
        self._chosen = chosen = OF_SAMPLES if method is None else differentiable(method)
        tolerances = Tolerances.of(self.system, chosen.rtol, chosen.atol)
        self._settings = Settings(tolerances, chosen.max_step, chosen.first_step or 0.0)
        self._first, self._count, self.steps = self._start.t, 0, 0
        self._begin()

    def _begin(self) -> None:
        """The method at work, its inputs and outputs."""
        start, system = self._start, self.system
        self._stops = points_of_tables(system, start.t, start.t)[0]
        self._method = _reported(lambda: self._chosen.stepper(system, start, self._settings))
        self._has_history = self._method.has_history
        self._named = NamedOutputs(system, self.outputs)
        self._named.begin(start.q, start.revolutions)
        until = start.t + HORIZON * self.step
        _reported(lambda: self._method.restart(start.t, start.q.copy(), start.v.copy(), until))
        own, seen = (
            [(place, k) for k, name in enumerate(self.inputs) for place in where(name)]
            for where in (
                lambda name: system.inputs[name].places,
                lambda name: self._named.inputs.get(name, ()),
            )
        )
        pairs = (np.array(found, dtype=np.int64).reshape(-1, 2).T.copy() for found in (own, seen))
        given = np.array([system.b[system.inputs[name].places[0]] for name in self.inputs])
        (places, k_of), (seen_places, k_seen) = pairs
        self._inputs = Inputs(given, given.copy(), places, k_of, seen_places, k_seen, np.zeros(1))
        self._pack()
        self._call(start.t)

    def _pack(self) -> None:
        """Fix the arguments of the compiled loop."""
        own = self._method
        self._call = Bound(take_sample, Sampling(own.run(), self._inputs, self._named.loop))

    @property
    def t(self) -> float:
        """The time reached."""
        return float(self._method._control.t)

    @property
    def q(self) -> Array:
        """The coordinates reached (nq,)."""
        return np.array(self._method._state.q0)

    @property
    def v(self) -> Array:
        """The velocities reached (nq,)."""
        return np.array(self._method._state.v0)

    @property
    def values(self) -> Array:
        """The outputs at the time reached (k,)."""
        return self._named.loop.out[self._named.order]

    def advance(self, u: Any = None) -> Array:
        """Integrate to the next sample.

        Parameters
        ----------
        u : values of the inputs (k,), a number for one input, or a mapping of some of them by name; None leaves them

        Returns
        -------
        outputs (k,)

        Raises
        ------
        ValueError
            If a value is not finite.
        SarrusError
            If the motion cannot go on; the state is that of the last step.
        """
        if u is not None:
            self._set(u)
        if self._has_history:
            self._begin_anew()
        until = self._first + (self._count + 1) * self.step
        if len(self._stops) or self._method.independence.rows is not None:
            self._over_stops(until)
        else:
            status, taken = self._call(until)
            self.steps += taken
            if status != loop.FINISHED:
                self._complete(status, taken, until)
        self._count += 1
        return self._named.loop.out[self._named.order]

    def _set(self, u: Any) -> None:
        """Take the inputs of the next sample."""
        given = self._inputs.given
        if isinstance(u, Mapping):
            for name, value in u.items():
                if name not in self.inputs:
                    raise SarrusError(
                        f"{name!r} is no input of this stepper. {suggest(str(name), self.inputs)}"
                    )
                given[self.inputs.index(name)] = value
        else:
            given[:] = u
        for k in range(len(given)):
            if not abs(given[k]) < np.inf:
                wrong, given[k] = given[k], self._inputs.present[k]
                raise ValueError(f"the input {self.inputs[k]} must be finite, but is {wrong}. Give a number.")

    def _begin_anew(self) -> None:
        """Take changed inputs where a method has accelerations of its own, or of steps before."""
        own, inputs = self._method, self._inputs
        if np.array_equal(inputs.given, inputs.present):
            return
        inputs.present[:] = inputs.given
        own.b[inputs.places] = inputs.present[inputs.own]
        own.t = self.t
        _reported(own.jump)

    def _over_stops(self, until: float) -> None:
        """A sample with points of tables in it, or with a choice of equations that is looked at."""
        for stop in (*self._stops[(self._stops > self.t) & (self._stops < until)], until):
            if self._method.independence.rows is not None:
                self._method._renew_equations()
                if self._method._arrays is None:
                    self._pack()
            status, taken = self._call(stop)
            self.steps += taken
            if status != loop.FINISHED:
                self._complete(status, taken, stop)

    @one_thread_if_small
    def _complete(self, status: int, taken: int, until: float) -> None:
        """Go on after new pivots, or with shorter steps."""
        while status != loop.FINISHED:
            self._method.t = self.t
            _reported(lambda: self._method._look(status, taken))  # noqa: B023 - called at once
            _reported(self._pack)
            status, taken = self._call(until)
            self.steps += taken

    def state(self) -> dict[str, Array]:
        """All on which the next samples depend, to the last bit, for `restore`."""
        self._method.t = self.t
        return state_of(self, VARIABLES)

    def restore(self, state: Mapping[str, Array]) -> None:
        """Go back to a state of this stepper, or of a copy."""
        take_over(self, VARIABLES, state)
        self._pack()

    def copy(self) -> Stepper:
        """Return an independent stepper at the same state."""
        found = object.__new__(type(self))
        found.__dict__.update(self.__dict__)
        found._begin()
        found.restore(self.state())
        return found

    __copy__ = copy


def refuse_inputs(system: System, names: Sequence[str], unset: Sequence[str]) -> None:
    """Refuse inputs that cannot be set or are named twice, and others without a value."""
    refuse_repeated_inputs(system.name, names)
    for name in names:
        refuse_unknown_input(system.name, name, system.inputs)
        one = system.inputs[name]
        if one.varies:
            raise SarrusError(
                f"the input {name} follows a law over time. Give it a number, or leave it out of inputs."
            )
        if one.driving:
            raise SarrusError(
                f"drivers follow the input {name}, and positions cannot jump. Use a force or a controller."
            )
    for name in unset:
        if name not in names:
            raise SarrusError(
                f"{system.name}: the input {name} is not set. Name it in inputs, or give it a value."
            )


def _reported(function: Any) -> Any:
    """The result of a function; failures of the motion are errors."""
    try:
        return function()
    except RunFailure as failure:
        raise SarrusError(failure.message) from None
