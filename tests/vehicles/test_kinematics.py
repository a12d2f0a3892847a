"""The kinematics of two published suspensions: static values, sweeps, slopes, and derivatives by their points."""

from functools import cache
from math import degrees, pi

import numpy as np
import pytest
from tests.vehicles.published import RADIUS, SUSPENSIONS, V23, Reference, corner, model, mp

import sarrus as sr

UNIT = {"rad": 180 / pi, "m": 1e3, "1": 1.0}
WHOLE = sr.Vehicle(wheelbase=1.351, cg_height=0.55, brake_share=0.81, drive_share=1.0)
DAMPER = {"V23": "lower_arm", "BAT": "upper_arm"}
STATIC = {  # as printed in the reports; the printed hub trail is positive if the steering axis is behind the centre
    "V23": {
        "caster": "16.22", "kingpin_inclination": "9.75", "caster_trail": "76.31", "scrub_radius": "50.13",
        "spindle_offset": "98.13", "mechanical_trail": "73.27", "hub_trail": "-5.00",
    },
    "BAT": {
        "caster": "15.71", "kingpin_inclination": "17.53", "caster_trail": "62.11", "scrub_radius": "21.39",
        "mechanical_trail": "59.79",
    },
}  # fmt: skip
PRINTED_ROLL_CENTRE = {"V23": 293.64, "BAT": 196.89}
NAMES = ("toe", "camber", "caster", "kingpin_inclination", "scrub_radius", "caster_trail", "mechanical_trail")
POINTS = (
    ("tie_inner", "z", "tie_rod.point_i.z"), ("tie_inner", "y", "tie_rod.point_i.y"),
    ("upper_ball", "z", "upper_ball.point.z"), ("lower_ball", "x", "lower_ball.point.x"),
    ("lower_rear", "y", "lower_rear.point.y"),
)  # fmt: skip


@cache
def analysed(name: str) -> sr.Suspension:
    points = SUSPENSIONS[name]
    system = sr.System(model(points, damper_on=DAMPER[name]))
    return sr.suspension(system, right=corner(points, RADIUS[name]), forward="-x", steps=4, vehicle=WHOLE)


@cache
def reference(name: str) -> Reference:
    return Reference(SUSPENSIONS[name], RADIUS[name])


def in_units(result: sr.Suspension, name: str, value: float) -> float:
    """A value in mm and degrees."""
    return value * UNIT[result.response(name).characteristic.unit]


@pytest.mark.parametrize("name", SUSPENSIONS)
def test_static_values_are_those_printed(name: str) -> None:
    result = analysed(name)
    for characteristic, printed in STATIC[name].items():
        value = in_units(result, characteristic, result.at(characteristic))
        assert f"{value:.2f}" == printed, characteristic
    roll_centre = 1e3 * result.at(
        "roll_centre_height"
    )  # the report takes a step of the sweep in place of the slope
    assert roll_centre == pytest.approx(PRINTED_ROLL_CENTRE[name], abs=0.06)
    assert roll_centre == pytest.approx(float(reference(name).roll_centre()), rel=1e-12)


@pytest.mark.parametrize("name", SUSPENSIONS)
def test_sweeps_and_slopes(name: str) -> None:
    result = analysed(name)
    for row, z in enumerate(result.x()):
        if row % 2 == 0:
            expected = reference(name).values(mp.mpf(1e3 * z))
            for one in (*NAMES, "spindle_offset", "hub_trail", "wheel_recession"):
                found = in_units(result, one, result[one][row])
                assert found == pytest.approx(float(expected[one]), rel=1e-9, abs=1e-9), (one, z)
    for one in NAMES:
        for at in (-0.025, 0.0, 0.05):
            slope = in_units(result, one, result.at(one, at, slope=True)) * 1e-3
            assert slope == pytest.approx(float(reference(name).slope(one, 1e3 * at)), rel=1e-9, abs=1e-11), (
                one
            )


