"""Warnings about a legal model whose numbers suggest a mistake: another unit, a wrong axis, a forgotten joint."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cached_property
from itertools import pairwise
from math import pi, radians, tau
from operator import itemgetter
from typing import Any, NamedTuple

import numpy as np

from ... import elements
from ..coordinates import slice_of
from ..errors import ModelError
from ..forces.springs import TSDA
from ..geometry.orientation import AxisAngle, EulerAngles
from ..geometry.points import PERPENDICULAR
from ..geometry.rotation import matrix
from ..joints.pairs import Revolute, Translational
from ..laws.curve import Curve, Formula
from ..measure import measures_of
from ..model import Model
from ..quantity import ROUND_OFF, Array, is_list, vector
from .blueprint import Blueprint, Placement
from .tree import TreeModel

FULL = 2 * pi * (1 + ROUND_OFF)  # [rad] a full revolution, with the round-off of its formula
KILO = 1000.0  # what m and mm, N/m and N/mm, and kg and t differ by
UNLIKELY = KILO**0.5  # ratio from which a number is rather one of the other unit
# [rad], [rad/s] numbers of degrees that motions often have
DEGREES = (45.0, 60.0, 90.0, 120.0, 180.0, 270.0, 360.0, 720.0)
TIMES = np.linspace(0.0, 10.0, 2001)  # [s] at which motions are evaluated
SWING = 0.3  # of the range of a table's values, by which its spline is beyond two neighbouring ones
SAMPLES = 16  # in a segment of a table


class Reach(NamedTuple):
    """A point of a part on a body, from the body's centre of mass, in body axes [m]."""

    part: str
    s: Array


