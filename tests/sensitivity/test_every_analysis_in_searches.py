"""Studies, uncertainty, optimization and fits take every analysis without time integration, with one parameter each."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import pytest
from tests.analyses.driven import turned

import sarrus as sr
from sarrus.model.written import with_numbers, written_numbers
from sarrus.studies import Distribution

pytestmark = pytest.mark.filterwarnings("ignore:.*assembly changed")
BASE = sr.load("slider_crank")
PUSHED = replace(
    BASE, forces=[*BASE.forces, sr.Input("u", 0.5), sr.Torque("motor", "pin", value="u*(1 + pin.angle)")]
)


@dataclass(frozen=True)
class Search:
    """A model, an analysis, a response, and the parameter that is sought."""

    make: Callable[[], sr.Model]
    analysis: Callable[[], Any]
    response: str
    name: str
    time: float = 0.0

    @cached_property
    def model(self) -> sr.Model:
        return self.make()

    @cached_property
    def true(self) -> float:
        return float(written_numbers(self.model)[self.name])

    def at(self, value: float) -> sr.Model:
        return with_numbers(self.model, {self.name: value})

    def values(self, *numbers: float) -> Any:
        """The response by a study."""
        grid = {self.name: list(numbers)}
        return sr.study(self.model, grid, {"r": self.response}, analysis=self.analysis(), workers=1).found[
            :, 0
        ]


def driven() -> sr.Model:
    """The slider-crank with a drive."""
    return replace(BASE, drivers=[sr.AngleDriver("motor", "pin", "0*t")])


def moved() -> sr.InverseDynamics:
    """What its free motion requires."""
    return sr.InverseDynamics(sr.simulate(sr.System(BASE), until=0.5, t_eval=np.linspace(0, 0.5, 6)))


GAIN = "magnitude[slider.x, u, 0.6]"
SEARCHES = {
    "kinematics": Search(
        lambda: turned(3.0, 0.5).model, lambda: sr.Kinematics(until=1.0, steps=10), "slider.x", "motor.motion.1", 1.0
    ),
    "inverse dynamics": Search(driven, moved, "motor.torque.x", "rod.mass", 0.5),
    "equilibrium": Search(lambda: BASE, sr.Statics, "slider.x", "spring.k"),
    "modes": Search(lambda: BASE, sr.Vibration, "mode1.frequency", "rod.mass"),
    "linearization": Search(lambda: PUSHED, sr.Linearization, "A[pin.angle.rate, pin.angle]", "spring.k"),
    "frequency response": Search(lambda: PUSHED, lambda: sr.Linearization(outputs=["slider.x"]), GAIN, "spring.c"),
}  # fmt: skip


@pytest.mark.one_in(8)
@pytest.mark.parametrize("kind", SEARCHES)
def test_uncertainty_is_that_of_a_study(kind: str) -> None:
    one = SEARCHES[kind]
    spread = {one.name: Distribution("norm", {"loc": one.true, "scale": 0.01 * one.true})}
    found = sr.uncertainty(one.model, spread, {"r": one.response}, analysis=one.analysis())
    h = 1e-3 * one.true
    f = one.values(*(one.true + n * h for n in (-2, -1, 1, 2)))
    slope = (f[0] - 8 * f[1] + 8 * f[2] - f[3]) / (12 * h)
    assert found.std[0] == pytest.approx(abs(slope) * 0.01 * one.true, rel=1e-6)


@pytest.mark.one_in(8)
@pytest.mark.parametrize("kind", SEARCHES)
def test_optimization_and_fit_find_the_parameter(kind: str) -> None:
    one = SEARCHES[kind]
    (wanted,) = one.values(one.true)
    begin = sr.System(one.at(1.03 * one.true))
    scale = abs(float(wanted)) or 1.0
    goal = sr.Combined(lambda f: 1e4 * ((f - wanted) / scale) ** 2, [one.response])
    bounds = {one.name: (0.8 * one.true, 1.2 * one.true)}
    best = sr.optimize(begin, goal, [one.name], analysis=one.analysis(), bounds=bounds)
    assert best.success, best.message
    assert best.x[0] == pytest.approx(one.true, rel=1e-3)
    misfit = sr.Misfit(one.response, at=[one.time], data=[float(wanted)], sigma=1e-4 * scale)
    fitted = sr.fit(begin, misfit, [one.name], analysis=one.analysis())
    assert fitted.x[0] == pytest.approx(one.true, rel=1e-6)
