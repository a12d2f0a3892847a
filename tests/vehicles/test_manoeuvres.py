"""Manoeuvres: closed forms of a vehicle with one track, and the car of the package."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, minimize_scalar
from tests.vehicles.single_track import (
    C_REAR,
    FRONT,
    NAMES,
    RADIUS,
    REAR,
    SPIN,
    single_track,
    state_matrix,
    steered,
    understeer,
    whole,
)

import sarrus as sr
from sarrus.algebra import Array
from sarrus.vehicles.cornering import onto_circle
from sarrus.vehicles.lane_change import avoidance

SPEED, ANGLE, RISE = 20.0, 1e-4, 0.1
FINE, COARSE = sr.Radau(rtol=1e-8), sr.Radau(rtol=1e-6)


@pytest.fixture(scope="module")
def system() -> sr.System:
    return single_track()


@pytest.fixture(scope="module")
def step(system: sr.System) -> sr.Manoeuvre:
    return sr.step_steer(system, SPEED, ANGLE, until=6.0, names=NAMES, method=FINE)


def gain(chassis: float) -> float:
    _, _, l_f, l_r = whole(chassis)
    return SPEED / (l_f + l_r + understeer(chassis) * SPEED**2)


def test_the_poles_at_speed_are_those_of_the_single_track(system: sr.System) -> None:
    """The tyres' relaxation is among the states of the closed form; the spin of the wheels is apart."""
    plant = sr.linearize(system, sr.rolling_start(system, SPEED))
    expected = np.linalg.eigvals(state_matrix(SPEED)[0])
    for pole in expected:
        assert abs(plant.poles - pole).min() < 1e-8 * abs(pole)


def test_the_yaw_gain_and_its_derivative_are_those_of_the_single_track(step: sr.Manoeuvre) -> None:
    assert step["yaw_rate_gain"] == pytest.approx(gain(1200.0), rel=1e-7)
    by_mass = (gain(1200.0 + 1e-2) - gain(1200.0 - 1e-2)) / 2e-2
    found = step.sensitivity("yaw_rate_gain", ["chassis.mass"])["chassis.mass"]
    assert found == pytest.approx(by_mass, rel=1e-5)


def test_a_study_of_a_manoeuvre_has_its_numbers_by_name(system: sr.System) -> None:
    def analysis(one: sr.System) -> sr.Manoeuvre:
        return sr.step_steer(one, SPEED, ANGLE, until=6.0, names=NAMES, method=FINE)

    masses, names = [1150.0, 1250.0], ["yaw_rate_gain", "1/yaw_rate_gain", "jaw_rate"]
    table = sr.study(system.model, {"chassis.mass": masses}, names[:2], analysis=analysis, workers=1)
    for row, mass in enumerate(masses):
        assert table["yaw_rate_gain"][row] == pytest.approx(gain(mass), rel=1e-7)
        assert table["1/yaw_rate_gain"][row] == pytest.approx(1 / gain(mass), rel=1e-7)
    wrong = sr.study(system.model, {"chassis.mass": [1150.0]}, names[2], analysis=analysis, workers=1)
    assert "the function returned no 'jaw_rate'. Did you mean" in wrong.failures[0]


def step_metrics(chassis: float) -> dict[str, float]:
    """The metrics of ISO 7401 from the linear equations, at the origin of the chassis."""
    A, B = state_matrix(SPEED, chassis)
    mass, _, l_f, _ = whole(chassis)

    def rates(t: float, x: Array) -> Array:
        u = min(max(t / RISE, 0.0), 1.0)
        return A @ x + B * ANGLE * u**2 * (3 - 2 * u)

    options = {"rtol": 1e-12, "atol": 1e-18}
    first = solve_ivp(rates, (0.0, RISE), np.zeros(4), **options, dense_output=True)
    then = solve_ivp(rates, (RISE, 5.0), first.y[:, -1], **options, dense_output=True)

    def state(t: float) -> Array:
        return np.asarray((first if t < RISE else then).sol(t))

    def yaw_acceleration(t: float) -> float:
        return float(rates(t, state(t))[1])

    def lateral(t: float) -> float:
        x, x_dot = state(t), rates(t, state(t))
        return float(x_dot[0] + SPEED * x[1] + (l_f - FRONT) * x_dot[1])

    end = state(5.0)
    delay = RISE / 2
    T_yaw = brentq(lambda t: state(t)[1] - 0.9 * end[1], delay, 0.25, xtol=1e-14) - delay
    T_lateral = brentq(lambda t: lateral(t) - 0.9 * lateral(5.0), delay, 0.4, xtol=1e-14) - delay
    peak = brentq(yaw_acceleration, 0.2, 0.5, xtol=1e-14)
    top = minimize_scalar(lambda t: -lateral(t), (0.4, 0.5, 0.8), tol=1e-10).x
    return {
        "yaw_rate_response_time": T_yaw,
        "lateral_acceleration_response_time": T_lateral,
        "lateral_acceleration_gain": lateral(5.0) / ANGLE,
        "lateral_acceleration_overshoot": lateral(top) / lateral(5.0) - 1,
        "yaw_rate_peak_time": peak - delay,
        "tb_factor": (peak - delay) * (end[0] + (l_f - FRONT) * end[1]) / SPEED,
    }


