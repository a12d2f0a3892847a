"""Radau IIA: order, accuracy, what a free body keeps, dependent equations; against trajectories of other programs."""

from itertools import pairwise

import numpy as np
import pytest
from tests.analyses.linkages import bennett
from tests.analyses.test_simulation import rigid_velocity, table
from tests.system.mechanisms import hmmwv, slider_crank

import sarrus as sr
from sarrus.analyses.dynamics.integrators import described
from sarrus.analyses.dynamics.stepping.tolerance import Tolerances


def test_order_five(monkeypatch: pytest.MonkeyPatch) -> None:
    wide = Tolerances.of(slider_crank(), 0.9, 1e3).for_loop(
        speed=True
    )  # no error control: every step is the longest
    monkeypatch.setattr(described, "filtered_tolerance", lambda given, error: wide._replace(newton=1e-15))
    exact, errors = 3.715022003716, []
    for h in (1 / 20, 1 / 40, 1 / 80):
        run = sr.simulate(
            slider_crank(), until=2.0, t_eval=[2.0], method=sr.Radau(max_step=h, rtol=0.9, atol=1.0)
        )
        errors.append(abs(run["slider"].position[-1, 0] - exact))
    slopes = np.log2(np.array(errors[:-1]) / errors[1:])
    assert 4.7 < slopes[-1] < 5.5, slopes


def test_the_error_falls_with_the_tolerance() -> None:
    reference, errors = table("spatial_slidercrank_paper.csv"), []
    for rtol in (1e-5, 1e-7, 1e-9, 1e-11):
        run = sr.simulate(
            slider_crank(), until=10.0, t_eval=reference["t"], method=sr.Radau(rtol=rtol, atol=rtol)
        )
        assert run.success, run.message
        errors.append(abs(run["slider"].position[:, 0] - reference["x_slider"]).max())
    assert all(before > 20 * after for before, after in pairwise(errors)), errors
    assert errors[-1] < 1e-9


def test_hmmwv_follows_the_reference() -> None:
    reference, system = table("hmmwv_T1.csv"), hmmwv()
    v = rigid_velocity(system, np.array([5.0, 0, -0.3]), np.array([0.2, 0.1, 0.05]))
    start = sr.assemble(system, system.q0, v)
    settings = {"until": 2.0, "t_eval": reference["t"], "method": sr.Radau(rtol=1e-10, atol=1e-10)}
    chassis = sr.simulate(system, start, **settings)["chassis"]
    for k, axis in enumerate("xyz"):
        assert np.allclose(chassis.position[:, k], reference[axis], rtol=0, atol=1e-10)
        assert np.allclose(chassis.velocity[:, k], reference[f"v{axis}"], rtol=0, atol=5e-9)


def tumbling() -> sr.System:
    """A free body that turns about its middle axis, which is unstable."""
    body = sr.Body("book", mass=1.0, inertia=(1, 2, 3), angular_velocity=(0.01, 5, 0.02))
    return sr.System(sr.Model("book", bodies=[body]))


def test_a_tumbling_body_keeps_energy_and_angular_momentum_over_100_s() -> None:
    settings = {"until": 100.0, "t_eval": [1.0, 20.0, 50.0, 100.0]}
    run = sr.simulate(tumbling(), method=sr.Radau(rtol=1e-13, atol=1e-13), **settings)
    assert run.success, run.message
    J, w = np.array([1.0, 2.0, 3.0]), run["book"].angular_velocity_body
    w0 = np.array([0.01, 5.0, 0.02])
    assert np.allclose(w[0], (-0.2196222938891, 4.9951842856923, 0.1282366977807), atol=1e-9)
    assert np.allclose(w[1], (-4.9209117585531, 0.8858484433201, 2.8411542569565), atol=2e-9)
    energy = 0.5 * np.sum(J * w * w, axis=1)
    assert np.allclose(energy, 0.5 * np.sum(J * w0 * w0), rtol=1e-9, atol=0)
    for k, p in enumerate(run["book"].euler):
        assert np.allclose(rotation(p) @ (J * w[k]), J * w0, rtol=0, atol=1e-9 * np.linalg.norm(J * w0))


