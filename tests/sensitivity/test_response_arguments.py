"""Arguments of responses in the wrong place: a time that was taken for a name gave the value at the start."""

from __future__ import annotations

import pytest

import sarrus as sr


@pytest.mark.parametrize("response", [sr.At, sr.Final, sr.Integral, sr.Maximum, sr.Misfit, sr.AtEvent])
def test_names_of_responses_are_texts(response: type[sr.At]) -> None:
    with pytest.raises(TypeError, match=r"name must be a text, got 0\.5"):
        response("slider.x", 0.5)  # type: ignore[arg-type]


def test_an_unknown_output_of_a_part_is_compared_with_those_of_this_part() -> None:
    ball = sr.Body("ball", mass=1, inertia=(1, 1, 1), position=(1, 0, 0))
    spring = sr.TSDA("s", sr.ground.point(0, 0, 0), ball.point(0, 0, 0), k=1.0, c=0.0, length=1.0)
    pin = sr.Revolute("q", sr.ground, ball, point=(0, 0, 0), axis=(0, 0, 1))
    run = sr.simulate(sr.System(sr.Model("one", [ball], [pin], [spring])), until=0.1, store="steps")
    with pytest.raises(sr.SarrusError, match=r"no output 's.pull'. Choose from s\."):
        sr.sensitivity(run, sr.Final("s.pull"), ["ball.mass"])


def falling() -> sr.System:
    ball = sr.Body("ball", mass=2, inertia=(1, 1, 1), velocity=(0, 0, 3))
    spring = sr.TSDA("s", sr.ground.point(0, 0, 5), ball.point(0, 0, 0), k=1.0, c=0.0, length=4.0)
    return sr.System(sr.Model("one", [ball], [], [spring], gravity=(0, 0, -9.81)))


@pytest.mark.parametrize(
    ("text", "response"),
    [
        ("max(ball.z)", sr.Maximum("ball.z")),
        ("min( ball(0, 0, 0.1).z )", sr.Minimum("ball(0, 0, 0.1).z")),
        ("integral(s.tension)", sr.Integral("s.tension")),
        ("final(ball.z)", sr.Final("ball.z")),
        ("ball(0, 0, 0.1).z", sr.Final("ball(0, 0, 0.1).z")),
    ],
)
def test_reductions_as_texts(text: str, response: sr.Final) -> None:
    """As studies and the command line write them."""
    run = sr.simulate(falling(), until=1.0, store="steps")
    found, wanted = (sr.sensitivity(run, one, ["ball.mass"]) for one in (text, response))
    assert found.values == wanted.values
    assert found["ball.mass"] == wanted["ball.mass"]
    assert found.responses == wanted.responses


def test_bounds_as_pairs_in_the_order_of_the_variables() -> None:
    """As SciPy has them."""
    search = {"until": 0.5, "progress": False}
    by_name = sr.optimize(falling(), "max(ball.z)", ["s.k"], bounds={"s.k": (0.5, 2.0)}, **search)
    assert sr.optimize(falling(), "max(ball.z)", ["s.k"], bounds=[(0.5, 2.0)], **search).x == by_name.x
    with pytest.raises(ValueError, match=r"there are 2 for 1 variables\. Give a pair \(low, high\) for each"):
        sr.optimize(falling(), "max(ball.z)", ["s.k"], bounds=[(0, 1), (0, 2)], **search)
