"""Outputs that a formula of a force may contain: coordinates of joints, motions of bodies, outputs of other forces."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple, Protocol

import numpy as np

from .. import elements
from ..algebra import Array, cross
from ..elements import Element
from ..elements.element import Pair, Single, Vec3
from ..elements.forces.tyres.contact import RollingTyre
from ..elements.forces.tyres.rotor import Rotor
from ..euler import A, B, E, G, rotate
from ..functions import sqrt
from .coordinate import Known, is_angle
from .errors import ModelError
from .geometry.points import GROUND, NEXT, UNIT
from .geometry.pose import Poses
from .laws.recorded import Recording
from .primitive import Primitive
from .show import quote, suggest

POINT = re.compile(r"(?P<body>[^().]+)(\((?P<place>[^()]*)\))?")
RELATIVE = re.compile(r"relative\[(?P<i>[^(),]+(?:\([^()]*\))?),(?P<j>[^(),]+(?:\([^()]*\))?)\]")
AXES = ("x", "y", "z")
EULER = ("e0", "e1", "e2", "e3")
ORIGIN = (0.0, 0.0, 0.0)


class MeasureClass(Protocol):
    """A class of functions of the coordinates of some bodies: of an element, or of motions of a point."""

    @property
    def fields(self) -> Mapping[str, str]:
        """The kinds of its fields by name."""

    def __call__(self, *values: Any, **named: Any) -> Any:
        """Return the functions for values of the fields."""


class Measure(NamedTuple):
    """Measure of a signal: a class with ``fields``, its bodies by name, its values."""

    kind: MeasureClass
    bodies: tuple[str, ...]
    values: tuple[Any, ...]

    @classmethod
    def of(cls, primitive: Primitive) -> Measure:
        """The element of a joint's coordinate or of a force."""
        return cls(primitive.element, primitive.bodies, primitive.values)


class Signal(NamedTuple):
    """A method of a measure, how many of x, v and t it takes, and which component of its result is meant."""

    measure: Measure
    method: str
    arguments: int
    component: int
    unit: str


@dataclass(frozen=True)
class PointMotion:
    """Motion of a point of one body, as functions of the body's coordinates and their rates."""

    fields: ClassVar[dict[str, str]] = {"s": "Vec3"}
    bodies: ClassVar[int] = 1

    s: Vec3  # [m] the point in the body

    def position(self, x: Single) -> Array:
        """Global position [m]."""
        return np.asarray(x.r + rotate(x.p, self.s))

    def velocity(self, x: Single, v: Single) -> Array:
        """Global velocity [m/s]. Eq. (36)."""
        return np.asarray(v.r + B(x.p, self.s) @ v.p)

    def velocity_body(self, x: Single, v: Single) -> Array:
        """The global velocity, in body axes [m/s]."""
        return np.asarray(self.velocity(x, v) @ A(x.p))

    def angular_velocity(self, x: Single, v: Single) -> Array:
        """2 E ṗ, in global axes [rad/s]."""
        return 2 * (E(x.p) @ v.p)

    def angular_velocity_body(self, x: Single, v: Single) -> Array:
        """2 G ṗ, in body axes [rad/s]."""
        return 2 * (G(x.p) @ v.p)

    def euler_parameters(self, x: Single) -> Array:
        """The four Euler parameters."""
        return x.p


@dataclass(frozen=True)
class RelativeMotion:
    """Motion of a point of body i, and of the axes of this body, as it is seen from a point of body j in its axes."""

    fields: ClassVar[dict[str, str]] = {"s_i": "Vec3", "s_j": "Vec3"}
    bodies: ClassVar[int] = 2

    s_i: Vec3  # [m] in the bodies
    s_j: Vec3

    def position(self, x: Pair) -> Array:
        """A_jᵀ d, of the distance d from the point of body j [m]."""
        return np.asarray((x.r_i + rotate(x.p_i, self.s_i) - x.r_j - rotate(x.p_j, self.s_j)) @ A(x.p_j))

    def distance(self, x: Pair) -> Array:
        """|d| [m]."""
        d = self.position(x)
        return np.array([sqrt(d @ d)])

    def velocity(self, x: Pair, v: Pair) -> Array:
        """The rate of the position [m/s]: A_jᵀ ḋ - ω′_j × A_jᵀ d."""
        d_dot = v.r_i + B(x.p_i, self.s_i) @ v.p_i - v.r_j - B(x.p_j, self.s_j) @ v.p_j
        return np.asarray(d_dot @ A(x.p_j) - cross(2 * (G(x.p_j) @ v.p_j), self.position(x)))

    def distance_rate(self, x: Pair, v: Pair) -> Array:
        """The rate of the distance [m/s]."""
        return np.asarray(self.position(x) @ self.velocity(x, v) / self.distance(x))

    def angular_velocity(self, x: Pair, v: Pair) -> Array:
        """A_jᵀ (ω_i - ω_j) [rad/s]."""
        return np.asarray(2 * ((E(x.p_i) @ v.p_i - E(x.p_j) @ v.p_j) @ A(x.p_j)))

    def axes(self, x: Pair) -> Array:
        """The matrix A_jᵀ A_i, column by column."""
        return np.ravel((A(x.p_j).T @ A(x.p_i)).T)