def test_the_metrics_of_a_step_and_their_derivatives_are_those_of_the_linear_equations(
    step: sr.Manoeuvre,
) -> None:
    expected = step_metrics(1200.0)
    heavy, light = step_metrics(1201.0), step_metrics(1199.0)
    gradient = step.sensitivity([*expected], ["chassis.mass"])
    for name, found in zip(expected, gradient.matrix[:, 0], strict=True):
        assert step[name] == pytest.approx(expected[name], rel=1e-5, abs=5e-7), name  # |V| is rounded
        assert found == pytest.approx((heavy[name] - light[name]) / 2, rel=1e-4), name


def test_the_gradients_of_cornering_are_those_of_the_single_track(system: sr.System) -> None:
    """The lag behind a slow ramp is constant, so that it does not change them."""
    options = {"wheelbase": FRONT + REAR, "steering_ratio": 1.0, "names": NAMES, "method": FINE}
    result = sr.steady_state_cornering(system, SPEED, 4e-4, rate=1e-4, levels=(0.02, 0.04), **options)
    assert result["understeer_gradient"] == pytest.approx(understeer(), rel=1e-5)
    mass, _, l_f, l_r = whole()
    beta = REAR / SPEED**2 - mass * l_f / ((l_f + l_r) * C_REAR)  # of the origin of the chassis, over a_y
    assert result["sideslip_gradient"] == pytest.approx(beta, rel=1e-5)
    by_mass = (understeer(1201.0) - understeer(1199.0)) / 2
    found = result.sensitivity("understeer_gradient", ["chassis.mass"])["chassis.mass"]
    assert found == pytest.approx(by_mass, rel=1e-3)


def test_the_frequency_response_of_steering_is_that_of_the_single_track() -> None:
    plant = sr.steering_response(single_track(servo=True), SPEED, at=1.0, names=NAMES)
    response = plant.frequency_response([0.2, 1.0, 2.0, 4.0])
    for frequency, values in zip(response.frequencies, response.values, strict=True):
        expected = steered(SPEED, 2j * np.pi * frequency)
        np.testing.assert_allclose(values[:2, 0], expected, rtol=1e-7)


@pytest.fixture(scope="module")
def sweep() -> sr.SweptSine:
    system, times = single_track(servo=True), {"duration": 2.0, "at": 0.8}
    return sr.swept_sine_steer(system, SPEED, ANGLE, **times, frequencies=[1.0, 3.0], names=NAMES)


def test_the_frequency_response_of_a_swept_sine_is_that_of_the_single_track(sweep: sr.SweptSine) -> None:
    """At the frequencies of the numbers by integrals over steps, and at others by sums of samples."""
    response = sweep.frequency_response([0.5, 1.0, 2.0, 3.0])
    for frequency, values in zip(response.frequencies, response.values, strict=True):
        expected = steered(SPEED, 2j * np.pi * frequency)
        np.testing.assert_allclose(values[:2, 0], expected, rtol=1e-5)
    for n, name in enumerate(("yaw_rate", "lateral_acceleration")):
        for frequency in (1.0, 3.0):
            expected = steered(SPEED, 2j * np.pi * frequency)[n]
            assert sweep[f"{name}_gain_{frequency:g}_Hz"] == pytest.approx(abs(expected), rel=1e-5)
            assert sweep[f"{name}_phase_{frequency:g}_Hz"] == pytest.approx(np.angle(expected), abs=1e-5)


