"""Outputs that controllers read: by compiled kernels at every sample, or recorded, for derivatives."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np

from ...._jit.kernels.pointer import call_kernels
from ...._jit.linking.link import compiled, link
from ....algebra import Array
from ....model import SarrusError
from ....outputs import Level, Outputs, find_output
from ....outputs.motion import MotionOutputs, motion_outputs, over
from ....results import State
from ....system import System
from . import sample_loop
from .named_outputs import NamedOutputs


class Readings:
    """Argument of a controller: outputs at a sample, ``o["pin.angle"]``, or ``o("pin.angle")``.

    Parameters
    ----------
    read : gives the value of an output by its name
    """

    def __init__(self, read: Callable[[str], Any]) -> None:
        self._read = read

    def __getitem__(self, name: str) -> Any:
        """The value of an output."""
        return self._read(name)

    __call__ = __getitem__


class SampledOutputs:
    """Outputs of a system at one state after another, compiled for all names that were read so far.

    Those that have no kernels of one state, such as energies, are evaluated by their formulas.
    """

    def __init__(self, system: System) -> None:
        self._system = system
        self._places: dict[str, int] = {}
        self._formulas: set[str] = set()
        self._compiled: NamedOutputs | None = None

    def at(self, state: State, known: Mapping[str, float]) -> Readings:
        """The outputs at a state, or known values by name."""
        found: Array | None = None

        def read(name: str) -> float:
            nonlocal found
            if name in known:
                return known[name]
            if name not in self._places and name not in self._formulas:
                self._add(name)
                found = None
            if name in self._formulas:
                return float(readings_at(self._system, state)[name])
            found = self._values(state) if found is None else found
            return float(found[self._places[name]])

        return Readings(read)

    def _add(self, name: str) -> None:
        """Compile one more output."""
        find_output(self._system, name, Level.VELOCITY, "a controller")
        try:
            self._compiled = NamedOutputs(self._system, [*self._places, name])
            self._places[name] = len(self._places)
        except SarrusError:
            self._formulas.add(name)

    def _values(self, state: State) -> Array:
        """All values at a state."""
        assert self._compiled is not None
        self._compiled.begin(state.q, state.revolutions)
        link(evaluate)(self._compiled.loop, float(state.t), state.q, state.v)
        return self._compiled.loop.out[self._compiled.order]


@compiled(entry=True)
def evaluate(outputs: sample_loop.Outputs, t: float, q: Array, v: Array) -> None:
    """Write the values of outputs at a state."""
    call_kernels(outputs.values, outputs.b, t, q, v, outputs.out)


def outputs_at(system: System, state: State, kind: type[Outputs] = Outputs) -> Outputs:
    """The recorded outputs of one state."""
    rows = {name: np.asarray(value)[None] for name, value in state._asdict().items()}
    return motion_outputs(system, SimpleNamespace(**rows), kind)


def readings_at(system: System, state: State, known: Mapping[str, float] | None = None) -> Readings:
    """Outputs at a state by their formulas, or known values by name."""

    def read(name: str) -> float:
        if known and name in known:
            return known[name]
        output = find_output(system, name, Level.VELOCITY, "a controller")
        return float(over(output.record(outputs_at(system, state, MotionOutputs)), np.zeros(1))[0])

    return Readings(read)


def recorded_readings(outputs: Outputs) -> Readings:
    """Outputs as recorded numbers."""

    def read(name: str) -> Any:
        return find_output(outputs.system, name, Level.VELOCITY, "a controller").record(outputs)

    return Readings(read)
