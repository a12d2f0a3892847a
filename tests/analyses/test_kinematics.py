"""Kinematic analysis against closed forms: the motion in all its derivatives; where it ends or could branch."""

from collections.abc import Callable

import numpy as np
import pytest
from tests.analyses.driven import X0, SliderOfCrank, parallelogram, pendulum, pushed, six_bar, turned
from tests.analyses.least_reactions import least
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus.analyses.driven.steps import Path

ROUND_OFF = 1e-11


def test_slider_crank_follows_the_closed_form() -> None:
    t = np.linspace(0.0, 4.0, 81)
    run, want = sr.kinematics(turned(3.0, 0.5), t), SliderOfCrank(t, 3.0, 0.5)
    assert run.success, run.message
    assert np.array_equal(run.t, t)
    assert np.allclose(run["slider"].position[:, 0], want.x, atol=ROUND_OFF)
    assert np.allclose(run["slider"].velocity[:, 0], want.v, atol=ROUND_OFF)
    assert np.allclose(run.a[:, 14], want.a, atol=10 * ROUND_OFF)
    assert run.violation.max() < 1e-12
    assert run.singular == ()
    assert run.nfev < 3 * len(t)  # the predictor leaves Newton's method two or three steps


def test_coarse_grids_are_filled_in() -> None:
    """Steps of half a turn: too long for the predictor, so that they are halved."""
    t = np.array([0.0, 1.0, 2.0, 3.0])
    run, want = sr.kinematics(turned(3.0, 0.5), t), SliderOfCrank(t, 3.0, 0.5)
    assert run.success
    assert run.nsteps > 3
    assert np.allclose(run["slider"].position[:, 0], want.x, atol=ROUND_OFF)


def test_lock_up_is_located() -> None:
    """The pin comes no nearer to the slider's axis than 2 - √2, so the slider no farther than √(25 - (2 - √2)²)."""
    run = sr.kinematics(pushed(0.5), np.linspace(0.0, 4.0, 41))
    end = (np.sqrt(25 - (2 - np.sqrt(2)) ** 2) - X0) / 0.5
    assert not run.success
    assert run.status == "lock-up"
    assert f"locks at t = {end:.9g} s" in run.message
    assert "push (displacement)" in run.message
    assert "guide" not in run.message  # it bears no share of the jam
    assert run.t[-1] == 1.5
    assert len(run.q) == len(run.lam) == 16


def test_the_inner_end_of_the_stroke() -> None:
    end = (X0 - np.sqrt(25 - (2 + np.sqrt(2)) ** 2)) / 0.3
    run = sr.kinematics(pushed(-0.3), np.linspace(0.0, 8.0, 17))
    assert f"locks at t = {end:.9g} s" in run.message


@pytest.mark.parametrize("count", [38, 41])
def test_a_flat_parallelogram_is_passed_and_told(count: int) -> None:
    """The crank is flat after π - 1 and 2π - 1 seconds."""
    t = np.linspace(0.0, 6.0, count)
    run = sr.kinematics(parallelogram(), t)
    assert run.success, run.message
    assert run.singular == pytest.approx((np.pi - 1, 2 * np.pi - 1), abs=1e-7)
    assert np.allclose(run["rocker"].position, run["crank"].position + [2, 0, 0], atol=1e-9)
    assert np.allclose(run["crank"].position[:, 0], np.cos(1 + t), atol=ROUND_OFF)
    assert "could have branched at t = 2.1415" in run.message


def test_a_time_exactly_on_the_singular_configuration() -> None:
    t = np.array([0.0, 1.0, 2.0, np.pi - 1, 2.5, 3.0])
    run = sr.kinematics(parallelogram(), t)
    assert run.success, run.message
    assert run.singular == pytest.approx((np.pi - 1,), abs=1e-7)
    assert np.allclose(run["rocker"].position, run["crank"].position + [2, 0, 0], atol=1e-6)
    assert np.allclose(run["rocker"].position[-1], run["crank"].position[-1] + [2, 0, 0], atol=1e-12)


def test_free_motions_are_refused_in_words() -> None:
    run = sr.kinematics(slider_crank(), [0.0, 1.0])
    assert run.status == "not fully driven"
    assert "keeps 1 degree of freedom" in run.message
    assert len(run.t) == 0


@pytest.mark.parametrize(
    "use",
    [
        lambda run: run["slider.x"][-1],
        lambda run: run["slider"].position[-1],
        lambda run: run["spring"].tension[0],
        lambda run: run.joint("pin").angle[0],
        lambda run: run.reaction("pin").force[0],
        lambda run: run.output("slider.x").values[0],
        lambda run: run.q[-1],
        lambda run: run.t[-1],
        lambda run: run.q[0, 2],
    ],
)
def test_what_uses_a_failed_result_receives_the_failure(use: Callable[[sr.Trajectory], object]) -> None:
    run = sr.kinematics(slider_crank(), [0.0, 1.0])
    with pytest.raises(
        IndexError, match=r"no states, because the analysis failed.*keeps 1 degree of freedom"
    ):
        use(run)


def test_contradicting_drivers_are_told() -> None:
    with pytest.warns(sr.SarrusWarning, match="motor_0 drives pin, too"):
        system = pendulum("2*t", "2*t + 0.4")
    run = sr.kinematics(system, [0.0, 1.0])
    assert run.status == "not assembled"
    assert "motor_0: angle" in run.message


