"""Simulation against trajectories that other programs computed, and its trouble."""

import csv
from pathlib import Path

import numpy as np
import pytest
from tests.system.mechanisms import hmmwv, slider_crank

import sarrus as sr
from sarrus._jit.linking.link import link
from sarrus.analyses.dynamics.step_loop.loop import advance

REFERENCE = Path(__file__).parent.parent / "reference"


def table(name: str) -> np.ndarray:
    return np.genfromtxt(REFERENCE / name, delimiter=",", names=True)


def test_slider_crank_follows_the_reference() -> None:
    reference = table("spatial_slidercrank_paper.csv")
    run = sr.simulate(
        slider_crank(), until=10.0, t_eval=reference["t"], method=sr.ODE(rtol=1e-11, atol=1e-13)
    )
    assert run.success
    assert np.allclose(run["slider"].position[:, 0], reference["x_slider"], atol=1e-9)
    assert np.allclose(run["slider"].velocity[:, 0], reference["v_slider"], atol=1e-9)
    assert np.allclose(run["crank"].angular_velocity_body[:, 0], reference["omega_crank"], atol=1e-9)
    assert run.violation.max() < 1e-12


@pytest.mark.slow
def test_the_error_falls_with_the_tolerance() -> None:
    reference = table("spatial_slidercrank_paper.csv")
    errors = []
    for rtol in (1e-5, 1e-7, 1e-9):
        run = sr.simulate(
            slider_crank(), until=10.0, t_eval=reference["t"], method=sr.ODE(rtol=rtol, atol=0.01 * rtol)
        )
        errors.append(abs(run["slider"].position[:, 0] - reference["x_slider"]).max())
    assert errors[0] > 10 * errors[1] > 100 * errors[2]


def test_hmmwv_follows_the_reference() -> None:
    reference, system = table("hmmwv_T1.csv"), hmmwv()
    v = rigid_velocity(system, np.array([5.0, 0, -0.3]), np.array([0.2, 0.1, 0.05]))
    start = sr.assemble(system, system.q0, v)
    assert np.allclose(start.v, v, atol=1e-10)
    assert system.kinetic_energy(start.q, start.v) == pytest.approx(32312.2285226517, rel=1e-10)
    times = reference["t"][reference["t"] <= 0.3]
    run = sr.simulate(system, start, until=0.3, t_eval=times, method=sr.ODE(rtol=1e-9, atol=1e-11))
    chassis = run["chassis"]
    for k, axis in enumerate("xyz"):
        assert np.allclose(chassis.position[:, k], reference[axis][: len(times)], atol=2e-8)
        assert np.allclose(chassis.velocity[:, k], reference[f"v{axis}"][: len(times)], atol=2e-7)


def rigid_velocity(system: sr.System, v0: np.ndarray, omega: np.ndarray) -> np.ndarray:
    """All bodies move as one rigid body: velocity of the chassis and angular velocity in global axes."""
    q, v = system.q0.reshape(-1, 7), np.zeros((len(system.bodies), 7))
    for body, (r, p) in enumerate(zip(q[:, :3], q[:, 3:], strict=True)):
        v[body, :3] = v0 + np.cross(omega, r - q[0, :3])
        v[body, 3] = -0.5 * p[1:] @ omega
        v[body, 4:] = 0.5 * (p[0] * omega + np.cross(omega, p[1:]))
    return v.reshape(-1)


def test_methods_agree() -> None:
    runs = [
        sr.simulate(slider_crank(), until=1.0, method=sr.ODE(name, rtol=1e-9, atol=1e-11))
        for name in ("DOP853", "RK45")
    ]
    assert np.allclose(runs[0].q[-1], runs[1].q[-1], atol=1e-7)
    assert len(runs[0].t) == 1001
    assert runs[0].t[-1] == 1.0


def test_multipliers_and_accelerations_satisfy_the_equations() -> None:
    system = slider_crank()
    run = sr.simulate(system, until=0.5, t_eval=[0.1, 0.5], method=sr.ODE())
    for q, v, a, lam in zip(run.q, run.v, run.a, run.lam, strict=True):
        left = system.M_a(q, a) + system.Phi_qT_lam(q, lam)
        assert np.allclose(left, system.Q(q, v) + system.S(q, v), atol=1e-10)
        assert np.allclose(system.Phi_q_xi(q, a), system.gamma(q, v), atol=1e-10)


