"""Outputs that change faster than the steps of a calm motion: integrals and extremes against closed forms and sums."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.special import erf

import sarrus as sr
from sarrus.analyses.sensitivity.parameters.parameters import Parameters
from sarrus.analyses.sensitivity.responses.evaluation import Evaluation

METHODS = {"Radau": sr.Radau(), "HHT": sr.HHT()}
WIDTH = 0.003


def glider(speed: float) -> sr.System:
    """A body that flies on at 2 m/s, and falls: Radau takes a few long steps."""
    body = sr.Body("glider", 1.0, (0.1,) * 3, position=(-1.0, 0, 0), velocity=(speed, 0, 0))
    return sr.System(sr.Model("glider", [body], gravity=(0, 0, -9.81)))


@cache
def run(method: str) -> sr.Trajectory:
    found = sr.simulate(glider(2.0), until=1.0, method=METHODS[method], store_steps=True)
    assert method == "HHT" or found.nsteps < 60
    return found


def bell(o: Any) -> Any:
    return np.exp(-(((o("glider.x") - 0.1234) / WIDTH) ** 2))


def waves(o: Any) -> Any:
    return np.sin(200 * o.t) ** 2


def edge(o: Any) -> Any:
    return np.tanh((o.t - 0.7331) * 1e6)


def folded(o: Any) -> Any:
    return np.abs(np.sin(300 * o.t))


HALF = WIDTH * np.sqrt(np.pi) / 2  # of the integral over x
INTEGRALS: dict[Callable[[Any], Any], float] = {
    bell: HALF * (erf((1 - 0.1234) / WIDTH) + erf((1 + 0.1234) / WIDTH)) / 2,
    waves: 0.5 - np.sin(400) / 800,
    edge: 1 - 2 * 0.7331,
    folded: (2 * (300 // np.pi) + 1 - np.cos(300 % np.pi)) / 300,
}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("output", INTEGRALS, ids=lambda f: f.__name__)
def test_integrals(method: str, output: Any) -> None:
    found = sr.sensitivity(run(method), sr.Integral(output), ["glider.velocity.x"], error=True)
    error = found.values[0] - INTEGRALS[output]
    assert abs(error) < (1e-4 if method == "Radau" else 1e-2) * abs(INTEGRALS[output])
    assert abs(error) <= 3 * found.errors[0].error + 1e-15
    assert found.warnings == ()


@pytest.mark.parametrize("kind", [sr.Maximum, sr.Peak])
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("output", [bell, waves, folded], ids=lambda f: f.__name__)
def test_largest_values(method: str, output: Any, kind: Any) -> None:
    found = sr.sensitivity(run(method), kind(output), ["glider.velocity.x"])
    assert found.values[0] == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("method", METHODS)
def test_least_values(method: str) -> None:
    low = sr.Minimum(lambda o: -bell(o))
    assert sr.sensitivity(run(method), low, ["glider.velocity.x"]).values[0] == pytest.approx(-1, abs=1e-3)


@pytest.mark.parametrize("method", METHODS)
def test_derivatives_of_a_narrow_bell(method: str) -> None:
    """∫ f(x₀ + v t) dt ~ 1/v where the bell is passed: its derivative is -1/v of it, the second one 2/v²."""
    response, names = sr.Integral(bell), ["glider.velocity.x", "glider.position.x"]
    found = sr.sensitivity(run(method), response, names)
    value, turned = INTEGRALS[bell], 2 / 2.0  # the integral of the absolute derivative by the position
    assert found.matrix[0] == pytest.approx(
        [-value / 2, 0], abs=(2e-4 if method == "Radau" else 1e-2) * turned
    )
    bent = sr.hessian(run(method), response, names).matrix
    bends = 4 * np.exp(-0.5) / np.sqrt(2) / WIDTH  # twice the height of the first derivative
    assert bent == pytest.approx(
        np.array([[value / 2, 0], [0, 0]]), abs=(3e-4 if method == "Radau" else 3e-2) * bends
    )


def test_an_output_of_round_off_is_left_alone() -> None:
    """A coordinate that stays zero, and a difference of numbers that are equal: nothing is searched in their digits."""
    for output in ("glider.y", lambda o: np.sin(o.t) ** 2 + np.cos(o.t) ** 2 - 1):
        found = sr.sensitivity(run("Radau"), sr.Integral(output), ["glider.velocity.x"])
        assert abs(found.values[0]) < 1e-14
        assert not found.warnings


def test_what_no_number_of_samples_shows_is_said() -> None:
    response = sr.Integral(lambda o: np.sin(1e7 * o.t), name="noise")
    with pytest.warns(sr.SarrusWarning, match="noise: its output changes so fast, .* max_step"):
        sr.sensitivity(run("Radau"), response, ["glider.velocity.x"])


def test_a_narrow_bell_between_events() -> None:
    """Stretches end at events that change velocities; the bell lies in the second one."""
    wall = sr.Event("glider.x - 0.5", direction=1, reset=sr.Impact(1.0), name="wall")
    there = sr.simulate(glider(2.0), until=1.0, events=wall, store_steps=True)
    found = sr.sensitivity(there, sr.Integral(bell), ["glider.velocity.x"])
    assert found.values[0] == pytest.approx(2 * INTEGRALS[bell], rel=3e-5)
    assert found.matrix[0, 0] == pytest.approx(-INTEGRALS[bell], abs=2e-4)


def hanging(amplitude: float, unit: float = 1.0) -> sr.System:
    """A mass on a spring, 5.39 units of length below the origin."""
    place = np.array([0.1, 0.2, -5.0 - 2 * 9.81 / 50 - amplitude])
    body = sr.Body("m", 2.0, (unit**2,) * 3, position=tuple(unit * place))
    slide = sr.Translational("g", sr.ground, body, point=(0.1 * unit, 0.2 * unit, 0), axis=(0, 0, 1))
    above = sr.ground.point(0.1 * unit, 0.2 * unit, 0)
    spring = sr.TSDA("s", above, body.point(0, 0, 0), k=50.0, length=5.0 * unit)
    return sr.System(sr.Model("hanging", [body], [slide], [spring], gravity=(0, 0, -9.81 * unit)))


@pytest.mark.parametrize("unit", [1.0, 1e-9])
@pytest.mark.parametrize("kind", [sr.Peak, sr.Maximum, sr.Integral])
def test_round_off_of_a_mass_at_rest_is_not_resolved(kind: Any, unit: float) -> None:
    """Its energy, some 1e-28 J, was sampled 60,000 times within four steps, which took 5 s, with a warning."""
    found = sr.simulate(hanging(0.0, unit), until=2.0, store_steps=True)
    response = kind("energy.kinetic")
    evaluation = Evaluation(found.system, found.steps, [response], Parameters(found.system, []))
    assert abs(evaluation.values[0]) < 1e-24 * unit**2
    assert len(evaluation.signals[0]) < 100


@pytest.mark.parametrize("unit", [1.0, 1e-9])
def test_motions_in_nanometres_are_resolved_as_those_in_metres(unit: float) -> None:
    """How long a mass nearly stops: v of 5 sin(5 t) is within 0.02 units; in nanometres a fifth of it was missing."""
    found = sr.simulate(hanging(1.0, unit), until=3.0, store_steps=True)
    response = sr.Integral(lambda o: np.exp(-((o["m.velocity.z"] / (0.02 * unit)) ** 2)), name="stops")
    time = sr.sensitivity(found, response, []).values[0]
    assert time == pytest.approx(4.5 * np.sqrt(np.pi) * 0.02 / 25, rel=2e-5)


def test_tiny_motions_far_from_the_origin_are_resolved() -> None:
    """Of 1 μm: round-off of positions is 1e-9 of it."""
    found = sr.simulate(hanging(1e-6), until=2.0, rtol=1e-10, atol=1e-14, store_steps=True)
    energies = sr.sensitivity(found, [sr.Integral("energy.kinetic"), sr.Peak("energy.kinetic")], [])
    highest, phase = 0.5 * 50.0 * 1e-12, 2 * 5.0 * 2.0
    assert energies.values == pytest.approx([highest * (1 - np.sin(phase) / phase), highest], rel=1e-4)
