"""How fast a joint turns or slides, as a linear function of the velocities: rate = C(q) v."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..algebra import Array
from ..elements import OPERATORS, Dot1, Dot2
from ..elements.evaluation import dense
from ..model.frame import LocalFrame
from ..model.joints import Cylindrical, Revolute, Translational
from ..model.pose import GROUND_POSE
from ..model.solid import GROUND
from ..system import System
from ..system.local import GROUND as AT_REST
from .held import place_of, unknown

Feature = Dot1 | Dot2


@dataclass(frozen=True)
class CoordinateRate:
    """The rate of one coordinate."""

    place: int
    size: int

    def row(self, q: Array) -> Array:
        """C(q) (nq,)."""
        return np.asarray(np.eye(1, self.size, self.place)[0])

    def row_xi_q(self, q: Array, xi: Array) -> Array:
        """(C ξ)_q (nq,): zero."""
        return np.zeros(self.size)

    def row_q(self, q: Array) -> Array:
        """(Cᵀ)_q (nq, nq): zero."""
        return np.zeros((self.size, self.size))


@dataclass(frozen=True)
class JointRate:
    """The rate of a joint's angle about h_i [rad/s], or of its displacement along h_i [m/s].

    The angle is Im log z with z = (f_i + √-1 g_i)·f_j, a complex DOT-1; the displacement h_i·d is a DOT-2.
    """

    system: System
    bodies: tuple[str, str]
    feature: Any
    turns: bool

    def row(self, q: Array) -> Array:
        """C(q) (nq,): Im(z_q / z), or (h_i·d)_q."""
        z_q = self._get("Phi_q", q)
        return self._spread(np.imag(z_q / self._get("Phi", q)[0]) if self.turns else np.real(z_q))

    def row_xi_q(self, q: Array, xi: Array) -> Array:
        """(C ξ)_q (nq,), symmetric in ξ and what it is multiplied by: Im[(z_q ξ)_q / z - (z_q ξ) z_q / z²]."""
        second = self._get("Phi_q_xi_q", q, xi=xi)
        if not self.turns:
            return self._spread(np.real(second))
        z, z_q = self._get("Phi", q)[0], self._get("Phi_q", q)
        return self._spread(np.imag(second / z - (z_q @ self._local(xi, np.zeros(7))) * z_q / z**2))

    def row_q(self, q: Array) -> Array:
        """(Cᵀ)_q (nq, nq), symmetric."""
        found = np.zeros((self.system.nq, self.system.nq))
        for body in (b for b in self.bodies if b != GROUND):
            for n in range(*self.system.coordinates_of(body).indices(self.system.nq)):
                found[n] = self.row_xi_q(q, np.eye(1, self.system.nq, n)[0])
        return found

    def _get(self, name: str, q: Array, **directions: Array) -> Array:
        operands = {n: self._local(x, np.zeros(7)) for n, x in directions.items()}
        value = dense(self.feature, OPERATORS[name], {"q": self._local(q, AT_REST), **operands})
        return np.asarray(value.astype(complex)).reshape(-1)

    def _local(self, x: Array, ground: Array) -> Array:
        return np.concatenate(
            [ground if b == GROUND else x[self.system.coordinates_of(b)] for b in self.bodies]
        )

    def _spread(self, local: Array) -> Array:
        row = np.zeros(self.system.nq)
        for n, body in enumerate(self.bodies):
            if body != GROUND:
                row[self.system.coordinates_of(body)] += local[7 * n : 7 * n + 7]
        return row


Rate = CoordinateRate | JointRate


def rate(system: System, name: str) -> Rate:
    """The rate of a coordinate (``slider.x``) or of a joint.

    A revolute joint has an angle, a translational joint a displacement; a cylindrical joint has ``name.angle`` and
    ``name.displacement``.

    Raises
    ------
    KeyError
        If there is no such coordinate or joint, or the joint has no such rate.
    """
    place = place_of(system, name)
    if place is not None:
        return CoordinateRate(place, system.nq)
    joint_name, _, what = name.partition(".")
    for joint in system.model.joints:
        if joint.name == joint_name:
            return _of_joint(system, joint, what, name)
    raise KeyError(unknown(system, name, "coordinate or joint"))


def _of_joint(system: System, joint: Any, what: str, name: str) -> JointRate:
    have = [kind for kind, types in _HAVE.items() if isinstance(joint, types)]
    if (what and what not in have) or (not what and len(have) != 1):
        offered = " or ".join(f"{joint.name}.{kind}" for kind in have) or "the rate of a coordinate"
        raise KeyError(f"the joint {joint.name!r} has no single rate {name!r}; give {offered}")
    poses = {GROUND: GROUND_POSE, **{body.name: body.pose() for body in system.model.bodies}}
    i, j = joint.frames(poses)
    turns = (what or have[0]) == "angle"
    return JointRate(system, (i.body, j.body), _feature(i, j, turns), turns)


_HAVE: dict[str, tuple[type, ...]] = {
    "angle": (Revolute, Cylindrical),
    "displacement": (Translational, Cylindrical),
}


def _feature(i: LocalFrame, j: LocalFrame, turns: bool) -> Feature:
    f, g, h, s_i, f_j, s_j = (np.array(x) for x in (i.f, i.g, i.h, i.s, j.f, j.s))
    return Dot1(f + 1j * g, f_j) if turns else Dot2(h, s_i, s_j)