def test_numbers_of_the_first() -> None:
    """Numbers that were computed with another code in double precision, with the points of the report."""
    result = analysed("V23")
    assert degrees(result.at("ride_camber")) * 1e-3 == pytest.approx(-0.0326171618, rel=1e-8)
    assert degrees(result.at("ride_steer")) * 1e-3 == pytest.approx(0.0283202144, rel=1e-8)  # toe-in in bump
    assert degrees(result.at("ride_caster")) * 1e-3 == pytest.approx(0.0090091155, rel=1e-8)
    assert result.at("spring_ratio") == pytest.approx(-0.4895231649, rel=1e-8)
    assert result.at("anti_dive") == pytest.approx(-22.967, abs=5e-4)
    assert np.tan(result.at("svsa_angle")) == pytest.approx(0.11543437, rel=1e-6)
    assert np.tan(result.at("fvsa_angle")) == pytest.approx(0.4516662, rel=1e-6)
    assert result.at("wheel_recession", slope=True) == pytest.approx(0.13016463, rel=1e-6)
    assert result.at("fvsa_length") == pytest.approx(-1 / np.radians(-32.6171618), rel=1e-8)


@pytest.mark.parametrize("name", SUSPENSIONS)
def test_derivatives_by_hardpoints(name: str) -> None:
    result, exact = analysed(name), reference(name)
    wrt = [one for *_, one in POINTS]
    slopes = result.sensitivity(["toe", "camber"], slope=True, wrt=wrt)
    values = result.sensitivity(["toe", "caster_trail"], at=0.05, wrt=wrt)
    height = result.sensitivity("roll_centre_height", wrt=wrt)
    compared = [
        lambda r: r.slope("toe"), lambda r: r.slope("camber"), lambda r: r.roll_centre(),
        lambda r: r.values(mp.mpf(50))["toe"], lambda r: r.values(mp.mpf(50))["caster_trail"],
    ]  # fmt: skip
    for point, axis, parameter in POINTS:
        toe, camber, rise, angle, trail = exact.gradients(compared, point, axis)
        assert degrees(slopes[parameter][0]) * 1e-6 == pytest.approx(toe, rel=1e-8, abs=1e-13)
        assert degrees(slopes[parameter][1]) * 1e-6 == pytest.approx(camber, rel=1e-8, abs=1e-13)
        assert height[parameter] == pytest.approx(rise, rel=1e-8)
        assert degrees(values[parameter][0]) * 1e-3 == pytest.approx(angle, rel=1e-8, abs=1e-12)
        assert values[parameter][1] == pytest.approx(trail, rel=1e-8, abs=1e-10)


def test_published_derivatives() -> None:
    """Differences of Newton solutions in double precision, good to six digits."""
    gradient = analysed("V23").sensitivity("toe", slope=True)
    assert degrees(gradient["tie_rod.point_i.z"]) * 1e-6 == pytest.approx(3.70598696e-3, rel=1e-6)
    assert degrees(gradient["upper_front.point.z"]) * 1e-6 == pytest.approx(-9.37046454e-4, rel=2e-6)
    assert gradient.ranked()[0].startswith("tie_rod")
    assert not any(name.startswith(("pad", "centre", "spindle")) for name in gradient.names)


def test_both_sides_are_mirrored() -> None:
    """A left corner with x forward has the same characteristics as the right corner with x rearward."""
    mirrored = {name: (-x, y, z) for name, (x, y, z) in V23.items()}
    left = sr.suspension(
        sr.System(model(mirrored)), left=corner(mirrored, RADIUS["V23"]), steps=2, vehicle=WHOLE
    )
    right = analysed("V23")
    for name in left.names():
        if name != "steer_angle":
            assert left[name][[0, 2, 4]] == pytest.approx(right[name][[0, 4, 8]], rel=1e-8, abs=1e-10), name


def test_slopes_of_slopes() -> None:
    """The slope of a quantity of velocities agrees with the differences of its curve."""
    points = V23
    fine = sr.suspension(
        sr.System(model(points)), right=corner(points, 279.4), forward="-x", bump=(-1e-4, 1e-4), steps=1
    )
    for name in ("fvsa_angle", "svsa_length", "spring_ratio", "roll_centre_height"):
        difference = (fine[name][2] - fine[name][0]) / 2e-4
        assert fine.at(name, slope=True) == pytest.approx(difference, rel=1e-5)