def test_the_driver_sets_the_first_position() -> None:
    with pytest.warns(sr.SarrusWarning, match="assembly changed .*bob: orientation changed by 22.92 deg"):
        run = sr.kinematics(pendulum("0.4 + 2*t"), [0.0, 0.5])
    assert np.allclose(run["bob"].position[:, 0], 0.7 * np.sin([0.4, 1.4]), atol=ROUND_OFF)


@pytest.mark.parametrize("times", [[], [0.0, 0.0], [1.0, 0.5], [0.0, np.nan]])
def test_wrong_times(times: list[float]) -> None:
    with pytest.raises(ValueError, match=r"times must be (rising|finite)"):
        sr.kinematics(slider_crank(), times)


def test_sign_and_smallest_singular_value_agree_with_dense_ones() -> None:
    for system in (turned(3.0, 0.5), six_bar()):
        path, q = Path(system, system.q0), sr.assemble(system).q.copy()
        assert path.choose_rows(0.0, q)
        J = system.Phi_q(q).toarray()[path.rows] * path.unit
        length = np.sqrt((J**2).sum(axis=1))
        size, weak, direction = path.weakest(0.0, q)
        assert path.sign(0.0, q) == np.sign(np.linalg.det(J))
        assert size == pytest.approx(np.linalg.svd(J / length[:, None], compute_uv=False).min(), rel=0.05)
        assert np.linalg.norm(weak[path.rows] * length) == pytest.approx(1.0)
        assert np.linalg.norm(J @ (direction / path.unit) / length) == pytest.approx(size)


def test_equations_that_become_dependent_are_exchanged() -> None:
    """Six equations are redundant. Those chosen at the start become dependent at 0.387 s; the motion is regular."""
    system, end = six_bar(), 0.387063781
    for times in (np.linspace(0.0, 1.0, 101), [0.0, 0.2, end, 0.6]):
        run = sr.kinematics(system, times)
        assert run.success, run.message
        assert run.singular == ()
        values = [np.linalg.svd(system.Phi_q(q).toarray(), compute_uv=False)[-1] for q in run.q]
        assert min(values) > 0.1
        assert np.allclose(run.joint("O").rate, 6.0, atol=1e-10)


def door() -> sr.System:
    """A door that a motor opens, on two hinges that share its weight."""
    door = sr.Body("door", mass=20.0, inertia=(2, 3, 1), position=(0.4, 0, 1))
    heights = {"low": 0.2, "high": 1.7}
    hinges = [
        sr.Revolute(name, sr.ground, door, point=(0, 0, z), axis=(0, 0, 1)) for name, z in heights.items()
    ]
    motor = sr.AngleDriver("motor", "low", "0.5*t^2")
    return sr.System(sr.Model("door", [door], hinges, drivers=[motor], gravity=(0, 0, -9.81)))


@pytest.mark.parametrize("make", [six_bar, door])
def test_multipliers_are_those_of_minimum_norm(make: Callable[[], sr.System]) -> None:
    """In a planar mechanism the redundant equations carry no load; in a door they do."""
    system = make()
    run = sr.kinematics(system, np.linspace(0.0, 1.0, 11))
    for t, q, v, a, lam in zip(run.t, run.q, run.v, run.a, run.lam, strict=True):
        force = system.Q(q, v, t) + system.S(q, v) - system.M_a(q, a)
        shortest = least(system, q, force, t)
        assert np.allclose(lam, shortest, atol=1e-10 * abs(lam).max())


def test_reactions_are_those_of_simulation_and_inverse_dynamics() -> None:
    system, times = door(), np.linspace(0.0, 1.0, 11)
    run = sr.kinematics(system, times)
    simulated = sr.simulate(system, until=1.0, t_eval=times)
    solved = sr.inverse_dynamics(system, run)
    for name in ("low.force", "high.force", "low.torque", "motor.torque"):
        assert simulated[name] == pytest.approx(run[name], abs=1e-6)
        assert solved[name] == pytest.approx(run[name], abs=1e-6)
    assert run["low.force.z"] + run["high.force.z"] == pytest.approx(196.2, rel=1e-12)
    reported = sr.sensitivity(run, "low.force.z", ["door.mass"])
    assert reported.values == pytest.approx(run["low.force.z"][-1:], rel=1e-12)


def test_many_turns() -> None:
    """Seven turns forward: the driver counts them, and so does the joint's angle."""
    t = np.linspace(0.0, 1.0, 51)
    run = sr.kinematics(pendulum("44*t"), t)
    assert run.success, run.message
    assert np.allclose(run.joint("pin").angle, 44 * t, atol=1e-11)


def test_a_time_limit_and_ctrl_c_keep_the_times_before(capsys: pytest.CaptureFixture[str]) -> None:
    system, times = turned(1.0, 0.0), np.linspace(0, 6, 601)
    whole = sr.kinematics(system, times, progress=True)
    assert "analysed 6 of 6 s" in capsys.readouterr().err

    def stop(t: float) -> None:
        if t > 1:
            raise KeyboardInterrupt

    for status, options in (("time limit", {"time_limit": 1e-6}), ("stopped", {"progress": stop})):
        cut = sr.kinematics(system, times, **options)
        assert (cut.success, cut.status) == (False, status)
        assert 0 < len(cut.t) < 601
        assert np.array_equal(cut.q, whole.q[: len(cut.t)])


def test_until_instead_of_times() -> None:
    run = sr.kinematics(turned(3.0, 0.5), until=1.0)
    assert np.array_equal(run.t, np.linspace(0.0, 1.0, 1001))
    for wrong in ({}, {"times": [0.0, 1.0], "until": 1.0}):
        with pytest.raises(TypeError, match=r"give the times, or until=2\.0"):
            sr.kinematics(turned(3.0, 0.5), **wrong)