def test_the_gain_of_a_swept_sine_has_the_derivatives_of_the_single_track(sweep: sr.SweptSine) -> None:
    found = sweep.sensitivity(["yaw_rate_gain_1_Hz", "lateral_acceleration_phase_3_Hz"], ["chassis.mass"])
    heavy, light = (steered_by(mass) for mass in (1201.0, 1199.0))
    for one, h, l in zip(found.matrix[:, 0], heavy, light, strict=True):
        assert one == pytest.approx((h - l) / 2, rel=1e-3)


def steered_by(chassis: float) -> tuple[float, float]:
    """The gain of the yaw rate at 1 Hz, and the phase of the lateral acceleration at 3 Hz."""
    slow, fast = (steered(SPEED, 2j * np.pi * frequency, chassis) for frequency in (1.0, 3.0))
    return abs(slow[0]), float(np.angle(fast[1]))


def test_a_swept_sine_of_small_amplitude_has_the_response_of_the_linearized_car(car: sr.System) -> None:
    """The deviation falls with the amplitude; the friction of tyres is not linear at any."""
    swept = sr.swept_sine_steer(car, angle=0.01, duration=4.0, frequencies=[1.0])
    frequencies = [0.5, 1.0, 2.0, 3.0]
    linear = sr.steering_response(car).frequency_response(frequencies)
    response = swept.frequency_response(frequencies)
    for output in ("chassis.angular_velocity.z", "chassis.acceleration_body.y"):
        np.testing.assert_allclose(response.of(output, "steer"), linear.of(output, "steer"), rtol=2e-3)


def test_both_methods_of_cornering_have_the_same_understeer_of_the_car(car: sr.System) -> None:
    """In the linear range. The force that raises the speed has a part in it, which falls with the rate."""
    numbers = {"levels": (1.0, 2.0), "wheelbase": 2.6, "steering_ratio": 16.0}
    turned = sr.steady_state_cornering(car, 20.0, 0.34, rate=0.05, **numbers)
    fast, slow = (
        sr.constant_radius_cornering(car, -100.0, 2.2, rate=rate, **numbers) for rate in (0.1, 0.05)
    )
    steady = 2 * slow["understeer_gradient"] - fast["understeer_gradient"]
    assert steady == pytest.approx(turned["understeer_gradient"], rel=0.02)
    assert slow["roll_gradient"] == pytest.approx(turned["roll_gradient"], rel=0.01)
    assert slow["deviation"] < 0.3
    assert slow["lateral_accelerations"][-1] == pytest.approx(-2.2, rel=0.03)
    assert slow["steering_angles"][-1] < 0.0
    wheels = [f"tyre_{axle}_{side}[tyre].PKY1" for axle in ("front", "rear") for side in ("left", "right")]
    by_stiffness = [
        one.sensitivity("understeer_gradient", wheels).matrix.reshape(2, 2).sum(axis=1)
        for one in (turned, slow)
    ]
    assert by_stiffness[1] == pytest.approx(by_stiffness[0], rel=0.02)


def test_the_way_onto_a_circle_ends_on_it() -> None:
    points = np.array(onto_circle(50.0, 20.0, 300.0))
    assert np.all(points[:6, 1] == 0.0)
    first, middle, last = points[[20, 40, 60]]  # the circle through three points
    (a, b, c), area = (
        [np.linalg.norm(one) for one in (middle - first, last - middle, first - last)],
        np.cross([*(middle - first), 0], [*(last - first), 0])[2] / 2,
    )
    assert a * b * c / (4 * area) == pytest.approx(50.0, rel=1e-3)  # to the left
    assert len(points) > 300 / 4


def test_a_swept_sine_has_its_frequencies_in_its_band(sweep: sr.SweptSine, system: sr.System) -> None:
    with pytest.raises(sr.SarrusError, match=r"9 Hz is outside of the band of the sweep, 0.1 to 4 Hz"):
        sweep.frequency_response([1.0, 9.0])
    with pytest.raises(sr.SarrusError, match=r"5 Hz is outside of the band"):
        sr.swept_sine_steer(system, frequencies=[5.0], names=NAMES)
    with pytest.raises(sr.SarrusError, match=r"band must be positive and rise"):
        sr.swept_sine_steer(system, band=(2.0, 1.0), names=NAMES)


