"""HHT and generalized-α on the stabilized equations: order, both constraints at every step, redundancy, going on."""

from dataclasses import replace

import numpy as np
import pytest
from tests.analyses import linkages
from tests.analyses.test_simulation import rigid_velocity, table
from tests.prescribed_steps import run_of
from tests.sensitivity.frozen import solved
from tests.system.mechanisms import hmmwv, slider_crank

import sarrus as sr
from sarrus.analyses.dynamics.stepping.stepper import Settings
from sarrus.analyses.dynamics.stepping.tolerance import Tolerances
from sarrus.analyses.equations.motion import EquationsOfMotion

METHODS = (sr.HHT(stabilized=True), sr.GeneralizedAlpha(0.8, stabilized=True))
EXACT = 3.715022003716  # x of the slider after 2 s


@pytest.mark.parametrize("kind", [sr.HHT, sr.GeneralizedAlpha])
def test_order_two(kind: type) -> None:
    errors = []
    for h in (1e-2, 5e-3, 2.5e-3):
        method = kind(step=h, stabilized=True)
        run = sr.simulate(
            slider_crank(), until=2.0, t_eval=[2.0], method=replace(method, rtol=1e-9, atol=1e-9)
        )
        assert run.nsteps == round(2 / h)
        errors.append(abs(run["slider"].position[-1, 0] - EXACT))
    slopes = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all((slopes > 1.9) & (slopes < 2.1)), slopes