class Suspicions:
    """Messages about suspicious input in a model.

    Parameters
    ----------
    model, plan : a checked model and its blueprint
    """

    def __init__(self, model: Model, plan: Blueprint) -> None:
        self.model, self.plan = model, plan
        self.gravity = np.array(vector(model.gravity, "gravity"))

    def messages(self) -> Iterator[str]:
        """Yield the messages, in the order of the parts."""
        yield from self._gravity()
        yield from self._angles()
        for number in self.properties:
            name = self.plan.bodies[number - 1]
            yield from list(self._far_points(number, name)) or self._inertia(number, name)
            yield from self._loose(number, name)
        yield from self._springs()
        yield from self._driven_twice()
        yield from motions_in_degrees(self.plan)
        yield from exchanged_points(self.plan, self._place, self.size)
        yield from self._idle_pendulums()
        yield from overshooting_tables(self.model)
        yield from self._contacts()

    @cached_property
    def properties(self) -> dict[int, tuple[float, Array, Array]]:
        """Mass [kg], inertia entries [kg m²] and centre of mass [m] by number, of each body that has them."""
        found = {}
        for one in self.plan.placed:
            fields = values_of(one)
            if issubclass(one.element, elements.RigidInertia | elements.EccentricInertia) and fields["mass"]:
                mass, inertia, *center = fields.values()
                found[one.bodies[0]] = float(mass), np.array(inertia), np.array(*center or [(0.0, 0.0, 0.0)])
        return found

    @cached_property
    def reaches(self) -> dict[int, list[Reach]]:
        """The points of joints, drivers and forces on each body, by number."""
        points: dict[int, list[Reach]] = {number: [] for number in self.properties}
        for one in self.plan.placed:
            for number, s in self._points(one):
                if number in points:
                    points[number].append(Reach(one.owner, s - self.properties[number][2]))
            body = one.bodies[-1] if one.element.nonholonomic else one.bodies[0]  # which rolls, or touches
            if body in points and "radius" in one.element.fields:
                points[body].append(Reach(one.owner, np.array([values_of(one)["radius"], 0.0, 0.0])))
        return points

    @cached_property
    def size(self) -> float:
        """The largest extent of the mechanism in its initial pose. [m]"""
        places = [self._place(*point) for one in self.plan.placed for point in self._points(one)]
        places += [self._place(number, center) for number, (_, _, center) in self.properties.items()]
        return float(np.ptp(places, axis=0).max())

    def _points(self, one: Placement) -> Iterator[tuple[int, Array]]:
        """Yield the number of the body that a point of an element is on, and the point in its axes. (3,) [m]"""
        fields, bodies = values_of(one), self.plan.bodies_of(one)
        for name, side in (("s", 0), ("s_i", 0), ("s_j", 1)):
            if name in fields and side < len(bodies):
                yield bodies[side], np.array(fields[name], dtype=float)

    def _place(self, number: int, local: Array) -> Array:
        """A point of a body, global in the initial pose. (3,) [m]"""
        if number == 0:
            return local
        q = self.plan.q[slice_of(number - 1)]
        return np.asarray(q[:3] + matrix(q[3:]) @ local)

    @cached_property
    def _parts_on(self) -> dict[int, set[str]]:
        """The joints, drivers and forces on each body, by number."""
        parts: dict[int, set[str]] = {number: set() for number in self.properties}
        for one in self.plan.placed:
            for number in parts.keys() & one.bodies:
                if one.owner != self.plan.bodies[number - 1]:
                    parts[number].add(one.owner)
        return parts

    @cached_property
    def _named(self) -> dict[str, tuple[int, Any]]:
        """Every part and its place in the model, by name."""
        every = (part for parts in self.model.sections().values() for part in parts)
        return {part.name: (place, part) for place, part in enumerate(every)}

    def _gravity(self) -> Iterator[str]:
        if np.linalg.norm(self.gravity) > KILO:
            yield f"gravity: it is {np.linalg.norm(self.gravity):.4g} m/s². Give it in m/s², such as (0, 0, -9.81)."

    def _angles(self) -> Iterator[str]:
        """Angles of more than a full revolution, unless a file gives them with a unit or by a formula."""
        for part, field, angle in angles_of(self.model):
            stated = any(field in path and part in path for path in self.model.expressions)
            if abs(angle) > FULL and not stated:
                yield (
                    f"{part}: {field} is {angle:g} rad, more than a full revolution. Give radians: "
                    f"{angle:g} degrees are {np.radians(angle):.6g} rad."
                )

    def _far_points(self, number: int, body: str) -> Iterator[str]:
        mass, _, center = self.properties[number]
        far = [(float(np.linalg.norm(s)), part) for part, s in (*self.reaches[number], Reach(body, center))]
        distance, part = max(far)
        if _is_far(distance, mass):
            yield (
                f"{part}: it reaches {distance:.4g} m from the centre of mass of {body}, which has {mass:.4g} kg. "
                "Check that lengths are in m."
            )

    def _inertia(self, number: int, body: str) -> Iterator[str]:
        mass, inertia, _ = self.properties[number]
        radius = float(np.sqrt(max(inertia[:3]) / mass))
        if _is_far(radius, mass):
            yield (
                f"{body}: its radius of gyration is {radius:.4g} m at a mass of {mass:.4g} kg. Check that its inertia "
                "is in kg m²."
            )

    def _loose(self, number: int, body: str) -> Iterator[str]:
        declared = isinstance(self.model, TreeModel)  # where bodies are free by an entry in a robot's file
        if self.model.joints and not (self._parts_on[number] or self._moves(number) or declared):
            yield f"{body}: no joint and no force is attached to it. Attach it to another body, or remove it."

    def _moves(self, number: int) -> bool:
        """Whether a body has an initial velocity."""
        return any(self.plan.v[slice_of(number - 1)])

    def _springs(self) -> Iterator[str]:
        stiffness: dict[int, float] = {}
        lengths: dict[int, float] = {}
        for one in self.plan.placed:
            if not issubclass(one.element, elements.TSDA | elements.NonlinearTSDA):
                continue
            given = values_of(one)
            ends = [self._place(*point) for point in self._points(one)]
            length = float(np.linalg.norm(ends[1] - ends[0]))
            if given["length"] > UNLIKELY * length:
                yield (
                    f"{one.owner}: its free length is {given['length']:.4g} m, its length at the start {length:.4g} m. "
                    "Give the free length in m."
                )
            for number in one.bodies:
                stiffness[number] = stiffness.get(number, 0.0) + given["k"]
                lengths[number] = max(lengths.get(number, 0.0), length)
        for number in sorted(stiffness.keys() & self.properties.keys()):
            yield from self._sag(number, stiffness[number], lengths[number])

    def _sag(self, number: int, k: float, length: float) -> Iterator[str]:
        """A body that nothing but springs holds against gravity, and that they do not hold."""
        mass = self.properties[number][0]
        body, weight = self.plan.bodies[number - 1], mass * float(np.linalg.norm(self.gravity))
        others = [part for part in self._joints_and_forces(number) if not isinstance(part, TSDA)]
        free = all(isinstance(part, Translational) and self._is_along_gravity(part.axis) for part in others)
        if free and k and weight > UNLIKELY * length * k:
            yield (
                f"{body}: its springs, of {k:.4g} N/m in all, give way by {weight / k:.4g} m under its weight of "
                f"{weight:.4g} N. Give k in N/m."
            )

    def _joints_and_forces(self, number: int) -> list[Any]:
        places = [self._named[name] for name in self._parts_on[number] & self._named.keys()]
        return [part for _, part in sorted(places, key=itemgetter(0))]

    def _is_along_gravity(self, axis: Any) -> bool:
        return axis is not None and parallel(np.array(vector(axis, "axis")), self.gravity)

    def _driven_twice(self) -> Iterator[str]:
        """Coordinates of joints with two drivers."""
        drivers: dict[str, str] = {}
        for driver in self.model.drivers:
            joint = getattr(driver, "joint", None)
            if joint in drivers and type(driver) is type(self._named[drivers[joint]][1]):
                yield f"{driver.name}: {drivers[joint]} drives {joint}, too. Remove one of the drivers."
            elif joint:
                drivers[joint] = driver.name

    def _idle_pendulums(self) -> Iterator[str]:
        """Links on one pin alone, whose axis points along them, so that gravity does not move them."""
        for number in self.properties:
            body = self.plan.bodies[number - 1]
            match self._joints_and_forces(number):
                case [Revolute(axis=axis, point=point, name=pin)] if axis is not None and point is not None:
                    lever = self._place(number, self.properties[number][2]) - np.array(vector(point, "point"))
                    along = parallel(np.array(vector(axis, "axis")), lever) and not self._is_along_gravity(
                        axis
                    )
                    apart = np.linalg.norm(lever) > PERPENDICULAR * self.size
                    moves = self._moves(number) or self.model.rates
                    if along and apart and np.any(self.gravity) and not moves:
                        yield (
                            f"{pin}: its axis passes through the centre of mass of {body}, which therefore does not "
                            "swing. Give an axis across the link."
                        )

    def _contacts(self) -> Iterator[str]:
        """Planes and roads that gravity pulls bodies away from."""
        for one in self.plan.placed:
            if issubclass(one.element, elements.SphereContact) and one.bodies[1] == 0:
                normal = np.array(values_of(one)["n_j"])
            elif issubclass(one.element, elements.Tyre | elements.RoadTyre | elements.SurfaceTyre):
                normal = np.array([0.0, 0.0, 1.0])
            else:
                continue
            if normal @ self.gravity > 0.5 * np.linalg.norm(self.gravity):
                yield (
                    f"{one.owner}: gravity pulls its body away from the ground, upwards. Reverse gravity, usually "
                    "(0, 0, -9.81), or the normal of the plane."
                )


