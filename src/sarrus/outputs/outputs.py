"""Named outputs of a motion as traced numbers: what responses are functions of."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import tau
from typing import Any, TypeAlias

import numpy as np

from ..algebra import Array, cross
from ..elements import Dot1, Dot2, Force, Heading, Normalization
from ..elements.element import Pair
from ..euler import A, B, E, G
from ..model.coordinates import POSITION, WIDTH
from ..model.geometry.points import GROUND, NEXT
from ..model.signals import RelativeMotion
from ..model.tape import Tracer, own
from ..system.structure.population import Population, firsts
from .energy import EnergyRecording
from .output import UnknownOutput, find_output
from .recording import members_of

End: TypeAlias = tuple[str, Sequence[float]]  # a body, and a point of it


class Outputs(EnergyRecording):
    """Quantities of a motion for functions used as responses or outputs, each over all times.

    ``o("slider.x")``, or ``o["slider.x"]``, reads an output by its name; the methods give vectors as arrays of three.

    Attributes
    ----------
    t : the time [s]
    """

    def __call__(self, name: str) -> Any:
        """An output by name, one of those that `outputs_of` lists, or by a formula of them and of parameters.

        Raises
        ------
        UnknownOutput
            If there is no such output.
        """
        return find_output(self.system, name).record(self)

    __getitem__ = __call__
    __iter__ = None

    def __getattr__(self, name: str) -> Any:
        """Refuse a name that is no method."""
        raise AttributeError(f"Outputs has no method {name!r}. Read outputs by name, as in o('slider.x').")

    def own(
        self,
        value: Callable[..., Any],
        slopes: Callable[..., Sequence[Any]],
        *args: Any,
        bends: Callable[..., Sequence[Sequence[Any]]] | None = None,
    ) -> Tracer:
        """The value of a function with given derivatives, if it cannot be recorded, such as an external program.

        Parameters
        ----------
        value : of arrays over time (nt,) that stand for the arguments, or of plain numbers
        slopes : of the same, its derivatives by each of them
        args : outputs, the time, parameters
        bends : its second derivatives, a row for each argument; for Hessians only
        """
        return own(self.tape, value, slopes, bends, args)

    def parameter(self, name: str) -> Any:
        """A parameter of the model by name, for responses that depend on it directly."""
        if name in self.system.parameter_names:
            return self.input("b", self.system.parameter_names.index(name))
        return self._parameters(name, self._variable)

    def _variable(self, name: str, value: float) -> Tracer:
        """A number that derivatives are taken by."""
        if name not in self.named:
            self.named[name] = self.tape.variable(value)
        return self.named[name]

    def position(self, body: str, point: Sequence[Any] | Array = (0, 0, 0)) -> Array:
        """Global position of a point given in body axes (3,). [m]"""
        q = self.vector("q", body)
        return np.asarray(q[:3] + A(q[3:]) @ np.asarray(point))

    def velocity(self, body: str, point: Sequence[Any] = (0, 0, 0)) -> Array:
        """The velocity of a point (3,). [m/s]"""
        q, v = self.vector("q", body), self.vector("v", body)
        return np.asarray(v[:3] + B(q[3:], np.asarray(point)) @ v[3:])

    def in_body_axes(self, word: str, body: str, point: Sequence[Any]) -> Array:
        """A vector of a point, "velocity" or "acceleration", in body axes (3,)."""
        return np.asarray(getattr(self, word)(body, point) @ A(self.vector("q", body)[3:]))

    def relative(self, word: str, i: End, j: End) -> Any:
        """What a method of `RelativeMotion` returns for two points, each with its body; also the acceleration."""
        if word == "acceleration":  # the second derivative of the position that is seen
            w, alpha = self.angular_velocity_body(j[0]), self.angular_acceleration_body(j[0])
            d, d_dot = (self.relative(known, i, j) for known in ("position", "velocity"))
            seen = (self.acceleration(*i) - self.acceleration(*j)) @ A(self.vector("q", j[0])[3:])
            return seen - cross(alpha, d) - cross(w, cross(w, d)) - 2 * cross(w, d_dot)
        parts = [[x for body, _ in (i, j) for x in np.split(self.vector(kind, body), [3])] for kind in "qv"]
        method = getattr(RelativeMotion(np.asarray(i[1]), np.asarray(j[1])), word)
        return method(*(Pair(*x) for x in parts[: method.__code__.co_argcount - 1]))

    def acceleration(self, body: str, point: Sequence[Any] = (0, 0, 0)) -> Array:
        """The acceleration of a point (3,). [m/s²]"""
        q, v, a = (self.vector(kind, body) for kind in ("q", "v", "a"))
        s = np.asarray(point)
        return np.asarray(a[:3] + B(q[3:], s) @ a[3:] + B(v[3:], s) @ v[3:])  # B is linear in p

    def angular_velocity(self, body: str) -> Array:
        """Angular velocity in global axes, 2 E(p) ṗ (3,). [rad/s]"""
        return np.asarray(2 * (E(self.vector("q", body)[3:]) @ self.vector("v", body)[3:]))

    def angular_velocity_body(self, body: str) -> Array:
        """Angular velocity in body axes, 2 G(p) ṗ (3,). [rad/s]"""
        return np.asarray(2 * (G(self.vector("q", body)[3:]) @ self.vector("v", body)[3:]))

    def angular_acceleration(self, body: str) -> Array:
        """Angular acceleration in global axes, 2 E(p) p̈ (3,). [rad/s²]"""
        return np.asarray(2 * (E(self.vector("q", body)[3:]) @ self.vector("a", body)[3:]))

    def angular_acceleration_body(self, body: str) -> Array:
        """Angular acceleration in body axes, 2 G(p) p̈ (3,). [rad/s²]"""
        return np.asarray(2 * (G(self.vector("q", body)[3:]) @ self.vector("a", body)[3:]))

    def turn(self, body: str, axis: str) -> Any:
        """The angle of a body about a global axis, see `model.function.Turn`; revolutions count. [rad]"""
        found = self.angle((body, ()), (GROUND, ()), axis + "".join(reversed(NEXT[axis])), 0)
        return self._with_revolutions(found, self._angles.near(f"{body}.rotation_{axis}", self.states.t))

    def angle(self, i: End, j: End, sequence: str, n: int) -> Any:
        """Angle n of the rotations about three successive axes of body i that lead from the axes of body j to its own.

        The first and the last are between -π and π: revolutions do not count, as those of `turn` and `joint` do. They
        jump where the second one is ±π/2, or 0 or π if the first axis is also the last. [rad]
        """
        return np.arctan2(
            *_sides(A(self.vector("q", j[0])[3:]).T @ A(self.vector("q", i[0])[3:]), sequence, n)
        )

    def _with_revolutions(self, angle: Any, near: Array) -> Any:
        """An angle with the revolutions that bring it near to known values."""
        return angle + self.constant(tau * np.round((near - angle.value) / tau))

    def joint(self, name: str, *, rate: bool = False) -> Any:
        """An angle or displacement of a joint, ``pin.angle``, or its rate; revolutions count. [rad], [m], [1/s]"""
        every = self.system.joint_coordinates
        population, k = _element_at(every.populations, every.index(name))
        element, x = self.element(population, k, "c"), self.local(population, k, "q")
        if rate:
            found = element.Phi_q_xi(x, self.local(population, k, "v"))[0]
        elif not every.angles[every.index(name)]:
            found = element.Phi(x)[0]
        else:
            c, s = (_projection(element, axis).Phi(x)[0] for axis in (element.f_i, element.g_i))
            found = self._with_revolutions(
                np.arctan2(s, c) - element.angle, self._angles.near(name, self.states.t)
            )
        return found

    def joint_acceleration(self, name: str) -> Any:
        """The second derivative of an angle or displacement of a joint. [rad/s²], [m/s²]"""
        every = self.system.joint_coordinates
        population, k = _element_at(every.populations, every.index(name))
        element, x = self.element(population, k, "c"), self.local(population, k, "q")
        v, a = (self.local(population, k, kind) for kind in ("v", "a"))
        return element.Phi_q_xi(x, a)[0] - element.gamma(x, v)[0]

    def driving_power(self, driver: str) -> Any:
        """The power that a driver, or a joint with a prescribed motion, supplies: -λᵀΦ_q v. [W]"""
        found: Any = self.constant(0.0)
        for p in self.system.populations:
            for k in members_of(p, driver) if p.kind.rows else ():
                v = self.local(p, k, "v", states=False)  # only bodies are driven
                moved = self.element(p, k, "b").Phi_q_xi(self.local(p, k, "q"), v)
                found = found - sum(self.input("lam", int(p.rows[k]) + n) * x for n, x in enumerate(moved))
        return found

    def elastic_energy(self) -> Any:
        """The energy stored in forces without a `potential`, such as contacts, stops and tyres. [J]"""
        forces = [
            p
            for p in self.system.populations
            if issubclass(p.kind, Force) and not hasattr(p.kind, "potential")
        ]
        every = [(p, k) for p in forces for k in range(p.count)]
        return sum((self.scalars(p, k, "stored_energy", 3)[0] for p, k in every), self.constant(0.0))

    def accumulated(self, rate: str) -> Any:
        """The integral of a power since the start; of a whole run only.

        Raises
        ------
        UnknownOutput
            Where single states are known.
        """
        raise UnknownOutput(
            f"{self.system.name}: the integral of {rate} since the start is known of a whole run only. "
            f"Use Final(...) of it alone, or Integral({rate!r})."
        )

    def multiplier(self, joint: str) -> Array:
        """Multipliers of a joint's or driver's equations."""
        return np.array([self.input("lam", int(row)) for row in self.system.rows[joint]], dtype=object)

    def force(self, joint: str, side: str = "", body_axes: bool = False) -> Array:
        """Force of a joint on its body j, or i, in global axes or in those of the body (3,). [N]

        On body j in global axes it is that of `System.reaction`.
        """
        return self._in_axes(joint, side, body_axes, self._wrench(joint, side)[0])

    def torque(self, joint: str, side: str = "", body_axes: bool = False) -> Array:
        """Torque of a joint on its body j, or i, about the joint's point there (3,). [N m]"""
        return self._in_axes(joint, side, body_axes, self._wrench(joint, side)[1])

    def force_on(self, part: str, body: str) -> Array:
        """Force of a joint, coupling or driver on any body, in global axes (3,). [N]"""
        return self._action(part, body)[0]

    def torque_on(self, part: str, body: str) -> Array:
        """Torque of a joint, coupling or driver on any body, about the body's origin, in global axes (3,). [N m]"""
        return self._action(part, body)[1]

    def _in_axes(self, joint: str, side: str, body_axes: bool, vector: Array) -> Array:
        marker = self.system.marker(joint)
        body = marker.body_i if side else marker.body_j
        return np.asarray(vector @ A(self.vector("q", body)[3:]) if body_axes else vector)

    def point_of_joint(self, joint: str, side: str) -> Array:
        """The joint's point on body i or j, in global axes (3,). [m]"""
        marker = self.system.marker(joint)
        body, s = (marker.body_i, marker.s_i) if side == "i" else (marker.body_j, marker.s_j)
        q = self.vector("q", body)
        return np.asarray(q[:3] + A(q[3:]) @ self._joint_point(marker.joint, f"s_{side}", s))

    def _wrench(self, joint: str, side: str = "") -> tuple[Array, Array]:
        """Force of a joint on its body j, or i, and torque about its point there."""
        marker = self.system.marker(joint)
        body, other = (marker.body_i, marker.body_j) if side else (marker.body_j, marker.body_i)
        point = self.point_of_joint(joint, "i" if side else "j")
        if body == GROUND and not marker.coupled:  # the ground has no coordinates; forces are in equilibrium
            force, torque = (-1 * x for x in self._action(joint, other))
            return force, torque - cross(point - self.vector("q", other)[:3], force)
        force, torque = self._action(joint, body)
        return force, torque - cross(point - self.vector("q", body)[:3], force)

    def _action(self, part: str, body: str) -> tuple[Array, Array]:
        """Force and torque about the origin of a body of all that a joint, coupling or driver does to it."""
        return self.shared(("action", part, body), lambda: self._recorded_action(part, body))

    def _recorded_action(self, part: str, body: str) -> tuple[Array, Array]:
        first = -1 if body == GROUND else self.system.coordinates_of(body).start
        members = [(p, k) for p in self.system.populations if p.kind.rows for k in members_of(p, part)]
        total = np.sum([self._pull(p, k, first) for p, k in members], axis=0)
        return -1 * total[:3], -0.5 * (E(self.vector("q", body)[3:]) @ total[3:])

    def _pull(self, p: Population, k: int, body: int) -> Array:
        """Φ_qᵀλ of one element on one body (7,), given by its first coordinate."""
        rows = range(int(p.rows[k]), int(p.rows[k]) + p.kind.rows)
        lam = np.array([self.input("lam", row) for row in rows], dtype=object)
        blocks = self._blocks(p, k, lam)
        total = np.array([0.0 for _ in range(WIDTH)], dtype=object)
        for first, on_it in zip(firsts(p, k), p.kind.by_owner(blocks), strict=True):
            if first == body:
                for at, block in zip((0, POSITION), on_it, strict=True):
                    if block is not None:
                        total[at : at + len(block)] = total[at : at + len(block)] + block
        return total

    def _blocks(self, p: Population, k: int, lam: Array) -> Any:
        """Φ_qᵀλ of one element; angles in formulas have revolutions, which recorded kernels alone can count."""
        if not hasattr(p.kind, "gradient"):
            return self.element(p, k, "b").Phi_qT_lam(self.local(p, k, "q"), lam)
        flat = lam[0] * np.array(self.scalars(p, k, "gradient", 1), dtype=object)
        return np.split(flat, np.cumsum(p.kind.coordinates())[:-1])

    def _joint_point(self, joint: str, field: str, otherwise: Array) -> Array:
        """The joint's point on a body, as the numbers of an element that has it."""
        for p in self.system.populations:
            if p.kind.rows and field in p.kind.fields and p.kind is not Normalization:
                for k in members_of(p, joint):
                    return np.asarray(getattr(self.element(p, k, "b"), field))
        return otherwise


def _sides(R: Array, sequence: str, n: int) -> tuple[Any, Any]:
    """Sine and cosine, times the same number, of angle n of successive rotations about body axes that make R."""
    i, j, k = map("xyz".index, sequence)
    third = 3 - i - j
    sign = 1 if (j - i) % 3 == 1 else -1
    if k != i:
        sides = (
            (-sign * R[j, k], R[k, k]),
            (sign * R[i, k], np.hypot(R[i, i], R[i, j])),
            (-sign * R[i, j], R[i, i]),
        )
    else:
        sides = (
            (R[j, i], -sign * R[third, i]),
            (np.hypot(R[i, j], R[i, third]), R[i, i]),
            (R[i, j], sign * R[i, third]),
        )
    return sides[n]


def _projection(element: Any, axis: Any) -> Any:
    """Return the component of an angle's direction along an axis."""
    return Dot2(axis, element.s_i, element.s_j) if isinstance(element, Heading) else Dot1(axis, element.f_j)


def _element_at(populations: Sequence[Population], row: int) -> tuple[Population, int]:
    return next((p, k) for p in populations for k in range(p.count) if p.rows[k] == row)
