"""Driven motions follow f(t) exactly, over several turns; times and velocities are consistent."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import sarrus as sr
from sarrus.functions import sin

CRANK, ROD, TURNS = 1.0, 3.0, 3


def angle(t: float) -> float:
    """The prescribed crank angle: three turns in two seconds, with a ripple. [rad]"""
    return 2 * np.pi * TURNS * t / 2 + 0.2 * sin(4 * t)


@cache
def slider_crank() -> sr.System:
    """A planar slider-crank whose crank is driven; no degree of freedom is left."""
    crank = sr.Body("crank", 1.0, (0.1, 0.1, 0.1), position=(CRANK / 2, 0, 0))
    rod = sr.Body("rod", 1.0, (0.1, 0.5, 0.5), position=(CRANK + ROD / 2, 0, 0))
    slider = sr.Body("slider", 2.0, (0.1, 0.1, 0.1), position=(CRANK + ROD, 0, 0))
    joints = [
        sr.Revolute("pin", sr.ground, crank, point=(0, 0, 0), axis=(0, 0, 1)),
        sr.Revolute("knee", crank, rod, point=(CRANK, 0, 0), axis=(0, 0, 1)),
        sr.Translational("guide", sr.ground, slider, point=(CRANK + ROD, 0, 0), axis=(1, 0, 0)),
        sr.PointOnLine("wrist", rod, slider, point=(CRANK + ROD, 0, 0), axis=(0, 0, 1)),
    ]
    model = sr.Model(
        "slider-crank", [crank, rod, slider], joints, drivers=[sr.AngleDriver("motor", "pin", angle)]
    )
    return sr.System(model)


def place(t: float) -> float:
    """Position of the slider in closed form. [m]"""
    turned = angle(t)
    return CRANK * np.cos(turned) + np.sqrt(ROD**2 - (CRANK * np.sin(turned)) ** 2)


@cache
def run() -> sr.Trajectory:
    return sr.simulate(
        slider_crank(), until=2.0, t_eval=np.linspace(0, 2, 81), method=sr.ODE(rtol=1e-9, atol=1e-11)
    )


def test_a_driven_slider_crank_is_a_system_of_full_rank() -> None:
    system = slider_crank()
    assert system.nq == system.m
    assert np.linalg.matrix_rank(system.Phi_q(sr.assemble(system).q).toarray()) == system.nq
    assert list(system.rows["motor"]) == [system.m - 4]
    assert system.row_names[system.m - 4] == "motor: angle"


def test_the_crank_follows_over_three_turns() -> None:
    assert run().success
    turned = np.array([angle(t) for t in run().t])
    assert turned[-1] > 6 * np.pi
    assert np.allclose(run().joint("pin").angle, turned, atol=1e-11)
    rate = 2 * np.pi * TURNS / 2 + 0.8 * np.cos(4 * run().t)
    assert np.allclose(run().joint("pin").rate, rate, atol=1e-10)


def test_the_slider_follows_the_closed_form() -> None:
    assert np.allclose(run()["slider"].position[:, 0], [place(t) for t in run().t], atol=1e-11)
    h = 1e-4
    bend = [(place(t + h) - 2 * place(t) + place(t - h)) / h**2 for t in run().t]
    assert np.allclose(run().a[:, 14], bend, atol=1e-4)


def test_velocity_and_acceleration_equations_hold() -> None:
    system = slider_crank()
    for t, q, v, a in zip(run().t, run().q, run().v, run().a, strict=True):
        assert np.allclose(system.Phi_q_xi(q, v, t), -system.Phi_t(q, t), atol=1e-11)
        assert np.allclose(system.Phi_q_xi(q, a, t), system.gamma(q, v, t), atol=1e-8)


def test_assembly_at_another_time_and_with_the_drivers_velocity() -> None:
    system = slider_crank()
    start = sr.assemble(system, t=0.05)
    assert start.success
    assert system.joint("pin").angle(start.q) == pytest.approx(angle(0.05), abs=1e-12)
    assert np.allclose(system.Phi_q_xi(start.q, start.v, 0.05), -system.Phi_t(start.q, 0.05), atol=1e-12)
    assert abs(start.v).max() > 1


def test_derivatives_to_time_by_complex_step() -> None:
    """The motions that formulas, tables and functions give, against their own derivatives."""
    system, t = slider_crank(), 0.3
    q, row = sr.assemble(system, t=0.3).q, slice(*[slider_crank().m - 4, slider_crank().m - 3])
    step = 1e-30
    slope = (2 * np.pi * TURNS * complex(t, step) / 2 + 0.2 * np.sin(4 * complex(t, step))).imag / step
    assert system.Phi_t(q, t)[row] == pytest.approx(-slope, abs=1e-13)
    assert system.Phi_tt(q, t)[row] == pytest.approx(3.2 * np.sin(4 * t), abs=1e-12)


def gears(ratio: float) -> sr.System:
    """Two wheels on the ground, geared, the first driven."""
    wheels = [sr.Body(name, 1.0, (1, 1, 2.0), position=(x, 0, 0)) for x, name in enumerate("ab")]
    pins = [
        sr.Revolute(f"pin_{wheel.name}", sr.ground, wheel, point=wheel.position, axis=(0, 0, 1))
        for wheel in wheels
    ]
    gear = sr.Gear("gear", "pin_a", "pin_b", ratio=ratio)
    motor = sr.AngleDriver("motor", "pin_a", "3*t + 5*t^2")
    return sr.System(sr.Model("gears", wheels, [*pins, gear], drivers=[motor]))


def test_gears_of_no_whole_ratio_count_their_turns() -> None:
    run = sr.simulate(
        gears(-2.3), until=3.0, t_eval=np.linspace(0, 3, 61), method=sr.ODE(rtol=1e-8, atol=1e-10)
    )
    turned = 3 * run.t + 5 * run.t**2
    assert run.success
    assert turned[-1] > 8 * 2 * np.pi
    assert np.allclose(run.joint("pin_a").angle, turned, atol=1e-10)
    assert np.allclose(run.joint("pin_b").angle, -2.3 * turned, atol=1e-10)


def test_a_driven_screw_moves_over_many_turns() -> None:
    body = sr.Body("screw", 1.0, (1, 1, 2.0), position=(0.3, 0, 0))
    thread = sr.Screw("thread", sr.ground, body, point=(0, 0, 0), axis=(0, 0, 1), pitch=0.05)
    system = sr.System(
        sr.Model("screw", [body], [thread], drivers=[sr.AngleDriver("motor", "thread", "20*t")])
    )
    run = sr.simulate(system, until=2.0, t_eval=np.linspace(0, 2, 41), method=sr.ODE(rtol=1e-8, atol=1e-10))
    assert run.success
    assert np.allclose(run.joint("thread").angle, 20 * run.t, atol=1e-10)
    assert np.allclose(run.joint("thread").displacement, 0.05 / (2 * np.pi) * 20 * run.t, atol=1e-11)


def test_a_point_follows_a_path_and_a_length_its_formula() -> None:
    body = sr.Body("tool", 1.0, (1, 1, 1), position=(1, 0, 0))
    hold = sr.PointDriver("path", body.point(0, 0, 0), x="cos(2*t)", y="sin(2*t)")
    lift = sr.DistanceDriver("lift", sr.ground.point(0, 0, -2), body.point(0, 0, 0), "sqrt(5) * (1 + 0.1*t)")
    level = [
        sr.CoordinateDriver(f"level {name}".replace(" ", "_"), body, name, 0.0) for name in ("e1", "e2", "e3")
    ]
    system = sr.System(sr.Model("tool", [body], drivers=[hold, lift, *level]))
    run = sr.simulate(system, until=1.0, t_eval=np.linspace(0, 1, 11), method=sr.ODE(rtol=1e-8, atol=1e-10))
    assert run.success
    x, y, z = run["tool"].position.T
    assert np.allclose(x, np.cos(2 * run.t), atol=1e-11)
    assert np.allclose(y, np.sin(2 * run.t), atol=1e-11)
    assert np.allclose(z, np.sqrt(5 * (1 + 0.1 * run.t) ** 2 - 1) - 2, atol=1e-11)
