"""Angles that drivers prescribe at a time, alone or through gears: with all their revolutions, which a pose has not."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from functools import partial
from math import tau
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from ... import elements
from ...algebra import Array
from ...euler import A
from ...model import AngleDriver, ModelError
from ...system import System
from ...system.cached import once
from ...system.structure.population import Population

# of a joint's angle or displacement: its bodies, and the vectors that measure it
Key: TypeAlias = tuple[Any, ...]
NEAR = 0.25  # of the distance between two poses of a wheel that satisfy its gear
ALIGNED = 1e-3  # [rad] between axes in the initial pose: models are written with few digits


class Relation(NamedTuple):
    """A coupling of two coordinates, second = ratio · first + offset; a gear leaves revolutions of the second open."""

    first: Key
    second: Key
    ratio: float
    offset: float
    is_gear: bool = False


class Follower(NamedTuple):
    """A remembered angle, reference = start + sign · (angle of a joint - its initial value)."""

    place: int
    start: float
    joint: Key
    initial: float
    sign: float


class Prescription(NamedTuple):
    """Prescribed quantities: motions, couplings, angles of joints by row, and state variables of elements."""

    motions: tuple[tuple[Key, float, Callable[[float], float]], ...]
    relations: tuple[Relation, ...]
    rows: tuple[tuple[int, Key], ...]
    followers: tuple[Follower, ...]

    def values(self, t: float) -> dict[Key, float]:
        """The prescribed coordinates at a time."""
        return self._values(t)[0]

    def leaders(self, t: float, angles: Array) -> dict[int, float]:
        """The angles of first wheels whose second is driven, by row: several of their poses satisfy the gear.

        Only of those that are at another one at the given angles (nc,).
        """
        values, leaders = self._values(t)
        far = {
            row: values[key] for row, key in self.rows
            if key in leaders and abs(np.remainder(values[key] - angles[row] + np.pi, tau) - np.pi) > leaders[key]
        }  # fmt: skip
        return far

    def _values(self, t: float) -> tuple[dict[Key, float], dict[Key, float]]:
        values, leaders = (
            {key: scale * motion(t) for key, scale, motion in self.motions},
            dict[Key, float](),
        )
        for _ in self.relations:
            for first, second, ratio, offset, is_gear in self.relations:
                if first in values:
                    values.setdefault(second, ratio * values[first] + offset)
                elif second in values:
                    values[first] = (values[second] - offset) / ratio
                    if is_gear:
                        leaders[first] = NEAR * tau / abs(ratio)
        return values, leaders


def prescribed_memory(system: System, t: float, b: Array) -> Array:
    """Return the state variables of elements (k,); those of the parameters b without a driver."""
    plan, parameters = prescription(system), b.copy()
    values = plan.values(t)
    for place, start, joint, initial, sign in plan.followers:
        if joint in values:
            parameters[place] = start + sign * (values[joint] - initial)
    return np.asarray(parameters[system.memory_places])


def prescribed_revolutions(system: System, q: Array, t: float, known: Array) -> Array:
    """The revolutions of the joints' angles (nc,) at an assembled state; those known where no driver prescribes them.

    Empty where all are nearest to their initial values.
    """
    plan = prescription(system)
    if not plan.motions:
        return known
    values, angles = plan.values(t), system.joint_coordinates.Phi(q)
    revolutions = known.copy() if len(known) else np.zeros(len(angles))
    for row, key in plan.rows:
        if key in values:
            revolutions[row] = np.round((values[key] - angles[row]) / tau)
    return revolutions if np.any(revolutions) or len(known) else known


def with_leaders(system: System, q: Array, t: float) -> System | None:
    """The system whose drivers also turn the first wheels of gears whose second wheels are driven; None without any.

    In its assembly, each of these wheels is at the pose that its revolutions determine.
    None, too, where all are at it in an assembled state q.
    """
    if not (plan := prescription(system)).motions:
        return None
    leaders = plan.leaders(t, system.joint_coordinates.Phi(q))
    if not leaders:
        return None
    names, model = system.joint_coordinates.names, system.model
    added = [
        AngleDriver(f"pose-of-{names[row].replace('.', '-')}", names[row], value)
        for row, value in leaders.items()
    ]
    led = System(replace(model, drivers=[*model.drivers, *added]))
    return led.with_memory(prescribed_memory(led, t, led.b))


@once
def prescription(system: System) -> Prescription:
    """Return the quantities that drivers and couplings of a model prescribe."""
    motions, relations = [], []
    for kind, bodies, x, _, owner in _members(system.populations):
        if kind in (elements.AngleDriver, elements.DisplacementDriver):
            motions.append((_key(bodies, x), x["scale"], partial(_value, owner, x["motion"])))
        elif kind is elements.Screw:
            angle = (bodies, x["f_i"], x["g_i"], x["f_j"])
            displacement = (bodies, x["h_i"], x["s_i"], x["s_j"])
            offset = x["displacement"] - x["lead"] * x["angle"]
            relations.append(Relation(angle, displacement, x["lead"], offset))
        elif kind in (elements.AngleAngle, elements.DisplacementDisplacement):
            gear = kind is elements.AngleAngle
            relations.append(Relation(*_pair(bodies, x), x["ratio"], x["offset"], gear))
        elif kind is elements.DisplacementAngle:
            relations.append(Relation(*_pair(bodies, x)[::-1], x["ratio"], x["offset"]))
    if not motions:
        return Prescription((), (), (), ())
    joints = [
        (_key(bodies, x), x["reference"], row)
        for kind, bodies, x, row, _ in _members(system.joint_coordinates.populations)
        if kind is elements.Angle
    ]
    rows = tuple((row, key) for key, _, row in joints)
    return Prescription(tuple(motions), tuple(relations), rows, tuple(_followers(system, joints)))


def _value(driver: str, motion: Callable[[float], float], t: float) -> float:
    """The value of a motion at a time.

    Raises
    ------
    ModelError
        If it is not finite.
    """
    with suppress(ArithmeticError, ValueError, TypeError):  # a root of a negative number is a complex one
        if np.isfinite(value := float(motion(t))):
            return value
    raise ModelError(
        f"{driver}: its motion has no finite value at t = {t:.6g} s. Choose other times, or a motion that is smooth "
        "there."
    )


def _followers(system: System, joints: list[tuple[Key, float, int]]) -> Iterator[Follower]:
    """Elements that remember an angle about the axis of a joint between the same bodies."""
    for kind, bodies, x, place, _ in _members(system.populations, "reference"):
        if not {"f_i", "g_i", "f_j"} <= x.keys():
            continue
        key = (bodies[:2], x["f_i"], x["g_i"], x["f_j"])
        for joint, initial, _ in joints:
            alone = sum(set(other[0]) == set(joint[0]) for other, *_ in joints) == 1
            sign = 1.0 if kind is elements.AngleAngle and joint == key else _sign(system, joint, key) * alone
            if sign:
                yield Follower(place, x["reference"], joint, initial, sign)


def _sign(system: System, joint: Key, other: Key) -> float:
    """1 or -1 for an angle in or against the sense of a joint's angle, 0 for one about another axis."""
    if set(joint[0]) != set(other[0]):
        return 0.0
    same = _axis(system, joint) @ _axis(system, other)
    sense = float(np.sign(same)) * (1.0 if joint[0] == other[0] else -1.0)
    return sense if abs(same) > 1 - ALIGNED**2 else 0.0


