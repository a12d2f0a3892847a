"""Outputs of every force: vectors at its first and last body, power, and what becomes of the energy.

The power splits into three: P = supplied - dissipated - d(stored)/dt. An element declares what it dissipates and
stores; the rest is supplied. An element whose parts are known apart, such as the actuator of a spring, states what it
supplies itself, so that a passive one supplies exactly zero.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..algebra import Array
from ..euler import A, E
from .derived import potential, potential_rate
from .output import output

ZERO: Array = np.zeros(3, dtype=int)


class ForceOutputs:
    """Forces and torques in global or body axes, powers and the stored energy of elements with a kernel Q."""

    if TYPE_CHECKING:

        def Q(self, x: Any, v: Any, t: Any) -> Any:
            """The generalized force, two blocks for each body."""

    @output("N", "force", vector=True, of=-1)
    def force_on_last_body(self, x: Any, v: Any, t: Any) -> Any:
        """The force on its last body, in global axes."""
        return _force(self.Q(x, v, t)[-2])

    @output("N m", "torque", vector=True, of=-1)
    def torque_on_last_body(self, x: Any, v: Any, t: Any) -> Any:
        """The torque on its last body about that body's origin, in global axes."""
        return _torque(self.Q(x, v, t)[-1], x[-1])

    @output("N", "force_i", vector=True, bodies=2, of=0)
    def force_on_first_body(self, x: Any, v: Any, t: Any) -> Any:
        """The force on its first body, in global axes."""
        return _force(self.Q(x, v, t)[0])

    @output("N m", "torque_i", vector=True, bodies=2, of=0)
    def torque_on_first_body(self, x: Any, v: Any, t: Any) -> Any:
        """The torque on its first body about that body's origin, in global axes."""
        return _torque(self.Q(x, v, t)[1], x[1])

    @output("N", "force_body", vector=True, of=-1)
    def force_on_last_body_in_its_axes(self, x: Any, v: Any, t: Any) -> Any:
        """The force on its last body, in the axes of that body."""
        return self.force_on_last_body(x, v, t) @ A(x[-1])

    @output("N m", "torque_body", vector=True, of=-1)
    def torque_on_last_body_in_its_axes(self, x: Any, v: Any, t: Any) -> Any:
        """The torque on its last body, in the axes of that body."""
        return self.torque_on_last_body(x, v, t) @ A(x[-1])

    @output("N", "force_i_body", vector=True, bodies=2, of=0)
    def force_on_first_body_in_its_axes(self, x: Any, v: Any, t: Any) -> Any:
        """The force on its first body, in the axes of that body."""
        return self.force_on_first_body(x, v, t) @ A(x[1])

    @output("N m", "torque_i_body", vector=True, bodies=2, of=0)
    def torque_on_first_body_in_its_axes(self, x: Any, v: Any, t: Any) -> Any:
        """The torque on its first body, in the axes of that body."""
        return self.torque_on_first_body(x, v, t) @ A(x[1])

    @output("W")
    def power(self, x: Any, v: Any, t: Any) -> Any:
        """Its power on its bodies, Qᵀ v: negative where it takes energy from them."""
        blocks = zip(self.Q(x, v, t), v, strict=True)
        return sum(block @ rate for block, rate in blocks if block is not None)

    @output("J", "energy")
    def stored_energy(self, x: Any, v: Any, t: Any) -> Any:
        """The elastic energy that it stores: the sum of its `potential`, zero for an element without one."""
        return potential(self, x) if hasattr(self, "potential") else 0

    @output("W")
    def dissipated_power(self, x: Any, v: Any, t: Any) -> Any:
        """The power that it converts into heat: zero unless an element states it."""
        return 0

    @output("W")
    def supplied_power(self, x: Any, v: Any, t: Any) -> Any:
        """The power that it brings into the mechanism: its power, what it dissipates, and what it stores."""
        stored = potential_rate(self, x, v) if hasattr(self, "potential") else 0
        return self.power(x, v, t) + self.dissipated_power(x, v, t) + stored


class Passive:
    """A force that brings in no energy."""

    def supplied_power(self, x: Any, v: Any, t: Any) -> Any:
        """Zero."""
        return 0


class Dissipative(Passive):
    """A force that stores no energy: whatever it takes becomes heat."""

    def dissipated_power(self, x: Any, v: Any, t: Any) -> Any:
        """The opposite of its power."""
        return -self.power(x, v, t)  # type: ignore[attr-defined]


def _force(block: Any) -> Any:
    return ZERO if block is None else block


def _torque(block: Any, p: Any) -> Any:
    """½ E Q_p."""
    return ZERO if block is None else E(p) @ block / 2
