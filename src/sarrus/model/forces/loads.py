"""A force at a point of a body and a torque on a body, constant or varying in time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple, TypeAlias

from ... import elements
from ..checks.names import find
from ..errors import ModelError
from ..expression import Expression
from ..geometry.point import Axes, Point
from ..geometry.pose import Poses
from ..geometry.solid import Solid
from ..laws.curve import Curve, Formula
from ..laws.law import Law, scaled, varies
from ..measure import In
from ..primitive import Primitive
from ..quantity import Vec3, Vector, is_list, vector
from .force import Force, choose, refuse_ground

Load: TypeAlias = Vector | Sequence[Law]


class History(NamedTuple):
    """A vector, and for its three components the curves over time that scale them; none if it is constant."""

    vector: Vec3
    curves: tuple[Curve | Formula, ...]


def history(load: Any, factor: Any, field: str) -> History:
    """Return the vector ``factor`` times ``load``, of which one or the other may vary.

    Raises
    ------
    ModelError
        If both vary, or if a number or curve of them is wrong.
    """
    if not (_has_three(load) and any(varies(part) for part in load)):
        numbers = [_number(part, field) for part in load] if _has_three(load) else load
        return _by_factor(vector(numbers, field), factor)
    if varies(factor):
        message = (
            f"has both a factor and components of its {field} that vary in time. Leave one of them constant."
        )
        raise ModelError(message, field="factor")
    parts, size = [scaled(part, field, "t") for part in load], scaled(factor, "factor", "t").factor
    x, y, z = (size * part.factor for part in parts)
    return History((x, y, z), tuple(part.curve for part in parts))


def _by_factor(load: Vec3, factor: Any) -> History:
    size, curve = scaled(factor, "factor", "t")
    if varies(factor):
        return History(load, (curve,) * 3)
    x, y, z = (size * part for part in load)
    return History((x, y, z), ())


def _number(value: Any, field: str) -> Any:
    """A number that was given as a formula; `vector` checks all others."""
    return scaled(value, field, "t").factor if isinstance(value, str | Expression) else value


def _has_three(load: Any) -> bool:
    return is_list(load) and len(load) == 3


@dataclass(frozen=True, eq=False)
class PointForce(Force):
    """A ``force`` [N] at ``point``, in global axes, or in body axes: it follows the body.

    Parameters
    ----------
    point
        Where it acts.
    force
        Three components; each a number, or a law over time [s].
    axes
        "global" or "body".
    factor
        A number, or a law over time [s], that scales the force: a magnitude, where ``force`` is a direction.
    """

    point: Point
    force: Annotated[Load, In("N", over="s")]
    axes: Axes = "global"
    factor: Annotated[Law, In("1", over="s")] = 1.0

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the point force or the follower force."""
        point = self.point.resolve(poses, "point")
        refuse_ground(point.body, "point")
        force, curves = history(self.force, self.factor, "force")
        element = choose(self.axes, of_global=elements.PointForce, of_body=elements.FollowerForce)
        if curves:
            element = choose(
                self.axes, of_global=elements.VaryingForce, of_body=elements.VaryingFollowerForce
            )
        yield Primitive(element, (point.body,), (point.s, force, *curves), "force")


@dataclass(frozen=True, eq=False)
class Torque(Force):
    """A ``torque`` [N m] on ``body``, in global axes, or in body axes: it follows the body.

    Parameters
    ----------
    body
        On which it acts.
    torque
        Three components; each a number, or a law over time [s].
    axes
        "global" or "body".
    factor
        A number, or a law over time [s], that scales the torque.
    """

    body: Solid
    torque: Annotated[Load, In("N m", over="s")]
    axes: Axes = "global"
    factor: Annotated[Law, In("1", over="s")] = 1.0

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the torque."""
        find(self.body.name, poses, "body")
        refuse_ground(self.body.name, "body")
        torque, curves = history(self.torque, self.factor, "torque")
        element = choose(self.axes, of_global=elements.Torque, of_body=elements.BodyTorque)
        if curves:
            element = choose(self.axes, of_global=elements.VaryingTorque, of_body=elements.VaryingBodyTorque)
        yield Primitive(element, (self.body.name,), (torque, *curves), "torque")
