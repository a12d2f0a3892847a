"""An RSDA counts revolutions: its torque goes on growing over many turns, in a simulation too."""

import numpy as np
import pytest

import sarrus as sr


def wheel(spin: float, k: float = 0.0, c: float = 0.0, torque: float = 0.0) -> sr.System:
    body = sr.Body("wheel", mass=1.0, inertia=(1, 1, 2.0), angular_velocity=(0, 0, spin))
    pin = sr.Revolute("pin", sr.ground, body, point=(0, 0, 0), axis=(0, 0, 1))
    spring = sr.RSDA("spring", sr.ground, body, point=(0, 0, 0), axis=(0, 0, 1), k=k, c=c, torque=torque)
    return sr.System(sr.Model("wheel", bodies=[body], joints=[pin], forces=[spring]))


def turned(angle: float) -> np.ndarray:
    return np.array([0, 0, 0, np.cos(angle / 2), 0, 0, np.sin(angle / 2)])


def test_the_angle_is_continuous_over_turns() -> None:
    system = wheel(0.0, k=3.0)
    b = system.b.copy()
    rest = np.zeros(7)
    for angle in np.arange(0.0, 25.0, 0.5):
        q = turned(angle)
        system.remember(q, b)
        about_axis = 0.5 * system.Q(q, rest, b=b)[3:] @ np.array([-q[6], q[5], -q[4], q[3]])
        assert about_axis == pytest.approx(-3.0 * angle, abs=1e-11)


def test_a_weak_spring_winds_up_over_several_turns() -> None:
    k, inertia, spin = 0.02, 2.0, 8.0
    run = sr.simulate(wheel(spin, k=k), until=20.0, method=sr.ODE(rtol=1e-10, atol=1e-12))
    omega = np.sqrt(k / inertia)
    expected = spin * np.cos(omega * run.t)
    assert run.success
    assert np.allclose(run["wheel"].angular_velocity_body[:, 2], expected, atol=1e-7)
    assert spin / omega * np.sin(omega * run.t[-1]) > 2 * np.pi * 10
