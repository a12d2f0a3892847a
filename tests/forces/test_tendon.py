"""Tendons: against forces between two points, and against the power of a rope over pulleys."""

import numpy as np
import pytest

import sarrus as sr


def arm(*forces: sr.Force) -> sr.System:
    """Two links, swinging from the ground, with forces."""
    upper = sr.Body("upper", 1.0, (0.1, 0.2, 0.3), (0.3, 0, 0))
    lower = sr.Body("lower", 2.0, (0.1, 0.2, 0.3), (0.9, 0, 0))
    hip = sr.Revolute("hip", sr.ground, upper, point=(0, 0, 0), axis=(0, 1, 0))
    knee = sr.Revolute("knee", upper, lower, point=(0.6, 0, 0), axis=(0, 1, 0))
    return sr.System(sr.Model("arm", [upper, lower], [hip, knee], forces, gravity=(0, 0, -9.81)))


BODIES = arm().model.bodies
VALUE = {"value": "-k*(x - 0.7) - 0.3*v", "parameters": {"k": 5.0}}
ENDS = sr.ground.point(0.1, 0, 0.4), BODIES[1].point(0.2, 0, 0.1)
VIA = BODIES[0].point(-0.1, 0, 0.2), BODIES[0].point(0.1, 0, 0.3)
TENDONS = {
    "two points": (sr.Tendon("t", ENDS, **VALUE), {}),
    "pulleys": (sr.Tendon("t", [ENDS[0], *VIA, ENDS[1]], factors=[1, 2, 0.5], **VALUE), {}),
    "gap": (sr.Tendon("t", [ENDS[0], VIA[0], VIA[1], ENDS[1]], factors=[1, 0, 0.5], **VALUE), {}),
    "joints": (sr.Tendon("t", joints={"hip": 0.5, "knee.angle": -1.5}, **VALUE), {}),
}


@pytest.mark.parametrize("name", TENDONS)
def test_a_tendon_does_work_along_its_length(name: str) -> None:
    """Its power is F ẋ, with the rate of the length by its differences, on a motion whose energy is balanced."""
    run = sr.simulate(arm(TENDONS[name][0]), until=0.4, t_eval=np.linspace(0, 0.4, 4001), rtol=1e-9)
    length, rate, value = run["t.length"], run["t.rate"], run["t.value"]
    assert np.ptp(length) > 0.1
    np.testing.assert_allclose((length[2:] - length[:-2]) / 2e-4, rate[1:-1], atol=1e-5)
    np.testing.assert_allclose(value, -5 * (length - 0.7) - 0.3 * rate, atol=1e-10)
    np.testing.assert_allclose(run["t.power"], value * rate, atol=1e-9)


def test_a_tendon_of_two_points_is_a_force_between_them() -> None:
    runs = [
        sr.simulate(arm(one), until=0.5) for one in (TENDONS["two points"][0], sr.Force("t", *ENDS, **VALUE))
    ]
    np.testing.assert_allclose(runs[0].q[-1], runs[1].q[-1], rtol=0, atol=1e-9)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("name", ["pulleys", "joints"])
def test_derivatives(name: str) -> None:
    assert arm(TENDONS[name][0]).check_derivatives()


MISTAKES = {
    "both": (sr.Tendon("t", ENDS, joints={"hip": 1.0}, value=1), "must have points or joints"),
    "neither": (sr.Tendon("t", value=1), "must have points or joints"),
    "factors": (sr.Tendon("t", ENDS, factors=[1, 2], value=1), "one factor less than points"),
    "one body": (sr.Tendon("t", VIA, value=1), "no segment of it can move"),
    "no value": (sr.Tendon("t", ENDS), "value is missing"),
    "no point": (sr.Tendon("t", [ENDS[0], "upper"], value=1), 'points has "upper"'),
    "no joint": (sr.Tendon("t", joints={"hup": 1.0}, value=1), "there is no joint"),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_mistakes(name: str) -> None:
    tendon, words = MISTAKES[name]
    with pytest.raises(sr.ModelError, match=words):
        arm(tendon)
