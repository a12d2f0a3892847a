"""The compliance of suspensions at the wheels, against closed forms and differences of equilibria."""

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from tests.vehicles.published import RADIUS, V23, corner, metres, model

import sarrus as sr
from sarrus import mechanisms
from sarrus.model.written import with_numbers

TIRE = 250e3
AXLE = sr.Vehicle(wheelbase=3.3, tyre_stiffness=TIRE)


@cache
def single() -> sr.Suspension:
    """One corner with a rack."""
    system = sr.System(model(V23, rack=True))
    wheel = corner(V23, RADIUS["V23"])
    return sr.suspension(
        system, right=wheel, forward="-x", steps=2, steering="rack", vehicle=AXLE, steer=(-0.01, 0.01)
    )


@cache
def axle() -> sr.Suspension:
    """The front axle of the shipped vehicle."""
    vehicle = sr.load(mechanisms.path("hmmwv"))
    system = sr.System(vehicle)

    def wheel(side: str) -> sr.Corner:
        body = next(one for one in vehicle.bodies if one.name == f"knuckle_front_{side}")
        out = 1.0 if side == "left" else -1.0
        balls = f"sph_LCA_front_{side}", f"sph_UCA_front_{side}"
        centre = body.pose().global_point(np.array([0, out * 0.0340837328143118, 0]))
        inboard = body.pose().global_point(np.zeros(3))
        return sr.Corner(body.name, tuple(centre), tuple(inboard), 0.47, balls, f"spring_front_{side}")

    fixed = "chassis", "knuckle_rear_left", "knuckle_rear_right"
    return sr.suspension(
        system, wheel("left"), wheel("right"), steps=2, steering="rack", fixed=fixed, vehicle=AXLE
    )


def test_wheel_rate_of_a_spring() -> None:
    """F = T i and dF/dz = k i² + T di/dz, with the tension T, the length l and i = dl/dz of the spring."""
    result = single()
    for at in (0.0, 0.05):
        k, slope = 30e3, result.at("spring_ratio", at)
        length = result.sweeps["bump"].run["spring.length"][list(result.x()).index(at)]
        tension = k * (length - 0.4)
        expected = k * slope**2 + tension * result.at("spring_ratio", at, slope=True)
        found = result.compliance(at)
        assert found["wheel_rate"] == pytest.approx(expected, rel=1e-9)
        assert found.loads["right"] == pytest.approx(tension * slope, rel=1e-9)
        assert found["ride_rate"] == pytest.approx(1 / (1 / expected + 1 / TIRE), rel=1e-9)


def test_derivatives_of_the_wheel_rate() -> None:
    """They agree with the differences of whole analyses, with the pads' loads of each."""
    wrt = ["upper_ball.point.z", "tie_rod.point_j.y", "lower_ball.point.y", "spring.k", "spring.length"]
    found = single().compliance(0.05).sensitivity("wheel_rate", wrt=wrt)
    for name in wrt:
        size = 1e-5 * max(1.0, abs(found.at[wrt.index(name)]))
        sides = []
        for sign in (1, -1):
            changed = sr.System(
                with_numbers(single().rig.system.model, {name: found.at[wrt.index(name)] + sign * size})
            )
            other = sr.suspension(
                changed,
                right=corner(V23, RADIUS["V23"]),
                forward="-x",
                steps=2,
                steering="rack",
                vehicle=AXLE,
            )
            sides.append(other.compliance(0.05)["wheel_rate"])
        assert found[name] == pytest.approx((sides[0] - sides[1]) / (2 * size), rel=2e-6), name


def test_matrix_of_an_axle() -> None:
    """It is symmetric, and the rates follow from its entries, with loads at the wheel centres."""
    found = axle().compliance()
    C = found.matrix
    assert abs(C - C.T).max() < 1e-12 * abs(C).max()
    assert found.components[2] == "left.z"
    assert found["wheel_rate"] == pytest.approx(1 / (C[2, 2] + C[2, 8]), rel=1e-9)
    left, right = (axle().rig.corners[side].design("centre") for side in ("left", "right"))
    span = C[2, 2] - C[2, 8] - C[8, 2] + C[8, 8]
    track = left[1] - right[1]
    assert found["suspension_roll_rate"] == pytest.approx(track**2 / span, rel=1e-9)
    assert found["total_roll_rate"] == pytest.approx(track**2 / (span + 2 / TIRE), rel=1e-9)
    assert found["fore_aft_stiffness"] == pytest.approx(1 / (C[0, 0] + C[0, 6]), rel=1e-9)
    assert found.value("wheel_rate", "right") == pytest.approx(found["wheel_rate"], rel=1e-9)
    assert "wheel_rate" in str(found)
    assert "total_roll_rate" in str(found)