def _axis(system: System, key: Key) -> Array:
    """The unit vector of an angle's axis, global, in the initial pose."""
    (i, _), f, g, _ = key
    axis, layout = np.cross(f, g), system.layout
    direction = axis if i < 0 else A(system.q0[layout.rotations[layout.owner_of[i]]]) @ axis
    return np.asarray(direction / np.linalg.norm(direction))


def _key(bodies: tuple[int, ...], x: dict[str, Any]) -> Key:
    """The first three vectors of an element that measures or drives a joint's coordinate."""
    return (bodies, *list(x.values())[:3])


def _pair(bodies: tuple[int, ...], x: dict[str, Any]) -> tuple[Key, Key]:
    """Both coordinates of a coupling."""
    vectors = list(x.values())
    return (bodies[:2], *vectors[:3]), (bodies[2:], *vectors[3:6])


def _members(
    populations: list[Population], field: str | None = None
) -> Iterator[tuple[Any, tuple[int, ...], dict[str, Any], int, str]]:
    """Return for each element its kind, first coordinates of its bodies (-1: ground), fields, row, and part."""
    for p in populations:
        if field is not None and field not in p.kind.fields:
            continue
        names = [name for name, kind in p.kind.fields.items() if kind != "Time"]
        starts = dict(zip(p.kind.fields, np.cumsum([0, *p.kind.widths()]), strict=False))
        for k in range(p.count):
            bodies = tuple(int(p.bodies[k][slot]) if slot >= 0 else -1 for slot in p.variant.slots)
            values = [tuple(map(float, v)) if np.ndim(v) else v for v in map(_plain, p.values[k])]
            place = int(p.rows[k]) if field is None else p.at + k * p.kind.size() + int(starts[field])
            yield p.kind, bodies, dict(zip(names, values, strict=True)), place, p.owners[k]


def _plain(value: Any) -> Any:
    return tuple(value) if isinstance(value, list | tuple | np.ndarray) else value
