"""A rotor on a carrier: its spin about an axis of the carrier is a state, and it is no body.

With the unit spin axis s, which is fixed in the carrier, and the angular velocity ω of the carrier, the state is the
absolute spin W about the axis. The rotor is symmetric about s, with the moments of inertia J about s and J_t across,
and turns with the carrier across s, so that its angular momentum about its centre is

    L = J_t (ω - (ω·s) s) + J W s

The first term is that of a rigid body with the inertia J_t (I - s sᵀ), which is part of the inertia of the carrier, as
is the mass. With ṡ = ω × s, the second one changes by

    d(J W s)/dt = J Ẇ s + J W ω × s

Along s the carrier has no torque on the rotor but those of brakes and motors. So, for the moment M on the rotor,

    J Ẇ = M·s,    torque on the carrier = M - (M·s) s - J W ω × s

without accelerations of the carrier. The last torque is the gyroscopic one; it has no power, as it is normal to ω.
The kinetic energy of the second term is J W²/2. The rate relative to the carrier is W - ω·s.
"""

from __future__ import annotations

from typing import Any

from ....algebra import Array, Row, cross
from ....euler import E, rotate
from ...element import Force, Pair, Scalar, Vec3
from ...force_outputs import Passive
from ...output import output

SPIN = 2  # slot of W in the block of the states


class Rotor(Passive, Force, bodies=2, derivatives="automatic", rare=True, registered=False):
    """The gyroscopic torque and the energy of a rotor. Bodies are the block of the states, and the carrier."""

    spin_inertia: Scalar  # [kg m²] J
    axis: Vec3  # [-] s in the carrier

    def Q(self, x: Pair, v: Pair, t: Any) -> Row:
        omega, s = 2 * (E(x.p_j) @ v.p_j), rotate(x.p_j, self.axis)
        torque = -self.spin_inertia * v.r_i[SPIN] * cross(omega, s)
        return None, None, None, self.generalized(torque, x)

    @staticmethod
    def generalized(torque: Array, x: Pair) -> Array:
        """Q of a torque on the carrier: 2 Eᵀ torque."""
        return 2 * (torque @ E(x.p_j))

    def stored_energy(self, x: Pair, v: Pair, t: Any) -> Any:
        """The energy of the spin."""
        return self.spin_energy(x, v)

    @output("J")
    def spin_energy(self, x: Pair, v: Pair) -> Any:
        """J W²/2."""
        return self.spin_inertia * v.r_i[SPIN] * v.r_i[SPIN] / 2

    @output("rad/s")
    def rate(self, x: Pair, v: Pair) -> Any:
        """W - ω·s, relative to the carrier."""
        return v.r_i[SPIN] - 2 * (E(x.p_j) @ v.p_j) @ rotate(x.p_j, self.axis)


# Others are those of the tyre
Rotor.outputs = {word: Rotor.outputs[word] for word in ("rate", "spin_energy")}
