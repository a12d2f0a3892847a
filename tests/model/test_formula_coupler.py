"""Formula couplers: against a gear, and a cam by its formula, its reaction and its gradient."""

import numpy as np
import pytest

import sarrus as sr


def cam(mass: float = 1.0, **law: object) -> sr.System:
    shaft = sr.Body("shaft", mass, (0.1, 0.2, 0.1), (0.3, 0, 0))
    tappet = sr.Body("tappet", 1.0, (0.1, 0.1, 0.1), (0.9, 0, 0))
    pin = sr.Revolute("pin", sr.ground, shaft, point=(0, 0, 0), axis=(0, 1, 0))
    guide = sr.Translational("guide", sr.ground, tappet, point=(0.6, 0, 0), axis=(0, 0, 1))
    coupler = (
        sr.FormulaCoupler("cam", "guide", **law) if law else sr.Coupler("cam", "pin", "guide", ratio=0.2)
    )
    return sr.System(sr.Model("cam", [shaft, tappet], [pin, guide, coupler], gravity=(0, 0, -9.81)))


CAM = {"value": "a*sin(2*pin) + 0.2*pin.angle^2", "parameters": {"a": 0.1}}


def test_a_linear_formula_is_a_coupler() -> None:
    runs = [sr.simulate(cam(**law), until=3.0) for law in ({"value": "0.2*pin"}, {})]
    np.testing.assert_allclose(runs[0].q[-1], runs[1].q[-1], rtol=0, atol=1e-7)
    for name in ("cam.force.z", "cam.multiplier.1"):
        assert runs[0][name][-1] == pytest.approx(runs[1][name][-1], rel=1e-5)


@pytest.mark.slow
def test_a_cam_moves_its_tappet() -> None:
    run = sr.simulate(cam(**CAM), until=1.5, store="steps")
    angle = run["pin.angle"]
    np.testing.assert_allclose(
        run["guide.displacement"], 0.1 * np.sin(2 * angle) + 0.2 * angle**2, atol=1e-10
    )
    np.testing.assert_allclose(run["cam.force.z"], run["tappet.acceleration.z"] + 9.81, atol=1e-8)
    assert np.ptp(run["energy.total"]) < 1e-6
    gradient = sr.sensitivity(run, sr.Final("pin.angle"), ["cam.parameters.a"])
    ends = [
        sr.simulate(
            cam(**CAM | {"parameters": {"a": a}}), until=1.5, method=sr.Radau(rtol=1e-10, atol=1e-12)
        )["pin.angle"][-1]
        for a in (0.1 - 1e-4, 0.1 + 1e-4)
    ]
    assert gradient["cam.parameters.a"] == pytest.approx((ends[1] - ends[0]) / 2e-4, rel=1e-4)


def test_derivatives() -> None:
    assert cam(**CAM).check_derivatives()


@pytest.mark.slow
def test_a_table_over_the_angle() -> None:
    run = sr.simulate(cam(value=[(-9, -1.8), (0, 0), (1, 0.2), (9, 1.8)], over="pin.angle"), until=0.5)
    np.testing.assert_allclose(run["guide.displacement"], 0.2 * run["pin.angle"], atol=1e-10)


@pytest.mark.parametrize(
    ("value", "words"),
    [("t*pin", 'uses "t", but'), ("pin.rate", "depends on positions only"), ("x", "unknown name"), (None, "missing")],
)  # fmt: skip
def test_what_a_coupler_cannot_depend_on(value: object, words: str) -> None:
    with pytest.raises(sr.ModelError, match=words):
        cam(value=value)
