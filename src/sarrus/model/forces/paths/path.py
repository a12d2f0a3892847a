"""Path of a tendon: the sum of factors times lengths of segments, or times coordinates of joints."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

import numpy as np

from ....algebra import Block, Row, scaled
from ....elements import Pair
from ....elements.element import Scalar
from ...errors import ModelError
from ...geometry.placement import points_apart
from ...geometry.points import LocalPoint, Point
from ...measure import In
from ...quantity import is_list, number
from ...show import show
from ...signals import Measure, MeasureClass, Signal, Signals
from ..formula_element import Line, along_coordinate
from ..springs import along_joint
from .wrapping import Wrap

ONE = np.array([1])  # unit load


class PathKind(NamedTuple):
    """The kind of a path: the kinds of its parts, segments or joint coordinates."""

    parts: tuple[Any, ...]

    @property
    def fields(self) -> Mapping[str, str]:
        """The kinds of the fields by name: those of the parts, their factors, and a constant length."""
        found = {
            f"{name}_{n}": kind for n, part in enumerate(self.parts) for name, kind in part.fields.items()
        }
        return found | {f"factor_{n}": "Scalar" for n in range(len(self.parts))} | {"start": "Scalar"}

    def __call__(self, *values: Any) -> Path:
        """Return the path with these values of its fields."""
        at, measures = 0, []
        for part in self.parts:
            measures.append(part(*values[at : at + len(part.fields)]))
            at += len(part.fields)
        return Path(self, measures, values[at:-1], values[-1])


class Path(NamedTuple):
    """A path: its parts, their factors, and a constant length."""

    kind: PathKind
    measures: list[Any]
    factors: tuple[Any, ...]
    start: Any

    @property
    def fields(self) -> Mapping[str, str]:
        """The kinds of the fields by name."""
        return self.kind.fields

    def length(self, x: Any) -> Scalar:
        """The sum of factors times lengths or coordinates."""
        parts = zip(self.measures, self.factors, self._local(x), strict=True)
        return sum((factor * _coordinate(one, own) for one, factor, own in parts), self.start)

    def rate(self, x: Any, v: Any) -> Scalar:
        parts = zip(self.measures, self.factors, self._local(x), self._local(v), strict=True)
        return sum(factor * _rate(one, own, rates) for one, factor, own, rates in parts)

    def gradient(self, x: Any) -> list[Block]:
        """The derivatives of the length to the coordinates of the bodies of all parts, one after the other."""
        found = list[Block]()
        for one, factor, own in zip(self.measures, self.factors, self._local(x), strict=True):
            has_act = hasattr(one, "act")
            unit = one.act(ONE, own, own, 0) if has_act else along_coordinate(one, ONE, own, own, 0)
            found += [scaled(factor, block) for block in unit]
        return found

    def act(self, values: Any, x: Any, v: Any, t: Scalar) -> Row:
        """Q of a force that increases the length if it is positive."""
        return tuple(scaled(values[0], block) for block in self.gradient(x))

    def remember(self, x: Any) -> tuple[Scalar, ...]:
        """New values of the memory fields of all parts at an accepted state."""
        pairs = zip(self.measures, self._local(x), strict=True)
        return tuple(
            value for one, own in pairs if "Memory" in one.fields.values() for value in one.remember(own)
        )

    def _local(self, x: Any) -> Iterator[Any]:
        """Coordinates, or rates, of the bodies of each part."""
        at, blocks = 0, tuple(x)
        for part in self.kind.parts:
            own = blocks[at : at + 2 * part.bodies]
            at += 2 * part.bodies
            yield Pair(*own) if part.bodies == 2 else own


class Pull(NamedTuple):
    """A force along a path; further laws are outputs of the part."""

    outputs: tuple[tuple[str, str], ...]

    def __call__(self, of: Path, values: Any, x: Any, v: Any, t: Scalar) -> Row:
        """Q of the first value."""
        return of.act(values, x, v, t)


def _coordinate(of: Any, x: Any) -> Scalar:
    return of.length(x) if hasattr(of, "act") else of.Phi(x)[0]


def _rate(of: Any, x: Any, v: Any) -> Scalar:
    return of.rate(x, v) if hasattr(of, "act") else of.Phi_q_xi(x, v)[0]


def path_of(measures: list[Measure], factors: list[Any], start: Any) -> Measure:
    """Return the measure of a path with factors of its parts, and a constant length."""
    kinds: tuple[MeasureClass, ...] = tuple(one.kind for one in measures)
    values = [value for one in measures for value in one.values]
    bodies = tuple(body for one in measures for body in one.bodies)
    return Measure(PathKind(kinds), bodies, (*values, *factors, start))


class Share(NamedTuple):
    """A part of a tendon: what it is measured and loaded by, and its factor in the length."""

    measure: Measure
    factor: Any


@dataclass(frozen=True, eq=False)
class PathPart:
    """A part along a path from point to point, or along a sum of factors times coordinates of joints.

    Parameters
    ----------
    points
        The path, from point to point; it slides through them without friction. Segments between points of one body
        have a constant length, unless they wrap a shape of another one.
    factors
        One for each segment, by default 1: a segment behind a pulley counts 1/2, a gap between two branches 0.
    joints
        Instead of points, a factor for each coordinate of a joint, ``{"pin": 0.02, "slide": -1}``.
    around
        For each segment the sphere or cylinder that it wraps, a `Wrap`, or None where it is straight.
    """

    points: Sequence[Point] = ()
    factors: Annotated[Sequence[float], In("1")] = ()
    joints: Annotated[Mapping[str, float], In("")] = field(default_factory=dict)
    around: Sequence[Wrap | None] = ()

    def path(self, signals: Signals) -> Measure:
        """Return the measure of the path."""
        constant, shares = self._shares(signals)
        return path_of([one.measure for one in shares], [one.factor for one in shares], constant)

    def coordinates(self, path: Measure) -> tuple[Signal, Signal]:
        """Return the length and its rate."""
        unit = "m" if self.points else ""
        return Signal(path, "length", 1, 0, unit), Signal(path, "rate", 2, 0, f"{unit or '1'}/s")

    def _shares(self, signals: Signals) -> tuple[float, list[Share]]:
        """Return the constant part of the length, and the parts that move."""
        if bool(self.points) == bool(self.joints):
            raise ModelError("must have points or joints. Give one of them.", field="points")
        if self.joints and (self.factors or self.around):
            message = "factors and around belong to points, but it has joints. Remove them, or give points."
            raise ModelError(message, field="factors" if self.factors else "around")
        if self.joints:
            return 0.0, [self._of_joint(name, factor, signals) for name, factor in self.joints.items()]
        return self._of_points(signals)

    def _of_joint(self, name: str, factor: Any, signals: Signals) -> Share:
        return Share(along_joint(name, None, signals).target.measure, number(factor, f"joints.{name}"))

    def _of_points(self, signals: Signals) -> tuple[float, list[Share]]:
        for name in ("points", "factors", "around"):
            if not is_list(getattr(self, name)):
                message = f"{name} must be a list, but is {show(getattr(self, name))}. Give a list."
                raise ModelError(message, field=name)
        count = len(self.points) - 1
        factors, around = self.factors or (1.0,) * count, self.around or (None,) * count
        if count < 1 or len(factors) != count:
            message = "needs two or more points, and one factor less than points"
            raise ModelError(f"{message}. Give them, or no factors.", field="points")
        if len(around) != count:
            message = f"around must have {count} entries, one for each segment, but has {len(around)}"
            raise ModelError(f"{message}. Give None for those that are straight.", field="around")
        centers = [one.center for one in around if isinstance(one, Wrap)]
        for name, kind, values in (
            ("points", Point, self.points),
            ("around", Wrap | None, around),
            ("around.center", Point, centers),
        ):
            for one in values:
                if not isinstance(one, kind):
                    remedy = "body.point(x, y, z)" if kind is Point else "a Wrap or None"
                    raise ModelError(f"{name} has {show(one)}. Give {remedy}.", field=name)
        constant, shares = 0.0, []
        for first, second, given, shape in zip(self.points, self.points[1:], factors, around, strict=False):
            i, j = (point.resolve(signals.poses, "points") for point in (first, second))
            factor = number(given, "factors")
            wound = shape.measure((i, j), signals.poses) if shape is not None else None
            if len({i.body, j.body, *(wound.bodies if wound else ())}) == 1:
                constant += factor * _constant(i, j, wound)
            elif factor:
                if i.body != j.body:
                    points_apart(first, second, signals.poses)
                shares.append(Share(wound or Measure(Line, (i.body, j.body), (i.s, j.s)), factor))
        if not shares:
            raise ModelError("no segment of it can move. Give points of other bodies.", field="points")
        return constant, shares


def _constant(i: LocalPoint, j: LocalPoint, wound: Measure | None) -> float:
    """The length of a segment on one body."""
    if wound is None:
        return float(np.linalg.norm(np.subtract(j.s, i.s)))
    here = np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])
    values = [np.array(one) if isinstance(one, tuple) else one for one in wound.values]
    return float(wound.kind(*values).length(here * 4))
