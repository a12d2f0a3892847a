"""Couplings: coordinates of named joints are proportional, as with gears, or one is a function, as of a cam."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Annotated, ClassVar

from ... import elements
from ...elements import Element
from ..coordinate import ANGLE, DISPLACEMENT, Coordinate, Known, chosen
from ..errors import ModelError
from ..forces.by_formula import WithParameters, refuse_other_than_positions
from ..forces.formula_element import constraint_primitive
from ..geometry.pose import Poses
from ..laws.law import Law
from ..laws.recorded import Recording
from ..measure import Angle, In, Length, Ratio
from ..primitive import Primitive
from ..quantity import number
from ..signals import Signals
from .joint import Joint


@dataclass(frozen=True, eq=False)
class Coupling(Joint, abstract=True):
    """A part among the joints that couples the coordinates of two others; it has no primitives without them.

    Its reaction is a generalized force along both coordinates: a torque about the axis of a joint with an angle, a
    force along the axis of one with a displacement, on the second body of each joint and with opposite sign on the
    first. It is ideal: teeth press on no bearing. Reported is all that it does to the second body of the joint that
    follows, and by `torque_on.wheel.x` and the like to any body.
    """

    @property
    def follower(self) -> str:
        """The joint, or its coordinate, that follows the other."""
        raise NotImplementedError

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        yield from ()


def refuse_same(i: Coordinate, j: Coordinate, names: tuple[str, str]) -> None:
    """Raise a ModelError if both coordinates of a coupling are one."""
    if i is j:
        raise ModelError(f"{names[0]} and {names[1]} are the same. Couple two joints.", field=names[1])


def ratio_of(value: object, field: str = "ratio") -> float:
    """Return a ratio that is not 0."""
    ratio = number(value, field)
    if not ratio:
        raise ModelError(f"{field} must not be 0. Give the second coordinate over the first.", field=field)
    return ratio


def coupled(first: Coordinate, second: Coordinate, ratio: float, offset: float | None) -> Primitive:
    """Second = ratio · first + offset; without an offset, as it is in the design position."""
    shift = second.start - ratio * first.start if offset is None else number(offset, "offset")
    kinds = first.measure.element is ANGLE, second.measure.element is ANGLE
    if kinds == (True, True):
        return _relation(elements.AngleAngle, first, second, (ratio, shift, first.start))
    if kinds == (False, True):
        return _relation(elements.DisplacementAngle, first, second, (1 / ratio, -shift / ratio))
    if kinds == (True, False):
        return _relation(elements.DisplacementAngle, second, first, (ratio, shift))
    return _relation(elements.DisplacementDisplacement, first, second, (ratio, shift))


def _relation(element: type[Element], a: Coordinate, b: Coordinate, values: tuple[float, ...]) -> Primitive:
    bodies = (*a.measure.bodies, *b.measure.bodies)
    return Primitive(element, bodies, (*a.measure.values[:3], *b.measure.values[:3], *values), "coupling")


@dataclass(frozen=True, eq=False)
class Coupler(Coupling):
    """Coordinate of ``joint_j`` = ``ratio`` · coordinate of ``joint_i`` + ``offset``, as numbers in m and rad.

    Coordinates are given as ``slide.displacement``, ``pin.angle``, or by the joint's name if it has only one.
    By default, the offset is that of the design position.

    Its reaction, `run.reaction`, is the torque or force along the coordinate of ``joint_j`` on the second body of that
    joint; along the coordinate of ``joint_i`` it is multiplied by -``ratio``. No other load is transmitted to bearings.
    """

    joint_i: str
    joint_j: str
    ratio: Ratio
    offset: Ratio | None = None
    kind: ClassVar[type[Element] | None] = None  # of both coordinates

    @property
    def follower(self) -> str:
        """The second joint."""
        return self.joint_j

    def relations(self, known: Known) -> Iterator[Primitive]:
        """Yield the second coordinate - ratio · the first - offset."""
        i, j = (chosen(getattr(self, name), self.kind, known, name) for name in ("joint_i", "joint_j"))
        refuse_same(i, j, ("joint_i", "joint_j"))
        yield coupled(i, j, ratio_of(self.ratio), self.offset)


@dataclass(frozen=True, eq=False)
class Gear(Coupler):
    """Angle of ``joint_j`` = ``ratio`` · angle of ``joint_i`` + ``offset`` [rad], revolutions included.

    The joints are given by name, ``pin``, or if one has several angles ``hook.angle_i``. By default, the offset is
    that of the design position. External spur gears with axes of the same direction have a negative ratio.
    In a planetary gear the angles are those relative to the carrier: connect the sun, each planet and the ring with
    it by a revolute, carrier first, even where the sun or the ring has another joint with the ground.

    Its reaction, `run.reaction`, is the torque on the second body of ``joint_j``; the second body of ``joint_i``
    receives -``ratio`` times this torque, and the first bodies the opposite ones. Only torques are transmitted: the
    bearings of the wheels carry no radial or tangential tooth force.
    """

    offset: Angle | None = None
    kind = ANGLE


@dataclass(frozen=True, eq=False)
class RackAndPinion(Coupling):
    """Displacement of ``rack`` = ``radius`` [m] · angle of ``pinion`` + ``offset`` [m], revolutions included.

    The joints are given by name, ``pin``, or where one has several angles ``hook.angle_i``. The sign of the radius
    is that of the displacement. By default, the offset is that of the design position.

    Its reaction, `run.reaction`, is the force on the second body of ``rack`` along the displacement; the second body of
    ``pinion`` receives the torque -``radius`` times this force. The tooth force is not transmitted to the bearing of
    the pinion, and causes no moment on the rack.
    """

    rack: str
    pinion: str
    radius: Length
    offset: Length | None = None

    @property
    def follower(self) -> str:
        """The rack."""
        return self.rack

    def relations(self, known: Known) -> Iterator[Primitive]:
        """Yield displacement - radius θ - offset."""
        pinion = chosen(self.pinion, ANGLE, known, "pinion")
        yield coupled(
            pinion,
            chosen(self.rack, DISPLACEMENT, known, "rack"),
            ratio_of(self.radius, "radius"),
            self.offset,
        )


@dataclass(frozen=True, eq=False)
class FormulaCoupler(WithParameters, Coupling):
    """Coordinate of ``joint`` = ``value``, a formula of coordinates of other joints, as numbers in m and rad.

    Its reaction is all that it does to the second body of ``joint``: along the coordinate of ``joint``, and along those
    that the formula contains, as of a bead on a rail, ``slide.displacement_y`` over ``slide.displacement_x``.

    Parameters
    ----------
    joint
        The joint that follows, by name, or one of its coordinates, ``hook.angle_i``.
    value
        A formula such as ``"0.01*sin(3*crank) + 0.5*slide"``, a function, or a table over what ``over`` names, as of a
        cam.
    over
        For a table: a coordinate, or a formula.
    """

    joint: str
    value: Annotated[Law | None, In("", outputs=True)] = field(default=None, kw_only=True)
    over: str = field(default="", kw_only=True)

    @property
    def follower(self) -> str:
        """The joint whose coordinate the formula gives."""
        return self.joint

    def relations(self, known: Known) -> Iterator[Primitive]:
        """Yield the coordinate - value."""
        if self.value is None:
            raise ModelError("value is missing. Give a formula, a function or a table.", field="value")
        own, _, _ = self.joint.partition(".")
        coordinate = chosen(self.joint, None, known, "joint")
        recording = Recording("value", {}, self.checked_parameters())
        law = recording.named(f"{own}.{coordinate.name}") - recording.law(self.value, self.over)
        found = Signals({}, known, {}).of(recording)
        refuse_other_than_positions(recording, found, "a coupler depends on positions only")
        yield constraint_primitive(law, recording, found)
