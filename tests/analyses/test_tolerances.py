"""Tolerances in the units of their user."""

import numpy as np
import pytest
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus.analyses.dynamics.stepping.tolerance import Tolerances

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
        sr.simulate(slider_crank(), until=0.2, t_eval=[0.2], rtol=1e-5, atol=given)
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
        sr.simulate(slider_crank(), until=0.1, atol=given)


def test_a_relative_tolerance_has_no_unit() -> None:
    with pytest.raises(ValueError, match="rtol of position must be a plain number"):
        sr.simulate(slider_crank(), until=0.1, rtol={"position": "1 um"})