def test_locked_wheels_brake_with_their_friction() -> None:
    mu = 0.8
    result = sr.straight_braking(single_track(5000.0, mu), SPEED, names=NAMES)
    g = 9.81 * 1200.0 / whole(1200.0)[0]  # the wheels are not carried by the tyres
    assert result["deceleration"] == pytest.approx(mu * g, rel=1e-6)
    late = result["distance"] - SPEED**2 / (2 * mu * g)  # of the rise in 0.2 s
    assert 0.0 < late < 0.2 * SPEED
    both = result.sensitivity("deceleration", ["tyre_front.mu", "tyre_rear.mu"])
    assert both.matrix.sum() == pytest.approx(g, rel=1e-5)


def distance_with_pressure(torque: float, time: float) -> float:
    """∫ V dt of V̇ = −a (1 − exp(−t/τ)), with (m + Σ J/(R_e R_l)) a = Σ T/R_l."""
    loaded = RADIUS - 1200.0 * 9.81 / 2 / 2e5
    rolling = (2 * RADIUS + loaded) / 3
    a = 2 * torque / loaded / (whole()[0] + 2 * SPIN[1] / (rolling * loaded))
    end = brentq(lambda t: SPEED - a * (t + time * np.expm1(-t / time)), 0.1, 20.0, xtol=1e-13)
    return float(SPEED * end - a * (end**2 / 2 - time * end - time**2 * np.expm1(-end / time)))


def test_the_distance_of_brakes_whose_pressure_builds_up_is_that_of_the_integral() -> None:
    torque, time, rise = 900.0, 0.2, 1e-3
    braked = single_track(pressure=time, brakes=torque)
    result = sr.straight_braking(braked, SPEED, rise=rise, names=NAMES, method=FINE)
    expected = SPEED * rise / 2 + distance_with_pressure(torque, time)
    assert result["distance"] == pytest.approx(expected, rel=1e-5)
    by_time = (
        distance_with_pressure(torque, time + 1e-4) - distance_with_pressure(torque, time - 1e-4)
    ) / 2e-4
    found = result.sensitivity("distance", ["pressure.time"])["pressure.time"]
    assert found == pytest.approx(by_time, rel=1e-3)


@pytest.fixture(scope="module")
def car() -> sr.System:
    return sr.System(sr.load("car"))


def test_the_car_stands_and_drives_straight(car: sr.System) -> None:
    with pytest.warns(sr.SarrusWarning, match=r"no equation determines cruise.integral, tyre_front_left"):
        rest = sr.equilibrium(car)
    assert rest.success
    loads = sum(rest[f"tyre_{axle}_{side}.load"] for axle in ("front", "rear") for side in ("left", "right"))
    assert loads == pytest.approx(1300 * 9.81, rel=1e-9)
    start = sr.rolling_start(car, 20.0)
    assert start.success
    run = sr.simulate(car, start, until=3.0, inputs={"speed": 20.0}, method=COARSE)
    assert abs(run["tyre_front_left.slip_velocity"][0]) < 1e-3
    assert abs(run["chassis.y"]).max() < 1e-9
    assert abs(run["chassis.velocity.x"] - 20.0).max() < 0.1


def test_the_car_understeers(car: sr.System) -> None:
    """Handwheel angle over yaw rate rises faster than with V: less yaw gain than without understeer."""
    slow, fast = (
        sr.step_steer(car, speed, 0.1, until=4.0, method=COARSE)["yaw_rate_gain"] / speed
        for speed in (10.0, 25.0)
    )
    assert 0.0 < fast < 0.9 * slow


def test_the_car_brakes_with_the_friction_of_its_tyres(car: sr.System) -> None:
    """More than half of what PDX1 = 1.16 allows. Controllers have no energy that the check of energies could miss."""
    result = sr.straight_braking(car, level=0.8)
    assert 0.5 * 1.16 * 9.81 < result["deceleration"] < 1.16 * 9.81
    assert not result.run.warnings


def test_a_vehicle_that_stands_on_two_wheels_is_refused() -> None:
    """Tyres that hang over the road at first: the search finds the car on its side."""
    tyres = [f"tyre_{end}_{side}" for end in ("front", "rear") for side in ("left", "right")]
    small = {f"{tyre}.coefficients.UNLOADED_RADIUS": 0.3 for tyre in tyres}
    car = sr.System(sr.load("car").with_parameters(small))
    with pytest.raises(sr.SarrusError, match=r"tyre_front_\w+, tyre_rear_\w+ do not touch the road"):
        sr.rolling_start(car, 20.0)