def _is_far(distance: float, mass: float) -> bool:
    """Whether a body of this mass [kg] has rather this size in mm: it is lighter than water of that size."""
    return distance >= KILO or (distance >= UNLIKELY and mass < KILO * (distance / KILO) ** 3)


def parallel(a: Array, b: Array) -> bool:
    """Whether two vectors have one direction, or opposite ones."""
    return bool(abs(a @ b) > (1 - ROUND_OFF) * np.linalg.norm(a) * np.linalg.norm(b))


def values_of(one: Placement) -> dict[str, Any]:
    """The fields of an element by name."""
    return dict(zip((f for f, kind in one.element.fields.items() if kind != "Time"), one.values, strict=True))


def angles_of(model: Model) -> Iterator[tuple[str, str, float]]:
    """Yield part, field and value of every angle in a model."""
    for body in model.bodies:
        for field in ("orientation", "initial_orientation"):
            match getattr(body, field):
                case AxisAngle(angle=angle):
                    yield body.name, field, float(angle)
                case EulerAngles(angles=angles):
                    yield body.name, field, float(max(angles, key=abs))
    for parts in (model.joints, model.forces):  # drivers move by more than a revolution
        for part in parts:
            for field, measure in measures_of(part).items():
                value = getattr(part, field, None)
                if measure.unit == "rad" and isinstance(value, int | float):
                    yield part.name, field, float(value)


def motions_in_degrees(plan: Blueprint) -> Iterator[str]:
    """Yield a message for each angle driver that seems to rotate by 360 degrees per second, or to swing by 90."""
    for one in plan.placed:
        if issubclass(one.element, elements.AngleDriver):
            *_, scale, motion = one.values
            if not np.isfinite(scale):
                continue  # an input that is not set yet
            times = _times(motion)
            angle, each = _round_in_degrees(times, scale * _values(motion, times))
            if angle:
                yield (
                    f"{one.owner}: its motion of {angle:g} rad{each} is {angle / tau:.3g} revolutions. Give radians: "
                    f"{angle:g} degrees are {radians(angle):.6g} rad."
                )


