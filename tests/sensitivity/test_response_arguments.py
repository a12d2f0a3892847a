"""Arguments of responses in the wrong place: a time that was taken for a name gave the value at the start."""

from __future__ import annotations

import pytest

import sarrus as sr


@pytest.mark.parametrize(
    "response", [sr.At, sr.Final, sr.Integral, sr.Peak, sr.Maximum, sr.Misfit, sr.AtEvent]
)
def test_names_of_responses_are_texts(response: type[sr.At]) -> None:
    with pytest.raises(TypeError, match=r"name must be a text, got 0\.5"):
        response("slider.x", 0.5)  # type: ignore[arg-type]


def test_an_unknown_output_of_a_part_is_compared_with_those_of_this_part() -> None:
    ball = sr.Body("ball", mass=1, inertia=(1, 1, 1), position=(1, 0, 0))
    spring = sr.TSDA("s", sr.ground.point(0, 0, 0), ball.point(0, 0, 0), k=1.0, c=0.0, length=1.0)
    pin = sr.Revolute("q", sr.ground, ball, point=(0, 0, 0), axis=(0, 0, 1))
    run = sr.simulate(sr.System(sr.Model("one", [ball], [pin], [spring])), until=0.1, store_steps=True)
    with pytest.raises(sr.SarrusError, match=r"no output 's.pull'. Choose from s\."):
        sr.sensitivity(run, sr.Final("s.pull"), ["ball.mass"])