def test_a_vehicle_without_rolling_tyres_is_refused() -> None:
    ball = sr.System(sr.Model("ball", [sr.Body("ball", 1, (1, 1, 1))]))
    with pytest.raises(sr.SarrusError, match="no rolling tyres"):
        sr.rolling_start(ball, 1.0)
    with pytest.raises(sr.SarrusError, match=r"no body 'chassis'. Give the names .* names=sr.VehicleNames"):
        sr.double_lane_change(ball)
    with pytest.raises(sr.SarrusError, match=r"no input 'steer'.*inputs: none"):
        sr.step_steer(ball, names=sr.VehicleNames(chassis="ball"))
    with pytest.raises(sr.SarrusError, match="angle must not be 0"):
        sr.step_steer(ball, angle=0.0)


def test_names_that_a_manoeuvre_does_not_have_are_refused(step: sr.Manoeuvre) -> None:
    with pytest.raises(KeyError, match="yaw_rate_gain"):
        step["yaw_rate_gian"]
    with pytest.raises(KeyError, match="yaw_rate_peak"):
        step.sensitivity("yaw_rate_peka")
    assert len(step["yaw_rates"]) == len(step.run.t)
    assert "yaw_rate_gain" in str(step)


def test_the_car_misses_the_cones_of_a_lane_change(car: sr.System) -> None:
    result = sr.double_lane_change(car, method=COARSE)
    assert min(result[f"margin_{n}"] for n in (1, 2, 3)) > 0.05
    assert 5.0 < result["lateral_acceleration"] < 8.0


def test_a_coasting_car_stays_stable_in_the_sine_with_dwell(car: sr.System) -> None:
    result = sr.sine_with_dwell(car, angle=1.0, method=COARSE)
    assert result["yaw_rate_peak"] < 0.0
    assert abs(result["yaw_rate_ratio_1_00"]) < 0.35
    assert abs(result["yaw_rate_ratio_1_75"]) < 0.2


def test_the_car_avoids_an_obstacle(car: sr.System) -> None:
    """ISO 3888-2: lanes of 12, 11 and 12 m within 61 m, widths for a width of 1.7 m; coasting from 2 m on."""
    first, second, third = avoidance(1.7)
    assert [first.end, second.begin, second.end, third.begin, third.end] == [12, 25.5, 36.5, 49, 61]
    assert [one.width for one in (first, second, third)] == pytest.approx([2.12, 2.7, 3.0])
    assert second.centre - second.width / 2 - first.width / 2 == pytest.approx(1.0)
    assert third.centre - third.width / 2 == pytest.approx(-first.width / 2)
    result = sr.double_lane_change(car, 60 / 3.6, "3888-2", curvature_gain=50.0, preview=3.0)
    assert min(result[f"margin_{n}"] for n in (1, 2, 3)) > 0.05
    assert result["entry_speed"] == pytest.approx(60 / 3.6, rel=5e-3)
    assert result["final_speed"] < 0.95 * result["entry_speed"]


def test_margins_to_cones_have_the_derivatives_of_other_runs(car: sr.System) -> None:
    """By the stiffness of an anti-roll bar, which does not change the start."""

    def change(bar: float) -> sr.Manoeuvre:
        varied = sr.System(car.model.with_parameters({"front_bar": bar}))
        return sr.double_lane_change(
            varied, 60 / 3.6, "3888-2", curvature_gain=50.0, preview=3.0, method=FINE
        )

    found = change(1500.0).sensitivity(["margin_2", "roll"], ["front_bar"]).matrix[:, 0]
    stiff, soft = change(1510.0), change(1490.0)
    for name, one in zip(("margin_2", "roll"), found, strict=True):
        assert one == pytest.approx((stiff[name] - soft[name]) / 20, rel=1e-3), name


def test_a_car_that_rolls_over_is_reported(car: sr.System) -> None:
    """With a load on a high frame."""
    chassis = next(body for body in car.model.bodies if body.name == "chassis")
    load = sr.Body("load", 600.0, (100, 100, 100), position=(-0.2, 0, 3.5))
    tall = car.model.adding(load, sr.Fixed("rack_of_load", chassis, load, point=(-0.2, 0, 3.5)))
    with pytest.raises(sr.SarrusError, match=r"it rolls over, chassis lies on its side at t = .* steer less"):
        sr.step_steer(sr.System(tall), 25.0, 1.5, method=COARSE)


