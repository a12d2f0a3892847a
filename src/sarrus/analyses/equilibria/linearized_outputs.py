"""Derivatives of outputs at one state, by coordinates, velocities, accelerations, multipliers and parameters."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...algebra import Array
from ...model.tape import Traced
from ...outputs import Outputs
from ...outputs.motion import motion_outputs
from ...outputs.output import Level, components, find_output
from ...system import System


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
    single = [one for name in names for one in components(system, name)]
    every = [find_output(system, name, Level.ACCELERATION, "a linearization") for name in single]
    recording = motion_outputs(system, state, Outputs)
    found = [one.record(recording) for one in every]
    widths = {"q": system.nq, "v": system.nq, "a": system.nq, "lam": system.m, "b": len(system.b)}
    slopes: dict[str, Any] = {kind: np.zeros((len(every), width)) for kind, width in widths.items()}
    for row, value in enumerate(found):
        if isinstance(value, Traced):
            bars = recording.tape.gradient({value.at: 1.0})
            for (kind, n), variable in recording.inputs.items():
                if kind in slopes:
                    slopes[kind][row, n] = np.ravel(bars[variable.at])[0]
    values = np.array([np.ravel(x.value if isinstance(x, Traced) else x)[0] for x in found], dtype=float)
    return OutputSlopes(tuple(one.name for one in every), tuple(one.unit for one in every), values, **slopes)
