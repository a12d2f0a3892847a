"""Muscle: Hill's tension along a path, by its activation, length and rate, with the curves of MuJoCo.

With L = (l - tendon_length)/optimal_length, its rate V = l̇/(optimal_length · max_velocity) and the activation a,

    tension = peak_force (a F_L(L) F_V(V) + F_P(L)).

F_L is a bump of quadratic splines, 1 at L = 1 and 0 outside of min_length and max_length. F_V is 0 for V ≤ -1, 1 at
V = 0, and the eccentric force from V = eccentric_force - 1 on. F_P is quadratic above L = 1, and linear from the middle
of 1 and max_length on. All have continuous first derivatives.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any

from ..._jit.formulas.expression import Expression as Recorded
from ...functions import positive as is_positive
from ..errors import ModelError
from ..laws.law import Law, scaled, varies
from ..laws.recorded import Recording
from ..measure import In
from ..primitive import Primitive
from ..quantity import fraction, not_negative, number, positive
from ..signals import Signals
from .by_formula import WithParameters
from .force import Force
from .formula_element import Target, load_primitive
from .paths.path import PathPart, Pull


def force_length(L: Any, shortest: Any, longest: Any) -> Any:
    """F_L: 0 outside of the shortest and longest L, 1 at L = 1."""
    return _spline(2 * (L - shortest) / (1 - shortest)) * _spline(2 * (longest - L) / (longest - 1))


def force_velocity(V: Any, eccentric: Any) -> Any:
    """F_V: 0 for V ≤ -1, 1 at V = 0, `eccentric` for V ≥ eccentric - 1."""
    more = eccentric - 1
    return _either(V, _square(V + 1), eccentric - _square(more - V) / more)


def passive_force(L: Any, longest: Any, factor: Any) -> Any:
    """F_P: 0 for L ≤ 1, half of `factor` at the middle of 1 and the longest L, and linear beyond."""
    x = 2 * (L - 1) / (longest - 1)
    return factor * _either(x - 1, _square(x) / 2, x - 0.5)


def _spline(x: Any) -> Any:
    """0 up to x = 0, 1 from x = 2 on, and two parabolas between."""
    return _either(x - 1, _square(x) / 2, 1 - _square(2 - x) / 2)


def _either(x: Any, below: Any, above: Any) -> Any:
    """The second value where x is positive, which there continues the first one with its slope."""
    is_above = is_positive(x)
    return (1 - is_above) * below + is_above * above


def _square(x: Any) -> Any:
    """x² where x is positive, else 0: it has no corner."""
    return is_positive(x) * x * x


@dataclass(frozen=True, eq=False, kw_only=True)
class Muscle(PathPart, WithParameters, Force):
    """A muscle with a rigid tendon along a path: peak_force · (activation · F_L · F_V + F_P), a tension.

    F_L, F_V and F_P are the curves of MuJoCo for active force over length, over velocity, and passive force over
    length. Lengths relative to the optimal one are (x - tendon_length)/optimal_length with the length x of the path.
    Outputs are ``name.tension`` [N], ``name.length`` and ``name.rate``.

    Parameters
    ----------
    activation
        From 0 to 1: a number; a formula of outputs, such as the name of a `MuscleActivation`, and of x and v, the
        length of the path and its rate; or a function.
    peak_force
        Largest isometric force [N]; along angles of joints in N m, without the unit.
    optimal_length
        [m] of the muscle, at which it has this force.
    tendon_length
        [m] of the tendon, which is the rest of the path. Along joints, the length x - tendon_length must be that of the
        muscle, so it may be negative.
    min_length, max_length
        Ends of the range of active force, in optimal lengths.
    max_velocity
        Of shortening, where the active force is zero, in optimal lengths per second [1/s].
    passive_force
        Slope of the passive force beyond the middle of 1 and ``max_length``, as a factor of ``peak_force`` over half of
        ``max_length`` - 1.
    eccentric_force
        Largest active force while lengthening, as a factor of ``peak_force``; greater than 1.
    """

    activation: Annotated[Law, In("1", outputs=True)]
    peak_force: Annotated[float, In("N")]
    optimal_length: Annotated[float, In("m")]
    tendon_length: Annotated[float, In("m")] = 0.0
    min_length: Annotated[float, In("1")] = 0.5
    max_length: Annotated[float, In("1")] = 1.6
    max_velocity: Annotated[float, In("s^-1")] = 1.5
    passive_force: Annotated[float, In("1")] = 1.3
    eccentric_force: Annotated[float, In("1")] = 1.2

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        self._check()
        path = self.path(signals)
        x, v = self.coordinates(path)
        r = Recording("activation", {}, self.checked_parameters(), variables=signals.variables)
        activation = r.law(self.activation)
        signals = signals.extended({"x": x, "v": v})
        self.check_units(self.activation, "activation", "1", r, signals)
        tension = self._tension(r, activation)
        laws = [-tension, tension, r.named("x"), r.named("v")]
        outputs = ("tension", "N" if self.points else ""), ("length", x.unit), ("rate", v.unit)
        yield load_primitive(Target(path, Pull(outputs)), laws, r, signals.of(r))

    def _tension(self, r: Recording, activation: Recorded) -> Recorded:
        peak, optimal, free, shortest, longest, speed, factor, eccentric = (
            r.number(getattr(self, field), f"{field}.own")
            for field in (
                "peak_force",
                "optimal_length",
                "tendon_length",
                "min_length",
                "max_length",
                "max_velocity",
                "passive_force",
                "eccentric_force",
            )
        )
        L, V = (r.named("x") - free) / optimal, r.named("v") / (optimal * speed)
        active = activation * force_length(L, shortest, longest) * force_velocity(V, eccentric)
        tension: Recorded = peak * (active + passive_force(L, longest, factor))
        return tension

    def _check(self) -> None:
        """Refuse numbers for which the curves have no sense."""
        if not varies(self.activation):
            factor = scaled(self.activation, "activation").factor
            fraction(factor, "activation", "Give such a number, or a formula.")
        number(self.tendon_length, "tendon_length")
        positive(self.optimal_length, "optimal_length", "Give that of the muscle in m.")
        positive(self.max_velocity, "max_velocity", "Give it in optimal lengths per second.")
        for field in ("peak_force", "min_length", "passive_force"):
            not_negative(getattr(self, field), field, "Give 0 or more.")
        for field, sign in (("min_length", -1), ("max_length", 1), ("eccentric_force", 1)):
            value = number(getattr(self, field), field)
            if sign * value <= sign:
                limit = "less" if sign < 0 else "greater"
                message = f"{field} must be {limit} than 1, but is {float(value):g}. Give such a factor."
                raise ModelError(message, field=field)
