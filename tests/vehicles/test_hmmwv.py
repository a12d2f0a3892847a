"""The HMMWV that drives, by balances and closed forms, and its front axle on the rig."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import sarrus as sr
from sarrus.euler import A
from sarrus.studies.suspension import read_suspension_file

WEIGHT, WHEELBASE = 2576.924 * 9.81, 3.30198
CORNERS = [f"{axle}_{side}" for axle in ("front", "rear") for side in ("left", "right")]
FAST = {"method": sr.Radau(rtol=1e-6)}


@pytest.fixture(scope="module")
def system() -> sr.System:
    return sr.System(sr.load("hmmwv_driving"))


def test_it_has_the_bodies_of_the_first_file(system: sr.System) -> None:
    first = sr.System(sr.load("hmmwv"))
    assert system.bodies == first.bodies
    mass = sum(body.mass for body in system.model.bodies)
    assert mass == pytest.approx(WEIGHT / 9.81, rel=1e-12)
    own, others = (
        next(body for body in one.model.bodies if body.name == "knuckle_rear_right")
        for one in (system, first)
    )
    apart = np.subtract(others.mass_properties().inertia, own.mass_properties().inertia)
    assert apart == pytest.approx([0, 7.38782, 0, 0, 0, 0], abs=1e-12)


def test_it_stands_on_its_tyres(system: sr.System) -> None:
    with pytest.warns(sr.SarrusWarning, match="no equation determines"):
        rest = sr.equilibrium(system)
    loads = {name: rest[f"tyre_{name}.load"] for name in CORNERS}
    assert sum(loads.values()) == pytest.approx(WEIGHT, rel=1e-9)
    assert loads["front_left"] == pytest.approx(loads["front_right"], rel=1e-9)
    assert loads["front_left"] == pytest.approx(6533.3, rel=1e-3)  # of the first file, with other tyres


def test_it_drives_straight_and_forces_balance(system: sr.System) -> None:
    run = sr.simulate(
        system,
        sr.rolling_start(system, 15.0),
        until=4.0,
        t_eval=np.linspace(0, 4, 41),
        inputs={"speed": 15.0},
        **FAST,
    )
    assert abs(run["tyre_front_left.slip_velocity"][0]) < 1e-3
    assert abs(run["gearbox.value"][0]) < 1e-6  # no slip at the start
    assert abs(run["chassis.y"]).max() < 1e-6
    assert abs(run["chassis.velocity.x"] - 15.0).max() < 0.5
    forces = sum(run[f"tyre_{name}.longitudinal_force"][-1] for name in CORNERS)
    speed, acceleration = run["chassis.velocity.x"][-1], run["chassis.acceleration.x"][-1]
    assert forces == pytest.approx(WEIGHT / 9.81 * acceleration + 1.5 * speed**2, rel=2e-2)
    assert run["turbine.rate"] == pytest.approx(
        0.983 * run["center.rate"], abs=1.0
    )  # within the creep of its clutch
    wheels = sum(run[f"tyre_{name}.rate"] for name in CORNERS) / 4
    assert run["center.rate"] == pytest.approx(5 * wheels, rel=1e-12)


def test_shafts_before_an_open_clutch_turn_by_its_gear(system: sr.System) -> None:
    forces = [
        replace(one, engagement=0.0) if isinstance(one, sr.Transmission) else one
        for one in system.model.forces
    ]
    other = sr.System(replace(system.model, forces=forces))
    closed, opened = sr.rolling_start(system, 15.0), sr.rolling_start(other, 15.0)
    assert opened.v == pytest.approx(closed.v, rel=1e-12, abs=1e-12)


def test_shafts_turn_by_the_gear_of_the_run(system: sr.System) -> None:
    """Its own inputs, at which it stands, have another gear."""
    forces = [
        replace(one, ratio="gear") if isinstance(one, sr.Transmission) else one for one in system.model.forces
    ]
    other = sr.System(replace(system.model, forces=[*forces, sr.Input("gear", 2.5)]))
    for gear, given in ((2.5, None), (1.5, {"gear": 1.5}), (1.0, {"gear": "1 - t"})):
        start = sr.rolling_start(other, 15.0, given)
        turbine = start.v[other.states["turbine.rate"].place]
        center = 5 * np.mean([start.v[other.states[f"tyre_{name}.spin"].place] for name in CORNERS])
        assert turbine == pytest.approx(gear * center, rel=1e-9)
    with pytest.raises(sr.SarrusError, match=r'has no input "gaer"\. Did you mean'):
        sr.rolling_start(other, 15.0, {"gaer": 1.0})


def test_its_top_speed_is_that_of_the_engine_in_the_highest_gear(system: sr.System) -> None:
    start = sr.rolling_start(system, 36.0)
    run = sr.simulate(system, start, until=8.0, inputs={"speed": 60.0}, **FAST)
    full_load, drag = 2500 * np.pi / 30, 2700 * np.pi / 30
    assert full_load < run["crank.rate"][-1] < drag
    rate = run["turbine.rate"][-1] / (0.651 * 5)
    assert run["chassis.velocity.x"][-1] == pytest.approx(0.45 * rate, rel=0.02)
    assert run["converter.output"][-1] == pytest.approx(run["gearbox.value"][-1], rel=0.02)


def steering_angles(system: sr.System, run: sr.Trajectory) -> float:
    """The mean angle of the front wheels about z at the end, in the chassis."""
    found = []
    for name in ("left", "right"):
        axes = [A(run[body].euler[-1]) for body in ("chassis", f"knuckle_front_{name}")]
        across = (axes[0].T @ axes[1])[:, 1]
        found.append(np.arctan2(-across[0], across[1]))
    return float(np.mean(found))


def test_it_turns_as_its_wheels_point(system: sr.System) -> None:
    """ψ̇ = V tan δ/L at low speed; at 15 m/s it understeers."""
    slow = sr.step_steer(system, 3.0, 1.0, until=4.0, **FAST)
    angle = steering_angles(system, slow.run)
    assert 0.05 < angle < 0.07
    speed = slow.run["chassis.velocity_body.x"][-1]
    assert slow["yaw_rate"] == pytest.approx(speed * np.tan(angle) / WHEELBASE, rel=0.05)
    fast = sr.step_steer(system, 15.0, 1.0, until=4.0, **FAST)
    assert 0.5 < fast["yaw_rate"] / (5 * slow["yaw_rate"]) < 0.95
    assert fast["lateral_acceleration"] == pytest.approx(15.0 * fast["yaw_rate"], rel=0.05)


def test_it_brakes_with_the_friction_of_its_tyres(system: sr.System) -> None:
    """v²/(2 μ g) with the largest and with less than the sliding friction, and at most the distance of the rise."""
    speed = 80 / 3.6
    result = sr.straight_braking(system, speed, 1.0, **FAST)
    best, least = 0.95, 0.45  # largest friction of the file at these loads, and less than the sliding one
    assert speed**2 / (2 * best * 9.81) < result["distance"] < speed**2 / (2 * least * 9.81) + 0.2 * speed
    assert result["deceleration"] == pytest.approx(speed**2 / (2 * result["distance"]), rel=0.15)


def test_it_changes_lanes(system: sr.System) -> None:
    result = sr.double_lane_change(
        system, 60 / 3.6, width=2.2, length=(2.3, -2.3), gain=1.5, curvature_gain=75.0, preview=6.0, **FAST
    )
    assert min(result[f"margin_{n}"] for n in (1, 2, 3)) > 0.0
    assert 0.01 < result["roll"] < 0.05
    assert result["final_speed"] == pytest.approx(60 / 3.6, rel=0.01)


def test_the_yaw_gain_by_a_hardpoint_of_the_included_file(system: sr.System) -> None:
    name, h = "front_tie_outer.x", 2e-4
    result = sr.step_steer(system, 15.0, 1.0, until=3.0, method=sr.Radau(rtol=1e-8, atol=1e-9))
    own = result.sensitivity("yaw_rate", [name])[name]

    def gain(x: float) -> float:
        other = sr.System(sr.load("hmmwv_driving", parameters={name: 1.5131462 + x}))
        return float(
            sr.step_steer(other, 15.0, 1.0, until=3.0, method=sr.Radau(rtol=1e-9, atol=1e-10))["yaw_rate"]
        )

    assert own == pytest.approx((gain(h) - gain(-h)) / (2 * h), rel=1e-4)
    assert abs(own) > 0.1


@pytest.fixture(scope="module")
def axle() -> sr.Suspension:
    return read_suspension_file("hmmwv", sr.load).analysed()


STATIC = -0.075  # [m] of bump


def test_the_front_axle_on_the_rig(axle: sr.Suspension) -> None:
    """Numbers of an axle with double wishbones and a rack behind it; ratios against the geometry of the arm."""
    assert axle.success, axle.message
    caster, kingpin = np.degrees(axle.at("caster")), np.degrees(axle.at("kingpin_inclination"))
    lower, upper = np.array([1653.405, 786.511, -118.11]), np.array([1635.9298, 715.518, 215.4936])
    x, y, z = upper - lower
    assert caster == pytest.approx(np.degrees(np.arctan2(-x, z)), rel=1e-12)
    assert kingpin == pytest.approx(np.degrees(np.arctan2(-y, z)), rel=1e-12)
    assert axle.at("toe") == pytest.approx(0.0, abs=1e-12)
    assert -0.55 < axle.at("spring_ratio", STATIC) < -0.4
    assert 0.2 < axle.at("roll_centre_height", STATIC) < 0.5
    assert np.degrees(axle.at("steer_angle", sweep="steer", slope=True)) / 1e3 == pytest.approx(
        -0.409, abs=1e-3
    )
    assert axle.at("toe", 0.0, side="left") == pytest.approx(axle.at("toe", 0.0, side="right"), abs=1e-12)


def test_wheel_rate_and_loads_at_the_static_position(axle: sr.Suspension) -> None:
    """F = T i and dF/dz = k i² + T di/dz with the tension T of the spring and i = dl/dz."""
    found, ratio, slope = (
        axle.compliance(STATIC), axle.at("spring_ratio", STATIC), axle.at("spring_ratio", STATIC, slope=True),
    )  # fmt: skip
    run = axle.sweeps["bump"].run
    length = np.interp(STATIC, axle.x(), run["spring_front_left.length"])
    tension = 167070.93858 * (length - 0.339344)
    assert found["wheel_rate"] == pytest.approx(167070.93858 * ratio**2 + tension * slope, rel=2e-2)
    unsprung = (90.555 + 23.965 / 2 + 5.813 / 2) * 9.81
    assert found.loads["left"] == pytest.approx(tension * ratio + unsprung, rel=0.05)


@pytest.mark.parametrize(("name", "value"), [("front_tie_outer.z", -0.0163322), ("front_wheel.z", -0.026289)])
def test_derivatives_of_the_rig_by_hardpoints(axle: sr.Suspension, name: str, value: float) -> None:
    """The wheel centre is also a point of the tyre, which the rig removes, and has a negative coordinate."""
    h = 1e-4
    own = axle.sensitivity("ride_steer", wrt=[name])[name]

    def ride_steer(x: float) -> float:
        moved = read_suspension_file("hmmwv", lambda file: sr.load(file, parameters={name: value + x}))
        return float(moved.analysed().at("ride_steer"))

    found = (-ride_steer(2 * h) + 8 * ride_steer(h) - 8 * ride_steer(-h) + ride_steer(-2 * h)) / (12 * h)
    assert own == pytest.approx(found, rel=1e-7)
