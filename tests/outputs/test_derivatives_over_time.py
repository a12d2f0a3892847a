"""`StateDerivatives` gives the derivatives of any output by its name, those of responses at the same times."""

from functools import cache

import numpy as np
import pytest
from tests.outputs.test_every_name_everywhere import WANTED, system

import sarrus as sr

WRT = ["rod.mass", "spring.k", "magnet.strength"]
METHODS = {"HHT": sr.HHT(), "stabilized": sr.GeneralizedAlpha(stabilized=True), "Radau": sr.Radau()}


@cache
def run(method: str) -> sr.Trajectory:
    return sr.simulate(system(), until=0.05, method=METHODS[method], store="steps")


@cache
def derivatives(method: str) -> sr.results.StateDerivatives:
    return sr.state_derivatives(run(method), WRT)


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_derivatives_over_time_are_those_of_responses(method: str) -> None:
    found, names = derivatives(method), [*WANTED, "crank.angular_velocity_body.y"]
    for n in (0, len(found.t) // 2, len(found.t) - 1):
        responses = [sr.At(name, time=float(found.t[n])) for name in names]
        wanted = sr.sensitivity(run(method), responses, WRT).matrix
        for name, row in zip(names, wanted, strict=True):
            values = np.array([found[name, parameter][n] for parameter in WRT])
            assert values == pytest.approx(row, rel=1e-8, abs=1e-10 * (1 + abs(row).max())), name


def test_derivatives_of_coordinates_are_those_of_the_states() -> None:
    found = derivatives("Radau")
    for name in ("slider.x", "slider.r.x"):
        assert np.array_equal(found[name, "spring.k"], found.q_b[:, 14, 1])
    assert found.output("spring.tension").shape == (len(found.t), 3)


def test_unknown_names_are_refused_with_the_nearest() -> None:
    with pytest.raises(KeyError, match=r"no output 'spring\.tenson'. Did you mean \"spring\.tension\"\?"):
        derivatives("Radau")["spring.tenson", "spring.k"]
    with pytest.raises(KeyError, match=r'as in d\["slider\.x", "rod\.mass"\]'):
        derivatives("Radau")["spring.tension"]
