"""HHT and generalized-α: order, tolerances, stiffness, trouble; against trajectories that other programs computed."""

from dataclasses import replace

import numpy as np
import pytest
from tests.analyses.test_simulation import rigid_velocity, table
from tests.prescribed_steps import run_of
from tests.system.mechanisms import hmmwv, slider_crank

import sarrus as sr
from sarrus._jit.linking.link import fingerprint
from sarrus.analyses.dynamics.step_loop import equations, loop, newton

METHODS = (sr.HHT(), sr.GeneralizedAlpha(0.8), sr.HHT(0.0))


def fixed(method: object) -> object:
    """The method without error control: every step is the longest."""
    blind = type(
        "Blind", (type(method),), {"scheme": lambda self: type(method).scheme(self)._replace(error=0.0)}
    )
    return blind(**vars(method))


@pytest.mark.parametrize("method", METHODS)
def test_order_two(method: object) -> None:
    exact = 3.715022003716
    errors = []
    for h in (1e-2, 5e-3, 2.5e-3):
        settings = {"method": replace(fixed(method), rtol=1e-9, atol=1e-9, max_step=h)}
        run = sr.simulate(slider_crank(), until=2.0, t_eval=[2.0], **settings)
        errors.append(abs(run["slider"].position[-1, 0] - exact))
    slopes = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all((slopes > 1.8) & (slopes < 2.3)), slopes


def prescribed(method: object, lengths: np.ndarray) -> sr.Trajectory:
    """A run with given steps."""
    settings = {"rtol": 1e-9, "atol": 1e-9, "store_steps": True, "given": lengths}
    times = np.array([0.0, lengths.sum()])
    return run_of(method, slider_crank(), sr.assemble(slider_crank()), times, **settings)