@pytest.mark.parametrize("method", METHODS)
def test_order_two_with_steps_that_change(method: object) -> None:
    errors, system = [], slider_crank()
    for n in (200, 400, 800):
        pattern = np.tile(np.repeat([1.0, 1.7], 5), n // 10)
        lengths = 2.0 * pattern / pattern.sum()
        times = np.array([0.0, lengths.sum()])
        run = run_of(method, system, sr.assemble(system), times, rtol=1e-9, atol=1e-9, given=lengths)
        assert run.nsteps == n
        errors.append(abs(run["slider"].position[-1, 0] - EXACT))
    slopes = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all((slopes > 1.8) & (slopes < 2.2)), (slopes, errors)


@pytest.mark.parametrize("method", METHODS)
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
    assert run.njev < 0.1 * run.nsteps


def at_work(system: sr.System, method: object, tol: float, start: sr.Assembly | None = None) -> object:
    """The method before its first step, the end at 2 s."""
    begin = start or sr.assemble(system)
    stepper = method.stepper(system, begin, Settings(Tolerances.of(system, tol, tol)))
    stepper.restart(0.0, begin.q, begin.v, 2.0)
    return stepper


def violations(system: sr.System, nodes: object) -> tuple[float, float]:
    """The largest residual of positions and of velocities, as the method left them."""
    states = list(zip(nodes.t, nodes.q, nodes.v, strict=True))
    in_q = max(abs(system.Phi(q, t)).max() for t, q, v in states)
    return in_q, max(abs(system.Phi_q_xi(q, v) + system.Phi_t(q, t)).max() for t, q, v in states)


def driven() -> sr.System:
    """A door on a hinge, turned by a driver, and a ball that hangs from it."""
    door = sr.Body("door", 2.0, (1, 1, 1), position=(0.5, 0, 0))
    ball = sr.Body("ball", 1.0, (0.1, 0.1, 0.1), position=(1, 0, -0.5))
    hinge = sr.Revolute("hinge", sr.ground, door, point=(0, 0, 0), axis=(0, 0, 1))
    hang = sr.Spherical("hang", door, ball, point=(1, 0, 0))
    motor = sr.AngleDriver("motor", "hinge", motion=lambda t: 0.3 * t * t)
    return sr.System(sr.Model("door", [door, ball], [hinge, hang], drivers=[motor], gravity=(0, 0, -9.81)))


@pytest.mark.parametrize("make", [slider_crank, driven], ids=lambda make: make.__name__)
def test_both_constraints_hold_at_every_step(make: object) -> None:
    """To what Newton's method leaves, at steps of every length; on the index-3 equations velocities drift."""
    system, tol, left = make(), 1e-6, []
    for method in (*METHODS, sr.HHT()):
        nodes = at_work(system, method, tol).advance(2.0, 1000)
        assert nodes.t[-1] == 2.0
        left.append(violations(system, nodes))
    assert all(in_q < tol and in_v < tol for in_q, in_v in left[:2]), left
    assert left[2][1] > 100 * max(in_v for _, in_v in left[:2]), left


@pytest.mark.parametrize("kind", [sr.HHT, sr.GeneralizedAlpha])
def test_without_damping_multipliers_stay_right(kind: type) -> None:
    """Those of the steps, against the equations of motion there; on the index-3 equations their error grows."""
    system, errors = slider_crank(), []
    undamped = 0.0 if kind is sr.HHT else 1.0
    for method in (kind(undamped, stabilized=True), kind(undamped)):
        nodes, motion = at_work(system, method, 1e-6).advance(2.0, 2000), EquationsOfMotion(system)
        states = zip(nodes.t, nodes.q, nodes.v, nodes.lam, strict=True)
        errors.append(max(abs(lam - motion.acceleration(t, q, v)[1]).max() for t, q, v, lam in states))
    assert errors[0] < 3e-3 * abs(nodes.lam[0]).max(), (
        errors
    )  # left by the changes of the first steps' lengths
    assert errors[1] > 10 * errors[0], errors


def test_hmmwv_follows_the_reference() -> None:
    reference, system = table("hmmwv_T1.csv"), hmmwv()
    v = rigid_velocity(system, np.array([5.0, 0, -0.3]), np.array([0.2, 0.1, 0.05]))
    start, times = sr.assemble(system, system.q0, v), reference["t"]
    settings = {"until": times[-1], "t_eval": times, "method": replace(METHODS[0], rtol=1e-7, atol=1e-7)}
    run = sr.simulate(system, start, **settings)
    assert run.success
    for k, axis in enumerate("xyz"):
        assert np.allclose(run["chassis"].position[:, k], reference[axis], atol=1e-4)


@pytest.mark.parametrize("make", [linkages.door, linkages.bennett], ids=lambda make: make.__name__)
def test_dependent_equations(make: object) -> None:
    """Overconstrained linkages: as by an explicit method, all equations satisfied, the multipliers the shortest."""
    system, times = make(), [1.0, 2.0]
    found = [
        sr.simulate(system, until=2.0, t_eval=times, method=replace(method, rtol=tol, atol=tol))
        for method, tol in ((METHODS[0], 1e-8), (sr.ODE(), 1e-10))
    ]
    assert all(run.success for run in found), [run.message for run in found]
    assert abs(found[1].q[1] - found[1].q[0]).max() > 0.1
    assert np.allclose(found[0].q, found[1].q, atol=1e-4)
    assert np.allclose(found[0].lam, found[1].lam, atol=2e-3 * abs(found[1].lam).max())
    in_q, in_v = violations(system, at_work(system, METHODS[0], 1e-7).advance(2.0, 100))
    assert max(in_q, in_v) < 1e-7


def test_going_on_from_a_saved_state_gives_the_same_bits() -> None:
    system = slider_crank()
    first, second = (at_work(system, METHODS[0], 1e-6) for _ in range(2))
    first.advance(2.0, 40)
    second.resume({name: np.array(value) for name, value in first.state().items()})
    ahead, again = (stepper.advance(2.0, 40) for stepper in (first, second))
    assert len(ahead.t) == 41
    assert all(np.array_equal(x, y) for x, y in zip(ahead, again, strict=True))


@pytest.mark.parametrize("method", METHODS)
def test_steps_are_stored_with_both_multipliers(method: object) -> None:
    system = slider_crank()
    run = solved(sr.simulate(system, until=0.1, method=method, store="steps"), method)
    assert run.steps is not None
    assert len(run.steps.stages) == len(run.steps)
    assert np.any(run.steps.stages)
    for t, q, v in zip(run.steps.t, run.steps.q, run.steps.v, strict=True):
        assert abs(system.Phi(q, t)).max() < 1e-12
        assert abs(system.Phi_q_xi(q, v, t) + system.Phi_t(q, t)).max() < 1e-11
