"""What springs, coils and energies are along a motion, as traced numbers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..algebra import Array
from ..elements import RSDA, TSDA, NonlinearRSDA, NonlinearTSDA
from ..model.tape import Traced, whole
from ..system.population import Population
from .energies import Along, Energy, members, plain, told
from .recording import Recording, UnknownOutput, members_of

SPRINGS, COILS = (TSDA, NonlinearTSDA), (RSDA, NonlinearRSDA)
WORDS = {SPRINGS: ("length", "rate", "tension"), COILS: ("angle", "rate", "torque")}


class ForceOutputs(Recording):
    """Outputs of the elements that act with forces or keep energy."""

    def length(self, spring: str) -> Any:
        """Length of a TSDA. [m]"""
        return self._stretch(spring)[0]

    def stretching(self, spring: str) -> Any:
        """Its rate. [m/s]"""
        return self._stretch(spring)[1]

    def tension(self, spring: str) -> Any:
        """Its force, tension positive. [N]"""
        return self.element(*self._member(spring, SPRINGS), "b").law(*self._stretch(spring), self.t).f

    def coil(self, name: str, word: str) -> Any:
        """Of an RSDA the ``angle`` with all turns, its ``rate``, or the ``torque`` on body i. [rad], [rad/s], [N m]"""
        p, k = self._member(name, COILS)
        element: Any = self.element(p, k, "b")
        angle = self.told(p, k, "remember")[0]
        if word == "angle":
            return angle
        rate = element.turn(self.local(p, k, "q"), self.local(p, k, "v")).rate
        return rate if word == "rate" else element.law(angle, rate, self.t).n

    def kinetic_energy(self) -> Any:
        """½ vᵀ M v. [J]"""
        return self._summed("kinetic")

    def potential_energy(self) -> Any:
        """That of gravity, springs and bushings, and of users' elements with `potential`. [J]"""
        return self._summed("potential")

    def _summed(self, energy: Energy) -> Any:
        """The energy of all elements."""
        others = [p for p in members(self.system, energy) if not plain(p)]
        every = [(p, told(p.variant, energy), k) for p in others for k in range(p.count)]
        found = sum(self.replayed(p, k, one.graph, [one.value])[0] for p, one, k in every)
        along = Along(self.system, energy, self._b, *self._states[:3])
        return self._on_tape(along) + found if len(along.coordinates) else found

    def _on_tape(self, along: Along) -> Traced:
        """An energy as one operation."""
        inputs = [self.input(kind, int(n)) for kind in ("q", "v") for n in along.coordinates]
        inputs += [self.input("b", int(n)) for n in along.numbers]
        width, count = len(along.coordinates), len(self._states.t)

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

    def _stretch(self, spring: str) -> tuple[Any, Any]:
        p, k = self._member(spring, SPRINGS)
        element: Any = self.element(p, k, "b")
        x, v = self.local(p, k, "q"), self.local(p, k, "v")
        d, rate = element.d(x), element.d_xi(x, v)
        length = np.sqrt(d @ d)
        return length, (d @ rate) / length

    def has(self, name: str, kinds: tuple[type, ...]) -> bool:
        """Whether a part of the model is an element of some kinds."""
        return any(members_of(p, name) for p in self.system.populations if p.kind in kinds)

    def _member(self, name: str, kinds: tuple[type, ...]) -> tuple[Population, int]:
        found = [(p, k) for p in self.system.populations if p.kind in kinds for k in members_of(p, name)]
        if not found:
            raise UnknownOutput(f"{self.system.name} has no {kinds[0].__name__} named {name!r}")
        return found[0]