def test_a_start_that_could_not_be_assembled_is_a_status() -> None:
    rod = sr.Body("rod", mass=1.0, inertia=(1, 1, 1))
    post = sr.Spherical("post", sr.ground, rod, point=(3, 0, 0))
    far = sr.Distance("far", sr.ground.point(0, 0, 0), rod.point(3, 0, 0), length=9.0)
    run = sr.simulate(sr.System(sr.Model("torn", bodies=[rod], joints=[post, far])), until=1.0)
    assert not run.success
    assert run.status == "inconsistent"
    assert "far by" in run.message
    assert len(run.t) == 0


def test_a_box_welded_twice_stays() -> None:
    box = sr.Body("box", mass=1.0, inertia=(1, 1, 1))
    welds = [sr.Fixed(name, sr.ground, box, point=(0, 0, 0)) for name in ("first", "second")]
    system = sr.System(sr.Model("welded twice", bodies=[box], joints=welds, gravity=(0, 0, -9.81)))
    with pytest.warns(sr.SarrusWarning, match="nothing can move"):
        run = sr.simulate(system, until=1.0, t_eval=[0.0, 1.0], method=sr.ODE())
    assert run.success, run.message
    assert np.allclose(run.q[-1], system.q0, atol=1e-12)
    first, second = (run.lam[-1][system.rows[name]] for name in ("first", "second"))
    assert np.allclose(first, second, atol=1e-10)  # the shortest multipliers share the load


def test_an_end_time_may_be_a_whole_number() -> None:
    run = sr.simulate(slider_crank(), until=1, t_eval=[0, 1], method=sr.ODE("DOP853"))
    assert run.success
    assert run.t[-1] == 1.0


def test_whole_numbers_compile_nothing_anew() -> None:
    """The loop of integration is compiled for real numbers."""
    sr.simulate(slider_crank(), until=0.1, method=sr.Radau(max_step=1.0))
    known = set(link(advance).signatures)
    with pytest.warns(sr.SarrusWarning, match="not finite at"):  # with such a tolerance
        sr.simulate(slider_crank(), until=1, method=sr.Radau(max_step=1, first_step=1, atol=1)).q  # noqa: B018
    sr.simulate(slider_crank(), until=1, method=sr.Radau(max_step=np.float32(1)))
    assert set(link(advance).signatures) == known


@pytest.mark.parametrize("until", [0.0, -1.0, np.nan, np.inf])
def test_a_wrong_end_time_is_refused(until: float) -> None:
    with pytest.raises(ValueError, match="until must be a"):
        sr.simulate(slider_crank(), until=until)


@pytest.mark.parametrize("times", [[0.5, 0.1], [], [0.1, 2.0], [-0.1, 0.5], [0.1, 0.1]])
def test_wrong_times_are_refused(times: list[float]) -> None:
    with pytest.raises(ValueError, match="t_eval must be rising"):
        sr.simulate(slider_crank(), until=1.0, t_eval=times)


def test_names_of_the_result() -> None:
    run = sr.simulate(slider_crank(), until=0.1, t_eval=[0.0, 0.1])
    assert np.array_equal(run.coordinate("slider.x"), run["slider"].position[:, 0])
    assert np.array_equal(run.coordinate("crank.e0"), run["crank"].euler[:, 0])
    with pytest.raises(KeyError, match='no body "slyder"'):
        run["slyder"]
    with pytest.raises(KeyError, match=r"has no output 'slider\.w'"):
        run.coordinate("slider.w")


def test_csv(tmp_path: Path) -> None:
    run = sr.simulate(slider_crank(), until=0.1, t_eval=[0.0, 0.1])
    run.to_csv(tmp_path / "run.csv")
    header, *_ = csv.reader((tmp_path / "run.csv").read_text(encoding="utf-8").splitlines())
    again = np.loadtxt(tmp_path / "run.csv", delimiter=",", skiprows=1)
    frame = run.to_frame()
    assert header == [frame.index.name, *frame.columns]
    assert np.allclose(again, np.column_stack([run.t, frame]), rtol=1e-14)
    assert {"slider.x [m]", "spring.tension [N]", "pin.force.z [N]"} <= {*header}


@pytest.mark.parametrize("wrong", [{"rtol": -1.0}, {"rtol": float("nan")}, {"atol": 0.0}, {"atol": np.inf}])
def test_tolerances_are_positive_and_finite(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="tol must be positive and finite, but is"):
        sr.simulate(slider_crank(), until=0.1, method=sr.Radau(**wrong))


def test_a_wrong_method_is_refused_in_words() -> None:
    with pytest.raises(ValueError, match=r"there is no ODE solver 'foo'. Choose from DOP853, RK45, RK23"):
        sr.ODE("foo")
    with pytest.raises(TypeError, match=r'For a solver of SciPy give ODE\("DOP853"\)'):
        sr.simulate(slider_crank(), until=0.1, method="DOP853")  # type: ignore[arg-type]
