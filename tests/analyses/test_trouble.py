"""Trouble is a status with a sentence, and what was computed is kept."""

import os
import re
import signal
from dataclasses import replace

import numpy as np
import pytest
from tests.analyses import linkages
from tests.prescribed_steps import run_of
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus.analyses.dynamics.stepping.failures import STEEP, _beyond
from sarrus.functions import log, sqrt, tanh

METHODS = [sr.HHT(), sr.Radau(), sr.ODE()]


def named(method: object) -> str:
    return type(method).__name__


def falling(*forces: object) -> sr.System:
    return sr.System(sr.Model("falling", bodies=[BALL], forces=list(forces), gravity=(0, 0, -9.81)))


BALL = sr.Body("ball", mass=1.0, inertia=(1, 1, 1))


@pytest.mark.parametrize("method", METHODS, ids=named)
def test_a_force_that_is_not_a_number_is_named(method: object) -> None:
    root = sr.PointForce("thrust", BALL.point(0, 0, 0), (0, 0, lambda t: sqrt(0.5 - t)))
    run = sr.simulate(falling(root), until=1.0, method=method)
    assert run.status == "not finite"
    assert "the force thrust is not a finite number" in run.message
    assert 0.4 < run.t[-1] <= 0.5
    assert np.all(np.isfinite(run.q))


@pytest.mark.parametrize("method", METHODS, ids=named)
def test_a_force_that_is_never_a_number_is_named(method: object) -> None:
    root = sr.PointForce("thrust", BALL.point(0, 0, 0), (0, 0, lambda t: log(-1 - t)))
    run = sr.simulate(falling(root), until=1.0, method=method)
    assert run.status == "not finite"
    assert "thrust" in run.message
    assert len(run.t) == 0


@pytest.mark.one_in(3)
@pytest.mark.filterwarnings("ignore:parallelogram. a singular configuration is passed")
@pytest.mark.parametrize("method", METHODS, ids=named)
def test_a_position_where_motions_branch_is_named_by_its_rows(method: object) -> None:
    run = sr.simulate(linkages.parallelogram(), until=3.0, method=replace(method, rtol=1e-9, atol=1e-11))
    if run.success:  # it may pass the branch between two steps
        return
    assert run.status in ("singular configuration", "step too small")
    assert "hinge" in run.message
    assert 0 < len(run.t) < 1001


@pytest.mark.one_in(8)
@pytest.mark.parametrize("method", [*METHODS, sr.GeneralizedAlpha(), sr.HHT(stabilized=True)], ids=named)
def test_a_position_that_is_nearly_singular_is_told_with_its_rows(method: object) -> None:
    """A four-bar whose rocker is longer than its crank by 1e-4: nearly flat, but never quite."""
    nearly = linkages.four_bar(1.0, 2.0, 1.0001, 2.0, angle=0.5)
    run = sr.simulate(nearly, until=1.0, method=replace(method, rtol=1e-8, atol=1e-8))
    assert run.success, run.message
    assert len(run.singular) == 1
    place = int(np.searchsorted(run.t, run.singular[0]))
    assert abs(run["rod_1"].position[place, 1]) < 0.02
    assert f"near t = {run.singular[0]:.6g} s constraints are nearly dependent, among hinge_" in run.message
    far = sr.simulate(linkages.four_bar(1.0, 2.0, 1.4, 2.0, angle=0.5), until=1.0, method=method)
    assert far.message == "reached the end"
    assert far.singular == ()


def test_a_driver_that_pulls_too_far() -> None:
    """A rope pulls a crank of length 1 to the distance 3, which it can only just reach."""
    crank = sr.Body("crank", mass=1.0, inertia=(0.1, 0.1, 0.1), position=(0.5, 0, 0))
    pin = sr.Revolute("pin", sr.ground, crank, point=(0, 0, 0), axis=(0, 0, 1))
    ends = sr.ground.point(2.0, 0.5, 0), crank.point(0.5, 0, 0)
    rope = sr.DistanceDriver("rope", *ends, motion=lambda t: sqrt(1.25) + t)
    system = sr.System(sr.Model("pulled", bodies=[crank], joints=[pin], drivers=[rope]))
    run = sr.simulate(system, until=3.0)
    assert not run.success
    assert run.status == "singular configuration"
    assert "rope" in run.message
    assert run.t[-1] == pytest.approx(1 + np.sqrt(4.25) - np.sqrt(1.25), abs=0.01)


@pytest.mark.parametrize("method", METHODS, ids=named)
def test_an_inconsistent_start(method: object) -> None:
    system = slider_crank()
    wrong = sr.assemble(system)
    run = sr.simulate(
        system, replace(wrong, success=False, message="pin is open by 0.1 m"), until=1.0, method=method
    )
    assert (run.status, run.message) == ("inconsistent", "pin is open by 0.1 m")


@pytest.mark.filterwarnings("ignore:.*nearly dependent at the start")
@pytest.mark.parametrize("method", METHODS[:2], ids=named)
def test_a_nearly_singular_start_is_named_by_its_rows(method: object) -> None:
    """Ten microradians from the position where all links are in one line; the singular value is a sixth of it."""
    run = sr.simulate(linkages.parallelogram(1e-5), until=0.1, method=method)
    assert run.status == "singular configuration"
    start = r"the start is nearly singular\. The smallest singular value of its constraints is 1\.6e-06, among hinge_"
    assert re.search(start, run.message)


