"""What a user names, ``"pin.angle"``, ``"tool.x"`` or a function of the model, as an element that measures it."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any, NamedTuple, cast

from ... import elements
from ...model import Placed, SarrusError, blueprint
from ...model.function import AxisName, Function, PointCoordinate, Turn
from ...model.pose import GROUND_POSE
from ...model.show import quote, suggest
from ...model.solid import GROUND
from ...system import System

AT_POINT = re.compile(r"(?P<body>[^()]+)\((?P<place>[^()]*)\)\.(?P<axis>[xyz])")
AXES = ("x", "y", "z")
TURNS = ("turn_x", "turn_y", "turn_z")


class Measure(NamedTuple):
    """A named function of the coordinates: the element that measures it, and what kind of number that is."""

    name: str
    placed: Placed
    kind: str  # "length", "angle" or "square" (of a length)

    @property
    def measured(self) -> tuple[Any, ...]:
        """What is measured, whatever its name: the same for equal functions."""
        return self.placed.element, self.placed.bodies, repr(self.placed.values)

    @property
    def unit(self) -> str:
        """Of what the user is told."""
        return "rad" if self.kind == "angle" else "m"

    def value(self, wanted: float) -> float:
        """What the element shows for a wanted value."""
        return wanted * abs(wanted) if self.kind == "square" else wanted  # of no lowest length, -∞

    def slope(self, wanted: float) -> float:
        """The derivative of `value`."""
        return 2 * wanted if self.kind == "square" else 1.0

    def shown(self, found: Any) -> Any:
        """What the user is told for what the element shows."""
        return abs(found) ** 0.5 if self.kind == "square" else found


def measures(system: System, things: Iterable[Any]) -> list[Measure]:
    """The measures of names and functions, in their order.

    Raises
    ------
    SarrusError
        If the system has no such thing.
    """
    return [_measure(system, thing) for thing in things]


def _measure(system: System, thing: Any) -> Measure:
    if isinstance(thing, tuple) and len(thing) == 1:  # point["x"]
        thing = thing[0]
    if isinstance(thing, Function):
        return _of_function(system, thing)
    if not isinstance(thing, str):
        told = "give a name like 'pin.angle' or 'tool.x', or a function like tool.point(1, 0, 0)['x']"
        raise SarrusError(f"{thing!r} is no function of a position; {told}")
    at = AT_POINT.fullmatch(thing.replace(" ", ""))
    if at and at["body"] in system.bodies:
        return _of_function(system, _of_point(system, at["body"], at["place"], at["axis"]))
    body, _, what = thing.rpartition(".")
    if body in system.bodies and what in (*AXES, *TURNS):
        return _of_function(system, _of_body(system, body, what))
    return _of_joint(system, thing)


def _of_point(system: System, name: str, place: str, axis: Any) -> Function:
    try:
        x, y, z = (float(number) for number in place.split(","))
    except ValueError:
        raise SarrusError(f"({place}) is no point; give three numbers, as in {name}(0.1, 0, 0).x") from None
    return PointCoordinate(_body(system, name).point(x, y, z), axis, f"{name}({x:g}, {y:g}, {z:g}).{axis}")


def _body(system: System, name: str) -> Any:
    return next(body for body in system.model.bodies if body.name == name)


def _of_body(system: System, name: str, what: str) -> Function:
    body, axis = _body(system, name), cast(AxisName, what[-1])
    return PointCoordinate(body.point(0, 0, 0), axis) if what in AXES else Turn(body, axis)


def _of_function(system: System, function: Function) -> Measure:
    poses = {GROUND: GROUND_POSE, **{body.name: body.pose() for body in system.model.bodies}}
    number = {name: n for n, name in enumerate((GROUND, *system.bodies))}
    element, bodies, values, label = function.primitive(poses)
    unknown = [body for body in bodies if body not in number]
    if unknown:
        raise SarrusError(f"{function.label} is of {quote(unknown[0])}; {suggest(unknown[0], number)}")
    placed = Placed(element, tuple(number[body] for body in bodies), values, function.label, label)
    return Measure(function.label, placed, _kind(placed))


def _of_joint(system: System, name: str) -> Measure:
    known = {f"{one.owner}.{one.label}": one for one in blueprint(system.model).coordinates}
    fit = [key for key in known if name in (key, key.partition(".")[0])]
    if len(fit) != 1:
        offered = [
            *fit,
            *([] if fit else [*known, *(f"{body}.{axis}" for body in system.bodies for axis in AXES)]),
        ]
        raise SarrusError(f"there is no single function {quote(name)}; {suggest(name, offered)}")
    placed = known[fit[0]]
    return Measure(fit[0], placed, _kind(placed))


def _kind(placed: Placed) -> str:
    if placed.element is elements.Distance:
        return "square"
    return "angle" if placed.element is elements.Angle else "length"
