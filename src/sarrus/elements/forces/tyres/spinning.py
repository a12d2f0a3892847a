"""The contact of a tyre whose spin is a state: bodies are the block of the states, and the carrier of the wheel.

The angular velocity of the wheel is ω + (W - ω·s) s, of the carrier's ω, the spin axis s and the absolute spin W, the
third state of the block. Of the moment M about the wheel's centre, M·s acts on the spin,

    J Ẇ = M·s

and the rest on the carrier, with the force. The gyroscopic torque is that of the `Rotor`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ....algebra import Row, cross
from ....euler import E, rotate
from ...element import Pair, Scalar
from .contact import MASS, Contact, RollingTyre
from .rotor import SPIN


class SpinningTyre(RollingTyre, abstract=True):
    """Base of the classes of rolling tyres whose spin is a state."""

    prefix = "Spinning"
    spin_inertia: Scalar  # [kg m²] J

    def _contact(self, x: Pair, v: Pair) -> Contact:
        return super()._contact(x, self._of_wheel(x, v))

    def _of_wheel(self, x: Pair, v: Pair) -> Pair:
        """Velocities of a body that spins like the wheel, with the pose of the carrier."""
        omega, s, arm = 2 * (E(x.p_j) @ v.p_j), rotate(x.p_j, self.axis), rotate(x.p_j, self.s)
        own = (v.r_i[SPIN] - omega @ s) * s
        return Pair(v.r_i, v.p_i, v.r_j - cross(own, arm), v.p_j + own @ E(x.p_j) / 2)

    def Q(self, x: Pair, v: Pair, t: Any) -> Row:
        found: Any = super().Q(x, v, t)
        rates, _, F, turning = found
        s, arm = rotate(x.p_j, self.axis), rotate(x.p_j, self.s)
        moment = (E(x.p_j) @ turning / 2 - cross(arm, F)) @ s
        block = np.array([rates[0], rates[1], MASS * moment / self.spin_inertia])
        return block, None, F, turning - 2 * moment * (s @ E(x.p_j))

    def power(self, x: Pair, v: Pair, t: Any) -> Any:
        """The power on the carrier and on the spin."""
        found: Any = self.Q(x, v, t)
        block, _, F, turning = found
        return F @ v.r_j + turning @ v.p_j + self.spin_inertia / MASS * block[SPIN] * v.r_i[SPIN]
