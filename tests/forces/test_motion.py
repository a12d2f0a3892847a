"""Friction, drag and loads over time against closed solutions."""

import numpy as np
import pytest
from tests.forces.precise import precise

import sarrus as sr
from sarrus.functions import sin

G = 9.81


def slider(**given: object) -> tuple[sr.Body, sr.Translational]:
    body = sr.Body("slider", 2.0, (1, 1, 1), **given)  # type: ignore[arg-type]
    return body, sr.Translational("guide", sr.ground, body, (0, 0, 0), (1, 0, 0))


def friction(body: sr.Body, **given: float) -> sr.DisplacementFriction:
    return sr.DisplacementFriction("friction", sr.ground, body, (0, 0, 0), (1, 0, 0), load=2.0 * G, **given)


def test_a_slider_comes_to_rest() -> None:
    body, guide = slider(velocity=(1.0, 0, 0))
    rub = friction(body, mu=0.25, creep=1e-4)
    run = sr.simulate(sr.System(sr.Model("m", [body], [guide], [rub])), until=1.0, t_eval=[0.2, 0.3, 1.0])
    assert run["slider"].velocity[:2, 0] == pytest.approx([1 - 0.25 * G * t for t in (0.2, 0.3)], rel=1e-6)
    assert run["slider"].velocity[2, 0] == pytest.approx(0, abs=1e-6)
    assert run["slider"].position[2, 0] == pytest.approx(1 / (2 * 0.25 * G), abs=1e-4)


def test_stick_and_slip() -> None:
    """Pulled by a spring whose end runs away, the slider sticks up to μ_s N, slips, and sticks again."""
    k, pull = 200.0, 0.05
    body, guide = slider()
    spring = sr.TSDA(
        "spring", body.point(0, 0, 0), sr.ground.point(5, 0, 0), k=k, length=5.0, force=lambda t: k * pull * t
    )
    rub = friction(body, mu=0.2, mu_static=0.4, stribeck=0.02, creep=2e-4)
    system = sr.System(sr.Model("m", [body], [guide], [spring, rub]))
    run = sr.simulate(system, until=4.0, t_eval=np.linspace(0, 4, 801), method=sr.Radau(rtol=1e-6, atol=1e-8))
    speed, x, t = run["slider"].velocity[:, 0], run["slider"].position[:, 0], run.t
    slips = speed > 0.02
    starts = np.flatnonzero(slips[1:] & ~slips[:-1])
    assert len(starts) >= 2
    force = k * (pull * t - x)
    assert force[starts[0]] == pytest.approx(0.4 * 2 * G, rel=0.1)
    assert x[starts[0]] < 0.003
    assert force[starts[0] + 100 : starts[1]].min() < 0.2 * 2 * G  # it overshoots, and then sticks
    assert np.count_nonzero(abs(speed) < 2e-3) > len(t) / 3


def test_a_pin_brakes() -> None:
    wheel = sr.Body("wheel", 1.0, (1, 1, 0.5), angular_velocity=(0, 0, 10.0))
    hinge = sr.Revolute("hinge", sr.ground, wheel, (0, 0, 0), (0, 0, 1))
    rub = sr.AngleFriction(
        "rub",
        sr.ground,
        wheel,
        (0, 0, 0),
        (0, 0, 1),
        radius=0.02,
        load=100.0,
        mu=0.3,
        stribeck=1e-3,
        creep=1e-4,
    )
    run = precise(sr.System(sr.Model("m", [wheel], [hinge], [rub])), until=5.0, t_eval=[2.0, 5.0])
    assert run["wheel"].angular_velocity_body[0, 2] == pytest.approx(
        10 - 0.02 * 100 * 0.3 / 0.5 * 2.0, rel=1e-6
    )


def test_terminal_velocity() -> None:
    """v = v∞ tanh(g t / v∞) with v∞² = m g / c."""
    body = sr.Body("stone", 2.0, (1, 1, 1))
    air = sr.Drag("air", body.point(0, 0, 0), c=0.05, creep=1e-6)
    times = np.array([0.5, 2.0, 10.0])
    run = precise(
        sr.System(sr.Model("m", [body], forces=[air], gravity=(0, 0, -G))), until=10.0, t_eval=times
    )
    limit = np.sqrt(2 * G / 0.05)
    assert -run["stone"].velocity[:, 2] == pytest.approx(limit * np.tanh(G * times / limit), rel=1e-7)


