"""Tolerances in the units of their user."""

from typing import Any

import numpy as np
import pytest
from scipy.special import ellipj, ellipk
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus._jit.linking.link import link
from sarrus.analyses.dynamics.integrators import described
from sarrus.analyses.dynamics.stepping.motion_scale import (
    KNOWN,
    LARGEST,
    SPAN,
    Tolerance,
    periods,
    share_of,
)
from sarrus.analyses.dynamics.stepping.tolerance import Tolerances, begin_motion

WITH_UNITS = {"position": "1 um", "orientation": "0.01 deg", "velocity": "3 mm/s", "rotation": "2 deg/s"}
PLAIN = {"position": 1e-6, "orientation": np.radians(0.005), "velocity": 3e-3, "rotation": np.radians(1)}


def test_texts_with_units_by_kind() -> None:
    one, other = (Tolerances.of(slider_crank(), 1e-6, given) for given in (WITH_UNITS, PLAIN))
    for name in ("atol_q", "atol_v", "rtol_q"):
        assert np.allclose(getattr(one, name), getattr(other, name), rtol=1e-15, atol=0), name
    assert one.speed


def test_an_angle_is_half_of_it_in_euler_parameters() -> None:
    """A turn by a small angle changes four Euler parameters together by half the angle."""
    axis, angle = np.array([0.6, 0, 0.8]), 1e-6
    before, after = (np.array([np.cos(x / 2), *np.sin(x / 2) * axis]) for x in (0.7, 0.7 + angle))
    atol = {"position": "1 m", "orientation": f"{angle} rad"}
    assert np.linalg.norm(after - before) == pytest.approx(
        Tolerances.of(slider_crank(), 1e-6, atol).atol_q[3]
    )


def test_a_run_with_units_is_the_run() -> None:
    one, other = (
        sr.simulate(slider_crank(), until=0.2, t_eval=[0.2], method=sr.Radau(rtol=1e-5, atol=given))
        for given in (WITH_UNITS, PLAIN)
    )
    assert np.allclose(one.q, other.q, rtol=0, atol=1e-12)
    assert one.nsteps == other.nsteps


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ("1 um", "a unit needs a kind"),
        ({"position": "1 deg"}, "atol of position must be in m"),
        ({"position": "1 mm", "velocity": "1 mm"}, "atol of velocity must be in m/s"),
        ({"position": "1 banana"}, 'unknown unit "banana"'),
        ({"position": "-1 mm"}, "positive and finite"),
    ],
)
def test_units_that_do_not_fit_are_told(given: object, told: str) -> None:
    with pytest.raises(ValueError, match=told):
        sr.simulate(slider_crank(), until=0.1, method=sr.Radau(atol=given))


def test_a_relative_tolerance_has_no_unit() -> None:
    with pytest.raises(ValueError, match="rtol of position must be a plain number"):
        sr.simulate(slider_crank(), until=0.1, method=sr.Radau(rtol={"position": "1 um"}))


def test_tolerances_fall_with_the_number_of_periods() -> None:
    """Their factor to the power 1.3 and errors are proportional: beyond 200 periods it makes up for the square."""
    share = link(share_of)
    assert share(16.0, KNOWN) == pytest.approx(0.5)
    assert share(200.0, KNOWN) == pytest.approx(200**-0.25)
    assert share(201.0, KNOWN) == pytest.approx(share(200.0, KNOWN), rel=0.01)
    assert share(600.0, KNOWN) / share(300.0, KNOWN) == pytest.approx(2**-1.5)
    assert share(1e6, KNOWN) == share(1e4, KNOWN) < 0.1
    assert share(1e6, KNOWN - 1) == 0.1  # a start from rest, whose period is unknown


@pytest.mark.parametrize(("place", "speed"), [(0.1, 0.0), (0.0, 0.6), (0.1, 0.6)])
def test_periods_of_a_linear_oscillation_are_counted_within_a_factor_of_two(
    place: float, speed: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From rest half of them, as the displacement is counted from the start, and not by what outputs happen to see."""
    followed: list[Tolerance] = []

    def begin(tolerance: Tolerance, *given: Any) -> None:
        followed.append(tolerance)
        begin_motion(tolerance, *given)

    monkeypatch.setattr(described, "begin_motion", begin)
    body = sr.Body("b", 1.0, (1, 1, 1), position=(place, 0, 0), velocity=(speed, 0, 0))
    guide = sr.Translational("guide", sr.ground, body, point=(0, 0, 0), axis=(1, 0, 0))
    spring = sr.TSDA("spring", sr.ground.point(-1, 0, 0), body.point(0, 0, 0), k=40.0, length=1.0)
    number, period = 20, 2 * np.pi / 40**0.5
    system = sr.System(sr.Model("oscillator", [body], [guide], [spring]))
    sr.simulate(system, until=number * period, t_eval=np.arange(number + 1) * period)
    size = followed[0].size
    counted = link(periods)(size[SPAN], size[LARGEST + 2], size[LARGEST])
    assert number / 2 * 0.999 < counted < 2 * number


@pytest.mark.slow
@pytest.mark.filterwarnings(
    "ignore:.*which the outputs do not resolve"
)  # some outputs of two thousand swings
def test_a_pendulum_has_four_digits_after_a_thousand_periods() -> None:
    """From the horizontal: θ = 2 asin(k sn(K - ω t)), k² = ½. It had three with the fourth root alone."""
    t = np.linspace(0.0, 2000.0, 51)
    bob = sr.Body("bob", 1.0, (1e-3,) * 3, position=(1, 0, 0))
    pin = sr.Revolute("pin", sr.ground, bob, point=(0, 0, 0), axis=(0, -1, 0))
    run = sr.simulate(
        sr.System(sr.Model("pendulum", [bob], [pin], gravity=(0, 0, -9.81))), until=2000.0, t_eval=t
    )
    exact = 2 * np.arcsin(ellipj(ellipk(0.5) - np.sqrt(9.81 / 1.001) * t, 0.5)[0] / np.sqrt(2))
    assert abs(run.output("pin.angle").values - (exact - np.pi / 2)).max() < 1e-4 * np.pi
