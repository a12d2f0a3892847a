"""Events and impacts along functions of outputs are those of formulas."""

from functools import cache

import numpy as np
import pytest

import sarrus as sr

BALL = sr.Body("the-ball", mass=1.0, inertia=(1, 1, 1), position=(0, 0, 1))


@cache
def dropped() -> sr.System:
    """A ball above the ground."""
    return sr.System(sr.Model("m", [BALL], gravity=(0, 0, -10.0)))


def gap(o: sr.Outputs) -> object:
    """Twice the height over 0.2 m."""
    return 2 * (o("the-ball.z") - o["0.1*2"]) + np.sin(0 * o.t)


@pytest.mark.parametrize("along", [gap, "'the-ball'.z", lambda o: o("the-ball.z")])
@pytest.mark.parametrize("function", [gap, lambda t, q, v: q[2] - 0.2])
def test_an_impact_along_a_function(function: object, along: object) -> None:
    """A ball from 0.8 m above the floor strikes it at 0.4 s, and is back at 0.2 m + 0.25 · 0.8 m at 0.6 s."""
    hit = sr.Event(function, direction=-1, reset=sr.Impact(0.5, along=along), name="hit")
    run = sr.simulate(dropped(), until=0.6, events=hit, method=sr.Radau(rtol=1e-9))
    assert run.events[0].t == pytest.approx(0.4, abs=1e-7)
    assert run["the-ball.z"][-1] == pytest.approx(0.4, abs=1e-6)


def test_an_impact_along_the_function_of_its_event() -> None:
    run = sr.simulate(
        dropped(), until=0.6, events=sr.Event(gap, reset=sr.Impact(0.5)), method=sr.Radau(rtol=1e-9)
    )
    assert (run.events[0].name, round(run["the-ball.z"][-1], 6)) == ("gap", 0.4)


@pytest.mark.parametrize("wrong", [3, lambda o: o.position("the-ball")[2], lambda o: "x", lambda o: o("a +")])
def test_what_is_no_formula_is_refused(wrong: object) -> None:
    with pytest.raises(TypeError, match="along of an Impact must be a formula"):
        sr.Impact(0.5, along=wrong)
