"""The energy balance of a run: stored energy, and energy that each part dissipated and supplied since the start."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...algebra import Array
from ...deferred import accumulator, renderer
from ...outputs.energy import drivers_of, forces_of
from ...outputs.motion import motion_outputs, over
from ..result import Result


@dataclass(frozen=True, eq=False)
class EnergyBalance(Result):
    """Energies over the times of a run [J]. `total` is constant but for the error of the method.

    Attributes
    ----------
    t : (nt,) [s]
    kinetic, potential : (nt,) potential of gravity, springs and bushings
    elastic : (nt,) stored by contacts, stops and tyres, with spins that are states
    dissipated, supplied : by part (nt,), since the start
    impacts : (nt,) kinetic energy lost in impacts and resets of velocities since the start
    """

    name: str
    t: Array = field(repr=False)
    kinetic: Array = field(repr=False)
    potential: Array = field(repr=False)
    elastic: Array = field(repr=False)
    dissipated: Mapping[str, Array] = field(repr=False)
    supplied: Mapping[str, Array] = field(repr=False)
    impacts: Array = field(repr=False)

    @property
    def total(self) -> Array:
        """Kinetic + potential + elastic + dissipated + lost in impacts - supplied (nt,). [J]"""
        stored = self.kinetic + self.potential + self.elastic + self.impacts
        return np.asarray(stored + sum(self.dissipated.values()) - sum(self.supplied.values()))

    @property
    def drift(self) -> float:
        """The largest change of the total since the start. [J]"""
        return float(np.max(abs(self.total - self.total[0]), initial=0.0)) if len(self.t) else 0.0

    def rows(self) -> list[tuple[str, Array]]:
        """Name and values over time of each energy, parts by size; those that are zero are left out."""
        rows: list[tuple[str, Array]] = [
            (word, getattr(self, word)) for word in ("kinetic", "potential", "elastic")
        ]
        for word, parts in (("dissipated", self.dissipated), ("supplied", self.supplied)):
            ranked = sorted(parts.items(), key=lambda part: -abs(part[1][-1]))
            rows += [(f"{word} {name}", values) for name, values in ranked if np.any(values)]
        return [*rows, *([("impacts", self.impacts)] * bool(np.any(self.impacts)))]

    def summary(self) -> str:
        """Each energy at the start and at the end, parts by size."""
        if not len(self.t):
            return f"{self.name}: no states, so no energies"
        wide = max([len(name) for name in (*self.dissipated, *self.supplied)] + [9]) + 11
        lines = [f"{self.name}: energies in J", f"  {'':<{wide}}{'start':>14}{'end':>14}"]
        lines += [f"  {name:<{wide}}{values[0]:>14.6g}{values[-1]:>14.6g}" for name, values in self.rows()]
        return "\n".join([*lines, f"  drift of the total: {self.drift:.1g}"])

    def plot(self, ax: Any = None) -> Any:
        """Draw the energies over time; see `sarrus.views.plot_energy_balance`."""
        return renderer().plot_energy_balance(self, ax)


def energy_balance(run: Any) -> EnergyBalance:
    """See `Trajectory.energy_balance`."""
    system = run.system
    outputs, forces, drivers = motion_outputs(system, run), forces_of(system), drivers_of(system)
    names = [f"{force}.dissipated_power" for force in forces]
    names += [f"{part}.supplied_power" for part in (*forces, *drivers)]
    sums = accumulator()(system, run, names) if names else np.zeros((0, len(run.t)))
    kinetic, potential, elastic = (
        over(outputs(f"energy.{word}"), run.t) for word in ("kinetic", "potential", "elastic")
    )
    dissipated = dict(zip(forces, sums, strict=False))
    supplied = dict(zip((*forces, *drivers), sums[len(forces) :], strict=True))
    return EnergyBalance(run.name, run.t, kinetic, potential, elastic, dissipated, supplied, _lost(run))


def _lost(run: Any) -> Array:
    """Kinetic energy lost where velocities jumped, since the start (nt,)."""
    found = np.zeros(len(run.t))
    for event in run.events:
        before, after = (run.system.kinetic_energy(event.q, v) for v in (event.v, event.after))
        later = (run.t > event.t) | ((run.t == event.t) & np.all(run.v == event.after, axis=1))
        found += (before - after) * later
    return found
