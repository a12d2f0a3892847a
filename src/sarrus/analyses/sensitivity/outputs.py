"""Named outputs of a motion as traced numbers: what responses are functions of."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ...algebra import Array
from ...elements import TSDA, Dot1, Dot2, Heading, NonlinearTSDA, Normalization
from ...elements.evaluation import element_from, partition
from ...elements.operators import OPERATORS
from ...euler import A, B, E
from ...model import SarrusError
from ...model.coordinates import WIDTH
from ...model.show import suggest
from ...model.solid import GROUND
from ...model.tape import Tape, Traced
from ...system import System
from ...system.local import GROUND as STILL
from ...system.population import Population

AXES = {"x": 0, "y": 1, "z": 2}
SPRINGS = (TSDA, NonlinearTSDA)
TURN = 2 * np.pi
Key = tuple[str, int]
Variable = Callable[[str, float], Traced]


class UnknownOutput(SarrusError):
    """An output that the system does not have."""


class States(NamedTuple):
    """States at some times (nt,), (nt, nq), (nt, m)."""

    t: Array
    q: Array
    v: Array
    a: Array
    lam: Array


class Angles:
    """The joints' coordinates with all their turns.

    Parameters
    ----------
    system : System
    nodes : states so near to each other that turns can be counted
    first : gives the coordinates at the first of them; by default they have less than a turn there
    """

    def __init__(self, system: System, nodes: States, first: Callable[[], Array] | None = None) -> None:
        self._of, self._nodes, self._first = system.joint_coordinates, nodes, first

    @cached_property
    def values(self) -> Array:
        """At the nodes (nt, number of coordinates)."""
        values, _ = self._of.along(self._nodes.t, self._nodes.q, self._nodes.v)
        whole = 0.0 if self._first is None else np.round((self._first() - values[0]) / TURN)
        return np.asarray(values + TURN * whole)

    def near(self, name: str, t: Array) -> Array:
        """A coordinate at times between the nodes, to less than half a turn."""
        return np.interp(t, self._nodes.t, self.values[:, self._of.index(name)])


class Outputs:
    """Everything about a motion that a response may use; each number stands for its values at all times.

    ``o("slider.x")`` reads an output by its name; the methods give vectors as arrays of three.

    Attributes
    ----------
    t : the time [s]
    """

    def __init__(
        self,
        system: System,
        states: States,
        b: Array,
        parameters: Callable[[str, Variable], Any],
        angles: Angles | None = None,
    ) -> None:
        self.tape = Tape()
        self.inputs: dict[Key, Traced] = {}
        self.named: dict[str, Traced] = {}
        self._system, self._states, self._b, self._parameters = system, states, b, parameters
        self._angles = angles or Angles(system, states)
        self.t = self.tape.variable(states.t)

    def __call__(self, name: str) -> Any:
        """An output by name.

        ``slider.x``, ``slider.e0``; ``slider.velocity.x``, ``slider.acceleration.x``, ``slider.angular_velocity.x``;
        ``pin.angle``, ``pin.angle.rate``; ``pin.force.x``, ``pin.torque.x``, ``pin.multiplier.1``; ``spring.length``,
        ``spring.rate``, ``spring.tension``; ``energy.kinetic``; ``t``.

        Raises
        ------
        UnknownOutput
            If there is no such output.
        """
        if name == "t":
            return self.t
        part, _, rest = name.partition(".")
        word, _, axis = rest.partition(".")
        if name == "energy.kinetic":
            return self.kinetic_energy()
        if f"{part}.{word}" in self._system.joint_coordinates.names and axis in ("", "rate"):
            return self.joint(f"{part}.{word}", rate=axis == "rate")
        if part in self._system.bodies:
            return self._of_body(name, part, word, axis)
        if part in self._system.rows and word in ("force", "torque", "multiplier"):
            return self._of_joint(name, part, word, axis)
        if word in ("length", "rate", "tension") and self._spring(part):
            return getattr(self, {"rate": "stretching"}.get(word, word))(part)
        raise self._unknown(name)

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
        return self._vector("q", body)[own.index(word)]

    def _of_joint(self, name: str, joint: str, word: str, axis: str) -> Any:
        if word == "multiplier" and axis.isdigit() and 0 < int(axis) <= len(self._system.rows[joint]):
            return self.multiplier(joint)[int(axis) - 1]
        if word == "multiplier" or axis not in AXES:
            raise self._unknown(name)
        return (self.force if word == "force" else self.torque)(joint)[AXES[axis]]

    def _unknown(self, name: str) -> UnknownOutput:
        system = self._system
        springs = [owner for p in system.populations if p.kind in SPRINGS for owner in p.owners]
        known = [
            *(f"{b}.{w}" for b in system.bodies for w in ("x", "y", "z", "velocity.x", "acceleration.x")),
            *(f"{n}{w}" for n in system.joint_coordinates.names for w in ("", ".rate")),
            *(f"{j}.{w}" for j in system.rows for w in ("force.x", "torque.x", "multiplier.1")),
            *(f"{s}.{w}" for s in springs for w in ("length", "rate", "tension")),
            "energy.kinetic",
        ]
        return UnknownOutput(f"{system.name} has no output {name!r}; {suggest(name, known)}")

    def constant(self, value: Any) -> Traced:
        """A number, or one for each time, that depends on nothing."""
        return self.tape.add("constant", (), value)

    def parameter(self, name: str) -> Any:
        """A number of the model by name, for responses that depend on it themselves."""
        if name in self._system.number_names:
            return self._input("b", self._system.number_names.index(name))
        return self._parameters(name, self._variable)

    def _variable(self, name: str, value: float) -> Traced:
        """A number that derivatives are taken by."""
        if name not in self.named:
            self.named[name] = self.tape.variable(value)
        return self.named[name]

    def position(self, body: str, point: Sequence[Any] = (0, 0, 0)) -> Array:
        """Global position of a point given in body axes (3,). [m]"""
        q = self._vector("q", body)
        return np.asarray(q[:3] + A(q[3:]) @ np.asarray(point))

    def velocity(self, body: str, point: Sequence[Any] = (0, 0, 0)) -> Array:
        """Its velocity (3,). [m/s]"""
        q, v = self._vector("q", body), self._vector("v", body)
        return np.asarray(v[:3] + B(q[3:], np.asarray(point)) @ v[3:])

    def acceleration(self, body: str, point: Sequence[Any] = (0, 0, 0)) -> Array:
        """Its acceleration (3,). [m/s²]"""
        q, v, a = (self._vector(kind, body) for kind in ("q", "v", "a"))
        s = np.asarray(point)
        return np.asarray(a[:3] + B(q[3:], s) @ a[3:] + B(v[3:], s) @ v[3:])  # B is linear in p

    def angular_velocity(self, body: str) -> Array:
        """Angular velocity in global axes, 2 E(p) ṗ (3,). [rad/s]"""
        return np.asarray(2 * (E(self._vector("q", body)[3:]) @ self._vector("v", body)[3:]))

    def joint(self, name: str, *, rate: bool = False) -> Any:
        """An angle with all turns or travel of a joint, ``pin.angle``, or its rate. [rad], [m], [1/s]"""
        every = self._system.joint_coordinates
        population, k = _element_at(every.populations, every.index(name))
        element, x = self._element(population, k, "c"), self._local(population, k, "q")
        if rate:
            found = element.Phi_q_xi(x, self._local(population, k, "v"))[0]
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
        return np.array([self._input("lam", int(row)) for row in self._system.rows[joint]], dtype=object)

    def force(self, joint: str) -> Array:
        """Force of a joint on its body j, in global axes (3,), as `System.reaction` gives it. [N]"""
        return self._wrench(joint)[0]

    def torque(self, joint: str) -> Array:
        """Torque of a joint on its body j about the joint's point there, in global axes (3,). [N m]"""
        return self._wrench(joint)[1]

    def _wrench(self, joint: str) -> tuple[Array, Array]:
        marker = self._system.marker(joint)
        sign, body = (1, marker.body_j) if marker.body_j != GROUND else (-1, marker.body_i)
        members = [(p, k) for p in self._system.populations if p.kind.rows for k in _of(p, joint)]
        total = np.sum([self._pull(p, k, body) for p, k in members], axis=0)
        q = self._vector("q", body)
        arm = A(self._vector("q", marker.body_j)[3:]) @ self._joint_point(joint, marker.s_j)
        point = self._vector("q", marker.body_j)[:3] + arm
        force = -1 * total[:3]
        torque = -0.5 * (E(q[3:]) @ total[3:]) - np.cross(point - q[:3], force)
        return sign * force, sign * torque

    def _pull(self, p: Population, k: int, body: str) -> Array:
        """Φ_qᵀλ of one element on one body (7,)."""
        rows = range(int(p.rows[k]), int(p.rows[k]) + p.kind.rows)
        lam = np.array([self._input("lam", row) for row in rows], dtype=object)
        blocks = self._element(p, k, "b").Phi_qT_lam(self._local(p, k, "q"), lam)
        total = np.array([0.0] * WIDTH, dtype=object)
        for n, first in enumerate(_bodies(p, k)):
            if first == self._system.coordinates_of(body).start:
                for at, block in ((0, blocks[2 * n]), (3, blocks[2 * n + 1])):
                    if block is not None:
                        total[at : at + len(block)] = total[at : at + len(block)] + block
        return total

    def _joint_point(self, joint: str, otherwise: Array) -> Array:
        """The joint's point on body j, as the numbers of an element that has it."""
        for p in self._system.populations:
            if p.kind.rows and "s_j" in p.kind.fields and p.kind is not Normalization:
                for k in _of(p, joint):
                    return np.asarray(self._element(p, k, "b").s_j)
        return otherwise

    def length(self, spring: str) -> Any:
        """Length of a TSDA. [m]"""
        return self._stretch(spring)[0]

    def stretching(self, spring: str) -> Any:
        """Its rate. [m/s]"""
        return self._stretch(spring)[1]

    def tension(self, spring: str) -> Any:
        """Its force, tension positive. [N]"""
        p, k = self._spring(spring)[0]
        if p.kind is NonlinearTSDA:
            raise UnknownOutput(
                f"the tension of {spring!r}, whose laws are curves, is no output; use its length"
            )
        return self._element(p, k, "b").law(*self._stretch(spring), 0.0).f

    def _stretch(self, spring: str) -> tuple[Any, Any]:
        p, k = self._spring(spring)[0]
        element: Any = self._element(p, k, "b")
        x, v = self._local(p, k, "q"), self._local(p, k, "v")
        d, rate = element.d(x), element.d_xi(x, v)
        length = np.sqrt(d @ d)
        return length, (d @ rate) / length

    def _spring(self, name: str) -> list[tuple[Population, int]]:
        return [(p, k) for p in self._system.populations if p.kind in SPRINGS for k in _of(p, name)]

    def kinetic_energy(self) -> Any:
        """½ vᵀ M v. [J]"""
        inertias = [p for p in self._system.populations if OPERATORS["M_a"] in p.kind.family]
        return 0.5 * sum(self._twice_kinetic(p, k) for p in inertias for k in range(p.count))

    def _twice_kinetic(self, p: Population, k: int) -> Any:
        v = self._local(p, k, "v")
        momentum = self._element(p, k, "b").M_a(self._local(p, k, "q"), v)
        return sum(part @ block for part, block in zip(v, momentum, strict=True) if block is not None)

    def _element(self, p: Population, k: int, numbers: str) -> Any:
        """An element of recorded numbers, of the equations ("b") or of the joints' coordinates ("c")."""
        at, size = p.at + k * p.kind.size(), p.kind.size()
        own = np.array([self._input(numbers, n) for n in range(at, at + size)], dtype=object)
        return element_from(p.kind, own, self._b, self.t)

    def _local(self, p: Population, k: int, kind: str) -> Any:
        """Coordinates, or velocities, of an element's bodies."""
        still = STILL if kind == "q" else np.zeros(WIDTH)
        parts = [
            still if first < 0 else [self._input(kind, n) for n in range(first, first + WIDTH)]
            for first in _bodies(p, k)
        ]
        return partition(p.kind, np.array([x for part in parts for x in part], dtype=object))

    def _vector(self, kind: str, body: str) -> Array:
        if body == GROUND:
            return STILL if kind == "q" else np.zeros(WIDTH)
        at = self._system.coordinates_of(body).start
        return np.array([self._input(kind, n) for n in range(at, at + WIDTH)], dtype=object)

    def _input(self, kind: str, n: int) -> Traced:
        """One coordinate over time, or one number."""
        if (kind, n) not in self.inputs:
            self.inputs[kind, n] = self.tape.variable(self._value(kind, n))
        return self.inputs[kind, n]

    def _value(self, kind: str, n: int) -> Any:
        if kind == "b":
            return float(self._b[n])
        if kind == "c":
            return float(self._system.joint_coordinates.b[n])
        return getattr(self._states, kind)[:, n]


def _projection(element: Any, axis: Any) -> Any:
    """What an angle's direction has along an axis: a vector of body j, or the line between two points."""
    return Dot2(axis, element.s_i, element.s_j) if isinstance(element, Heading) else Dot1(axis, element.f_j)


def _of(p: Population, owner: str) -> list[int]:
    return [k for k, name in enumerate(p.owners) if name == owner]


def _bodies(p: Population, k: int) -> list[int]:
    """First coordinate of each body of element k, negative for ground."""
    return [-WIDTH if slot < 0 else int(p.bodies[k, slot]) for slot in p.variant.slots]


def _element_at(populations: Sequence[Population], row: int) -> tuple[Population, int]:
    return next((p, k) for p in populations for k in range(p.count) if p.rows[k] == row)
