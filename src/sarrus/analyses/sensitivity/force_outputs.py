"""What springs, coils and energies are along a motion, as traced numbers."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...elements import RSDA, TSDA, NonlinearRSDA, NonlinearTSDA
from ...elements.operators import OPERATORS
from ...system.population import Population
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
        inertias = [p for p in self.system.populations if OPERATORS["M_a"] in p.kind.family]
        return 0.5 * sum(self._twice_kinetic(p, k) for p in inertias for k in range(p.count))

    def potential_energy(self) -> Any:
        """That of gravity, linear springs and bushings, and of users' elements with `potential`. [J]"""
        members = [p for p in self.system.populations if callable(getattr(p.kind, "potential", None))]
        return sum(x for p in members for k in range(p.count) for x in self.told(p, k, "potential"))

    def _twice_kinetic(self, p: Population, k: int) -> Any:
        v = self.local(p, k, "v")
        momentum = self.element(p, k, "b").M_a(self.local(p, k, "q"), v)
        return sum(part @ block for part, block in zip(v, momentum, strict=True) if block is not None)

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