def rotation(p: np.ndarray) -> np.ndarray:
    """A(p), from the formula of Rodrigues."""
    e = p[1:]
    cross = np.cross(np.eye(3), e)
    return np.eye(3) + 2 * p[0] * cross + 2 * cross @ cross


def test_what_is_given_out_satisfies_all_equations() -> None:
    system = slider_crank()
    run = sr.simulate(system, until=1.0, t_eval=[0.0, 0.123, 0.5, 1.0], method=sr.Radau(rtol=1e-6))
    for q, v, a, lam in zip(run.q, run.v, run.a, run.lam, strict=True):
        assert abs(system.Phi(q)).max() < 1e-13
        assert abs(system.Phi_q_xi(q, v)).max() < 1e-13
        assert np.allclose(
            system.M_a(q, a) + system.Phi_qT_lam(q, lam), system.Q(q, v) + system.S(q, v), atol=1e-10
        )
        assert np.allclose(system.Phi_q_xi(q, a), system.gamma(q, v), atol=1e-10)


def test_driven_and_dependent_equations() -> None:
    """A door on two hinges, turned by a driver: as the driver says, and both hinges share the load."""
    door = sr.Body("door", mass=2.0, inertia=(1, 1, 1), position=(0.5, 0, 0))
    hinges = [sr.Revolute(f"hinge_{n}", sr.ground, door, point=(0, 0, n), axis=(0, 0, 1)) for n in (0, 1)]
    motor = sr.AngleDriver("motor", "hinge_0", motion=lambda t: 0.3 * t * t)
    model = sr.Model("door", bodies=[door], joints=hinges, drivers=[motor], gravity=(0, 0, -9.81))
    run = sr.simulate(sr.System(model), until=2.0, t_eval=[1.0, 2.0], method=sr.Radau(rtol=1e-8))
    assert run.success, run.message
    angle = 0.3 * run.t**2
    assert np.allclose(run["door"].position[:, 0], 0.5 * np.cos(angle), atol=1e-8)
    first, second = (run.lam[-1][run.system.rows[name]] for name in ("hinge_0", "hinge_1"))
    assert first[2] + second[2] == pytest.approx(-2.0 * 9.81, abs=1e-8)


def test_a_stiff_spring_does_not_set_the_steps() -> None:
    """A quarter of a car: its tyre a million times stiffer."""
    steps = []
    for k in (1e5, 1e11):
        wheel = sr.Body("wheel", 40.0, (1, 1, 1), position=(0, 0, 0.3))
        car = sr.Body("car", 250.0, (1, 1, 1), position=(0, 0, 0.8))
        tyre = sr.TSDA("tyre", sr.ground.point(0, 0, 0), wheel.point(0, 0, 0), k=k, c=0.0, length=0.3)
        spring = sr.TSDA("spring", wheel.point(0, 0, 0), car.point(0, 0, 0), k=1.6e4, c=1e3, length=0.5)
        system = sr.System(sr.Model("car", [wheel, car], forces=[tyre, spring], gravity=(0, 0, -9.81)))
        run = sr.simulate(system, until=4.0, method=sr.Radau(rtol=1e-5, atol=1e-5))
        assert run.success, run.message
        steps.append(run.nsteps)
    assert steps[1] < 1.5 * steps[0] < 150, steps


def test_round_off_in_redundant_loops_is_not_taken_for_divergence() -> None:
    """Where corrections stop falling far below the tolerance, a shorter step would only make them larger."""
    run = sr.simulate(bennett(), until=0.6, t_eval=[0.6], method=sr.Radau(rtol=1e-10, atol=1e-10))
    assert run.success, run.message
