"""Tendon: a force along the length of a path through points, or along a combination of coordinates of joints."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Annotated, Any, NamedTuple

import numpy as np

from ..._jit.formulas.expression import Expression as Recorded
from ...algebra import Row
from ...elements.element import Scalar
from ..errors import ModelError
from ..geometry.placement import points_apart
from ..geometry.point import LocalPoint, Point
from ..laws.recorded import Recording
from ..measure import In
from ..primitive import Primitive
from ..quantity import not_negative, number
from ..show import show
from ..signals import Measure, Signal, Signals
from .by_formula import ByFormula
from .force import Force
from .formula_element import Line, Target, along_coordinate, load_primitive
from .paths.inertia import path_inertia
from .paths.wrapping import Wound, Wrap
from .two_points import along_joint


class Segment(Line):
    """A straight part of a path."""


class Pull(NamedTuple):
    """A force along a part of a tendon, in proportion to its value; further laws are outputs of the tendon."""

    outputs: tuple[tuple[str, str], ...] = ()

    def __call__(self, of: Any, values: Any, x: Any, v: Any, t: Scalar) -> Row:
        """Q of the first value."""
        act = of.act if isinstance(of, Segment | Wound) else partial(along_coordinate, of)
        return act(values, x, v, t)


class Share(NamedTuple):
    """A part of a tendon: what it is measured and loaded by, coordinate and rate, and its factor in the length."""

    measure: Measure
    x: Signal
    v: Signal
    factor: float


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
        kinetic energy is ½ inertia · v². For coordinates of joints, in the unit that belongs to them.
    value
        As of a `Force`; x and v are the length and its rate.
    """

    points: Sequence[Point] = ()
    factors: Annotated[Sequence[float], In("1")] = ()
    joints: Annotated[Mapping[str, float], In("")] = field(default_factory=dict)
    around: Sequence[Wrap | None] = ()
    inertia: Annotated[float, In("")] = 0.0

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        """Yield a load for each segment or coordinate, and the inertia."""
        inertia = not_negative(self.inertia, "inertia", "Give it in kg.")
        if self.value is None and not inertia:
            raise ModelError("value is missing. Give a formula, a function or a table.", field="value")
        constant, shares = self._shares(signals)
        yield from self._loads(constant, shares, signals) if self.value is not None else ()
        if inertia:
            yield path_inertia(inertia, [one.measure for one in shares], [one.factor for one in shares])

    def _loads(self, constant: float, shares: Sequence[Share], signals: Signals) -> Iterator[Primitive]:
        own = {name: signal for n, one in enumerate(shares) for name, signal in self._named(n, one).items()}
        signals = signals.extended(own)
        further = (("value", self._unit()), *(self._units_of_length()))
        for n, share in enumerate(shares):
            r = self._recording(constant, shares, signals)
            value = r.law(self.value, self.over)
            laws = [r.number(share.factor) * value]
            if not n:
                laws += [value, r.named("x"), r.named("v")]
            act: Any = Pull(() if n else further)
            yield load_primitive(Target(share.measure, act), laws, r, signals.of(r))

    def _recording(self, constant: float, shares: Sequence[Share], signals: Signals) -> Recording:
        """Return a recording in which the length and its rate are variables."""

        def total(end: str, start: float) -> Any:
            def recorded(r: Recording) -> Recorded:
                parts = (r.number(s.factor) * r.named(f"{self.name}.{n}{end}") for n, s in enumerate(shares))
                return sum(parts, r.number(start))

            return recorded

        length, rate = total("", constant), total(".rate", 0.0)
        variables = {"x": length, "length": length, "v": rate, "rate": rate}
        own = {name: word for word in variables for name in (word, f"{self.name}.{word}")}
        return Recording(
            "value", own, self.checked_parameters(), variables={**signals.variables, **variables}
        )

    def _named(self, n: int, share: Share) -> dict[str, Signal]:
        return {f"{self.name}.{n}": share.x, f"{self.name}.{n}.rate": share.v}

    def _shares(self, signals: Signals) -> tuple[float, list[Share]]:
        """Return the constant part of the length, and the parts that move."""
        if bool(self.points) == bool(self.joints):
            raise ModelError("must have points or joints. Give one of them.", field="points")
        if self.joints:
            return 0.0, [self._of_joint(name, factor, signals) for name, factor in self.joints.items()]
        return self._of_points(signals)

    def _of_joint(self, name: str, factor: Any, signals: Signals) -> Share:
        target, x, v = along_joint(name, None, signals)
        return Share(target.measure, x, v, number(factor, f"joints.{name}"))

    def _of_points(self, signals: Signals) -> tuple[float, list[Share]]:
        count = len(self.points) - 1
        factors, around = self.factors or (1.0,) * count, self.around or (None,) * count
        if count < 1 or len(factors) != count:
            message = "needs two or more points, and one factor less than points"
            raise ModelError(f"{message}. Give them, or no factors.", field="points")
        if len(around) != count:
            message = f"around must have {count} entries, one for each segment, but has {len(around)}"
            raise ModelError(f"{message}. Give None for those that are straight.", field="around")
        for name, kind, values in (("points", Point, self.points), ("around", Wrap | None, around)):
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
            elif factor and wound is None:
                points_apart(first, second, signals.poses)
                shares.append(_share(Measure(Segment, (i.body, j.body), (i.s, j.s)), factor))
            elif factor and wound is not None:
                shares.append(_share(wound, factor))
        if not shares:
            raise ModelError("no segment of it can move. Give points of other bodies.", field="points")
        return constant, shares

    def _unit(self) -> str:
        return "N" if self.points else ""

    def _units_of_length(self) -> tuple[tuple[str, str], ...]:
        unit = "m" if self.points else ""
        return ("length", unit), ("rate", f"{unit or '1'}/s")


def _share(measure: Measure, factor: Any) -> Share:
    return Share(measure, Signal(measure, "length", 1, 0, "m"), Signal(measure, "rate", 2, 0, "m/s"), factor)


def _constant(i: LocalPoint, j: LocalPoint, wound: Measure | None) -> float:
    """The length of a segment on one body."""
    if wound is None:
        return float(np.linalg.norm(np.subtract(j.s, i.s)))
    here = np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])
    values = [np.array(one) if isinstance(one, tuple) else one for one in wound.values]
    return float(wound.kind(*values).length(here * 3))
