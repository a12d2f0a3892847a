"""Friction and viscoelasticity with states: the models of LuGre and Maxwell."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Annotated, Any

from ..._jit.formulas.expression import Expression as Recorded
from ...functions import exp, sqrt
from ..errors import ModelError
from ..forces.force import Force
from ..forces.formula_element import load_primitive
from ..forces.springs import LineForce, along_joint
from ..laws.recorded import Recording
from ..measure import In, Length, Ratio
from ..primitive import Primitive
from ..quantity import not_negative, number, positive
from ..signals import Signals
from ..tape import value_of
from .block import StateValue, WithNominal, rate_loads


@dataclass(frozen=True, eq=False)
class LuGre(Force):
    """Friction of a ``joint`` by a state z, the deflection of bristles between surfaces that slide at the speed u.

    ż = u - stiffness · z · s / g,    F = stiffness · z + damping · ż + viscous · u,
    g = load · [μ + (μ_s - μ) exp(-(u/stribeck)²)],    s = √(u² + creep²)

    s is |u| without its corner. What would stick under a force F creeps, at creep · F / √(g² - F²). The state is
    ``name.deflection`` [m]; the force -F, or the torque -radius · F, is ``name.value``.

    Parameters
    ----------
    joint
        By name, or one of its coordinates, ``hook.angle_i``: u is the rate of a displacement, or radius · rate of an
        angle.
    load
        Normal load [N], constant: the joint's reaction is not used.
    mu, mu_static
        Coefficients of sliding friction μ and of sticking friction μ_s; left out, the latter is ``mu``.
    stiffness
        Of the bristles [N/m], which is that of presliding.
    damping
        Of the bristles [N s/m].
    stribeck
        [m/s] Speed over which sticking friction falls to sliding friction.
    viscous
        [N s/m]
    creep
        [m/s] Width of the rounding of |u|.
    radius
        Of the pin [m], for an angle.
    """

    joint: str
    load: Annotated[float, In("N")]
    mu: Ratio
    stiffness: Annotated[float, In("N/m")]
    mu_static: Ratio | None = None
    damping: Annotated[float, In("N s/m")] = 0.0
    stribeck: Annotated[float, In("m/s")] = 1e-2
    viscous: Annotated[float, In("N s/m")] = 0.0
    creep: Annotated[float, In("m/s")] = 1e-6
    radius: Length | None = None

    def states(self) -> Iterator[StateValue]:
        """Yield the deflection, the size of which is that at which the bristles slide."""
        mu = positive(self.mu, "mu", "Give the coefficient of friction.")
        load = positive(self.load, "load", "Give the normal load in N.")
        stiffness = positive(self.stiffness, "stiffness", "Give that of the bristles in N/m.")
        sliding = float(value_of(load) * value_of(mu) / value_of(stiffness))
        yield StateValue(f"{self.name}.deflection", 0.0, "m", sliding)

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        """Yield the load of the deflection's rate, and the friction."""
        target, x, v = along_joint(self.joint, None, signals)
        angle = x.unit == "rad"
        if angle and self.radius is None:
            message = f"radius is missing, which the angle of {self.joint} needs. Give that of the pin in m."
            raise ModelError(message, field="radius")
        if self.radius is not None and not angle:
            raise ModelError("radius is for an angle. Leave it out.", field="radius")
        signals, state = signals.extended({"v": v}), f"{self.name}.deflection"
        r = Recording("load", {}, {})
        yield from rate_loads([state], [self._laws(r)[0]], r, signals, "m/s")
        r = Recording("load", {}, {})
        yield load_primitive(target, [-self._laws(r)[1]], r, signals.of(r), "N m" if angle else "N")

    def _laws(self, r: Recording) -> tuple[Recorded, Recorded]:
        """ż, and F or the torque of it."""

        def given(field: str, value: Any, checked: Any = not_negative) -> Recorded:
            return r.number(checked(value, field, "Give it in SI units."), field)

        u = r.named("v")
        if self.radius is not None:
            u = given("radius", self.radius, positive) * u
        mu = given("mu", self.mu)
        ratio = u / given("stribeck", self.stribeck, positive)
        friction = mu
        if self.mu_static is not None:
            friction = mu + (given("mu_static", self.mu_static) - mu) * exp(-ratio * ratio)
        creep, z = given("creep", self.creep, positive), r.named(f"{self.name}.deflection")
        elastic = given("stiffness", self.stiffness) * z
        slope = u - elastic * sqrt(u * u + creep * creep) / (given("load", self.load) * friction)
        force = elastic + given("damping", self.damping) * slope + given("viscous", self.viscous) * u
        return slope, force if self.radius is None else given("radius", self.radius) * force


@dataclass(frozen=True, eq=False)
class Maxwell(LineForce, WithNominal, Force):
    """A spring in series with a damper, whose tension F relaxes: Ḟ/k + F/c = v, v the rate of its length.

    The tension is the state ``name.tension`` [N]. The force that pushes its points apart, or increases the displacement
    of its joint, is ``name.value`` = -F.

    Parameters
    ----------
    point_i, point_j
        The ends, which must not coincide. Or instead of both the name of a joint, ``Maxwell("buffer", "slide", ...)``.
    joint
        Instead of points, a joint by name, whose displacement is the length.
    k
        Stiffness of the spring [N/m].
    c
        Coefficient of the damper [N s/m]; c/k is the time of relaxation.
    initial
        Tension at the start of a run [N].
    """

    k: Annotated[float, In("N/m")] = field(kw_only=True)
    c: Annotated[float, In("N s/m")] = field(kw_only=True)
    initial: Annotated[float, In("N")] = field(default=0.0, kw_only=True)

    def states(self) -> Iterator[StateValue]:
        yield StateValue(f"{self.name}.tension", number(self.initial, "initial"), "N", self.state_size())

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        """Yield the load of the tension's rate, and the force."""
        target, _, v = self.line(signals)
        tension, signals = f"{self.name}.tension", signals.extended({"v": v})
        r = Recording("k", {}, {})
        k = r.number(positive(self.k, "k", "Give a stiffness in N/m."))
        c = r.number(positive(self.c, "c", "Give a coefficient in N s/m."))
        yield from rate_loads([tension], [k * (r.named("v") - r.named(tension) / c)], r, signals, "N/s")
        r = Recording("k", {}, {})
        yield load_primitive(target, [-r.named(tension)], r, signals.of(r), "N")
