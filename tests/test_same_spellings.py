"""Python takes times with units and methods by name, as the command line and files do."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from tests.sensitivity.checkpoints import by_checkpoints

import sarrus as sr

BALL = sr.Body("ball", mass=1.0, inertia=(1, 1, 1), position=(0, 0, 1))


@cache
def dropped() -> sr.System:
    """A ball above the ground."""
    return sr.System(sr.Model("m", [BALL], gravity=(0, 0, -10.0)))


@pytest.mark.parametrize(
    ("name", "method"),
    [
        ("radau", sr.Radau()),
        ("HHT", sr.HHT()),
        ("generalizedalpha", sr.GeneralizedAlpha()),
        ("ode", sr.ODE()),
    ],
)
def test_methods_by_name_and_times_with_units(name: str, method: object) -> None:
    by_text = sr.simulate(dropped(), until="200 ms", limits=sr.Limits(time="1 min"), method=name)
    by_number = sr.simulate(dropped(), until=0.2, limits=sr.Limits(time=60), method=method)
    assert np.array_equal(by_text.q, by_number.q)
    assert replace(method, max_step="10 ms", first_step="1 ms") == replace(
        method, max_step=0.01, first_step=0.001
    )
    assert by_text.t[-1] == 0.2


def test_of_searches_and_checkpoints() -> None:
    asked = {"until": "0.1 s", "method": "radau"}
    found = by_checkpoints(dropped(), "ball.z", ["ball.position.z"], **asked)
    assert found.matrix[0, 0] == pytest.approx(1)
    best = sr.optimize(dropped(), "(ball.z - 2)**2", ["ball.position.z"], **asked)
    assert best.x[0] == pytest.approx(2.05)


def test_equal_intervals_of_kinematics() -> None:
    slide = sr.Translational("slide", sr.ground, BALL, axis=(1, 0, 0), point=(0, 0, 1))
    driver = sr.DisplacementDriver("drive", "slide", "t")
    run = sr.kinematics(sr.System(sr.Model("m", [BALL], [slide], drivers=[driver])), until="1 s", steps=4)
    assert run.t == pytest.approx([0, 0.25, 0.5, 0.75, 1])


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"until": "1 m"}, "until must be in s, or another unit of that kind"),
        ({"until": "soon"}, "until must be a time in s"),
    ],
)
def test_wrong_ones_are_refused(given: dict[str, object], message: str) -> None:
    with pytest.raises(sr.SarrusError) as refused:
        sr.simulate(dropped(), **given)
    assert message in str(refused.value)


def test_analyses_of_studies() -> None:
    assert sr.Simulation(until="200 ms").until == 0.2
    assert sr.Problem(dropped(), "ball.z", ["ball.mass"], until="0.1 s").values([1.0]) == pytest.approx(
        [0.95]
    )
    assert sr.Kinematics(times=np.array([0.25, 0.5])) == sr.Kinematics(until="0.5 s", times=(0.25, 0.5))
    with pytest.raises(sr.SarrusError, match="until is missing"):
        sr.Kinematics()
