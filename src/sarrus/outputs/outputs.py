"""Named outputs of a motion as traced numbers: what responses are functions of."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from difflib import get_close_matches
from typing import Any

import numpy as np

from ..algebra import Array
from ..elements import Dot1, Dot2, Heading, Normalization
from ..euler import A, B, E
from ..model.coordinates import WIDTH
from ..model.marker import Marker
from ..model.show import suggest
from ..model.solid import GROUND
from ..model.tape import Traced, own
from ..system.population import Population
from .force_outputs import COILS, SPRINGS, WORDS, ForceOutputs
from .recording import TURN, UnknownOutput, bodies_of, members_of

AXES = {"x": 0, "y": 1, "z": 2}
ENERGIES = ("energy.kinetic", "energy.potential", "energy.total")


class Outputs(ForceOutputs):
    """Everything about a motion that a response may use; each number stands for its values at all times.

    ``o("slider.x")`` reads an output by its name; the methods give vectors as arrays of three.

    Attributes
    ----------
    t : the time [s]
    """

    def __call__(self, name: str) -> Any:
        """An output by name.

        ``slider.x``, ``slider.e0``; ``slider.velocity.x``, ``slider.acceleration.x``, ``slider.angular_velocity.x``;
        ``pin.angle``, ``pin.angle.rate``; ``pin.force.x``, ``pin.torque.x``, ``pin.multiplier.1``; ``spring.length``,
        ``spring.rate``, ``spring.tension``; ``coil.angle``, ``coil.rate``, ``coil.torque``; ``energy.kinetic``,
        ``energy.potential``, ``energy.total``; ``t``.

        Raises
        ------
        UnknownOutput
            If there is no such output.
        """
        if name == "t":
            return self.t
        part, _, rest = name.partition(".")
        word, _, axis = rest.partition(".")
        if name in ENERGIES:
            return self._energy(name)
        if f"{part}.{word}" in self.system.joint_coordinates.names and axis in ("", "rate"):
            return self.joint(f"{part}.{word}", rate=axis == "rate")
        if part in self.system.bodies:
            return self._of_body(name, part, word, axis)
        if part in self.system.rows and word in ("force", "torque", "multiplier"):
            return self._of_joint(name, part, word, axis)
        if word in WORDS[SPRINGS] and not axis and self.has(part, SPRINGS):
            return getattr(self, {"rate": "stretching"}.get(word, word))(part)
        if word in WORDS[COILS] and not axis and self.has(part, COILS):
            return self.coil(part, word)
        raise self._unknown(name)

    def _energy(self, name: str) -> Any:
        if name == "energy.total":
            return self.kinetic_energy() + self.potential_energy()
        return self.kinetic_energy() if name == "energy.kinetic" else self.potential_energy()

    def _of_body(self, name: str, body: str, word: str, axis: str) -> Any:
        vectors = {
            "velocity": self.velocity,
            "acceleration": self.acceleration,
            "angular_velocity": self.angular_velocity,
        }
        if word in vectors and axis in AXES:
            return vectors[word](body)[AXES[axis]]
        own = ("x", "y", "z", "e0", "e1", "e2", "e3")
        if word not in own or axis:
            raise self._unknown(name)
        return self.vector("q", body)[own.index(word)]

    def _of_joint(self, name: str, joint: str, word: str, axis: str) -> Any:
        if word == "multiplier" and axis.isdigit() and 0 < int(axis) <= len(self.system.rows[joint]):
            return self.multiplier(joint)[int(axis) - 1]
        if word == "multiplier" or axis not in AXES:
            raise self._unknown(name)
        return (self.force if word == "force" else self.torque)(joint)[AXES[axis]]

    def _unknown(self, name: str) -> UnknownOutput:
        system = self.system
        known = [
            *(f"{b}.{w}" for b in system.bodies for w in ("x", "y", "z", "velocity.x", "acceleration.x")),
            *(f"{n}{w}" for n in system.joint_coordinates.names for w in ("", ".rate")),
            *(f"{j}.{w}" for j in system.rows for w in ("force.x", "torque.x", "multiplier.1")),
            *(f"{o}.{w}" for kinds, words in WORDS.items() for o in self._owners(kinds) for w in words),
            *ENERGIES,
        ]
        part, _, word = name.partition(".")
        words = [one.removeprefix(f"{part}.") for one in known if one.startswith(f"{part}.")]
        if not words:
            return UnknownOutput(f"{system.name} has no output {name!r}; {suggest(name, known)}")
        near = get_close_matches(word, words, n=1)
        offered = ", ".join(f"{part}.{one}" for one in words)
        told = f'did you mean "{part}.{near[0]}"?' if near else f"choose from {offered}"
        return UnknownOutput(f"{system.name} has no output {name!r}; {told}")

    def _owners(self, kinds: tuple[type, ...]) -> list[str]:
        return [owner for p in self.system.populations if p.kind in kinds for owner in p.owners]

    def own(
        self,
        value: Callable[..., Any],
        slopes: Callable[..., Sequence[Any]],
        *args: Any,
        bends: Callable[..., Sequence[Sequence[Any]]] | None = None,
    ) -> Traced:
        """A function whose derivatives are given, for one that cannot be recorded: a table, a foreign program.

        Parameters
        ----------
        value : of arrays over time (nt,) that stand for the arguments, or of plain numbers
        slopes : of the same, its derivatives by each of them
        args : outputs, the time, parameters
        bends : its second derivatives, a row for each argument; for Hessians only
        """
        return own(self.tape, value, slopes, bends, args)

    def parameter(self, name: str) -> Any:
        """A number of the model by name, for responses that depend on it themselves."""
        if name in self.system.number_names:
            return self.input("b", self.system.number_names.index(name))
        return self._parameters(name, self._variable)

    def _variable(self, name: str, value: float) -> Traced:
        """A number that derivatives are taken by."""
        if name not in self.named:
            self.named[name] = self.tape.variable(value)
        return self.named[name]

    def position(self, body: str, point: Sequence[Any] = (0, 0, 0)) -> Array:
        """Global position of a point given in body axes (3,). [m]"""
        q = self.vector("q", body)
        return np.asarray(q[:3] + A(q[3:]) @ np.asarray(point))

    def velocity(self, body: str, point: Sequence[Any] = (0, 0, 0)) -> Array:
        """Its velocity (3,). [m/s]"""
        q, v = self.vector("q", body), self.vector("v", body)
        return np.asarray(v[:3] + B(q[3:], np.asarray(point)) @ v[3:])

    def acceleration(self, body: str, point: Sequence[Any] = (0, 0, 0)) -> Array:
        """Its acceleration (3,). [m/s²]"""
        q, v, a = (self.vector(kind, body) for kind in ("q", "v", "a"))
        s = np.asarray(point)
        return np.asarray(a[:3] + B(q[3:], s) @ a[3:] + B(v[3:], s) @ v[3:])  # B is linear in p

    def angular_velocity(self, body: str) -> Array:
        """Angular velocity in global axes, 2 E(p) ṗ (3,). [rad/s]"""
        return np.asarray(2 * (E(self.vector("q", body)[3:]) @ self.vector("v", body)[3:]))

    def joint(self, name: str, *, rate: bool = False) -> Any:
        """An angle with all turns or travel of a joint, ``pin.angle``, or its rate. [rad], [m], [1/s]"""
        every = self.system.joint_coordinates
        population, k = _element_at(every.populations, every.index(name))
        element, x = self.element(population, k, "c"), self.local(population, k, "q")
        if rate:
            found = element.Phi_q_xi(x, self.local(population, k, "v"))[0]
        elif not every.angles[every.index(name)]:
            found = element.Phi(x)[0]
        else:
            c, s = (_projection(element, axis).Phi(x)[0] for axis in (element.f_i, element.g_i))
            found = np.arctan2(s, c) - element.angle
            turns = np.round((self._angles.near(name, self._states.t) - found.value) / TURN)
            found = found + self.constant(TURN * turns)
        return found

    def multiplier(self, joint: str) -> Array:
        """Multipliers of a joint's or driver's equations."""
        return np.array([self.input("lam", int(row)) for row in self.system.rows[joint]], dtype=object)

    def force(self, joint: str) -> Array:
        """Force of a joint on its body j, in global axes (3,), as `System.reaction` gives it. [N]"""
        return self._wrench(joint)[0]

    def torque(self, joint: str) -> Array:
        """Torque of a joint on its body j about the joint's point there, in global axes (3,). [N m]"""
        return self._wrench(joint)[1]

    def _wrench(self, joint: str) -> tuple[Array, Array]:
        marker = self.system.marker(joint)
        sign, body = (1, marker.body_j) if marker.body_j != GROUND else (-1, marker.body_i)
        members = [(p, k) for p in self.system.populations if p.kind.rows for k in members_of(p, joint)]
        total = np.sum([self._pull(p, k, body, marker) for p, k in members], axis=0)
        q = self.vector("q", body)
        arm = A(self.vector("q", marker.body_j)[3:]) @ self._joint_point(marker.joint, marker.s_j)
        point = self.vector("q", marker.body_j)[:3] + arm
        force = -1 * total[:3]
        torque = -0.5 * (E(q[3:]) @ total[3:]) - np.cross(point - q[:3], force)
        return sign * force, sign * torque

    def _pull(self, p: Population, k: int, body: str, marker: Marker) -> Array:
        """Φ_qᵀλ of one element on one body (7,), of a coupling through the joint of the marker alone."""
        rows = range(int(p.rows[k]), int(p.rows[k]) + p.kind.rows)
        lam = np.array([self.input("lam", row) for row in rows], dtype=object)
        blocks = self.element(p, k, "b").Phi_qT_lam(self.local(p, k, "q"), lam)
        total = np.array([0.0] * WIDTH, dtype=object)
        for n, first in enumerate(bodies_of(p, k)):
            if first == self.system.coordinates_of(body).start and marker.counts(n):
                for at, block in ((0, blocks[2 * n]), (3, blocks[2 * n + 1])):
                    if block is not None:
                        total[at : at + len(block)] = total[at : at + len(block)] + block
        return total

    def _joint_point(self, joint: str, otherwise: Array) -> Array:
        """The joint's point on body j, as the numbers of an element that has it."""
        for p in self.system.populations:
            if p.kind.rows and "s_j" in p.kind.fields and p.kind is not Normalization:
                for k in members_of(p, joint):
                    return np.asarray(self.element(p, k, "b").s_j)
        return otherwise


def _projection(element: Any, axis: Any) -> Any:
    """What an angle's direction has along an axis: a vector of body j, or the line between two points."""
    return Dot2(axis, element.s_i, element.s_j) if isinstance(element, Heading) else Dot1(axis, element.f_j)


def _element_at(populations: Sequence[Population], row: int) -> tuple[Population, int]:
    return next((p, k) for p in populations for k in range(p.count) if p.rows[k] == row)
