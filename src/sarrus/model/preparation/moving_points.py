"""Points of the ground that move by a formula: a shaker, a road under a test rig.

``sr.ground.point(0, 0, "0.1*sin(t)")`` becomes the origin of a massless body that a driver moves without rotation, when
a model is created. All analyses and derivatives are then those of bodies and drivers.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, fields, is_dataclass, replace
from typing import Any, NamedTuple

from ..bodies.body import Body
from ..checks.findings import Path
from ..drivers import Driver
from ..drivers.driver import PointDriver
from ..errors import ModelError
from ..expression import Expression, parse
from ..geometry.points import Frame, Ground, Point, ground
from ..joints import Joint
from ..joints.conditions import Cartesian
from ..laws.curve import Curve, Formula, Tree
from ..laws.jumps import TIME
from ..laws.law import motion_of
from ..quantity import is_list
from ..show import quote

AXES = ("x", "y", "z")


class Carrier(NamedTuple):
    """A body that is moved, and what moves it."""

    body: Body
    guide: Joint
    driver: Driver


@dataclass
class Carriers:
    """Carriers of the moving points of a model; parts that have the same point share one.

    ``constants`` are the formulas of constant coordinates that parameters give, by their places in drivers.
    """

    names: frozenset[str]
    found: dict[int, Carrier] = field(default_factory=dict)
    constants: dict[Path, Expression] = field(default_factory=dict)

    def replaced(self, part: Any) -> Any:
        """Return a part whose moving points are on carriers; the same object if it has none.

        Raises
        ------
        ModelError
            If a point moves by something that is no function of the time.
        """
        if not is_dataclass(part.__class__):
            return part
        name = str(getattr(part, "name", ""))
        values = {one.name: getattr(part, one.name, None) for one in fields(part)}
        changed = {one: self._value(name, one, value) for one, value in values.items()}
        changed = {one: value for one, value in changed.items() if value is not values[one]}
        changed |= self._place(name, part)
        return replace(part, **changed) if changed else part

    def _value(self, part: str, field: str, value: Any) -> Any:
        """A point or frame on a carrier, if it moves with the ground; of a list, with those among its entries."""
        if isinstance(value, list | tuple) and any(isinstance(one, Point) for one in value):
            points = [self._value(part, f"{field}_{n}", one) for n, one in enumerate(value, 1)]
            return points if any(a is not b for a, b in zip(points, value, strict=True)) else value
        if isinstance(value, Frame):
            point = self._value(part, field, value.point)
            return value if point is value.point else replace(value, point=point)
        if not isinstance(value, Point) or not moves(value.coordinates):
            return value
        if not isinstance(value.body, Ground):
            raise ModelError(
                f"{field} moves, but its body {quote(str(getattr(value.body, 'name', '')))} is not the ground. Give "
                "numbers, or a point of sarrus.ground.",
                field=field,
            )
        return self._carrier(f"{part}_{field}", id(value), value.coordinates).body.point(0, 0, 0)

    def _place(self, name: str, part: Any) -> dict[str, Any]:
        """The bodies and the initial point of a joint whose global point moves with the ground."""
        point = getattr(part, "point", None)
        bodies = [one for one in ("body_i", "body_j") if isinstance(getattr(part, one, None), Ground)]
        if isinstance(point, Point) or not moves(point):
            return {}
        if not bodies:
            message = "point moves, but none of its bodies is the ground. Give numbers"
            raise ModelError(f"{message}, or connect it with sarrus.ground.", field="point")
        body = self._carrier(f"{name}_point", id(point), point).body
        return {bodies[0]: body, "point": body.position}

    def _carrier(self, name: str, key: int, path: Any) -> Carrier:
        if key not in self.found:
            laws = [motion_of(law, "point", states=False) for law in path]
            start = tuple(law.factor * law.curve(0.0) for law in laws)
            while name in self.names:
                name += "_"
            body = Body(name, 0.0, (0.0, 0.0, 0.0), position=start)
            guide = Cartesian(f"{name}_guide", ground, body, point=start, axis=(0.0, 0.0, 1.0))
            motion = f"{name}_motion"
            given = {
                axis: self._constant(("drivers", motion, axis), one)
                for axis, one in zip(AXES, path, strict=True)
            }
            self.found[key] = Carrier(body, guide, PointDriver(motion, body.point(0, 0, 0), **given))
        return self.found[key]

    def _constant(self, place: Path, value: Any) -> Any:
        """The number of a formula of parameters alone, which is stored for its derivatives; anything else as it is."""
        tree = (
            value.function.tree if isinstance(value, Formula) and isinstance(value.function, Tree) else None
        )
        if tree is None or tree.names():
            return value
        self.constants[place] = tree
        return float(tree.value())


def moves(place: Any) -> bool:
    """Return whether one of three coordinates is a function of the time."""
    return is_list(place) and len(place) == 3 and any(_varies(one) for one in _entries(place))


def _entries(place: Any) -> Iterable[Any]:
    return place if isinstance(place, list | tuple) else ()


def _varies(value: Any) -> bool:
    if isinstance(value, str):
        try:
            value = parse(value)
        except ModelError:
            return False  # it is refused as a number
    if isinstance(value, Expression):
        return TIME in value.names()
    return isinstance(value, Curve | Formula) or callable(value) or is_list(value)
