"""Resistance of a fluid: quadratic at a point, or viscous."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

from .... import elements
from ....algebra import Row
from ....elements import Single, output
from ....elements.element import Scalar, Vec3
from ...geometry.point import LocalPoint, Point
from ...geometry.pose import Poses
from ...laws.law import Law, scaled, varies
from ...laws.recorded import Recording
from ...measure import In, Velocity
from ...primitive import Primitive
from ...quantity import not_negative, regularization, vector
from ...signals import Measure, Signal, Signals
from ..force import Force, refuse_ground
from ..formula_element import FormulaLoad, Target, load_primitive

SPEED = "speed"


class DragLoad(FormulaLoad, abstract=True):
    """Base of the classes of drags by laws: their power is dissipated, but for that of the wind."""

    def _drag(self, x: Any, v: Any, t: Scalar) -> tuple[elements.Drag, Any, Any]:
        last = len(self.structure.parts) - 1
        drag = self._measures()[-1].drag(self.values(x, v, t)[0])
        return drag, self._local(last, x), self._local(last, v)

    @output("m/s")
    def speed(self, x: Any, v: Any) -> Scalar:
        """sqrt(u·u + creep²)."""
        last = len(self.structure.parts) - 1
        return self._measures()[-1].speed(self._local(last, x), self._local(last, v))

    def dissipated_power(self, x: Any, v: Any, t: Scalar) -> Scalar:
        """-F·u."""
        drag, own, rates = self._drag(x, v, t)
        return drag.dissipated_power(own, rates, t)

    def supplied_power(self, x: Any, v: Any, t: Scalar) -> Scalar:
        """Of the wind, F·wind."""
        drag, own, rates = self._drag(x, v, t)
        return drag.supplied_power(own, rates, t)


@dataclass(frozen=True)
class Resisted:
    """A point of a body that moves through a wind."""

    fields: ClassVar[dict[str, str]] = {"s": "Vec3", "wind": "Vec3", "creep": "Scalar"}
    bodies: ClassVar[int] = 1
    load: ClassVar[type[FormulaLoad]] = DragLoad

    s: Vec3  # [m] in the body
    wind: Vec3  # [m/s] in global axes
    creep: Scalar  # [m/s]

    def drag(self, c: Scalar) -> elements.Drag:
        """The drag with a coefficient."""
        return elements.Drag(self.s, c, self.wind, self.creep)

    def speed(self, x: Single, v: Single) -> Scalar:
        """sqrt(u·u + creep²)."""
        return self.drag(0).speed(x, v)


def resistance(of: Resisted, values: Any, x: Single, v: Single, t: Scalar) -> Row:
    """Q of the drag with the coefficient that a law gives."""
    return of.drag(values[0]).Q(x, v, t)


@dataclass(frozen=True, eq=False)
class Drag(Force):
    """Quadratic drag: force −c |u| u at ``point``, with u its velocity through the air.

    Parameters
    ----------
    point
        The centre of pressure.
    c
        Half of density, area and drag coefficient [N s²/m²], or a law over the speed |u| [m/s], as of a sphere whose
        drag coefficient falls: a formula of ``x``, a table, or a Python function.
    wind
        Velocity of the air in global axes [m/s].
    creep
        [m/s] |u| is √(u² + creep²), so that the law has all its derivatives at rest.
    """

    point: Point
    c: Annotated[Law, In("N s^2/m^2", over="m/s")]
    wind: Velocity = (0.0, 0.0, 0.0)
    creep: Annotated[float, In("m/s")] = 1e-3

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the drag with a constant coefficient."""
        point, wind, creep = self._checked(poses)
        if not varies(self.c):
            c = not_negative(scaled(self.c, "c").factor, "c", "Give it in N s²/m².")
            yield Primitive(elements.Drag, (point.body,), (point.s, c, wind, creep), "drag")

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        """Yield the drag whose coefficient is a law of the speed."""
        if varies(self.c):
            point, wind, creep = self._checked(signals.poses)
            measure = Measure(Resisted, (point.body,), (point.s, wind, creep))
            scaled(self.c, "c")  # refuses what is no function of one variable
            recording = Recording("c", {"x": SPEED}, {})
            c = recording.law(self.c, "x")
            speed = [Signal(measure, SPEED, 2, 0, "m/s")] * len(recording.signals)
            yield load_primitive(Target(measure, resistance), [c], recording, speed)

    def _checked(self, poses: Poses) -> tuple[LocalPoint, Any, float]:
        point = self.point.resolve(poses, "point")
        refuse_ground(point.body, "point")
        creep = regularization(self.creep)
        return point, vector(self.wind, "wind"), creep


@dataclass(frozen=True, eq=False)
class ViscousDrag(Force):
    """A force −c v at ``point``, v its velocity, and a torque −c_turn ω, as in a thick fluid.

    Parameters
    ----------
    point
        Where the force acts.
    c
        [N s/m]
    c_turn
        [N m s/rad]
    """

    point: Point
    c: Annotated[float, In("N s/m")] = 0.0
    c_turn: Annotated[float, In("N m s/rad")] = 0.0

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the drag."""
        point = self.point.resolve(poses, "point")
        refuse_ground(point.body, "point")
        c, c_turn = (
            not_negative(self.c, "c", "Give it in N s/m."),
            not_negative(self.c_turn, "c_turn", "Give N m s/rad."),
        )
        yield Primitive(elements.ViscousDrag, (point.body,), (point.s, c, c_turn), "drag")
