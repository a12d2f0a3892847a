"""Outputs by name as compiled kernels of one state."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np

from ....algebra import Array
from ....elements.recorder import record_scalars
from ....model import ModelError, SarrusError
from ....model.expansion.blueprint import Placement
from ....model.expansion.expand import signals_of
from ....model.forces.formula_element import Target, load_primitive
from ....model.geometry.points import GROUND
from ....model.laws.recorded import Recording
from ....model.quantity import InputNumber
from ....model.signals import Measure
from ....model.states.input import Anywhere, nothing
from ....outputs import find_output
from ....system import System
from ....system.operators.element_values import ElementValues, memory_places
from ....system.structure.population import places_of, populate
from .sample_loop import Outputs

_values = partial(record_scalars, method="values", arguments=3)


class NamedOutputs:
    """Outputs of positions, velocities, states, forces and inputs.

    Parameters
    ----------
    system : System
    names : of the outputs

    Attributes
    ----------
    loop : for the compiled loop
    order : places of the names in its results
    inputs : input -> indices of its number in the parameters of the outputs' elements

    Raises
    ------
    SarrusError
        For an output that depends on more than that, or that does not exist.
    """

    def __init__(self, system: System, names: Sequence[str]) -> None:
        self._system = system
        full = {name: find_output(system, name).name for name in names}
        placed = [_placed(system, name, one) for name, one in full.items()]
        populations, b = populate(placed, system.layout.firsts)
        values, self._memory = (
            ElementValues("outputs", populations, _values, ("q", "v")),
            memory_places(populations),
        )
        remembered = ElementValues("remember", populations)
        own = {name: k for k, name in enumerate(values.owners)}
        self.order = np.array([own[name] for name in names], dtype=np.int64)
        self._angles = [full[owner] for owner in remembered.owners]
        self._refuse_windings(names, full)
        buffers = np.zeros(len(self._memory)), np.zeros(values.size)
        self.loop = Outputs(values.entry(), remembered.entry(), b, self._memory, *buffers)
        self.inputs: dict[str, list[int]] = {}
        for place, value in places_of(populations, placed, b):
            if isinstance(value, InputNumber):
                self.inputs.setdefault(value.name, []).append(place)

    def _refuse_windings(self, names: Sequence[str], full: Mapping[str, str]) -> None:
        known = self._system.joint_coordinates.names
        for name in names:
            if full[name] in self._angles and _coordinate(full[name]) not in known:
                raise SarrusError(f"{name}: its revolutions are not counted here. Name an angle of a joint.")

    def begin(self, q: Array, revolutions: Array) -> None:
        """Take the revolutions of angles at a state."""
        every = self._system.joint_coordinates
        values = every.with_revolutions(every.Phi(q), revolutions)
        for place, name in zip(self._memory, self._angles, strict=True):
            self.loop.b[place] = values[every.index(_coordinate(name))]


def _coordinate(name: str) -> str:
    """The coordinate that an output is, or whose rate it is."""
    return name.removesuffix(".rate")


def _placed(system: System, name: str, full: str) -> Placement:
    """The element that measures an output."""
    signals, bodies = signals_of(system.model)
    recording = Recording("output", {}, {}, variables=signals.variables)
    try:
        law = recording.named(full)
        target = Target(Measure(Anywhere, (bodies[0],), ()), nothing)
        found = load_primitive(target, [law], recording, signals.of(recording))
    except ModelError:
        message = f"{name} is no output of positions, velocities, states, forces and inputs alone"
        raise SarrusError(f"{message}. Read others, such as reactions, from a run.") from None
    index = {one: n for n, one in enumerate((GROUND, *bodies))}
    return Placement(found.element, tuple(index[one] for one in found.bodies), found.values, name, "output")
