"""Wheels on tyres: standing, rolling, braking, cornering, and falling over."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm
from tests.tyres.test_laws import CAR, CAR_52, FIALA, MICROBUS, NAMES

import sarrus as sr
from sarrus.views.looks.sketch import sketch

G, MASS, K, RADIUS, MU = 9.81, 1200.0, 2e5, 0.31, 0.9
BRUSH: dict[str, Any] = {
    "radius": RADIUS,
    "k": K,
    "c": 2000.0,
    "c_kappa": 8e4,
    "c_alpha": 8e4,
    "mu": MU,
    "half_length": 0.07,
}
CORNERS = {"fl": (1.2, 0.75), "fr": (1.2, -0.75), "rl": (-1.2, 0.75), "rr": (-1.2, -0.75)}
HEIGHT = RADIUS - MASS * G / 4 / K
WHEEL = {"radius": FIALA["radius"], "k": FIALA["k"], "c": 100.0}
TYRES: dict[str, tuple[type[Any], dict[str, Any]]] = {
    "brush": (sr.BrushTyre, BRUSH),
    "fiala": (
        sr.FialaTyre,
        WHEEL | {name: FIALA[name] for name in ("c_kappa", "c_alpha", "mu_min", "mu_max", "width")},
    ),
    "tmeasy": (
        sr.TmeasyTyre,
        WHEEL
        | {"nominal_load": 1900.0}
        | {name: (MICROBUS[f"{name}_1"], MICROBUS[f"{name}_2"]) for name in NAMES.values()},
    ),
    "magic formula 5.2": (sr.MagicFormulaTyre, {"coefficients": CAR_52 | {"FITTYP": 52}}),
    "magic formula 6.1": (sr.MagicFormulaTyre, {"coefficients": CAR}),
}


def block(slope: float = 0.0, speed: float = 0.0) -> sr.System:
    """A body on four locked wheels."""
    car = sr.Body(
        "car", mass=MASS, inertia=(400, 1500, 1600), position=(0, 0, HEIGHT), velocity=(speed, 0, 0)
    )
    tyres = [sr.BrushTyre(name, car.point(x, y, 0), **BRUSH) for name, (x, y) in CORNERS.items()]
    return sr.System(sr.Model("block", [car], [], tyres, gravity=(-G * np.sin(slope), 0, -G * np.cos(slope))))


def wheel(kind: str = "brush", road: Any = 0.0, gravity: float = G, **given: Any) -> sr.System:
    """A free wheel of 400 kg that rolls at 20 m/s, leaning and turning a little."""
    body = sr.Body(
        "wheel",
        mass=400.0,
        inertia=(60, 90, 60),
        position=(0, 0, 0.295),
        velocity=(20.0, 0.3, 0.0),
        angular_velocity=(0.05, 65.0, 0.2),
    )
    of, numbers = TYRES[kind]
    tyre = of("tyre", body.point(0, 0, 0), axis=(0.02, 1, 0.03), road=road, **numbers, **given)
    return sr.System(sr.Model("wheel", [body], [], [tyre], gravity=(0, 0, -gravity)))


SLOW = ("fiala", "tmeasy", "magic formula 5.2", "magic formula 6.1")


@pytest.mark.parametrize(
    "kind", [pytest.param(kind, marks=[pytest.mark.slow] * (kind in SLOW)) for kind in TYRES]
)
def test_derivatives(kind: str) -> None:
    report = wheel(kind).check_derivatives()
    assert report, report


@pytest.mark.slow
def test_derivatives_on_a_profile() -> None:
    report = wheel("brush", road="0.05*sin(2*x)").check_derivatives()
    assert report, report


WRONG_CURVES = {
    "slope_x": ((30000.0, 40000.0), "slope_x leads to -1.062e.04 at 4.25 times the nominal load, which must"),
    "slope_y": ((30000.0, 130000.0), "slope_y leads to -5000 at 0 times the nominal load"),
    "sliding_slip_x": ((0.139, 0.139), "peak_slip_x must be less than sliding_slip_x, but they are 0.139"),
    "end_slip": ((0.16, 0.2), "zero_slip must be less than end_slip"),
    "sliding_force_y": (
        (1850.0, 3000.0),
        "sliding_force_y must be less than peak_force_y, but they are 2200 and",
    ),
    "peak_force_x": ((2000.0, 2700.0), "are 2922.85 and 2700 at 2 times the nominal load"),
}


@pytest.mark.parametrize("name", WRONG_CURVES)
def test_curves_without_sense_at_a_load_are_refused(name: str) -> None:
    pair, message = WRONG_CURVES[name]
    given = TYRES["tmeasy"][1] | {name: pair}
    given |= {"peak_slip_x": (0.139, 0.139)}
    body = sr.Body("wheel", mass=1.0, inertia=(1, 1, 1))
    with pytest.raises(sr.ModelError, match=message):
        sr.TmeasyTyre("tyre", body.point(0, 0, 0), **given).tyre_law()


def test_a_parked_car_stands_on_a_slope() -> None:
    run = sr.simulate(block(slope=0.2), until=100.0, t_eval=[0.0, 50.0, 100.0])
    position = run["car"].position
    assert abs(position[2] - position[1]).max() < 1e-10
    total = sum(run[f"{name}.longitudinal_force"][-1] for name in CORNERS)
    assert total == pytest.approx(MASS * G * np.sin(0.2), rel=1e-6)
    assert run["fl.load"][-1] < run["rl.load"][-1]


def test_locked_wheels_brake_with_the_friction() -> None:
    run = sr.simulate(block(speed=20.0), until=4.0, t_eval=np.linspace(0, 4, 401))
    v, x = run["car"].velocity[:, 0], run["car"].position[:, 0]
    fast = [int(np.argmax(v < limit)) for limit in (18.0, 3.0)]
    way, speeds = np.diff(x[fast])[0], v[fast]
    assert way == pytest.approx((speeds[0] ** 2 - speeds[1] ** 2) / (2 * MU * G), rel=1e-4)
    assert x[-1] == pytest.approx(20.0**2 / (2 * MU * G), rel=3e-3)  # with the deflection at both ends
    assert abs(v[-1]) < 1e-3


def rolling(speed: float, steer: float = 0.0, **given: Any) -> sr.System:
    """A hub that is moved along x, with a wheel that turns freely."""
    axis = (-np.sin(steer), np.cos(steer), 0.0)
    hub = sr.Body("hub", mass=1.0, inertia=(1, 1, 1), position=(0, 0, 0.29))
    spin = tuple(speed * np.cos(steer) / given.pop("rolling", 0.3) * np.array(axis))
    disc = sr.Body(
        "disc",
        mass=20.0,
        inertia=(1, 1, 1),
        position=(0, 0, 0.29),
        velocity=(speed, 0, 0),
        angular_velocity=spin,
    )
    joints = [
        sr.Translational("rail", sr.ground, hub, point=(0, 0, 0.29), axis=(1, 0, 0)),
        sr.Revolute("bearing", hub, disc, point=(0, 0, 0.29), axis=axis),
    ]
    drivers = [sr.DisplacementDriver("pull", "rail", f"{speed!r}*t")]
    tyre = sr.BrushTyre("tyre", disc.point(0, 0, 0), axis=axis, **BRUSH | given)
    return sr.System(sr.Model("trailer", [hub, disc], joints, [tyre], drivers=drivers, gravity=(0, 0, -G)))


def test_a_wheel_rolls_without_slip() -> None:
    run = sr.simulate(rolling(10.0, rolling=0.29), until=3.0, t_eval=[0.0, 3.0])
    R_e = (2 * RADIUS + 0.29) / 3
    assert run["bearing.rate"][-1] == pytest.approx(10.0 / R_e, rel=1e-7)
    assert run["tyre.slip"][-1] == pytest.approx(0.0, abs=1e-7)
    assert run["tyre.longitudinal_force"][-1] == pytest.approx(0.0, abs=1e-2)
    assert run["tyre.load"][-1] == pytest.approx(K * 0.02)


def test_the_lateral_force_sets_in_over_the_relaxation_length() -> None:
    """F(t) = F_∞ (1 - exp(-V t/σ)) of a linear tyre."""
    speed, steer, sigma = 12.0, 1e-3, 0.4
    R_e = (2 * RADIUS + 0.29) / 3
    system = rolling(speed, steer, mu=1e4, relaxation_y=sigma, rolling=R_e)
    t = np.linspace(0.0, 0.2, 21)
    run = sr.simulate(system, until=0.2, t_eval=t, method=sr.Radau(rtol=1e-10, atol=1e-12))
    steady = 8e4 * np.tan(steer)
    wanted = steady * (1 - np.exp(-speed * np.cos(steer) * t / sigma))
    assert run["tyre.lateral_force"] == pytest.approx(wanted, abs=2e-6 * steady)


def test_a_driven_wheel_spins_up_to_the_slip_that_carries_its_torque() -> None:
    """J Ω̇ = T − b (Ω − V/R_e) − R_l C u/σ, u̇ = R_e Ω − V − V u/σ, of an engine whose torque falls, for small slips."""
    speed, T, b, C, sigma, start = 12.0, 1.0, 2.0, 8e4, 0.4, 1e-3
    R_l, R_e = 0.29, (2 * RADIUS + 0.29) / 3
    trailer = rolling(speed, mu=1e4, relaxation_x=sigma, rolling=R_e).model
    free = T + b * speed / R_e
    engine = sr.Engine("engine", "bearing", 1.0, [[0, free], [100, free - 100 * b]])
    t, exact = np.linspace(0.0, 0.2, 21), sr.Radau(rtol=1e-10, atol=1e-12)
    run = sr.simulate(sr.System(trailer.adding(engine)), until=0.2, t_eval=t, method=exact)
    matrix = np.array([[-b, -R_l * C / sigma], [R_e, -speed / sigma]])  # of Ω - V/R_e and u, J = 1
    end = np.linalg.solve(matrix, [-T, 0.0])
    wanted = np.array([end - expm(matrix * one) @ end for one in t])
    assert run["bearing.rate"] - speed / R_e == pytest.approx(wanted[:, 0], abs=start * wanted[:, 0].max())
    assert run["tyre.longitudinal_force"] == pytest.approx(C / sigma * wanted[:, 1], abs=start * T / R_l)


@pytest.mark.parametrize("speed", [0.5, 2.0, 10.0])
def test_slips_of_steady_rolling_do_not_depend_on_the_speed(speed: float) -> None:
    """α is the angle between wheel and velocity, also where a sliding wheel would be bounded."""
    run = sr.simulate(rolling(speed, 0.05), until=8.0 / speed, t_eval=[0.0, 8.0 / speed])
    assert run["tyre.slip_angle"][-1] == pytest.approx(-0.05, rel=1e-4)
    assert run["tyre.slip"][-1] == pytest.approx(0.0, abs=1e-5)


def dragged(velocity: tuple[float, float], mass: float = 400.0) -> sr.Trajectory:
    """A locked wheel that is moved at a constant velocity for a second."""
    body = sr.Body(
        "car",
        mass=mass,
        inertia=(200, 200, 200),
        position=(0, 0, RADIUS - mass * G / K),
        velocity=(*velocity, 0.0),
    )
    hold = sr.Torque("hold", body, tuple(f"-1e5*car.angular_velocity.{axis}" for axis in "xyz"))
    pull = sr.PointDriver("pull", body.point(0, 0, 0), x=f"{velocity[0]}*t", y=f"{velocity[1]}*t")
    tyre = sr.BrushTyre("tyre", body.point(0, 0, 0), **BRUSH)
    model = sr.Model("dragged", [body], [], [tyre, hold], drivers=[pull], gravity=(0, 0, -G))
    return sr.simulate(sr.System(model), until=1.0, t_eval=[0.0, 1.0])


@pytest.mark.parametrize("mass", [100.0, 400.0, 1200.0])
@pytest.mark.parametrize("velocity", [(0.0, 5.0), (0.3, 3.0), (2.0, 5.0), (-1.0, 0.5)])
def test_friction_is_against_the_sliding_velocity(velocity: tuple[float, float], mass: float) -> None:
    run = dragged(velocity, mass)
    F = np.array([run["tyre.longitudinal_force"][-1], run["tyre.lateral_force"][-1]])
    assert F == pytest.approx(
        -MU * run["tyre.load"][-1] * np.array(velocity) / np.hypot(*velocity), rel=5e-3, abs=1.0
    )


A, B = 1.3, 1.5  # [m] of the single-track car, from its centre of mass to the wheels
LIGHT = 2e-3  # [kg m] mass of a wheel times its distance, so that the centre of mass is that of the car
TRACK_MASS = 1500.0 + LIGHT / A + LIGHT / B


@cache
def single_track(speed: float, steer: float = 0.0) -> sr.System:
    """A car that moves in a plane, with one wheel in front and one behind, and linear tyres."""
    bodies = [
        sr.Body("car", mass=1500.0, inertia=(500, 2000, 2500), position=(0, 0, 0.29), velocity=(speed, 0, 0))
    ]
    joints: list[Any] = [sr.Planar("plane", sr.ground, bodies[0], point=(0, 0, 0.29), axis=(0, 0, 1))]
    forces = []
    R_e = (2 * RADIUS + 0.29) / 3
    for name, x, stiffness in (("front", A, 7e4), ("rear", -B, 9e4)):
        angle = steer if name == "front" else 0.0
        axis = (-np.sin(angle), np.cos(angle), 0.0)
        spin = tuple(speed / R_e * np.array(axis))
        wheel = sr.Body(
            name, mass=LIGHT / abs(x), inertia=(1e-4, 1e-4, 1e-4), position=(x, 0, 0.29), velocity=(speed, 0, 0),
            angular_velocity=spin,
        )  # fmt: skip
        bodies.append(wheel)
        joints.append(sr.Revolute(f"{name}_bearing", bodies[0], wheel, point=(x, 0, 0.29), axis=axis))
        linear = BRUSH | {"mu": 1e7, "half_length": 0.0, "c_alpha": stiffness}
        forces.append(
            sr.BrushTyre(f"{name}_tyre", wheel.point(0, 0, 0), axis=axis, relaxation_y=0.5, **linear)
        )
    return sr.System(sr.Model("single track", bodies, joints, forces))


def matrix_of_single_track(V: float) -> np.ndarray:
    """ẋ = A x of v_y, ψ̇ and the lateral deflections of the front and the rear."""
    m, J, sigma, C_f, C_r = TRACK_MASS, 2500.0 + 2e-4 + LIGHT * (A + B), 0.5, 7e4, 9e4
    force = [-C_f / sigma, -C_r / sigma]
    return np.array(
        [
            [0, -V, force[0] / m, force[1] / m],
            [0, 0, A * force[0] / J, -B * force[1] / J],
            [1, A, -V / sigma, 0],
            [1, -B, 0, -V / sigma],
        ]
    )


def test_yaw_gain_of_a_single_track_car() -> None:
    """ψ̇/δ = V/(L + K_us V²), K_us = (m/L) (b/C_f - a/C_r)."""
    V, steer = 15.0, 1e-4
    run = sr.simulate(
        single_track(V, steer), until=6.0, t_eval=[0.0, 6.0], method=sr.Radau(rtol=1e-9, atol=1e-12)
    )
    L = A + B
    understeer = TRACK_MASS / L * (B / 7e4 - A / 9e4)
    found = run["car.angular_velocity.z"][-1] / steer
    assert found == pytest.approx(V / (L + understeer * V**2), rel=1e-6)


def test_poles_of_a_single_track_car() -> None:
    system = single_track(15.0)
    poles = sr.linearize(system, system.q0, system.v0).poles
    for wanted in np.linalg.eigvals(matrix_of_single_track(15.0)):
        assert abs(poles - wanted).min() < 1e-10 * abs(wanted)


def test_a_wheel_off_the_road_has_no_force() -> None:
    body = sr.Body("wheel", mass=20.0, inertia=(1, 1, 1), position=(0, 0, 2.0), angular_velocity=(0, 30.0, 0))
    tyre = sr.MagicFormulaTyre("tyre", body.point(0, 0, 0), coefficients=CAR)
    run = sr.simulate(
        sr.System(sr.Model("flight", [body], [], [tyre], gravity=(0, 0, -G))), until=0.5, t_eval=[0.5]
    )
    assert run["wheel"].position[-1][2] == pytest.approx(2.0 - G * 0.5**2 / 2)
    assert run["tyre.load"][-1] == 0
    assert run["tyre.friction_use"][-1] == pytest.approx(0, abs=1e-5)


def test_a_wheel_that_lies_on_its_side_has_no_contact() -> None:
    body = sr.Body("wheel", mass=20.0, inertia=(1, 1, 1), position=(0, 0, 0.5))
    tyre = sr.BrushTyre("tyre", body.point(0, 0, 0), axis=(0, 0, 1), **BRUSH)
    system = sr.System(sr.Model("fallen", [body], [], [tyre], gravity=(0, 0, -G)))
    with pytest.warns(sr.SarrusWarning, match="tyre: its contact ends where the wheel leans"):
        run = sr.simulate(system, until=1.0, t_eval=[1.0])
    assert run["wheel"].position[-1][2] == pytest.approx(0.5 - G / 2)


@pytest.mark.filterwarnings("ignore:... its contact ends where the wheel leans")
def test_a_car_that_rolls_over_ends_finite() -> None:
    car = sr.Body(
        "car", mass=MASS, inertia=(400, 1500, 1600), position=(0, 0, 0.8), velocity=(5.0, 20.0, 0.0),
        angular_velocity=(-4.0, 0, 0.5),
    )  # fmt: skip
    tyres = [sr.BrushTyre(name, car.point(x, y, -0.5), **BRUSH) for name, (x, y) in CORNERS.items()]
    system = sr.System(sr.Model("rollover", [car], [], tyres, gravity=(0, 0, -G)))
    run = sr.simulate(system, until=2.0, t_eval=[1.0, 2.0], limits=sr.Limits(time=120.0))
    assert run.success, run.message
    assert np.isfinite(run.q).all()
    assert np.isfinite(run["fl.load"]).all()


@pytest.mark.filterwarnings("ignore:tyre. its contact ends where the wheel leans")
@pytest.mark.parametrize("kind", ["brush", "magic formula 6.1"])
def test_a_wheel_that_topples_ends_finite(kind: str) -> None:
    """It leans by more than 70° before it falls through the road, on which nothing else holds it."""
    system = wheel(kind)
    run = sr.simulate(system, until=3.0, t_eval=np.linspace(0, 3, 31), limits=sr.Limits(time=300.0))
    assert run.success, run.message
    assert np.isfinite(run.q).all()
    assert abs(run["tyre.inclination"]).max() <= np.arcsin(0.99)


def test_a_wheel_stands_on_an_inclined_profile() -> None:
    """The contact is below the centre along the normal of the road, at the loaded radius."""
    for angle in (0.0, 0.2, 0.4):
        slope = float(np.tan(angle))
        body = sr.Body("wheel", mass=1.0, inertia=(1, 1, 1), position=(0, 0, (RADIUS - 0.01) / np.cos(angle)))
        tyre = sr.BrushTyre("tyre", body.point(0, 0, 0), road=f"{slope!r}*x" if slope else 0.0, **BRUSH)
        system = sr.System(sr.Model("slope", [body], [], [tyre]))
        run = sr.simulate(system, until=1e-6, t_eval=[0.0])
        assert run["tyre.compression"][0] == pytest.approx(0.01)
        assert run["tyre.load"][0] == pytest.approx(0.01 * K)
        F = np.array([run[f"tyre.force.{axis}"][0] for axis in "xyz"])
        assert F == pytest.approx(0.01 * K * np.array([-np.sin(angle), 0, np.cos(angle)]), abs=1e-6)


def test_energy_is_balanced() -> None:
    """What the wheel loses is stored in the vertical spring, or dissipated."""
    t = np.linspace(0, 0.3, 601)
    run = sr.simulate(wheel(), until=0.3, t_eval=t, method=sr.Radau(rtol=1e-9, atol=1e-11))
    energy = run.total_energy + run["tyre.energy"]
    lost = np.trapezoid(run["tyre.dissipated_power"], t)
    assert energy[0] - energy[-1] == pytest.approx(lost, rel=1e-4)


def test_a_profile_that_is_flat_is_the_flat_road() -> None:
    flat, profile = (sr.simulate(wheel(road=road), until=0.2, t_eval=[0.2]) for road in (0.0, "0*x"))
    assert profile["wheel"].position == pytest.approx(flat["wheel"].position, abs=1e-8)


@pytest.mark.parametrize("kind", TYRES)
def test_a_tyre_is_drawn_on_its_wheel(kind: str) -> None:
    system = wheel(kind)
    drawn = sketch(system.model, system.q0[None]).parts
    tyre, _, road = (part for part in drawn if part.name.endswith("tyre"))
    assert (tyre.body, tyre.description, road.body) == (1, "tyre", 0)
    long, wide, high = np.ptp(tyre.mesh.vertices, axis=0)
    assert long == pytest.approx(high, rel=0.02)
    assert wide < 0.5 * long
