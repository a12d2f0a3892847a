"""Outputs at one state, recorded, with gradients of weighted sums and the changes of these."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from ....algebra import Array
from ....model.tape import Tracer
from ....outputs import Outputs
from ....outputs.output import find_output, parameters_of
from ....outputs.recording import States
from ....results import StateSpace
from ....system import System
from .solved_states import Slopes


class RecordedOutputs:
    """Outputs y(q, v, a, λ) at one state.

    Parameters
    ----------
    system : System
    states : one state
    names : of the outputs

    Attributes
    ----------
    outputs : recorded
    """

    def __init__(self, system: System, states: States, names: Sequence[str]) -> None:
        self._system = system
        self._recording = Outputs(system, states, system.b, lambda name, _: parameters_of(system)[name])
        self.outputs = self._recorded(names)

    def _recorded(self, names: Sequence[str]) -> list[Tracer]:
        return [self._traced(find_output(self._system, name).record(self._recording)) for name in names]

    def _traced(self, found: Any) -> Tracer:
        return found if isinstance(found, Tracer) else self._recording.constant(found)

    def gradient(self, bars: Mapping[int, float]) -> Slopes:
        """The gradient of a sum of what is recorded, with weights by their places."""
        return self._by_kind(self._recording.tape.gradient(bars))

    def change(self, bars: Mapping[int, float], along: Slopes) -> Slopes:
        """The change of the same gradient along a direction."""
        tape = self._recording.tape
        moved = {v.at: getattr(along, kind)[n] for (kind, n), v in self._recording.inputs.items()}
        return self._by_kind(tape.gradient_along(bars, {}, tape.along(moved))[1])

    def _by_kind(self, bars: Any) -> Slopes:
        found = self.zeros()
        for (kind, n), variable in self._recording.inputs.items():
            getattr(found, kind)[n] += np.sum(bars[variable.at])
        return found

    def zeros(self) -> Slopes:
        system = self._system
        sizes = *[system.nq] * 3, system.m, len(system.b), len(system.joint_coordinates.b)
        return Slopes._make(map(np.zeros, sizes))


def weighted(*pairs: tuple[list[Tracer], Array]) -> dict[int, float]:
    """Weights by places; those of the same place are added."""
    found = dict[int, float]()
    for some, weights in pairs:
        for one, weight in zip(some, weights, strict=True):
            found[one.at] = found.get(one.at, 0.0) + float(weight)
    return found


class RecordedCoordinates(RecordedOutputs):
    """Coordinates c(q), their first and second derivatives in time, and outputs y(q, v, a, λ) at one state.

    Parameters
    ----------
    system : System
    states : one state
    plant : the names of the coordinates and outputs

    Attributes
    ----------
    c, rate, acceleration, outputs : recorded
    c_q, rate_q : (n, nq) derivatives by q
    """

    def __init__(self, system: System, states: States, plant: StateSpace) -> None:
        super().__init__(system, states, plant.outputs)
        n = (len(plant.states) - len(system.states)) // 2
        self.c = self._recorded(plant.states[:n])
        self.rate = [self._along(x, {"q": "v"}) for x in self.c]
        self.acceleration = [self._along(x, {"q": "v", "v": "a"}) for x in self.rate]
        self.c_q, self.rate_q = (
            np.array([by.q for by in some]).reshape(n, system.nq) for some in self._slopes
        )

    @cached_property
    def _slopes(self) -> list[list[Slopes]]:
        """The gradients of each of c, and of each rate."""
        return [[self.gradient({x.at: 1.0}) for x in some] for some in (self.c, self.rate)]

    def _along(self, of: Tracer, rates: Mapping[str, str]) -> Tracer:
        """The change in time, recorded."""
        every = list(self._recording.inputs.items())
        moved = {
            variable.at: self._recording.input(rates[kind], n)
            for (kind, n), variable in every
            if kind in rates
        }
        return self._traced(self._recording.tape.recorded_along(of, moved))

    def by_parameters(self, db: Array, dc: Array) -> tuple[Array, Array]:
        """The changes of c and of its rate (n, k) with the parameters alone."""
        found = [
            np.array([by.b @ db + by.c @ dc[: len(by.c)] for by in some]).reshape(len(some), db.shape[1])
            for some in self._slopes
        ]
        return found[0], found[1]

    def gradient_by_parameters(self, c_bar: Array, rate_bar: Array) -> tuple[Array, Array]:
        """The gradients by the parameters of what has these by c and by its rate."""
        found = self.gradient(weighted((self.c, c_bar), (self.rate, rate_bar)))
        return found.b, found.c
