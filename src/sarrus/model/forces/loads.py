"""A force at a point of a body and a torque on a body, constant or varying in time."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from inspect import Signature, signature
from typing import Annotated, Any, ClassVar, NamedTuple, TypeAlias

from ... import elements
from ..arithmetic import Numeric
from ..checks.names import find
from ..coordinate import ANGLE
from ..errors import ModelError
from ..expression import Expression
from ..geometry.points import Axes, Point, Solid
from ..geometry.pose import Poses
from ..laws.curve import Curve, Formula
from ..laws.law import Law, scaled, varies
from ..measure import In
from ..parity import declared
from ..primitive import Primitive
from ..quantity import Vec3, Vector, is_list, vector
from ..show import show
from ..signals import Measure, Signals
from .by_formula import ByFormula, WithParameters, has_three
from .force import Force, choose, refuse_ground
from .formula_element import Spot, Target, WholeBody, body_force, body_torque, global_force, global_torque

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
    if not (has_three(load) and any(varies(part) for part in load)):
        numbers = [_number(part, field) for part in load] if has_three(load) else load
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


@dataclass(frozen=True)
class Component:
    """A component of a function that returns three."""

    function: Callable[..., Sequence[Numeric]]
    n: int

    @property
    def __signature__(self) -> Signature:
        return signature(self.function)

    def __call__(self, *given: Any) -> Any:
        """Return the component.

        Raises
        ------
        TypeError
            If the function returns anything else than three values.
        """
        found = self.function(*given)
        count = len(found) if is_list(found) else 1
        if count != 3:
            raise TypeError(
                f"it returns {count} of three components. Return all, as lambda t: (0, 5*sin(t), 0)."
            )
        return found[self.n]


def components_of(load: Any) -> Any:
    """Return three functions for one that returns three components; anything else as it is."""
    return tuple(Component(load, n) for n in range(3)) if callable(load) else load


@dataclass(frozen=True, eq=False)
class PointForce(WithParameters, Force):
    """A ``force`` [N] at ``point``, in global axes, or in body axes: it follows the body.

    Parameters
    ----------
    point
        Where it acts.
    force
        Three components; each a number, a law over time [s], or a formula of outputs and ``t``,
        ``"-c*boat.velocity.x*abs(boat.velocity.x)"``, or a function ``lambda o: -2*o["boat.velocity.x"]``. In Python
        also one function that returns all three, ``lambda t: (0, 5*sin(t), 0)``.
    axes
        "global" or "body".
    factor
        A number or a law that multiplies the force: a magnitude, if ``force`` is a direction.
    parameters
        Constants by name for formulas of outputs.
    """

    parity = declared(force="polar")

    point: Point
    force: Annotated[Load, In("N", over="s", outputs=True)]
    axes: Axes = "global"
    factor: Annotated[Law, In("1", over="s", outputs=True)] = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "force", components_of(self.force))

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the point force or the follower force."""
        point = self.point.resolve(poses, "point")
        refuse_ground(point.body, "point")
        self.checked_parameters()
        if self.depends_on_outputs(self.force, self.factor):
            return
        force, curves = history(self.force, self.factor, "force")
        constant = choose(self.axes, of_global=elements.PointForce, of_body=elements.FollowerForce)
        varying = choose(self.axes, of_global=elements.VaryingForce, of_body=elements.VaryingFollowerForce)
        element: type[elements.Element] = varying if curves else constant
        yield Primitive(element, (point.body,), (point.s, force, *curves), "force")

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        """Yield the force that depends on outputs."""
        if self.depends_on_outputs(self.force, self.factor):
            point = self.point.resolve(signals.poses, "point")
            act = choose(self.axes, of_global=global_force, of_body=body_force)
            target = Target(Measure(Spot, (point.body,), (point.s,)), act)
            yield self.vector_load(target, self.force, self.factor, "force", "N", signals)


@dataclass(frozen=True, eq=False)
class Torque(ByFormula, Force):
    """A torque [N m]: a vector on a ``body``, or a ``value`` about the axis of a ``joint``.

    A torque on a joint acts on its second body, and the opposite torque on the first; a positive value increases the
    angle.

    Parameters
    ----------
    body
        On which a vector acts; in Python also the name of the joint.
    torque
        Three components; each a number, a law over time [s], or a formula of outputs, as of a `PointForce`.
    axes
        "global" or "body".
    factor
        A number or a law that multiplies the torque.
    joint
        A joint by name, ``pin``, or if it has several angles ``hook.angle_i``; x is the angle of its second body [rad],
        with its revolutions.
    value
        As of a `Force`: ``"(T0 - k*crank_pin.rate)*step(t, 0, 0, 0.1, 1)"``, a function, or a motor's curve as a table,
        with ``over="crank_pin.rate"``.
    """

    parity = declared(torque="axial")

    body: Solid | str | None = None
    torque: Annotated[Load | None, In("N m", over="s", outputs=True)] = None
    axes: Axes = "global"
    factor: Annotated[Law, In("1", over="s", outputs=True)] = 1.0
    joint: str | None = field(default=None, kw_only=True)
    unit: ClassVar[str] = "N m"

    def __post_init__(self) -> None:
        if isinstance(self.body, str) and self.value is not None and self.joint is None:
            object.__setattr__(self, "joint", self.body)
            object.__setattr__(self, "body", None)
        object.__setattr__(self, "torque", components_of(self.torque))

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the torque on a body that depends on nothing but the time."""
        body = self._checked_body(poses)
        if not body or self.depends_on_outputs(self.torque, self.factor):
            return
        torque, curves = history(self.torque, self.factor, "torque")
        constant = choose(self.axes, of_global=elements.Torque, of_body=elements.BodyTorque)
        varying = choose(self.axes, of_global=elements.VaryingTorque, of_body=elements.VaryingBodyTorque)
        element: type[elements.Element] = varying if curves else constant
        yield Primitive(element, (body,), (torque, *curves), "torque")

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        """Yield the torque on a joint, or the one that depends on outputs."""
        if self.joint is not None:
            yield self.on_joint(self.joint, ANGLE, signals, self.factor)
        elif self.depends_on_outputs(self.torque, self.factor):
            body = self._checked_body(signals.poses)
            act = choose(self.axes, of_global=global_torque, of_body=body_torque)
            target = Target(Measure(WholeBody, (body,), ()), act)
            yield self.vector_load(target, self.torque, self.factor, "torque", "N m", signals)

    def _checked_body(self, poses: Poses) -> str:
        """Return the body that a vector acts on, or nothing if a joint is named."""
        self.checked_parameters()
        vector_given, value_given = self.torque is not None, self.value is not None
        if (self.joint is not None) + (self.body is not None) != 1:
            raise ModelError("must have a body or a joint. Give one of them.", field="joint")
        if vector_given and isinstance(self.body, str):
            message = (
                f"body must be a body, but is {show(self.body)}. Give the Body object (or sarrus.ground)."
            )
            raise ModelError(message, field="body")
        if vector_given == value_given or (self.joint is not None) == vector_given:
            message = (
                "needs torque, three components, on a body; or value, a formula, on a joint. Give this pair."
            )
            raise ModelError(message, field="torque")
        if not isinstance(self.body, Solid):
            return ""
        find(self.body.name, poses, "body")
        refuse_ground(self.body.name, "body")
        return self.body.name
