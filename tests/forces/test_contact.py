"""Contact: the loss of an impact, sliding that becomes rolling, stops that hold."""

import numpy as np
import pytest
from scipy.optimize import brentq
from tests.forces.precise import precise

import sarrus as sr

FLOOR = sr.ground.frame((0, 0, 0), z=(0, 0, 1))


def ball(**given: object) -> sr.Body:
    return sr.Body("ball", 2.0, (0.4 * 2.0 * 0.01,) * 3, **given)  # type: ignore[arg-type]


@pytest.mark.parametrize("exponent", [1.0, 1.5])
@pytest.mark.parametrize("damping", [0.0, 0.1, 0.3, 1.0, 1.6])
def test_loss_of_an_impact(exponent: float, damping: float) -> None:
    """N = g(δ) (1 + d δ̇) gives d u - ln(1 + d u) = -d w - ln(1 - d w) for the speeds u before and w after."""
    u, body = 1.5, ball(position=(0, 0, 0.2), velocity=(0, 0, -1.5))
    touch = sr.SphereContact(
        "touch", body.point(0, 0, 0), FLOOR, radius=0.1, stiffness=1e6, exponent=exponent, damping=damping
    )
    run = precise(sr.System(sr.Model("m", [body], forces=[touch])), until=0.2)
    w, z = run["ball"].velocity[-1, 2], run["ball"].position[:, 2]
    assert z[-1] > 0.11
    assert z.min() < 0.0999
    if damping == 0:
        assert w == pytest.approx(u, rel=1e-7)
        return
    spent = damping * u - np.log1p(damping * u)
    most = min(u, (1 - 1e-9) / damping)
    wanted = brentq(lambda w: -damping * w - np.log1p(-damping * w) - spent, 0, most)
    assert w == pytest.approx(wanted, rel=1e-6)


def test_a_sliding_ball_comes_to_roll() -> None:
    """The speed falls by μ g until 5/7 of it are left, and stays: a classic, whatever μ."""
    body = ball(position=(0, 0, 0.1), velocity=(2.0, 0, 0))
    touch = sr.SphereContact(
        "touch", body.point(0, 0, 0), FLOOR, radius=0.1, stiffness=1e6, damping=0.5, mu=0.2, creep=1e-4
    )
    model = sr.Model("m", [body], forces=[touch], gravity=(0, 0, -9.81))
    run = sr.simulate(
        sr.System(model), until=0.5, t_eval=[0.1, 0.2, 0.5], method=sr.Radau(rtol=1e-8, atol=1e-10)
    )
    speed, spin = run["ball"].velocity[:, 0], run["ball"].angular_velocity_body[:, 1]
    assert speed[:2] == pytest.approx([2 - 0.2 * 9.81 * t for t in (0.1, 0.2)], abs=2e-3)
    assert speed[2] == pytest.approx(2.0 * 5 / 7, rel=2e-3)
    assert spin[2] * 0.1 == pytest.approx(speed[2], rel=2e-3)


def test_a_ball_in_a_soft_plane_rolls_on_its_own_radius() -> None:
    """It sinks in by a tenth of its radius; friction acts a radius from its centre all the same."""
    body = ball(position=(0, 0, 0.1 - 2 * 9.81 / 2e3), velocity=(1.0, 0, 0))
    touch = sr.SphereContact(
        "touch", body.point(0, 0, 0), FLOOR, radius=0.1, stiffness=2e3, damping=0.5, mu=0.3, creep=1e-4
    )
    model = sr.Model("m", [body], forces=[touch], gravity=(0, 0, -9.81))
    run = sr.simulate(sr.System(model), until=0.6, t_eval=[0.6], method=sr.Radau(rtol=1e-8, atol=1e-10))
    speed, spin = run["ball"].velocity[-1, 0], run["ball"].angular_velocity_body[-1, 1]
    assert speed == pytest.approx(5 / 7, rel=1e-5)
    assert spin * 0.1 == pytest.approx(speed, rel=1e-5)


def test_a_point_rests_on_the_plane_where_its_weight_is_borne() -> None:
    body = sr.Body("ball", 2.0, (1, 1, 1), position=(0, 0, 1e-3))
    touch = sr.SphereContact("touch", body.point(0, 0, 0), FLOOR, stiffness=1e5, damping=20.0, rounding=1e-5)
    model = sr.Model("m", [body], forces=[touch], gravity=(0, 0, -9.81))
    run = sr.simulate(sr.System(model), until=3.0, t_eval=[3.0])
    assert run["ball"].position[-1, 2] == pytest.approx(-2 * 9.81 / 1e5, rel=1e-3)


def test_a_rope_ends_a_fall_and_an_apart_stop_does_nothing() -> None:
    body = sr.Body("ball", 1.0, (1, 1, 1), position=(0, 0, -0.5), velocity=(1.0, 0, 0))
    ropes = [
        sr.LengthStop("rope", sr.ground.point(0, 0, 0), body.point(0, 0, 0), upper=1.0, stiffness=1e5),
        sr.LengthStop(
            "other", sr.ground.point(0, 0, 0), body.point(0, 0, 0), lower=0.1, upper=9.0, stiffness=1e5
        ),
    ]
    system = sr.System(sr.Model("m", [body], forces=ropes, gravity=(0, 0, -9.81)))
    run = precise(system, until=2.0)
    length = np.linalg.norm(run["ball"].position, axis=1)
    free = length < 0.999
    energy = 0.5 * np.sum(run["ball"].velocity ** 2, axis=1) + 9.81 * run["ball"].position[:, 2]
    assert 1.0 < length.max() < 1.03
    assert np.count_nonzero(free[1:] != free[:-1]) >= 2
    assert np.allclose(energy[free], energy[0], atol=1e-5)


def test_a_door_turns_between_its_stops() -> None:
    door = sr.Body(
        "door", 3.0, (1, 1, 1), position=(0.5, 0, 0), angular_velocity=(0, 0, 2.0), velocity=(0, 1.0, 0)
    )
    hinge = sr.Revolute("hinge", sr.ground, door, (0, 0, 0), (0, 0, 1))
    stop = sr.AngleStop("stop", sr.ground, door, (0, 0, 0), (0, 0, 1), lower=-4.0, upper=4.0, stiffness=1e4)
    run = precise(sr.System(sr.Model("m", [door], [hinge], [stop])), until=8.0)
    angle = np.unwrap(2 * np.arctan2(run["door"].euler[:, 3], run["door"].euler[:, 0]))
    assert angle.max() == pytest.approx(4.0, abs=0.05)
    assert angle.min() == pytest.approx(-4.0, abs=0.05)
    assert abs(run["door"].angular_velocity_body[-1, 2]) == pytest.approx(2.0, rel=1e-5)


def test_a_slider_bounces_between_its_stops() -> None:
    slider = sr.Body("slider", 1.0, (1, 1, 1), velocity=(1.0, 0, 0))
    guide = sr.Translational("guide", sr.ground, slider, (0, 0, 0), (1, 0, 0))
    stop = sr.DisplacementStop(
        "stop", sr.ground, slider, (0, 0, 0), (1, 0, 0), lower=-0.2, upper=0.3, stiffness=1e5
    )
    run = precise(sr.System(sr.Model("m", [slider], [guide], [stop])), until=2.0)
    x = run["slider"].position[:, 0]
    assert x.max() == pytest.approx(0.303, abs=1e-3)
    assert x.min() == pytest.approx(-0.203, abs=1e-3)
