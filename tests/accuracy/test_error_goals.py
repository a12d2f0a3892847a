"""Runs that are repeated until their responses are as exact as a user wants."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import sarrus as sr


def oscillator() -> sr.System:
    """10 rad/s, from 0.1 m."""
    mass = sr.Body("mass", 1.0, (1e-3,) * 3, position=(0.1, 0, 0))
    guide = sr.Translational("guide", sr.ground, mass, point=(0, 0, 0), axis=(1, 0, 0))
    spring = sr.TSDA("spring", sr.ground.point(-1, 0, 0), mass.point(0, 0, 0), k=100.0, length=1.0)
    return sr.System(sr.Model("oscillator", [mass], [guide], [spring]))


EXACT = 0.1 * np.cos(20.0)


@pytest.mark.one_in(8)
@pytest.mark.parametrize(
    "settings",
    [
        {"method": sr.Radau(), "rtol": 1e-3, "atol": 1e-4},
        {"method": sr.Radau(), "rtol": {"position": 1e-3}, "atol": {"position": "100 um"}},
        {"method": sr.HHT(), "rtol": 1e-4, "atol": 1e-5},
        {"method": sr.HHT(step=0.01)},
    ],
)
@pytest.mark.parametrize("goal", ["1 um", 2e-5])
def test_goals_are_met(settings: Any, goal: Any) -> None:
    first = sr.simulate(oscillator(), until=2.0, **settings).output("mass.x").values[-1]
    wanted = 1e-6 if goal == "1 um" else goal
    assert abs(first - EXACT) > wanted
    run = sr.simulate(oscillator(), until=2.0, error={"mass.x": goal}, **settings)
    assert run.success, run.message
    assert abs(run.output("mass.x").values[-1] - EXACT) < wanted
    assert run.error("mass.x").error < wanted


def test_several_responses() -> None:
    goals = {"mass.x": "10 um", sr.Integral("mass.x"): 1e-7}
    run = sr.simulate(oscillator(), until=2.0, method=sr.Radau(), rtol=1e-2, error=goals)
    assert abs(run.error(sr.Integral("mass.x")).value - 0.01 * np.sin(20.0)) < 1e-7


def test_a_goal_below_round_off_is_missed() -> None:
    run = sr.simulate(oscillator(), until=2.0, method=sr.Radau(), error={"mass.x": 1e-18})
    assert not run.success
    assert run.status == "error goal missed"
    assert "mass.x" in run.message


@pytest.mark.parametrize(
    ("goal", "message"),
    [("1 deg", "must be in m"), (0.0, "positive"), (-1.0, "positive"), ("1 qqq", "qqq")],
)
def test_wrong_goals(goal: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        sr.simulate(oscillator(), until=1.0, error={"mass.x": goal})


@pytest.mark.parametrize("goals", [1e-6, ["mass.x"], sr.Final("mass.x")], ids=str)
def test_goals_without_responses_or_sizes_are_refused(goals: Any) -> None:
    with pytest.raises(TypeError, match="error must be a mapping of responses"):
        sr.simulate(oscillator(), until=1.0, error=goals)
