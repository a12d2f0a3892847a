"""Base class of couplings: a relation between the coordinates of two named joints."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ... import elements
from ...elements import Element
from ..coordinate import ANGLE, Coordinate
from ..errors import ModelError
from ..pose import Poses
from ..primitive import Primitive
from ..quantity import number
from .joint import Joint


@dataclass(frozen=True, eq=False)
class Coupling(Joint, abstract=True):
    """A part among the joints that couples the coordinates of two others; it has no primitives without them.

    Its reaction is a generalized force along both coordinates: a torque about the axis of a joint with an angle, a
    force along the axis of one with a travel, on the second body of each joint and with opposite sign on the first.
    It is ideal: teeth press on no bearing. Reported is the reaction on the joint that follows.
    """

    @property
    def follower(self) -> str:
        """The joint, or its coordinate, that follows the other."""
        raise NotImplementedError

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield nothing."""
        yield from ()


def ratio_of(value: object, field: str = "ratio") -> float:
    """Return a ratio that is not 0."""
    ratio = number(value, field)
    if not ratio:
        raise ModelError(f"{field} must not be 0; give the second coordinate over the first", field=field)
    return ratio


def coupled(first: Coordinate, second: Coordinate, ratio: float, offset: float | None) -> Primitive:
    """Second = ratio · first + offset; without an offset, as it is in the initial pose."""
    shift = second.start - ratio * first.start if offset is None else number(offset, "offset")
    kinds = first.measure.element is ANGLE, second.measure.element is ANGLE
    if kinds == (True, True):
        return _relation(elements.AngleAngle, first, second, (ratio, shift, first.start))
    if kinds == (False, True):
        return _relation(elements.TravelAngle, first, second, (1 / ratio, -shift / ratio))
    if kinds == (True, False):
        return _relation(elements.TravelAngle, second, first, (ratio, shift))
    return _relation(elements.TravelTravel, first, second, (ratio, shift))


def _relation(element: type[Element], a: Coordinate, b: Coordinate, values: tuple[float, ...]) -> Primitive:
    bodies = (*a.measure.bodies, *b.measure.bodies)
    return Primitive(element, bodies, (*a.measure.values[:3], *b.measure.values[:3], *values), "coupling")
