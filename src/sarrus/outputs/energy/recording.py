"""Energies along a motion as traced numbers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...algebra import Array
from ...model.tape import Traced, whole
from ..recording import Recording
from .energies import Along, Energy, members, plain, recorded


class EnergyRecording(Recording):
    """A recording with energies."""

    def kinetic_energy(self) -> Any:
        """½ vᵀ M v. [J]"""
        return self._summed("kinetic")

    def potential_energy(self) -> Any:
        """Return the potential energy of gravity, springs, bushings, and users' elements with `potential`. [J]"""
        return self._summed("potential")

    def _summed(self, energy: Energy) -> Any:
        """The energy of all elements."""
        others = [p for p in members(self.system, energy) if not plain(p)]
        every = [(p, recorded(p.variant, energy), k) for p in others for k in range(p.count)]
        found = sum(self.replayed(p, k, one.graph, [one.value])[0] for p, one, k in every)
        along = Along(self.system, energy, self._b, *self.states[:3])
        return self._on_tape(along) + found if len(along.coordinates) else found

    def _on_tape(self, along: Along) -> Traced:
        """An energy as one operation."""
        inputs = [self.input(kind, int(n)) for kind in ("q", "v") for n in along.coordinates]
        inputs += [self.input("b", int(n)) for n in along.numbers]
        width, count = len(along.coordinates), len(self.states.t)

        def turned(dots: Sequence[Any]) -> Array:
            q_dot, v_dot = np.zeros((2, count, self.system.nq))
            for n, place in enumerate(along.coordinates):
                q_dot[:, place], v_dot[:, place] = dots[n], dots[width + n]
            b_dot = np.zeros(len(self._b))
            b_dot[along.numbers] = dots[2 * width :]
            return along.turned(q_dot, v_dot, b_dot)

        return self.tape.add(
            whole(along.value, along.slopes, turned), tuple(x.at for x in inputs), along.value
        )
