"""A unit runs up to a sign with spaces: ``30 deg*t`` was 30 degree-tonnes, a constant of 524 rad, without a word."""

from __future__ import annotations

import pytest

import sarrus as sr

BALL = sr.Body("ball", mass=1, inertia=(1, 1, 1), position=(1, 0, 0))
PIN = sr.Revolute("pin", sr.ground, BALL, point=(0, 0, 0), axis=(0, 0, 1))


@pytest.mark.parametrize("text", ["30 deg*t", "2 kN*t", "1 + 5 N/t", "t + 3 t"])
def test_a_variable_within_a_unit_is_refused(text: str) -> None:
    force = sr.PointForce("push", BALL.point(0, 0, 0), (text, 0, 0))  # type: ignore[arg-type]
    driver = sr.AngleDriver("motor", "pin", text)
    for model in (
        sr.Model("m", [BALL], [], [force]),
        sr.Model("m", [BALL], [PIN], drivers=[driver]),
    ):
        with pytest.raises(sr.ModelError, match=r"t counts as a unit, the tonne, .*a space on each side"):
            sr.System(model)


def test_a_variable_behind_a_unit_is_one() -> None:
    driver = sr.AngleDriver("motor", "pin", "30 deg/s * t")
    system = sr.System(sr.Model("m", [BALL], [PIN], drivers=[driver]))
    run = sr.kinematics(system, [0.0, 1.0])
    assert run.joint("pin").angle[-1] == pytest.approx(0.5235987755982988)
