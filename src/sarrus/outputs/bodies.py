"""Outputs of bodies: ``slider.x``, ``crank.e0``, ``rod.velocity.x``, ``tool.rotation_z``, and those of their points."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from ..model.expansion.blueprint import Placement
from ..model.geometry.points import AXES, GROUND, AxisName, Function, Point, PointCoordinate, Rotation, Solid
from ..model.show import quote, suggest
from ..model.signals import RELATIVE, RELATIVE_WORDS
from ..system import System
from .output import POINT, Level, Output, UnknownOutput, among, calls, provides
from .outputs import End

EULER = ("e0", "e1", "e2", "e3")
ORIGIN = (0.0, 0.0, 0.0)
TURNING = (
    ("angular_velocity", "rad/s", Level.VELOCITY),
    ("angular_velocity_body", "rad/s", Level.VELOCITY),
    ("angular_acceleration", "rad/s²", Level.ACCELERATION),
    ("angular_acceleration_body", "rad/s²", Level.ACCELERATION),
)
MOTION = (("velocity", "m/s", Level.VELOCITY), ("acceleration", "m/s²", Level.ACCELERATION))
CARDAN = {"yaw": ("zyx", 0), "pitch": ("zyx", 1), "roll": ("zyx", 2)}
SEQUENCES = [a + b + c for a in "xyz" for b in "xyz" for c in "xyz" if b not in (a, c)]


@provides
def bodies(system: System, part: str | None) -> Iterator[Output]:
    """Position, orientation, velocities and accelerations of bodies."""
    for body in among(system.bodies, part):
        first = system.coordinates_of(body).start
        for word, place in zip(
            EULER, system.layout.rotations[system.bodies.index(body)].tolist(), strict=True
        ):
            yield Output(f"{body}.{word}", "1", calls("input", "q", place), place=place)
        yield from _of_point(body, body, ORIGIN, first)
        for word, unit, level in TURNING:
            for n, axis in enumerate(AXES):
                yield Output(f"{body}.{word}.{axis}", unit, calls(word, body, at=n), level)
        for axis in AXES:
            yield Output(
                f"{body}.rotation_{axis}", "rad", calls("turn", body, axis), element=_turn(body, axis)
            )
        i, j = (body, ORIGIN), (GROUND, ORIGIN)
        yield from (one for one in _relative(body, i, j) if ".axis_" in one.name)
        yield from _angles(body, i, j, every=part is not None)


@provides
def points(system: System, part: str | None) -> Iterator[Output]:
    """Position, velocity and acceleration of a point of a body: ``rod(0.1, 0, 0).x``."""
    if part and (found := point_of(system, part)):
        yield from _of_point(part, *found)


@provides
def relative(system: System, part: str | None) -> Iterator[Output]:
    """Motion that is seen from another body or point, in its axes: ``relative[hub(0, 0, 0.1), chassis].x``."""
    if found := RELATIVE.fullmatch(part or ""):
        i, j = (_end(system, found[side].strip()) for side in "ij")
        if i and j:
            yield from _relative(str(part), i, j)
            yield from _angles(str(part), i, j, every=True)


def _end(system: System, name: str) -> End | None:
    return (name, ORIGIN) if name in (GROUND, *system.bodies) else point_of(system, name, GROUND)


def _relative(part: str, i: End, j: End) -> Iterator[Output]:
    seen = {f"acceleration.{axis}": ("acceleration", 3, n, "m/s²") for n, axis in enumerate(AXES)}
    for word, (method, arguments, n, unit) in (RELATIVE_WORDS | seen).items():
        level = Level(arguments - 1)
        yield Output(f"{part}.{word}", unit, calls("relative", method, i, j, at=n), level)


def _angles(part: str, i: End, j: End, every: bool) -> Iterator[Output]:
    """Roll, pitch and yaw, and the angles of all sequences of rotations, which are too many for a list.

    They have no element that counts their revolutions, see `Outputs.angle`.
    """
    numbered = {f"angles_{axes}.{n + 1}": (axes, n) for axes in SEQUENCES for n in range(3)}
    for word, (axes, n) in (CARDAN | (numbered if every else {})).items():
        yield Output(f"{part}.{word}", "rad", calls("angle", i, j, axes, n))


def point_of(system: System, name: str, more: str = "") -> tuple[str, tuple[float, float, float]] | None:
    """Body (of the system, or `more`) and coordinates of a point ``rod(0.1, 0, 0)``; None for any other name.

    Raises
    ------
    UnknownOutput
        If its coordinates are not three numbers.
    """
    found = POINT.fullmatch(name)
    if not found or found["rest"] or found["body"] not in (*system.bodies, more):
        return None
    try:
        x, y, z = (float(number) for number in found["place"].split(","))
    except ValueError:
        message = f"{system.name}: {name} is no point. Give three numbers, as in {found['body']}(0.1, 0, 0)."
        raise UnknownOutput(message) from None
    return found["body"], (x, y, z)


def _of_point(part: str, body: str, s: tuple[float, ...], first: int | None = None) -> Iterator[Output]:
    """Return the outputs of a point of a body."""
    for n, axis in enumerate(AXES):
        place = None if first is None else first + n
        record = calls("position", body, s, at=n) if place is None else calls("input", "q", place)
        yield Output(f"{part}.{axis}", "m", record, place=place, element=_coordinate(body, s, axis))
    for word, unit, level in MOTION:
        for n, axis in enumerate(AXES):
            yield Output(f"{part}.{word}.{axis}", unit, calls(word, body, s, at=n), level)
            in_body = calls("in_body_axes", word, body, s, at=n)
            yield Output(f"{part}.{word}_body.{axis}", unit, in_body, level)


def _coordinate(body: str, s: tuple[float, ...], axis: AxisName) -> Callable[[System], Placement]:
    return lambda system: placed(system, PointCoordinate(Point(_solid(system, body), s), axis))


def _turn(body: str, axis: AxisName) -> Callable[[System], Placement]:
    return lambda system: placed(system, Rotation(_solid(system, body), axis))


def _solid(system: System, name: str) -> Solid:
    return next(body for body in system.model.bodies if body.name == name)


def placed(system: System, function: Function) -> Placement:
    """The element that measures a function of the model's position.

    Raises
    ------
    UnknownOutput
        If it is of a body that the system does not have.
    """
    poses = system.model.design_poses()
    number = {name: n for n, name in enumerate((GROUND, *system.bodies))}
    element, names, values, label = function.primitive(poses)
    for body in names:
        if body not in number:
            raise UnknownOutput(f"{function.label}: there is no body {quote(body)}. {suggest(body, number)}")
    return Placement(element, tuple(number[body] for body in names), values, function.label, label)
