"""Suspensions with bushings: equilibria on the rig, their slopes, and derivatives by stiffnesses."""

from dataclasses import replace

import pytest
from tests.vehicles.published import RADIUS, V23, corner, metres, model

import sarrus as sr
from sarrus.model.written import with_numbers

RIG = {"right": corner(V23, RADIUS["V23"]), "forward": "-x"}
PIVOTS = "lower_front", "lower_rear"


def soft(k: float, rotational: float = 10.0, *, rack: bool = False) -> sr.Model:
    """The lower arm on two bushings."""
    plain, p = model(V23, rack=rack), metres(V23)
    arm = next(body for body in plain.bodies if body.name == "lower_arm")
    stiffness = (k, k, k, rotational, rotational, rotational)
    bushings = [sr.Bushing(name, sr.ground, arm, point=p[name], stiffness=stiffness) for name in PIVOTS]
    joints = [joint for joint in plain.joints if joint.name not in PIVOTS]
    return replace(plain, joints=joints, forces=[*plain.forces, *bushings])


def analysed(given: sr.Model, **other: object) -> sr.Suspension:
    return sr.suspension(sr.System(given), **RIG | {"steps": 2} | other)


def test_stiff_bushings_are_joints() -> None:
    """The difference is of the order of the load over the stiffness."""
    rigid = analysed(model(V23))
    for k in (1e10, 1e12):
        found = analysed(soft(k, 0.0))
        for name in ("toe", "camber", "caster", "roll_centre_height", "spring_ratio"):
            assert found[name] == pytest.approx(rigid[name], abs=2e5 / k), name
        assert found.at("ride_steer") == pytest.approx(rigid.at("ride_steer"), abs=2e6 / k)


def test_slopes_are_those_of_the_curves() -> None:
    """Those of toe and camber by the compliance under the static load, too, which are computed in another way."""
    fine = analysed(soft(2e6), bump=(-1e-4, 1e-4), steps=1)
    for name in fine.names():
        difference = (fine[name][2] - fine[name][0]) / 2e-4
        assert fine.at(name, slope=True) == pytest.approx(difference, rel=1e-5), name
    found = fine.compliance()
    wrt = ["lower_front.stiffness.1", "tie_rod.point_i.z"]
    for name in ("ride_steer", "ride_camber"):
        assert found[name] == pytest.approx(fine.at(name), rel=1e-9), name
        by_load, by_sweep = found.sensitivity(name, wrt=wrt), fine.sensitivity(name, wrt=wrt)
        assert by_sweep.matrix == pytest.approx(by_load.matrix, rel=1e-8), name


CASES = {
    "toe": False, "ride_steer": False, "roll_centre_height": False, "spring_ratio": False, "svsa_angle": False,
    "camber": True,
}  # fmt: skip


def test_derivatives_by_bushings_and_points() -> None:
    """Of values and slopes, with differences of fourth order of whole analyses."""
    given = soft(2e6)
    found, wrt = (
        analysed(given),
        ["lower_front.stiffness.1", "tie_rod.point_i.z", "spring.length", "spring.k"],
    )
    exact = {name: found.sensitivity(name, at=0.05, slope=slope, wrt=wrt) for name, slope in CASES.items()}
    for place, number in enumerate(wrt):
        value = exact["toe"].at[place]
        h = (0.02 if "stiffness" in number else 3e-3) * abs(value)
        whole = [
            analysed(with_numbers(given, {number: value + step * h}), roll=None) for step in (2, 1, -1, -2)
        ]
        for name, slope in CASES.items():
            a, b, c, d = (one.at(name, 0.05, slope=slope or name == "ride_steer") for one in whole)
            difference = (8 * (b - c) - (a - d)) / (12 * h)
            assert exact[name][number] == pytest.approx(difference, rel=1e-7), (name, number)


def test_least_bump_steer_on_bushings() -> None:
    """The gradient of an integral over the equilibria, by one adjoint solution and along each parameter."""
    found = analysed(soft(2e6), bump=(-0.02, 0.02))
    slope, run = found.response("toe", slope=True), found.sweeps["bump"].run
    wanted = sr.Integral(lambda o: slope(o) ** 2, name="ride steer squared")
    wrt = ["tie_rod.point_i.y", "tie_rod.point_i.z", "upper_ball.point.z"]
    adjoint, along = (sr.sensitivity(run, wanted, wrt, method=one) for one in ("adjoint", "direct"))
    assert adjoint.matrix == pytest.approx(along.matrix, rel=1e-9)
    best = sr.optimize(
        run.system, wanted, wrt[:2], analysis=found.analysis("bump"),
        bounds={name: (adjoint.at[n] - 0.03, adjoint.at[n] + 0.03) for n, name in enumerate(wrt[:2])},
    )  # fmt: skip
    assert best.value < 1e-3 * adjoint.value


def test_what_is_refused() -> None:
    found = analysed(soft(2e6))
    with pytest.raises(sr.SarrusError, match=r"that depend on velocities have no derivatives by parameters"):
        found.sensitivity("roll_centre_height", slope=True)
    loose = soft(0.0, 0.0)
    with pytest.raises(sr.SarrusError, match=r"give bushings stiffness along and about all axes"):
        analysed(loose)


def test_a_steering_axis_without_joints_is_left_out() -> None:
    """The other curves remain, and those of given points."""
    steered = {"steering": "rack", "steer": (-0.01, 0.01)}
    given = analysed(soft(2e6, rack=True), **steered)
    found = analysed(soft(2e6, rack=True), right=corner(V23, RADIUS["V23"], kingpin=None), **steered)
    assert found.curve("toe", "steer") == pytest.approx(given.curve("toe", "steer"), abs=1e-12)
    assert "caster" not in found.names("bump")
    with pytest.raises(sr.SarrusError, match=r"Give both points of kingpin in the corners"):
        found.at("caster")
