"""Prescribed motions whose value, rate or acceleration is infinite within a run are refused by the driver's name."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import sarrus as sr


def driven(motion: Any) -> sr.System:
    wheel = sr.Body("wheel", 1.0, (1, 1, 1))
    pin = sr.Revolute("pin", sr.ground, wheel, point=(0, 0, 0), axis=(0, 0, 1))
    return sr.System(sr.Model("wheel", [wheel], [pin], drivers=[sr.AngleDriver("motor", "pin", motion)]))


ANALYSES = [sr.kinematics, sr.simulate]
INFINITE: list[tuple[Any, str]] = [
    ("sqrt(t)", "rate at t = 0 s"),
    ("0.5*t**1.5", "acceleration at t = 0 s"),
    ("1/t", "value at t = 0 s"),
    ("log(t)", "value at t = 0 s"),
    ("t*log(t + 1e-300)", "rate at t = 0 s"),
    ("1/(t - 0.5)", "value at t = 0.5 s"),
    ("sqrt(1 - t)", "rate at t = 1 s"),
    ("max(0, t - 0.25)**0.5", "rate at t = 0.25 s"),
    (lambda t: t**0.5, "rate at t = 0 s"),
    (lambda t: 1 / t, "value at t = 0 s"),
    (lambda t: (t - 0.5) ** 0.5, "value at t = 0 s"),
]


@pytest.mark.parametrize("analysis", ANALYSES)
@pytest.mark.parametrize(("motion", "fault"), INFINITE)
def test_infinite_motions_are_refused(analysis: Callable[..., Any], motion: Any, fault: str) -> None:
    with pytest.raises(
        sr.ModelError, match=rf"motor: its motion has no finite {fault}. Choose other times, or"
    ):
        analysis(driven(motion), until=1.0)


FINITE = ["sin(3*t)", "t**3", "t**2.5", "max(0, t - 0.25)**1.5", "abs(t - 0.5)", "abs(sin(20*t))", "tanh(99*(t - 0.5))",
          "cos(2*pi*t)", "(t - 0.5)**2", "exp(-(t - 0.5)**2/1e-4)"]  # fmt: skip


@pytest.mark.filterwarnings("ignore:.*initial")
@pytest.mark.parametrize("motion", FINITE)
def test_finite_motions_pass(motion: str) -> None:
    run = sr.kinematics(driven(motion), until=1.0)
    assert run.success
    assert np.isfinite(run["pin.angle.acceleration"]).all()


def test_a_motion_is_refused_only_where_it_is_used() -> None:
    assert sr.kinematics(driven("sqrt(t)"), np.linspace(1.0, 2.0, 11)).success