RELATIVE_WORDS: dict[str, tuple[str, int, int, str]] = {  # method, arguments, component, unit
    **{axis: ("position", 1, n, "m") for n, axis in enumerate(AXES)},
    **{
        f"axis_{one}.{axis}": ("axes", 1, 3 * k + n, "1")
        for k, one in enumerate(AXES)
        for n, axis in enumerate(AXES)
    },
    "distance": ("distance", 1, 0, "m"),
    "distance.rate": ("distance_rate", 2, 0, "m/s"),
    **{f"velocity.{axis}": ("velocity", 2, n, "m/s") for n, axis in enumerate(AXES)},
    **{f"angular_velocity.{axis}": ("angular_velocity", 2, n, "rad/s") for n, axis in enumerate(AXES)},
}
MOTIONS = {
    "velocity": "m/s",
    "velocity_body": "m/s",
    "angular_velocity": "rad/s",
    "angular_velocity_body": "rad/s",
}


def part_of(name: str) -> str:
    """Return the part that an output is of: ``rod(0.1, 0, 0)`` for ``rod(0.1, 0, 0).x``."""
    end = next((end for end in "])" if f"{end}." in f"{name}."), "")
    return f"{name}.".partition(f"{end}.")[0] + end


def output_words() -> set[str]:
    """Return what may follow the name of a part in that of an output."""
    return {*AXES, *EULER, *MOTIONS, *(word for kind in Element.registry.values() for word in kind.outputs)}


UNKNOWN = "Give one of a joint, body or force, such as pin.angle, pin.rate, rod.velocity.x or spring.length."


