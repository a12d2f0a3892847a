"""Runs that are repeated until their responses are as exact as a user wants."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import sarrus as sr
from sarrus.analyses.dynamics import error_goal


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
        {"method": sr.Radau(rtol=1e-3, atol=1e-4)},
        {"method": sr.Radau(rtol={"position": 1e-3}, atol={"position": "100 um"})},
        {"method": sr.HHT(rtol=1e-4, atol=1e-5)},
        {"method": sr.HHT(step=0.01)},
    ],
)
@pytest.mark.parametrize("goal", ["1 um", 2e-5])
def test_goals_are_met(settings: Any, goal: Any) -> None:
    first = sr.simulate(oscillator(), until=2.0, **settings).output("mass.x").values[-1]
    wanted = 1e-6 if goal == "1 um" else goal
    assert abs(first - EXACT) > wanted
    run = sr.simulate(oscillator(), until=2.0, limits=sr.Limits(errors={"mass.x": goal}), **settings)
    assert run.success, run.message
    assert abs(run.output("mass.x").values[-1] - EXACT) < wanted
    assert run.error("mass.x").error < wanted


def test_several_responses() -> None:
    goals = {"mass.x": "10 um", sr.Integral("mass.x"): 1e-7}
    run = sr.simulate(oscillator(), until=2.0, method=sr.Radau(rtol=1e-2), limits=sr.Limits(errors=goals))
    assert abs(run.error(sr.Integral("mass.x")).value - 0.01 * np.sin(20.0)) < 1e-7


def test_a_goal_below_round_off_is_missed() -> None:
    """The run has its end and its errors all the same."""
    run = sr.simulate(oscillator(), until=2.0, method=sr.Radau(), limits=sr.Limits(errors={"mass.x": 1e-18}))
    assert not run.success
    assert run.status == "error goal missed"
    assert run.message.startswith("the estimated error of final of mass.x is ")
    assert run.error("mass.x").error > 1e-18


def test_runs_are_not_repeated_with_tolerances_below_the_least_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    counts = list[int]()

    def noted(run: sr.Trajectory, *given: Any) -> Any:
        counts.append(run.nsteps)
        return estimator(run, *given)

    estimator = error_goal.estimator()
    monkeypatch.setattr(error_goal, "estimator", lambda: noted)
    system = sr.System(sr.load("slider_crank"))
    run = sr.simulate(
        system, until=0.2, method=sr.HHT(rtol=1e-12), limits=sr.Limits(errors={"slider.x": 1e-13})
    )
    assert run.status == "error goal missed"
    assert 1 < len(counts) < error_goal.REPEATS
    assert counts[-1] == counts[-2]


@pytest.mark.parametrize(
    ("goal", "message"),
    [("1 deg", "must be in m"), (0.0, "positive"), (-1.0, "positive"), ("1 qqq", "qqq")],
)
def test_wrong_goals(goal: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        sr.simulate(oscillator(), until=1.0, limits=sr.Limits(errors={"mass.x": goal}))


@pytest.mark.parametrize("goals", [1e-6, ["mass.x"], sr.Final("mass.x")], ids=str)
def test_goals_without_responses_or_sizes_are_refused(goals: Any) -> None:
    with pytest.raises(TypeError, match="errors must be a mapping of responses"):
        sr.simulate(oscillator(), until=1.0, limits=sr.Limits(errors=goals))


@pytest.mark.parametrize(
    ("limit", "reason"),
    [
        (sr.Limits(time=60.0), r"The time limit of 1 min 0 s has passed\. Choose"),
        (sr.Limits(steps=60), r"Smaller tolerances need too many steps\. Choose"),
    ],
)
def test_a_limit_that_ends_a_repeated_run_leaves_the_run_before(
    limit: sr.Limits, reason: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The message names the user's limit, not what is left of it."""
    estimator = error_goal.estimator()

    def late(*given: Any) -> Any:
        monkeypatch.setattr(error_goal.time, "monotonic", lambda: np.inf)
        return estimator(*given)

    if limit.time:
        monkeypatch.setattr(error_goal, "estimator", lambda: late)
    method, goal = sr.Radau(rtol=1e-3, atol=1e-4), replace(limit, errors={"mass.x": 1e-11})
    run = sr.simulate(oscillator(), until=2.0, method=method, limits=goal)
    assert (run.status, run.t[-1]) == ("error goal missed", 2.0)
    assert re.fullmatch(
        rf"the estimated error of final of mass\.x is .*, not 1e-11\. {reason} .*\.", run.message
    )
    assert run.error("mass.x").error > 1e-11


def test_a_goal_and_a_folder_are_refused() -> None:
    with pytest.raises(ValueError, match=r"save: runs with an error goal are not saved.*Remove save=\."):
        sr.simulate(oscillator(), until=2.0, limits=sr.Limits(errors={"mass.x": 1e-6}), save="run.sarrus")
