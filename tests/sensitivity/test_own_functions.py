"""Curves that a user gives as functions of his own: whatever these are, and whatever they refer to."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

import sarrus as sr
from sarrus import model
from sarrus.elements import Force, Single
from sarrus.elements.element import Curve, Scalar, Vec3
from sarrus.model.laws.curve import curve_of
from sarrus.model.primitive import Primitive

SETTINGS = {"until": 0.2, "t_eval": [0.2], "store": "steps", "method": sr.Radau(rtol=1e-9, atol=1e-11)}
AT, LENGTH = 0.5, 0.8


@dataclass
class Linear:
    """A stiffness over length that can be changed, and so has no hash."""

    k: float

    def __call__(self, x: object) -> object:
        return self.k * x


def pulled(law: Callable[[object], object]) -> sr.Trajectory:
    mass = sr.Body("mass", mass=1, inertia=(1, 1, 1), position=(1, 0, 0))
    ends = sr.ground.point(0, 0, 0), mass.point(0, 0, 0)
    spring = sr.TSDA("spring", *ends, k=law, length=LENGTH)
    return sr.simulate(sr.System(sr.Model("pulled", [mass], forces=[spring])), **SETTINGS)


def test_a_function_is_taken_as_it_was_when_the_system_was_made() -> None:
    law = Linear(5.0)
    for law.k in (5.0, 7.0):
        found = sr.sensitivity(
            pulled(law), [sr.Final("spring.tension"), sr.Final("spring.length")], ["mass.mass"]
        )
        tension, length = found.values
        assert tension == pytest.approx(law.k * length * (length - LENGTH), rel=1e-13)
        slope = law.k * (2 * length - LENGTH)
        assert found.matrix[0] == pytest.approx(slope * found.matrix[1], rel=1e-12)


class Wind(Force, bodies=1, derivatives="automatic"):
    """A force along x that takes its profile at the time, and at a place that is written into its formula."""

    place: Vec3
    strength: Scalar
    profile: Curve

    def Q(self, x: Single, v: Single, t: object) -> tuple[object, None]:
        return self.strength * self.profile(AT) * self.profile(t) * (self.place - x.r), None


@dataclass(frozen=True, eq=False)
class Windy(model.Force):
    """The force in a model."""

    point: model.Point
    strength: float
    profile: float | sr.Curve

    def primitives(self, poses: object) -> object:
        values = ((0.3, 0, -1.1), self.strength, curve_of(self.profile, "profile"))
        yield Primitive(Wind, (self.point.resolve(poses, "point").body,), values, "wind")


del model.Force.kinds["windy"]  # files know nothing of it: other tests read what they may hold


def blown(first: float) -> sr.Trajectory:
    bob = sr.Body("bob", mass=1.0, inertia=(0.01, 0.02, 0.03), position=(0, 0, -1))
    profiles = [(0, first), (0.4, 2), (1, 5)], [(0, 1), (0.4, 2), (0.6, 3), (1, 5)]
    winds = [Windy(f"wind{n}", bob.point(0, 0, 0), 0.7, list(profile)) for n, profile in enumerate(profiles)]
    return sr.simulate(sr.System(sr.Model("blown", [bob], forces=winds)), **SETTINGS)


def test_an_element_may_take_a_curve_at_a_fixed_place() -> None:
    found = sr.sensitivity(blown(1.0), sr.Final("bob.x"), ["wind0.profile.1.y"])
    step = 1e-4
    one, other = (blown(1.0 + e)["bob"].position[-1][0] for e in (step, -step))
    assert found.matrix[0, 0] == pytest.approx((one - other) / (2 * step), rel=1e-6)
    assert np.isfinite(found.matrix).all()