def test_steer_and_camber_by_loads() -> None:
    """Of a wheel without toe and camber, steer is the rotation about z, and camber that about x."""
    found = single().compliance()
    C = found.matrix
    assert found["aligning_torque_steer"] == pytest.approx(C[5, 5], rel=1e-9)
    arm = 1e-3 * RADIUS["V23"]  # the road is below the centre: a force along y has the moment R about x
    ahead, left = (
        -1.0,
        -1.0,
    )  # directions of forward and left along x and y, with x rearward and y to the right
    assert found["lateral_force_steer"] == pytest.approx(left * (C[5, 1] + arm * C[5, 3]), rel=1e-9)
    assert found["longitudinal_force_steer"] == pytest.approx(ahead * (C[5, 0] - arm * C[5, 4]), rel=1e-9)
    assert found["lateral_force_camber"] == pytest.approx(-left * (C[3, 1] + arm * C[3, 3]), rel=1e-9)


def test_a_soft_rack_makes_the_wheel_steer() -> None:
    """Without static load, a spring k at the rack adds (dδ/dy)²/k, with the arms at rest: δ' = k_z t_y / t·(k × r).

    k is the unit vector of the steering axis, r the arm of the outer end of the tie rod about it, t the tie rod.
    """
    k, points = 1e6, {name: np.array(place) * 1e-3 for name, place in V23.items()}
    length = float(np.linalg.norm(points["damper_body"] - points["damper_arm"]))
    stiff = model(V23, rack=True)
    stiff = replace(stiff, forces=[replace(stiff.forces[0], length=length)])
    soft = replace(stiff, forces=[*stiff.forces, sr.Force("mount", "rack", value=f"-{k!r}*x")])
    wheel, found = corner(V23, RADIUS["V23"]), []
    for one in (stiff, soft):
        result = sr.suspension(
            sr.System(one), right=wheel, forward="-x", steps=1, bump=(-1e-3, 1e-3), steering="rack"
        )
        free = replace(result.rig, steering="") if one is soft else result.rig
        found.append(replace(result, rig=free).compliance()["aligning_torque_steer"])
    axis = points["upper_ball"] - points["lower_ball"]
    axis /= np.linalg.norm(axis)
    rod, arm = points["tie_outer"] - points["tie_inner"], points["tie_outer"] - points["lower_ball"]
    per_rack = axis[2] * rod[1] / (rod @ np.cross(axis, arm))
    assert found[1] - found[0] == pytest.approx(per_rack**2 / k, rel=1e-8)


HARDPOINTS = """
name: corner
hardpoints: {points}
bodies:
  lower_arm: {{mass: 5, inertia: [0.1, 0.1, 0.1], position: lower_ball}}
  upper_arm: {{mass: 3, inertia: [0.1, 0.1, 0.1], position: upper_ball}}
  knuckle: {{mass: 20, inertia: [0.5, 0.5, 0.5], position: centre}}
  rack_bar: {{mass: 2, inertia: [0.1, 0.1, 0.1], position: tie_inner}}
joints:
  lower_hinge: {{type: revolute, bodies: [ground, lower_arm], point: lower_front, axis: [lower_front, lower_rear]}}
  upper_hinge: {{type: revolute, bodies: [ground, upper_arm], point: upper_front, axis: [upper_front, upper_rear]}}
  lower_joint: {{type: spherical, bodies: [lower_arm, knuckle], point: lower_ball}}
  upper_joint: {{type: spherical, bodies: [upper_arm, knuckle], point: upper_ball}}
  rack: {{type: translational, bodies: [ground, rack_bar], point: tie_inner, axis: [0, 1, 0]}}
  tie_rod: {{type: distance, points: [rack_bar.tie_inner, knuckle.tie_outer]}}
forces:
  spring: {{type: tsda, points: [ground.damper_body, lower_arm.damper_arm], k: 30 N/mm, length: 400 mm}}
"""