class Signals:
    """The outputs of a model's parts by name.

    Parameters
    ----------
    poses
        Of the bodies in the design position.
    known
        The coordinates of the joints.
    forces
        The primitives of the forces by name; one that is itself given by such a formula has none.
    states
        The first-order states.
    variables
        Outputs of parts that are formulas: functions that record them, see `Recording`.
    followed
        For each state that drivers follow, one of these drivers.

    Attributes
    ----------
    used : for each state, the outputs that its rate uses, once this is recorded
    """

    def __init__(
        self,
        poses: Poses,
        known: Known,
        forces: Mapping[str, Sequence[Primitive]],
        states: Mapping[str, Signal] | None = None,
        variables: Mapping[str, Any] | None = None,
        followed: Mapping[str, str] | None = None,
    ) -> None:
        self.followed, self.used = followed or {}, dict[str, tuple[str, ...]]()
        self.variables = variables or {}
        self.poses, self.known, self._forces, self.states = poses, known, forces, states or {}

    def extended(self, own: Mapping[str, Signal]) -> Signals:
        """Return these signals with further ones by name, such as the x and v of a part."""
        found = copy(self)
        found.states = {**self.states, **own}
        return found

    def rotor(self, part: str) -> Measure | None:
        """The rotor of a part, the wheel of a tyre, if it has one."""
        primitives = self._forces.get(part, ())
        return next((Measure.of(one) for one in primitives if one.element is Rotor), None)

    def rolls(self, part: str) -> bool:
        """Whether a part is a rolling tyre."""
        return any(issubclass(one.element, RollingTyre) for one in self._forces.get(part, ()))

    def of(self, recording: Recording) -> list[Signal]:
        """The signals that were met by a recording, in the order of its inputs."""
        self.refuse_hidden(recording)
        return [self.find(*one) for one in zip(recording.signals, recording.fields, strict=True)]

    def refuse_hidden(self, recording: Recording) -> None:
        """Refuse a parameter with the name of a state, which formulas could mean instead.

        Raises
        ------
        ModelError
        """
        hidden = next((name for name in recording.parameters if name in self.states), None)
        if hidden is not None:
            message = (
                f"parameters has the name {quote(hidden)}, which is that of a state. Rename one of them."
            )
            raise ModelError(message, field="parameters")

    def find(self, name: str, field: str) -> Signal:
        """The signal of a name, as outputs have it.

        Raises
        ------
        ModelError
            If there is none, with the nearest name.
        """
        if name in self.states:
            return self.states[name]
        part = part_of(name)
        found = dict(self._of_part(part))
        if name in found:
            return found[name]
        if part in self._forces and not found:
            message = f"{field} uses {quote(name)}, but the force {part} is itself given by outputs"
            raise ModelError(f"{message}. Name outputs of joints, bodies and other forces.", field=field)
        if not found:
            parts = [
                *self.known,
                *(one for one in self.poses if one != GROUND),
                *self._forces,
                *self.states,
                *self.variables,
            ]
            near = suggest(part, parts) if part else UNKNOWN
            message = f"{field} has the unknown name {quote(name)}. {near}"
            raise ModelError(f"{message}" if "Did you mean" in near else f"{message} {UNKNOWN}", field=field)
        if name.endswith("acceleration") or ".acceleration." in name:
            message = f"{field} uses {quote(name)}, but a force cannot depend on accelerations"
            raise ModelError(f"{message}. Use positions, velocities and the time.", field=field)
        raise ModelError(
            f"{field} uses {quote(name)}, which {part} does not have. {suggest(name, found)}", field=field
        )

    def _of_part(self, part: str) -> Iterator[tuple[str, Signal]]:
        if part in self.known:
            yield from self._of_joint(part)
        if part in self._forces:
            yield from self._of_force(part)
        if (point := POINT.fullmatch(part)) and point["body"] in self.poses and point["body"] != GROUND:
            yield from _of_body(part, point["body"], point["place"])
        if pair := RELATIVE.fullmatch(part):
            ends = [POINT.fullmatch(pair[side].strip()) for side in "ij"]
            places = [_place(end["place"]) for end in ends if end and end["body"] in self.poses]
            bodies = tuple(end["body"] for end in ends if end)
            if len(places) == 2 and all(places):
                yield from _relative(part, bodies, tuple(places))

    def _of_joint(self, joint: str) -> Iterator[tuple[str, Signal]]:
        for one in self.known[joint]:
            names = [f"{joint}.{one.name}"] + [joint] * (len(self.known[joint]) == 1)
            unit, measure = "rad" if is_angle(one.measure) else "m", Measure.of(one.measure)
            for name in names:
                yield name, Signal(measure, "Phi", 1, 0, unit)
                yield f"{name}.rate", Signal(measure, "Phi_q_xi", 2, 0, f"{unit}/s")

    def _of_force(self, force: str) -> Iterator[tuple[str, Signal]]:
        primitives = self._forces[force]
        for number, primitive in enumerate(primitives, 1):
            for one in primitive.element.outputs.values():
                several = len([p for p in primitives if one.word in p.element.outputs]) > 1
                name = f"{force}.{one.word}" + f".{number}" * several
                for n, axis in enumerate(one.axes or ("",)):
                    signal = Signal(Measure.of(primitive), one.method, one.arguments, n, one.unit)
                    yield f"{name}.{axis}".rstrip("."), signal


def _of_body(part: str, body: str, place: str | None) -> Iterator[tuple[str, Signal]]:
    s = _place(place)
    if s is None:
        return
    measure = Measure(PointMotion, (body,), (s,))
    for name, one in _relative(part, (body, GROUND), (ORIGIN, ORIGIN)):
        if ".axis_" in name:
            yield name, one
    for n, axis in enumerate(AXES):
        yield f"{part}.{axis}", Signal(measure, "position", 1, n, "m")
        for word, unit in MOTIONS.items():
            yield f"{part}.{word}.{axis}", Signal(measure, word, 2, n, unit)
    for n, word in enumerate(EULER):
        yield f"{part}.{word}", Signal(measure, "euler_parameters", 1, n, "1")
    for axis in AXES:
        yield f"{part}.rotation_{axis}", Signal(_rotation(body, axis), "Phi", 1, 0, "rad")


def _place(text: str | None) -> tuple[float, ...] | None:
    """The coordinates of a point, of the origin without any; None for what is not three numbers."""
    try:
        x, y, z = ORIGIN if text is None else (float(number) for number in text.split(","))
    except ValueError:
        return None
    return x, y, z


def _relative(part: str, bodies: tuple[str, ...], points: tuple[Any, ...]) -> Iterator[tuple[str, Signal]]:
    for word, found in RELATIVE_WORDS.items():
        yield f"{part}.{word}", Signal(Measure(RelativeMotion, bodies, points), *found)


def _rotation(body: str, axis: str) -> Measure:
    first, second = NEXT[axis]
    return Measure(elements.Angle, (GROUND, body), (UNIT[first], UNIT[second], UNIT[first], 0.0, 0.0))