def test_wind_carries_along() -> None:
    body = sr.Body("leaf", 0.1, (1, 1, 1))
    air = sr.Drag("air", body.point(0, 0, 0), c=1.0, wind=(3.0, 1.0, 0))
    run = precise(sr.System(sr.Model("m", [body], forces=[air])), until=20.0, t_eval=[20.0])
    assert run["leaf"].velocity[-1] == pytest.approx([3, 1, 0], abs=0.05)


def test_viscous_decay() -> None:
    body = sr.Body("disc", 2.0, (1, 1, 0.5), velocity=(1, 0, 0), angular_velocity=(0, 0, 3.0))
    oil = sr.ViscousDrag("oil", body.point(0, 0, 0), c=0.5, c_turn=0.2)
    run = precise(sr.System(sr.Model("m", [body], forces=[oil])), until=2.0, t_eval=[2.0])
    assert run["disc"].velocity[-1, 0] == pytest.approx(np.exp(-0.5 / 2 * 2), rel=1e-7)
    assert run["disc"].angular_velocity_body[-1, 2] == pytest.approx(3 * np.exp(-0.2 / 0.5 * 2), rel=1e-7)


@pytest.mark.parametrize("force", [
    {"force": (0, lambda t: 3 * sin(2 * t), 0)},
    {"force": (0, 3, 0), "factor": lambda t: sin(2 * t)},
])  # fmt: skip
def test_a_force_over_time(force: dict[str, object]) -> None:
    body = sr.Body("body", 2.0, (1, 1, 1))
    load = sr.PointForce("load", body.point(0, 0, 0), **force)  # type: ignore[arg-type]
    run = precise(sr.System(sr.Model("m", [body], forces=[load])), until=2.0, t_eval=[1.0, 2.0])
    assert run["body"].velocity[:, 1] == pytest.approx(3 / 4 * (1 - np.cos(2 * run.t)), rel=1e-8)


def test_a_body_torque_over_time_turns_with_the_body() -> None:
    body = sr.Body("body", 1.0, (1, 1.2, 0.5), orientation=sr.AxisAngle((0, 1, 0), 0.7))
    load = sr.Torque("load", body, (0, 0, [[0, 0], [1, 1], [2, 2]]), axes="body")
    run = precise(sr.System(sr.Model("m", [body], forces=[load])), until=1.0, t_eval=[1.0])
    assert run["body"].angular_velocity_body[-1] == pytest.approx([0, 0, 0.5 / 0.5], abs=1e-7)  # in body axes


def test_a_hardening_spring_conserves_energy() -> None:
    """k(l) (l - length) has the potential ∫ (3 + 40 s²) s ds = 3/2 s² + 10 s⁴."""
    body, guide = slider(velocity=(2.0, 0, 0))
    spring = sr.TSDA(
        "spring",
        sr.ground.point(-5, 0, 0),
        body.point(0, 0, 0),
        length=5.0,
        k=lambda l: 3 + 40 * (l - 5) ** 2,
    )
    run = sr.simulate(
        sr.System(sr.Model("m", [body], [guide], [spring])), until=5.0, method=sr.ODE(rtol=1e-10, atol=1e-12)
    )
    x, speed = run["slider"].position[:, 0], run["slider"].velocity[:, 0]
    assert np.allclose(speed**2 + 1.5 * x**2 + 10 * x**4, 4.0, rtol=1e-8)
    assert abs(x).max() > 0.7


def test_a_hardening_coil_conserves_energy() -> None:
    wheel = sr.Body("wheel", 1.0, (1, 1, 0.5), angular_velocity=(0, 0, 4.0))
    hinge = sr.Revolute("hinge", sr.ground, wheel, (0, 0, 0), (0, 0, 1))
    coil = sr.RSDA("coil", sr.ground, wheel, (0, 0, 0), (0, 0, 1), k=lambda angle: 0.1 + 0.02 * angle * angle)
    run = sr.simulate(
        sr.System(sr.Model("m", [wheel], [hinge], [coil])), until=6.0, method=sr.ODE(rtol=1e-10, atol=1e-12)
    )
    angle = np.unwrap(2 * np.arctan2(run["wheel"].euler[:, 3], run["wheel"].euler[:, 0]))
    energy = 0.25 * run["wheel"].angular_velocity_body[:, 2] ** 2 + 0.05 * angle**2 + 0.005 * angle**4
    assert angle.max() > np.pi
    assert np.allclose(energy, 4.0, rtol=1e-7)