def of_hardpoints(points: dict[str, tuple[float, ...]], folder: Path) -> sr.Suspension:
    """The corner with points in mm as hardpoints."""
    listed = {"unit": "mm", **{name: [float(x) for x in place] for name, place in points.items()}}
    file = folder / "corner.yaml"
    file.write_text(HARDPOINTS.format(points=json.dumps(listed)))
    wheel = sr.Corner(
        "knuckle", "centre", "spindle", 0.2794, kingpin=("lower_ball", "upper_ball"), spring="spring"
    )
    system = sr.System(sr.load(file))
    return sr.suspension(system, right=wheel, forward="-x", steering="rack", steps=1, vehicle=AXLE)


def test_derivatives_of_rates_by_all_hardpoints(tmp_path: Path) -> None:
    """They agree with the differences of whole analyses; those of the wheel move its loads and its outputs as well."""
    rates = "wheel_rate", "ride_rate", "fore_aft_stiffness", "lateral_force_deflection", "lateral_force_steer"
    rates += "lateral_force_camber", "longitudinal_force_steer", "longitudinal_force_deflection", "ride_steer"
    names = [f"{point}.{axis}" for point in V23 for axis in "xyz"]
    here = of_hardpoints(V23, tmp_path).compliance(0.05)
    found = {rate: here.sensitivity(rate, wrt=names) for rate in rates}
    step = 0.02  # [mm]
    for name in names:
        point, axis = name.split(".")
        sides = []
        for sign in (1, -1):
            place = np.array(V23[point], dtype=float)
            place["xyz".index(axis)] += sign * step
            sides.append(of_hardpoints({**V23, point: tuple(place)}, tmp_path).compliance(0.05))
        for rate in rates:
            difference = (sides[0][rate] - sides[1][rate]) / (2e-3 * step)
            size = max(abs(found[rate].matrix).max(), abs(difference))
            assert abs(found[rate][name] - difference) < 1e-5 * size, (rate, name)


def test_derivatives_of_the_wheel_rate_in_closed_form(tmp_path: Path) -> None:
    """Of dF/dz = k i² + k (l - l₀) di/dz, with the derivatives of l, i and di/dz that kinematics gives."""
    k, rest, at = 30e3, 0.4, 0.05
    result = of_hardpoints(V23, tmp_path)
    names = [f"{point}.{axis}" for point in V23 for axis in "xyz"]
    run = result.sweeps["bump"].run
    length = sr.sensitivity(run, [sr.At("spring.length", "length", time=at)], names)
    ratio = result.sensitivity("spring_ratio", at, wrt=names)
    bend = result.sensitivity("spring_ratio", at, slope=True, wrt=names)
    i, slope = float(ratio.value), float(bend.value)
    expected = (
        2 * k * i * ratio.matrix[0]
        + k * slope * length.matrix[0]
        + k * (length.value - rest) * bend.matrix[0]
    )
    found = result.compliance(at).sensitivity("wheel_rate", wrt=names)
    np.testing.assert_allclose(found.matrix[0], expected, rtol=1e-8, atol=1e-8 * abs(expected).max())


def test_joints_that_are_a_wheel_centre_have_no_derivatives() -> None:
    """The rig does not follow them: derivatives by what moves them are refused, others are those of numbers."""
    given = replace(corner(V23, RADIUS["V23"]), spindle="upper_joint_of_wheel")
    plain = model(V23, rack=True)
    body = next(one for one in plain.bodies if one.name == "knuckle")
    tip = sr.Body("tip", 1, (0.1, 0.1, 0.1), position=metres(V23)["spindle"])
    hub = sr.Fixed("upper_joint_of_wheel", body, tip, point=metres(V23)["spindle"])
    system = sr.System(replace(plain, bodies=[*plain.bodies, tip], joints=[*plain.joints, hub]))
    result = sr.suspension(system, right=given, forward="-x", steps=1, steering="rack")
    names = ["upper_joint_of_wheel.point.x", "knuckle.position.z"]
    for name in names:
        for found in (result, result.compliance()):
            with pytest.raises(sr.SarrusError, match=r"moves the joint .*as a hardpoint"):
                found.sensitivity("ride_steer", wrt=[name])
        assert name not in result.rig.parameters()
    expected = single().compliance().sensitivity("wheel_rate", wrt=["lower_ball.point.y"])
    found = result.compliance().sensitivity("wheel_rate", wrt=["lower_ball.point.y"])
    assert found.matrix == pytest.approx(expected.matrix, rel=1e-8)
