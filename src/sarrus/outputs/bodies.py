"""Outputs of bodies: ``slider.x``, ``crank.e0``, ``rod.velocity.x``, ``tool.turn_z``, and those of their points."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any, cast

from ..model import Placed
from ..model.function import NEXT, AxisName, Function, PointCoordinate, Turn
from ..model.pose import GROUND_POSE
from ..model.show import quote, suggest
from ..model.solid import GROUND
from ..system import System
from .output import POINT, Level, Output, UnknownOutput, among, provides

AXES: tuple[AxisName, ...] = ("x", "y", "z")
EULER = ("e0", "e1", "e2", "e3")


@provides
def bodies(system: System, part: str | None) -> Iterator[Output]:
    """Position, orientation, velocities and accelerations of bodies."""
    for body in among(system.bodies, part):
        first = system.coordinates_of(body).start
        for n, word in enumerate((*AXES, *EULER)):
            unit, element = (
                ("m", partial(_coordinate, body, cast(AxisName, word), ())) if n < 3 else ("1", None)
            )
            yield Output(f"{body}.{word}", unit, partial(_input, first + n), place=first + n, element=element)
        yield from _motion(body, body, ())
        for n, axis in enumerate(AXES):
            turn = Output(f"{body}.angular_velocity.{axis}", "rad/s", partial(_spin, body, n), Level.VELOCITY)
            yield turn
        for axis in AXES:
            yield Output(
                f"{body}.turn_{axis}",
                "rad",
                partial(_turn, body, axis),
                element=partial(_turning, body, axis),
            )


@provides
def points(system: System, part: str | None) -> Iterator[Output]:
    """Position, velocity and acceleration of a point of a body: ``rod(0.1, 0, 0).x``."""
    found = POINT.fullmatch(part or "")
    if found and found["body"] in system.bodies:
        place = _numbers(system, part or "", found["place"])
        for n, axis in enumerate(AXES):
            element = partial(_coordinate, found["body"], axis, place)
            yield Output(
                f"{part}.{axis}", "m", partial(_vector, "position", found["body"], place, n), element=element
            )
        yield from _motion(str(part), found["body"], place)


def _numbers(system: System, part: str, place: str) -> tuple[float, ...]:
    try:
        x, y, z = (float(number) for number in place.split(","))
    except ValueError:
        raise UnknownOutput(
            f"{system.name}: {part} is no point. Give three numbers, as in body(0.1, 0, 0).x."
        ) from None
    return x, y, z


def _motion(part: str, body: str, place: tuple[float, ...]) -> Iterator[Output]:
    for word, unit, level in (
        ("velocity", "m/s", Level.VELOCITY),
        ("acceleration", "m/s²", Level.ACCELERATION),
    ):
        for n, axis in enumerate(AXES):
            yield Output(f"{part}.{word}.{axis}", unit, partial(_vector, word, body, place, n), level)


def _input(place: int, o: Any) -> Any:
    return o.input("q", place)


def _vector(word: str, body: str, place: tuple[float, ...], axis: int, o: Any) -> Any:
    return getattr(o, word)(body, place or (0, 0, 0))[axis]


def _spin(body: str, axis: int, o: Any) -> Any:
    return o.angular_velocity(body)[axis]


def _turn(body: str, axis: AxisName, o: Any) -> Any:
    return o.turn(body, *(AXES.index(name) for name in NEXT[axis]))


def _coordinate(body: str, axis: AxisName, place: tuple[float, ...], system: System) -> Placed:
    return placed(system, PointCoordinate(_body(system, body).point(*(place or (0, 0, 0))), axis))


def _turning(body: str, axis: AxisName, system: System) -> Placed:
    return placed(system, Turn(_body(system, body), axis))


def _body(system: System, name: str) -> Any:
    return next(body for body in system.model.bodies if body.name == name)


def placed(system: System, function: Function) -> Placed:
    """The element that measures a function of the model's position.

    Raises
    ------
    UnknownOutput
        If it is of a body that the system does not have.
    """
    poses = {GROUND: GROUND_POSE, **{body.name: body.pose() for body in system.model.bodies}}
    number = {name: n for n, name in enumerate((GROUND, *system.bodies))}
    element, names, values, label = function.primitive(poses)
    unknown = [body for body in names if body not in number]
    if unknown:
        raise UnknownOutput(f"{function.label} is of {quote(unknown[0])}; {suggest(unknown[0], number)}")
    return Placed(element, tuple(number[body] for body in names), values, function.label, label)