def test_what_cannot_be_judged_is_refused(car: sr.System) -> None:
    for speed in (0.0, -5.0):
        with pytest.raises(sr.SarrusError, match="speed must be a positive number"):
            sr.step_steer(car, speed)
    with pytest.raises(sr.SarrusError, match="does not reach 30 after 1 s"):
        sr.steady_state_cornering(car, 20.0, 0.3, levels=(1.0, 30.0))
    with pytest.raises(sr.SarrusError, match="levels must be positive and rise"):
        sr.steady_state_cornering(car, levels=(3.0, 1.0))
    with pytest.raises(sr.SarrusError, match=r"radius must not be 0.*Change radius=0"):
        sr.constant_radius_cornering(car, 0.0)
    with pytest.raises(sr.SarrusError, match="needs wheelbase and steering_ratio"):
        sr.steady_state_cornering(car, wheelbase=2.6)
    bodies = [
        replace(one, orientation=(0, 0, 0, 1)) if one.name == "chassis" else one for one in car.model.bodies
    ]
    backward = sr.System(replace(car.model, bodies=bodies))
    with pytest.raises(sr.SarrusError, match=r"the x axis of chassis is along \(-1, .* at the start. Turn"):
        sr.step_steer(backward)
    with pytest.raises(sr.SarrusError, match="standard must be one of 3888-1, 3888-2"):
        sr.double_lane_change(car, standard="3888")


def test_arguments_of_manoeuvres_are_checked(car: sr.System) -> None:
    for error, message, run in (
        (TypeError, "speed must be a number, got NoneType", lambda: sr.step_steer(car, None)),  # type: ignore[arg-type]
        (
            sr.ModelError,
            "speed must be a number, got .fast.. Give a number in m/s, or with its unit",
            lambda: sr.step_steer(car, "fast"),
        ),  # type: ignore[arg-type]
        (sr.ModelError, "angle must be in rad", lambda: sr.step_steer(car, angle="2 s")),  # type: ignore[arg-type]
        (sr.ModelError, "at must be .* at least 0", lambda: sr.step_steer(car, at=-1.0)),
        (sr.ModelError, "rise must be a positive number", lambda: sr.step_steer(car, rise=0.0)),
        (
            sr.SarrusError,
            "until must be later than the end of the step",
            lambda: sr.step_steer(car, until=0.5),
        ),
        (sr.SarrusError, "no input ''", lambda: sr.step_steer(car, names=sr.VehicleNames(steer=""))),
        (sr.SarrusError, "start is determined by the manoeuvre", lambda: sr.step_steer(car, start=None)),
        (
            sr.ModelError,
            "level must be a positive number of at most 1",
            lambda: sr.straight_braking(car, level=5),
        ),
        (
            sr.SarrusError,
            "stop must be less than the speed",
            lambda: sr.straight_braking(car, 20.0, stop=30.0),
        ),
        (sr.ModelError, "width must be a positive number", lambda: sr.double_lane_change(car, width=-1.0)),
        (
            sr.SarrusError,
            "Give the greater one first",
            lambda: sr.double_lane_change(car, length=(-2.0, 2.0)),
        ),
        (sr.ModelError, "levels must be two numbers", lambda: sr.steady_state_cornering(car, levels=(2.0,))),  # type: ignore[arg-type]
        (
            sr.ModelError,
            "wheelbase must be a positive",
            lambda: sr.steady_state_cornering(car, wheelbase=0.0),
        ),
        (sr.SarrusError, "must be a RandomRoad, got 'B'", lambda: sr.ride(car, road="B")),  # type: ignore[arg-type]
        (sr.ModelError, "duration must be a positive number", lambda: sr.ride(car, duration=0.0)),
    ):
        with pytest.raises(error, match=message):
            run()


def test_arguments_with_units_and_further_inputs(car: sr.System) -> None:
    result = sr.step_steer(
        car,
        "72 km/h",  # type: ignore[arg-type]
        "20 deg",  # type: ignore[arg-type]
        at="200 ms",  # type: ignore[arg-type]
        until=0.8,
        inputs={"brake": 0.05},
        method=COARSE,
    )
    assert result.run["chassis.velocity.x"][0] == pytest.approx(20.0)
    assert result.run["steer"][-1] == pytest.approx(np.radians(20.0))
    assert result.run["brake"][-1] == 0.05
