"""Where a vehicle is along a path, and how far from it: what a driver who steers needs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import Annotated, Any, NamedTuple

from ..._jit.formulas.expression import Expression as Recorded
from ...functions import sqrt
from ..errors import ModelError
from ..forces.by_formula import WithParameters
from ..forces.force import Force
from ..laws.path import Quintic, lengths, spline
from ..laws.recorded import Recording
from ..measure import In
from ..primitive import Primitive
from ..quantity import is_list, number, numbers, positive
from ..show import show
from ..signals import Signals
from ..tape import value_of
from .block import StateValue, WithNominal, rate_loads

POINTS = "Give a list of at least two points [x, y] in m."


class Place(NamedTuple):
    """The place on the path, relative to the point that follows it: r', r'', and the point less r."""

    tangent: tuple[Recorded, Recorded]
    bend: tuple[Recorded, Recorded]
    apart: tuple[Recorded, Recorded]

    @property
    def speed(self) -> Recorded:
        """|r'|."""
        found: Recorded = sqrt(dot(self.tangent, self.tangent))
        return found


def dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    """Scalar product in the plane."""
    return a[0] * b[0] + a[1] * b[1]


def cross(a: Sequence[Any], b: Sequence[Any]) -> Any:
    """Vector product in the plane, positive if b is on the left of a."""
    return a[0] * b[1] - a[1] * b[0]


@dataclass(frozen=True, eq=False)
class PathFollower(WithParameters, WithNominal, Force):
    """The place of a point of a vehicle along a path in the plane of x and y, by a state u.

    The path r(u) is the quintic spline through points, over the length u of the lines between them, continued by its
    tangents, with r'' = r''' = 0 at its ends. u is the place nearest to the point p: g = (p − r) · r' = 0, with
    ġ = −return_rate · g, which is

        u̇ = (ṗ · r' + return_rate · g) / (r' · r' − (p − r) · r'').

    Outputs: ``name.progress`` is u [m]; ``name.deviation`` is the distance of p from the path, positive on its left
    [m]; ``name.curvature`` is that of the path, positive to the left [1/m]. A driver who looks ahead is a formula of
    them for a point in front of the vehicle, such as a steering angle ``-0.2*path.deviation + 2.7*path.curvature``. The
    point must not come to the centre of curvature of the path, for which no place is the nearest.

    Parameters
    ----------
    point
        Which follows, as outputs name it: ``"chassis"``, or ``"chassis(5, 0, 0)"`` for one 5 m in front of its origin.
    path
        Points [x, y] [m].
    initial
        u at the start of a run [m].
    return_rate
        [1/s] With which u returns to the nearest place after errors of integration.
    """

    point: str
    path: Annotated[Sequence[Sequence[float]], In("m")]
    initial: Annotated[float, In("m")] = 0.0
    return_rate: Annotated[float, In("s^-1")] = 50.0

    def states(self) -> Iterator[StateValue]:
        yield StateValue(self._state, number(self.initial, "initial"), "m", self.state_size())

    @property
    def _state(self) -> str:
        return f"{self.name}.progress"

    def variables(self) -> Iterator[tuple[str, Any]]:
        curves = cache(self._curves)
        yield f"{self.name}.deviation", lambda r: _deviation(self._place(r, curves()))
        yield f"{self.name}.curvature", lambda r: _curvature(self._place(r, curves()))

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        """Yield the load of the rate of u."""
        point: Any = self.point
        if not isinstance(point, str):
            message = f"point must be the text of a body, or of a point of one, but is {show(point)}"
            raise ModelError(f'{message}. Give one such as "chassis(5, 0, 0)".', field="point")
        r = Recording("point", {}, self.checked_parameters(), variables=signals.variables)
        place = self._place(r, self._curves())
        velocity = [r.named(f"{self.point}.velocity.{axis}") for axis in "xy"]
        back = r.number(positive(self.return_rate, "return_rate", "Give a rate in 1/s."))
        closing = dot(velocity, place.tangent) + back * dot(place.apart, place.tangent)
        rate = closing / (dot(place.tangent, place.tangent) - dot(place.apart, place.bend))
        outputs = {"deviation": (_deviation(place), "m"), "curvature": (_curvature(place), "1/m")}
        yield from rate_loads([self._state], [rate], r, signals, outputs=outputs)

    def _place(self, r: Recording, curves: tuple[Quintic, Quintic]) -> Place:
        u = r.named(self._state)
        s = r.looked_up(curves[0].offset(), u)
        at, tangent, bend = zip(*(_derivatives(r, curve, u, s) for curve in curves), strict=True)
        x, y = (r.named(f"{self.point}.{axis}") for axis in "xy")
        return Place(tangent, bend, (x - at[0], y - at[1]))

    def _curves(self) -> tuple[Quintic, Quintic]:
        """X(u) and y(u).

        Raises
        ------
        ModelError
            If these are not at least two points, or two neighbours are equal.
        """
        if not is_list(self.path) or len(self.path) < 2:
            given = "has fewer than two" if is_list(self.path) else f"is {show(self.path)}"
            raise ModelError(f"path must be a list of points, but {given}. {POINTS}", field="path")
        points = [numbers(point, 2, "path", POINTS) for point in self.path]
        for before, after in pairwise(points):
            place = [float(value_of(coordinate)) for coordinate in before]
            if place == [value_of(coordinate) for coordinate in after]:
                message = f"path has the point [{place[0]:g}, {place[1]:g}] twice"
                raise ModelError(f"{message}. Remove one of them.", field="path")
        u = lengths(points)
        x, y = (spline(u, values) for values in zip(*points, strict=True))
        return x, y


def _derivatives(r: Recording, curve: Quintic, u: Recorded, s: Recorded) -> tuple[Recorded, ...]:
    """A coordinate of the path with its first and second derivative, s from the last knot."""
    c4, c5 = r.looked_up(curve.fourth, u), r.looked_up(curve.fifth, u)
    value, slope = (r.looked_up(curve.cubic, u, function) for function in ("curve", "curve_slope"))
    return (
        value + s**4 * (c4 + c5 * s),
        slope + s**3 * (4 * c4 + 5 * c5 * s),
        r.looked_up(curve.second(), u) + s**2 * (12 * c4 + 20 * c5 * s),
    )


def _deviation(place: Place) -> Recorded:
    """(p − r) · n."""
    found: Recorded = cross(place.tangent, place.apart) / place.speed
    return found


def _curvature(place: Place) -> Recorded:
    """(x' y'' − y' x'') / |r'|³."""
    found: Recorded = cross(place.tangent, place.bend) / place.speed**3
    return found
