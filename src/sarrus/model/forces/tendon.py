"""Tendon: a force along the length of a path through points, or along a combination of coordinates of joints."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

import numpy as np

from ...algebra import Row
from ...elements.element import Scalar
from ..errors import ModelError
from ..geometry.placement import points_apart
from ..geometry.point import LocalPoint, Point
from ..laws.recorded import Recording
from ..measure import In
from ..primitive import Primitive
from ..quantity import is_list, not_negative, number
from ..show import show
from ..signals import Measure, Signal, Signals
from .by_formula import ByFormula, with_full
from .force import Force
from .formula_element import Line, Target, load_primitive
from .paths.inertia import path_inertia
from .paths.path import Path, path_of
from .paths.wrapping import Wrap
from .two_points import along_joint


class Pull(NamedTuple):
    """A force along a path; further laws are outputs of the tendon."""

    outputs: tuple[tuple[str, str], ...]

    def __call__(self, of: Path, values: Any, x: Any, v: Any, t: Scalar) -> Row:
        """Q of the first value."""
        return of.act(values, x, v, t)


class Share(NamedTuple):
    """A part of a tendon: what it is measured and loaded by, and its factor in the length."""

    measure: Measure
    factor: Any


@dataclass(frozen=True, eq=False)
class Tendon(ByFormula, Force):
    """A force along x, the length of a path from point to point, or a sum of factors times coordinates of joints.

    A positive ``value`` increases x: it does work at the rate value · v, as that of a `Force`. A spring with a damper
    is ``value="-k*(x - L0) - c*v"``, a rope ``value="-k*max(x - L0, 0)"``.

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
    inertia
        [kg] of what moves along with the length, such as the rotor of a winch divided by the square of its radius: its
        kinetic energy is ½ inertia · v². For angles of joints in kg m², without the unit.
    value
        As of a `Force`; x and v are the length and its rate.
    """

    points: Sequence[Point] = ()
    factors: Annotated[Sequence[float], In("1")] = ()
    joints: Annotated[Mapping[str, float], In("")] = field(default_factory=dict)
    around: Sequence[Wrap | None] = ()
    inertia: Annotated[float, In("kg")] = 0.0

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        """Yield the load and the inertia."""
        inertia = not_negative(self.inertia, "inertia", "Give it in kg.")
        if self.value is None and not inertia:
            raise ModelError("value is missing. Give a formula, a function or a table.", field="value")
        constant, shares = self._shares(signals)
        path = path_of([one.measure for one in shares], [one.factor for one in shares], constant)
        if self.value is not None:
            yield self._load(path, signals)
        if inertia:
            yield path_inertia(inertia, path)

    def _load(self, path: Measure, signals: Signals) -> Primitive:
        unit = "m" if self.points else ""
        x, v = Signal(path, "length", 1, 0, unit), Signal(path, "rate", 2, 0, f"{unit or '1'}/s")
        own = {"x": x, "length": x, "v": v, "rate": v}
        r = Recording("value", with_full(own, self), self.checked_parameters(), variables=signals.variables)
        value = r.law(self.value, self.over)
        laws = [value, value, r.named("x"), r.named("v")]
        signals.refuse_hidden(r)
        pairs = zip(r.signals, r.fields, strict=True)
        found = [own[name] if name in own else signals.find(name, field) for name, field in pairs]
        outputs = ("value", "N" if self.points else ""), ("length", unit), ("rate", v.unit)
        return load_primitive(Target(path, Pull(outputs)), laws, r, found)

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
    return float(wound.kind(*values).length(here * 3))
