"""The coordinates of one joint over the times of a trajectory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ..algebra import Array


@dataclass(frozen=True)
class JointMotion:
    """Angles and displacements of a joint with their rates, over time.

    Attributes
    ----------
    values, rates : by the coordinate's name, ``angle``, ``travel``, ``angle_i`` ... (nt,) [rad or m], [1/s]
    """

    name: str
    values: Mapping[str, Array] = field(repr=False)
    rates: Mapping[str, Array] = field(repr=False)

    def _one(self, found: Mapping[str, Array], name: str) -> Array:
        if name not in found:
            raise AttributeError(f"joint {self.name!r} has no {name}; it has {', '.join(found)}")
        return found[name]

    @property
    def angle(self) -> Array:
        """The angle, including all revolutions (nt,). [rad]"""
        return self._one(self.values, "angle")

    @property
    def travel(self) -> Array:
        """The travel (nt,). [m]"""
        return self._one(self.values, "travel")

    @property
    def rate(self) -> Array:
        """The rate of the angle, or of the travel where there is no angle (nt,)."""
        return self._one(self.rates, "angle" if "angle" in self.rates else "travel")
