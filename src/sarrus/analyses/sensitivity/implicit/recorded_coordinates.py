"""Independent coordinates of a linearization and its outputs, recorded with their rates and accelerations."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

import numpy as np

from ....algebra import Array
from ....model.tape import Traced
from ....outputs.recording import States
from ....results import StateSpace
from ....system import System
from .recorded_outputs import RecordedOutputs, weighted
from .solved_states import Slopes


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

    def _along(self, of: Traced, rates: Mapping[str, str]) -> Traced:
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