@pytest.mark.parametrize("method", METHODS[:2])
def test_order_two_with_steps_that_change(method: object) -> None:
    exact, errors = 3.715022003716, []
    for n in (100, 200, 400):
        pattern = np.tile(np.repeat([1.0, 1.7], 5), n // 10)
        run = prescribed(method, 2.0 * pattern / pattern.sum())
        errors.append(abs(run.steps.q[-1, 14] - exact))
    slopes = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all((slopes > 1.7) & (slopes < 2.3)), (slopes, errors)


def test_kept_steps_are_what_was_done() -> None:
    """Steps of the same lengths give the same states, and satisfy the scheme's equations to round-off."""
    system = slider_crank()
    run = sr.simulate(system, until=1.0, store="steps", method=sr.HHT(rtol=1e-5, atol=1e-7))
    given = run.steps
    assert len(given) == run.nsteps
    assert np.allclose(given.t[1:], np.cumsum(given.h), rtol=1e-13)
    assert np.any(given.removed != 0)
    again = run_of(
        sr.HHT(),
        system,
        given.start,
        np.array([0.0, 1.0]),
        rtol=1e-5,
        atol=1e-7,
        store_steps=True,
        given=given.h,
    )
    steps = again.steps
    for n in range(1, len(steps) + 1):
        q, v, a, lam = steps.q[n], steps.v[n], steps.a[n], steps.lam[n]
        balance = system.M_a(q, a) + system.Phi_qT_lam(q, lam) - system.Q(q, v) - system.S(q, v)
        assert abs(balance).max() < 1e-9 * abs(system.M_a(q, a)).max() + 1e-10
        assert abs(system.Phi(q)).max() < 1e-14
    assert np.allclose(given.q, steps.q, rtol=0, atol=1e-5)
    assert np.array_equal(given.removed != 0, steps.removed != 0)


@pytest.mark.parametrize("method", METHODS[:2])
def test_the_error_falls_with_the_tolerance(method: object) -> None:
    reference = table("spatial_slidercrank_paper.csv")
    times = reference["t"][reference["t"] <= 5]
    errors = []
    for rtol in (1e-4, 1e-6, 1e-8):
        run = sr.simulate(
            slider_crank(), until=5.0, t_eval=times, method=replace(method, rtol=rtol, atol=rtol)
        )
        assert run.success
        errors.append(abs(run["slider"].position[:, 0] - reference["x_slider"][: len(times)]).max())
    assert errors[0] > 5 * errors[1] > 25 * errors[2]
    assert errors[2] < 1e-4


def test_constraints_hold_where_states_are_given_out() -> None:
    system = slider_crank()
    run = sr.simulate(system, until=3.0, method=sr.HHT(rtol=1e-5, atol=1e-5))
    assert run.violation.max() < 1e-12
    assert max(abs(system.Phi_q_xi(q, v)).max() for q, v in zip(run.q, run.v, strict=True)) < 1e-11
    p = run.q.reshape(len(run.t), -1, 7)[:, :, 3:]
    assert abs(np.sum(p * p, axis=2) - 1).max() < 1e-12


FINE = {"method": sr.Radau(rtol=1e-7, atol=1e-7)}


def test_hmmwv_follows_the_reference() -> None:
    reference, system = table("hmmwv_T1.csv"), hmmwv()
    v = rigid_velocity(system, np.array([5.0, 0, -0.3]), np.array([0.2, 0.1, 0.05]))
    run = sr.simulate(
        system, sr.assemble(system, system.q0, v), until=reference["t"][-1], t_eval=reference["t"], **FINE
    )
    assert run.success
    for k, axis in enumerate("xyz"):
        assert np.allclose(run["chassis"].position[:, k], reference[axis], atol=1e-4)


def spring_mass(stiffness: float) -> sr.System:
    """A pendulum whose bob hangs on a stiff spring along a light guide."""
    bob = sr.Body("bob", mass=1.0, inertia=(0.1, 0.1, 0.1), position=(1.0, 0, 0))
    spring = sr.TSDA("spring", sr.ground.point(0, 0, 0), bob.point(0, 0, 0), k=stiffness, c=0.0, length=1.0)
    return sr.System(sr.Model("spring", bodies=[bob], forces=[spring], gravity=(0, 0, -9.81)))


def test_steps_are_set_by_the_motion_not_by_the_stiffness() -> None:
    steps = []
    for stiffness in (1e5, 1e7, 1e9):
        run = sr.simulate(spring_mass(stiffness), until=2.0, method=sr.HHT(-0.3, rtol=1e-4, atol=1e-4))
        assert run.success, run.message
        steps.append(run.nsteps)
    assert steps[2] < 1.6 * steps[1] < 500, steps


def test_an_rsda_counts_its_turns() -> None:
    wheel = sr.Body("wheel", mass=1.0, inertia=(1, 1, 2.0), angular_velocity=(0, 0, 8.0))
    pin = sr.Revolute("pin", sr.ground, wheel, point=(0, 0, 0), axis=(0, 0, 1))
    spring = sr.RSDA("spring", sr.ground, wheel, point=(0, 0, 0), axis=(0, 0, 1), k=0.02)
    system = sr.System(sr.Model("wheel", bodies=[wheel], joints=[pin], forces=[spring]))
    run = sr.simulate(system, until=10.0, method=sr.HHT(rtol=1e-7, atol=1e-7))
    expected = 8.0 * np.cos(0.1 * run.t)
    assert np.allclose(run["wheel"].angular_velocity_body[:, 2], expected, atol=1e-3)


def test_the_history_tells_the_steps() -> None:
    run = sr.simulate(slider_crank(), until=1.0, method=sr.HHT())
    assert len(run.history) == run.nsteps
    assert run.history[-1, 0] == pytest.approx(1.0)
    assert np.all(run.history[:, 2] <= 1.0)
    assert np.allclose(np.cumsum(run.history[:, 1]), run.history[:, 0])
    assert run.njev < run.nsteps


def test_a_door_on_two_hinges_swings() -> None:
    """Redundant, consistent equations: the same motion as on one hinge, the load shared."""
    door = sr.Body(
        "door",
        mass=2.0,
        inertia=(1, 1, 1),
        position=(0.5, 0, 0),
        angular_velocity=(0, 0, 1.0),
        velocity=(0, 0.5, 0),
    )
    hinges = [sr.Revolute(f"hinge_{n}", sr.ground, door, point=(0, 0, n), axis=(0, 0, 1)) for n in (0, 1)]
    runs = []
    for count in (1, 2):
        model = sr.Model("door", bodies=[door], joints=hinges[:count], gravity=(0, 0, -9.81))
        runs.append(
            sr.simulate(sr.System(model), until=3.0, t_eval=[1.0, 3.0], method=sr.HHT(rtol=1e-7, atol=1e-7))
        )
    assert all(run.success for run in runs), [run.message for run in runs]
    assert np.allclose(runs[0].q, runs[1].q, atol=1e-6)
    assert runs[1].violation.max() < 1e-12


@pytest.mark.parametrize(
    ("method", "value"),
    [(sr.HHT, 0.1), (sr.HHT, -0.5), (sr.GeneralizedAlpha, 1.5), (sr.GeneralizedAlpha, -0.1)],
)
def test_wrong_coefficients_are_refused(method: type, value: float) -> None:
    with pytest.raises(ValueError, match="must lie between"):
        method(value)


def test_a_kept_loop_depends_on_its_constants(monkeypatch: pytest.MonkeyPatch) -> None:
    before, size = fingerprint(newton.newton), fingerprint(equations.size)
    advance = fingerprint(loop.advance)
    assert fingerprint(newton.newton) == before
    monkeypatch.setattr(newton, "NEWTON_SHARE", 0.5)
    assert fingerprint(newton.newton) != before
    assert fingerprint(loop.advance) != advance  # which calls it
    assert fingerprint(equations.size) == size


@pytest.mark.parametrize("until", [1e-4, 1e-3, 0.01])
def test_a_short_run_with_a_tight_tolerance(until: float) -> None:
    """The first step is no shorter than round-off of the constraints allows."""
    run = sr.simulate(slider_crank(), until=until, t_eval=[until], method=sr.HHT(rtol=1e-8, atol=1e-10))
    assert run.success, run.message
    assert run.nrejected == 0
    assert run["slider"].velocity[-1, 0] == pytest.approx(2.5589 * until, rel=1e-3)  # from rest


def test_steps_of_one_length() -> None:
    runs = [
        sr.simulate(slider_crank(), until=1.0, t_eval=[1.0], method=sr.HHT(step=h)) for h in (0.01, 0.005)
    ]
    assert [run.nsteps for run in runs] == [100, 200]
    assert np.allclose(runs[0].history[:, 1], 0.01, rtol=1e-9)
    with pytest.raises(ValueError, match="step must be a positive number"):
        sr.simulate(slider_crank(), until=1.0, method=sr.HHT(step=-0.1))
