"""Laws given as texts in Python have units that fit their places, as in files: "5 kg" was a stiffness of 5 N/m."""

from collections.abc import Callable
from typing import Any

import pytest

import sarrus as sr
from sarrus.model.drivers import Driver
from sarrus.model.forces import Force
from sarrus.model.laws.text_units import _laws
from sarrus.model.measure import measures

BALL = sr.Body("ball", mass=1, inertia=(1, 1, 1), position=(1, 0, 0))
A, B = sr.ground.point(0, 0, 0), BALL.point(0, 0, 0)
PIN = sr.Revolute("pin", sr.ground, BALL, point=(0, 0, 0), axis=(0, 0, 1))
SLIDE = sr.Translational("slide", sr.ground, BALL, point=(0, 0, 0), axis=(1, 0, 0))
FRAMES = {"frame_i": sr.ground.frame((0, 0, 0), z=(0, 0, 1)), "frame_j": BALL.frame((0, 0, 0), z=(0, 0, 1))}


def force(part: Force) -> sr.Model:
    return sr.Model("m", [BALL], [], [part])


def driver(part: Driver, joint: Any = PIN) -> sr.Model:
    return sr.Model("m", [BALL], [joint], drivers=[part])


def tsda(**law: Any) -> sr.Model:
    return force(sr.TSDA("s", A, B, **({"k": 1.0, "length": 0.5} | law)))


CASES: dict[str, tuple[Callable[[Any], sr.Model], str, str]] = {  # the model, a right text, a wrong one
    "k": (lambda x: tsda(k=x), "5 N/mm", "5 kg"),
    "c": (lambda x: tsda(c=x), "5 N*s/m", "5 N/m"),
    "force": (lambda x: tsda(force=x), "5 N * sin(2*pi*t)", "5 m"),
    "force of the variable": (lambda x: tsda(force=x), "5 N/s * t", "5 m/s * t"),
    "k of the variable": (lambda x: tsda(k=x), "5 N/m^2 * x", "5 N * x"),
    "point force": (lambda x: force(sr.PointForce("f", B, force=(x, 0, 0))), "5 N", "5 N m"),
    "factor": (lambda x: force(sr.PointForce("f", B, force=(1, 0, 0), factor=x)), "sin(t)", "5 N"),
    "torque": (lambda x: force(sr.Torque("f", BALL, torque=(0, 0, x))), "5 N*m", "5 N"),
    "angle": (lambda x: driver(sr.AngleDriver("d", "pin", x)), "30 deg", "5 m"),
    "angle over time": (lambda x: driver(sr.AngleDriver("d", "pin", x)), "3 rad/s * t", "3 m/s * t"),
    "displacement": (lambda x: driver(sr.DisplacementDriver("d", "slide", x), SLIDE), "1 m + 5 mm", "1 kg"),
    "distance": (lambda x: driver(sr.DistanceDriver("d", A, B, x)), "1000 mm", "1 s"),
    "path": (lambda x: driver(sr.PointDriver("d", B, x=x)), "1 m", "1 rad*m*s"),
    "coordinate": (lambda x: driver(sr.CoordinateDriver("d", BALL, "x", x)), "1 m", "1 kg"),
    "Euler parameter": (lambda x: driver(sr.CoordinateDriver("d", BALL, "e0", x)), "1", "1 m"),
    "formula": (lambda x: tsda(k=sr.parse_expression(x)), "5 N/m", "5 kg"),
}


@pytest.mark.parametrize("case", CASES)
def test_a_unit_that_does_not_fit_is_refused(case: str) -> None:
    make, right, wrong = CASES[case]
    sr.System(make(right))
    with pytest.raises(
        sr.ModelError, match=r'expects .*, but ".*" is in .*. Give it in .*, or omit the unit'
    ):
        sr.System(make(wrong))


def test_the_message_is_that_of_files(tmp_path: Any) -> None:
    text = """
bodies: {ball: {mass: 1, inertia: [1, 1, 1], position: [1, 0, 0]}}
forces: {s: {type: tsda, k: 5 kg * x, length: 0.5, points: [[ground, 0, 0], [ball, 0, 0]]}}
""".replace("[ground, 0, 0]", "{body: ground, at: [0, 0, 0]}").replace(
        "[ball, 0, 0]", "{body: ball, at: [0, 0, 0]}"
    )
    (tmp_path / "m.yaml").write_text(text)
    with pytest.raises(sr.ModelError) as of_file:
        sr.load(tmp_path / "m.yaml")
    with pytest.raises(sr.ModelError) as of_python:
        sr.System(tsda(k="5 kg * x"))
    assert of_file.value.message.split("expects")[1] == of_python.value.message.split("expects")[1]


@pytest.mark.parametrize("kind", [*Force.kinds.values(), *Driver.kinds.values()])
def test_every_law_says_what_it_measures(kind: type) -> None:
    """A field that may be a text has a unit, so that it is checked."""
    texts = [
        name for name, told in kind.__annotations__.items() if "Law" in str(told) or "Motion" in str(told)
    ]
    part = kind.__new__(kind)
    if kind is sr.CoordinateDriver:
        object.__setattr__(part, "coordinate", "x")
    later = {
        name for name, one in measures(kind).items() if one.outputs and one.over == "1"
    }  # with those of outputs
    assert set(texts) - later <= set(_laws(part))
