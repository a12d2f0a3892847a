"""Cartesian joint and Cartesian spring: a mass on a shaker, against SciPy and closed forms."""

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import sarrus as sr
from sarrus.model import ModelError

K, C, M = (50.0, 80.0, 200.0), (0.5, 1.0, 2.0), 2.0


def shaken() -> sr.Model:
    """A mass on springs on a table that a formula moves; neither rotates."""
    table = sr.Body("table", mass=5.0, inertia=(1, 1, 1))
    block = sr.Body("block", mass=M, inertia=(0.1, 0.2, 0.3), position=(0.1, 0.2, 0.5))
    joints = [
        sr.Cartesian("guide", sr.ground, table, point=(0, 0, 0), axis=(0, 0, 1)),
        sr.Cartesian("slide", table, block, point=(0.1, 0.2, 0.5), axis=(0, 0, 1)),
    ]
    spring = sr.CartesianSpring("mount", table.point(0, 0, 0), block.point(0, 0, 0), K, C, offset=(0, 0, 0.6))
    shaker = sr.PointDriver("shaker", table.point(0, 0, 0), x="0.05*t**2", y=0.0, z="0.02*(1 - cos(7*t))")
    return sr.Model("shaken", [table, block], joints, [spring], drivers=[shaker], gravity=(0, 0, -9.81))


def test_a_mass_on_a_shaker() -> None:
    """m r̈ = −k (r − road − offset) − c (ṙ − rȯad) + m g for each axis."""
    run = sr.simulate(sr.System(shaken()), until=2.0, method=sr.Radau(rtol=1e-11, atol=1e-12))

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        road = np.array([0.05 * t**2, 0, 0.02 * (1 - np.cos(7 * t))])
        speed = np.array([0.1 * t, 0, 0.14 * np.sin(7 * t)])
        force = -np.array(K) * (y[:3] - road - (0, 0, 0.6)) - np.array(C) * (y[3:] - speed)
        return np.concatenate([y[3:], force / M + (0, 0, -9.81)])

    start = [0.1, 0.2, 0.5, 0, 0, 0]
    exact = solve_ivp(rates, (0, 2), start, "DOP853", rtol=1e-13, atol=1e-13).y[:3, -1]
    assert run["block"].position[-1] == pytest.approx(exact, abs=1e-8)
    displaced = [run.output(f"slide.displacement_{axis}").values[-1] for axis in "xyz"]
    start_apart = np.array([0.1, 0.2, 0.5])
    assert displaced == pytest.approx(exact - run["table"].position[-1] - start_apart, abs=1e-8)


@pytest.mark.slow
def test_all_derivatives_are_exact_and_gradients_agree() -> None:
    model = shaken()
    report = sr.System(model).check_derivatives()
    assert report, report
    run = sr.simulate(sr.System(model), until=1.0, method=sr.Radau(rtol=1e-11, atol=1e-12), store="steps")
    wrt = ["mount.stiffness.1", "mount.damping.3", "mount.offset.z"]
    adjoint = sr.sensitivity(run, sr.Final("block.z"), wrt)
    direct = sr.sensitivity(run, sr.Final("block.z"), wrt, method="direct")
    assert direct.matrix == pytest.approx(adjoint.matrix, rel=1e-9, abs=1e-13)
    assert adjoint.matrix[0, 0] == pytest.approx(0, abs=1e-10)
    assert abs(adjoint.matrix[0, 1:]).min() > 1e-4


def test_it_is_written_to_a_file(tmp_path: Path) -> None:
    model = shaken()
    model.save(tmp_path / "shaken.yaml")
    again = sr.System(sr.load(tmp_path / "shaken.yaml"))
    assert np.array_equal(again.b, sr.System(model).b)


def test_the_joint_has_three_independent_equations() -> None:
    system = sr.System(shaken())
    rows = system.Phi_q(system.q0).toarray()[system.rows["slide"]]
    assert np.linalg.matrix_rank(rows) == 3 == len(rows)


def test_negative_stiffness_is_refused() -> None:
    block = sr.Body("block", mass=M, inertia=(1, 1, 1))
    spring = sr.CartesianSpring("mount", sr.ground.point(0, 0, 0), block.point(0, 0, 0), (1, -1, 1))
    with pytest.raises(ModelError, match="stiffness must not be negative"):
        sr.System(sr.Model("m", [block], [], [spring]))