def _times(motion: Curve | Formula) -> Array:
    if isinstance(motion, Curve):
        return np.array([x for x, _ in motion.pairs] or motion.knots)
    return TIMES


def _values(motion: Curve | Formula, times: Array) -> Array:
    """The motion at some times; zeros if it is not defined at all of them."""
    if isinstance(motion, Curve):
        return np.array([motion(t) for t in times])
    try:
        with np.errstate(all="ignore"):
            found = np.broadcast_to(np.asarray(motion.function(times), dtype=float), times.shape)
    except (ModelError, ArithmeticError, ValueError, TypeError, AttributeError):
        return np.zeros_like(times)
    return found if np.all(np.isfinite(found)) else np.zeros_like(times)


def _round_in_degrees(times: Array, angles: Array) -> tuple[float, str]:
    """The angle per second of a uniform rotation, or the range of a bounded motion, if round in degrees; else 0."""
    changes, extent = np.diff(angles), float(np.ptp(angles))
    rate = abs(angles[-1] - angles[0]) / (times[-1] - times[0])
    if np.allclose(changes, changes[0], rtol=ROUND_OFF, atol=ROUND_OFF * extent):
        return _round(rate, ROUND_OFF), " per second"
    returns = np.any(changes > 0) and np.any(changes < 0)
    rests = np.ptp(angles[-2:]) <= ROUND_OFF * extent
    swing = _round(extent / 2, 1 / len(TIMES)) if returns else 0.0  # of its samples
    return swing or (_round(extent, 1 / len(TIMES)) if returns or rests else 0.0), ""


def _round(angle: float, error: float) -> float:
    """The number of degrees that an angle is, up to a relative error; 0 if there is none."""
    return next((one for one in DEGREES if abs(angle - one) <= error * one), 0.0)


def exchanged_points(plan: Blueprint, place: Callable[[int, Array], Array], size: float) -> Iterator[str]:
    """Yield a message for each joint that would close if its points were exchanged, or has the same point twice.

    Parameters
    ----------
    plan : the blueprint of a model
    place : the function that returns the global position of a point of a body, by number, in the initial pose
    size : the extent of the mechanism [m]
    """
    for one in plan.placed:
        if not issubclass(one.element, elements.Spherical):
            continue
        (i, j), (s_i, s_j) = one.bodies, map(np.array, one.values)
        gap = float(np.linalg.norm(place(i, s_i) - place(j, s_j)))
        if gap <= PERPENDICULAR * size:
            continue
        apart = f"{one.owner}: its points are {gap:.4g} m apart in the initial pose"
        if np.linalg.norm(place(i, s_j) - place(j, s_i)) <= PERPENDICULAR * size:
            yield f"{apart}, and coincide if they are exchanged. Give each point in the axes of its own body."
        elif i and np.any(s_i) and np.linalg.norm(s_i - s_j) <= PERPENDICULAR * size:
            yield f"{apart}, with the same coordinates in both bodies. Give each point in the axes of its own body."


def overshooting_tables(model: Model) -> Iterator[str]:
    """Yield a message for each table of a law whose spline overshoots."""
    for parts in model.sections().values():
        for part in parts:
            for field, measure in measures_of(part).items():
                if measure.over != "1" or measure.outputs:
                    for curve in _tables(getattr(part, field, None)):
                        yield from _overshoot(f"{part.name}: the spline through the table of {field}", curve)


def _tables(value: Any) -> Iterator[Curve]:
    """The tables of a law, or of each component of a load."""
    if isinstance(value, Curve):
        if value.pairs:
            yield value
    elif is_list(value) and len(value) and all(is_list(row) and len(row) == 2 for row in value):
        yield Curve.table(value)
    elif is_list(value):
        for one in value:
            yield from _tables(one)


def _overshoot(table: str, curve: Curve) -> Iterator[str]:
    pairs, y = curve.pairs, [value for _, value in curve.pairs]
    size, worst, text = max(max(y) - min(y), SWING * max(map(abs, y))), SWING, ""
    for (a, before), (b, after) in pairwise(pairs):
        for x in np.linspace(a, b, SAMPLES + 1).tolist():
            beyond = max(curve(x) - max(before, after), min(before, after) - curve(x))
            if beyond > worst * size:
                worst, text = beyond / size, f"is {curve(x):.3g} at {x:.3g}, between {before:g} and {after:g}"
    if text:
        yield (
            f"{table} {text}. Add points next to its corners, or give a formula with step(x, x0, h0, x1, h1)."
        )