def test_a_force_whose_direction_is_not_determined_is_named() -> None:
    """The ends of the tendon coincide at this state, other than in the model."""
    points, shape = (
        [sr.ground.point(0, 0, 0.5), BALL.point(0, 0, 0.05)],
        sr.Wrap(sr.ground.point(0, 0, 2), 0.1),
    )
    system = falling(sr.Tendon("rope", points, around=[shape], value="-1e4*(x + 1)"))
    for z, names in ((0.4, []), (0.45, ["rope"])):
        q = np.array([0, 0, z, 1, 0, 0, 0])
        assert _beyond(STEEP, "Q_q", system, system.b, 0.0, q, 0 * q) == names


@pytest.mark.parametrize("method", METHODS, ids=named)
def test_redundant_joints_that_contradict_each_other(method: object) -> None:
    run = sr.simulate(linkages.contradictory_door(), until=1.0, method=method)
    assert run.status == "inconsistent"
    assert "hinge" in run.message
    assert len(run.t) == 0


def test_steps_that_become_too_small() -> None:
    """An attraction that grows beyond all bounds: the ball falls into the centre."""
    ball = sr.Body("ball", mass=1.0, inertia=(1, 1, 1), position=(1.0, 0, 0))
    centre = sr.ground.point(0, 0, 0), ball.point(0, 0, 0)
    pull = sr.TSDA("pull", *centre, k=lambda l: 10 / (l * l * l * l * l), length=0.0)
    system = sr.System(sr.Model("falling in", bodies=[ball], forces=[pull]))
    run = sr.simulate(system, until=2.0, method=sr.Radau(rtol=1e-9, atol=1e-11))
    assert run.status in ("step too small", "not finite")
    assert 0 < len(run.t) < 1001


def test_ctrl_c_returns_what_is_done() -> None:
    reached: list[float] = []

    def told(t: float) -> None:
        reached.append(t)
        if len(reached) == 2:
            os.kill(os.getpid(), signal.SIGINT)

    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # jobs in the background ignore it
    try:
        run = sr.simulate(slider_crank(), until=50.0, progress=told, method=sr.Radau(rtol=1e-8, atol=1e-10))
    finally:
        signal.signal(signal.SIGINT, before)
    assert run.status == "stopped"
    assert "stopped by the user" in run.message
    assert 0 < run.t[-1] <= reached[-1]


@pytest.mark.parametrize("method", [sr.HHT(), sr.GeneralizedAlpha(), sr.Radau()], ids=named)
def test_newtons_method_that_does_not_converge(method: object) -> None:
    """The third step is prescribed, and far too long; the first two are kept."""
    system, lengths = slider_crank(), np.array([0.01, 0.01, 2.98])
    times = np.linspace(0.0, 3.0, 301)
    run = run_of(method, system, sr.assemble(system), times, rtol=1e-6, atol=1e-8, given=lengths)
    assert run.status == "step too small"
    assert "near t = 0.02 s: Newton's method" in run.message
    assert run.t[-1] == pytest.approx(0.02)
    assert run.nrejected > 0


def test_a_force_that_is_too_steep_for_a_step_makes_it_shorter() -> None:
    """It was reported as a singular configuration. The mass moves in parabolas between 0.8 and 1.0 m."""
    block = sr.Body("block", 1.0, (0.01, 0.01, 0.01), position=(1.0, 0, 0))
    guide = sr.Translational("guide", sr.ground, block, point=(0, 0, 0), axis=(1, 0, 0))
    ends = sr.ground.point(0, 0, 0), block.point(0, 0, 0)
    relay = sr.TSDA("relay", *ends, k=lambda x: 10 * tanh((x - 0.9) / 1e-10) / (x - 0.5), length=0.5)
    run = sr.simulate(sr.System(sr.Model("relay", [block], [guide], [relay])), until=1.5)
    assert run.status == "finished"
    quarters = run.t / np.sqrt(2 * 0.1 / 10)
    high, low = abs((quarters + 1) % 4 - 1), abs((quarters + 1) % 4 - 3)
    exact = np.where(high < 1, 1.0 - 0.1 * high**2, 0.8 + 0.1 * low**2)
    assert run["block.x"] == pytest.approx(exact, abs=1e-6)


@pytest.mark.parametrize("method", [sr.Radau(), sr.HHT()], ids=named)
def test_a_coupler_whose_formula_jumps_is_named(method: object) -> None:
    """A pin at an angle q drives a slot, from behind the slot's axis: its angle jumps by 2π at the branch cut."""
    bodies = sr.Body("a", 1, (0.004,) * 3), sr.Body("b", 1, (0.02,) * 3, position=(0.16, 0, 0))
    begin = float(np.arctan2(0.1 * np.sin(2.0), 0.1 * np.cos(2.0) - 0.16))
    slot = f"atan2(0.1*sin(q+2), 0.1*cos(q+2)-0.16) - {begin!r}"
    joints = [
        sr.Revolute("q", sr.ground, bodies[0], point=(0, 0, 0), axis=(0, 0, 1)),
        sr.Revolute("p", sr.ground, bodies[1], point=(0.16, 0, 0), axis=(0, 0, 1)),
        sr.FormulaCoupler("slot", "p", value=slot),
    ]
    motor = sr.Torque("motor", "q", value="0.6-0.02*v")
    run = sr.simulate(sr.System(sr.Model("jump", bodies, joints, [motor])), until=3.0, method=method)
    assert run.status == "inconsistent"
    assert run.message.startswith("the equation of slot jumps near t = 0.17")
    assert "motor" not in run.message
