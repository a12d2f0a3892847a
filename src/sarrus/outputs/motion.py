"""Outputs of a result as plain numbers over time: of a trajectory, an equilibrium, modes, a linearization."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..algebra import Array
from ..deferred import accumulator, sharers
from ..system import System
from ..system.curves.curve_potentials import curve_potentials
from .energy import Energy
from .output import Level, find_output, labelled, parameters_of
from .outputs import Outputs
from .recording import Angles, States


@dataclass(frozen=True)
class Series:
    """An output over time.

    Attributes
    ----------
    name, unit, label : ``slider.x``, m, and both for axes
    t, values : (nt,)
    """

    name: str
    unit: str
    label: str
    t: Array = field(repr=False)
    values: Array = field(repr=False)
    run: Any = field(default=None, repr=False, compare=False, kw_only=True)

    @property
    def shared(self) -> tuple[str, ...]:
        """The redundant joints that share it, in least norm; none where it is determined, or without a system."""
        return shared_by(self.run, [self.name])

    def __str__(self) -> str:
        return f"{self!r}{words_of(self.shared)}"

    @classmethod
    def of(cls, name: str, unit: str, t: Array, values: Array, rate: bool = False) -> Series:
        """An output, or its rate of change, of the output's unit."""
        if rate:
            unit = f"{unit or 1}/s"
        return cls(name, unit, labelled(f"rate of {name}" if rate else name, unit), t, values)


def shared_by(run: Any, names: Sequence[str]) -> tuple[str, ...]:
    """The redundant joints that share what outputs of a run or an equilibrium read."""
    found: tuple[str, ...] = sharers()(run.system, run, names) if getattr(run, "system", None) else ()
    return found


def words_of(shared: Sequence[str]) -> str:
    """A line below what is shared; nothing where it is determined."""
    names = f"{', '.join(shared[:-1])} and {shared[-1]}" if len(shared) > 1 else "".join(shared)
    line = f"\nshared by {names}: the joints are redundant, and this is the share of least norm."
    return line if shared else ""


def reaction_outputs(joint: str) -> list[str]:
    """The names of the force and torque of a joint."""
    return [f"{joint}.{word}.{axis}" for word in ("force", "torque") for axis in "xyz"]


class MotionOutputs(Outputs):
    """Outputs whose values alone are wanted, not their derivatives."""

    result: object = None  # which they are of

    def accumulated(self, rate: str) -> Any:
        """The integral of a power since the start of the run. [J]"""
        return self.constant(accumulator()(self.system, self.result, [rate])[0])

    def _summed(self, energy: Energy) -> Any:
        t, q, v = self.states.t, self.states.q, self.states.v
        b, found = self._b.copy(), np.zeros(len(t))
        for n in range(len(t)):
            for place, values in self._memory.items():
                b[place] = values[n]
            if energy == "kinetic":
                found[n] = self.system.kinetic_energy(q[n], v[n], b=b)
            else:
                found[n] = self.system.potentials(q[n], b, t[n]).sum()
        if energy == "potential":
            found += curve_potentials(self.system.populations, self._b, self._memory, t, q)
        return self.constant(found)


def motion_outputs(
    system: System, result: Any, kind: type[Outputs] = MotionOutputs, level: Level = Level.HISTORY
) -> Outputs:
    """The outputs up to a level of a result that has q, and perhaps t, v, a, lam, revolutions and memory."""
    states, angles, memory = states_of(result, level), None, None
    known = [np.asarray(getattr(result, name, ())) for name in ("revolutions", "memory")]
    revolutions, remembered = (one[None] if one.ndim == 1 and len(one) else one for one in known)
    if revolutions.ndim == 2 and len(revolutions) == len(states.t):
        angles = Angles(system, states, revolutions=revolutions)
        memory = dict(zip(system.memory_places.tolist(), remembered.T, strict=True))
    found = kind(system, states, system.b, lambda name, _: parameters_of(system)[name], angles, memory)
    if isinstance(found, MotionOutputs):
        found.result = result
    found.about = result
    return found


def series(system: System, result: Any, name: str, *, rate: bool = False) -> Series:
    """An output of a result over time, or its rate of change.

    Raises
    ------
    UnknownOutput
        If there is no such output, or no rate of it.
    """
    output = find_output(system, name, Level.VELOCITY if rate else Level.HISTORY, "a rate of change")
    if output.place is not None and np.ndim(result.q) > 1:  # of a saved run only this column is read
        values = np.asarray((result.v if rate else result.q)[:, output.place])
        return Series.of(output.name, output.unit, np.asarray(result.t), values, rate)
    level = Level.HISTORY if rate else output.level
    outputs = motion_outputs(system, result, Outputs if rate else MotionOutputs, level)
    t = np.asarray(outputs.t.value)
    if not t.size:  # of an analysis that failed at its start
        return Series.of(output.name, output.unit, t, t, rate)
    found = output.record(outputs)
    return Series.of(output.name, output.unit, t, over(_rate(outputs, found) if rate else found, t), rate)


def several(system: System, result: Any, names: Sequence[str]) -> list[Series]:
    """Outputs of a result over time, recorded together."""
    every = [find_output(system, name) for name in names]
    outputs = motion_outputs(system, result, level=max((one.level for one in every), default=Level.POSITION))
    t = np.asarray(outputs.t.value)
    if not t.size:
        return [Series.of(one.name, one.unit, t, t) for one in every]
    return [Series.of(one.name, one.unit, t, over(one.record(outputs), t)) for one in every]


def over(found: Any, t: Array) -> Array:
    """Return recorded values as plain numbers, one for each time."""
    return np.broadcast_to(np.asarray(getattr(found, "value", found), dtype=float), t.shape)


def _rate(outputs: Outputs, found: Any) -> Any:
    """The change with time of what was recorded of positions and velocities."""
    states, moved = outputs.states, dict[int, Any]({outputs.t.at: 1.0})
    for (kind, n), variable in outputs.inputs.items():
        if kind in ("q", "v"):
            moved[variable.at] = (states.v if kind == "q" else states.a)[:, n]
    return outputs.tape.along(moved)[found.at]


def states_of(result: Any, level: Level = Level.HISTORY) -> States:
    """The states of a result, without accelerations below their level; those of an equilibrium are one, at rest."""
    if np.ndim(result.q) == 1:
        q, lam = result.q[None], np.asarray(getattr(result, "lam", np.zeros(0)))[None]
        t = np.atleast_1d(float(getattr(result, "t", 0.0)))
        v, a = (
            np.zeros_like(q) if x is None else x[None] for x in (getattr(result, name, None) for name in "va")
        )
        return States(t, q, v, a, lambda: lam)
    q, v = np.asarray(result.q), np.asarray(result.v)
    a = np.asarray(result.a) if level >= Level.ACCELERATION else np.zeros((len(q), 0))
    return States(np.asarray(result.t), q, v, a, lambda: np.asarray(result.lam))
