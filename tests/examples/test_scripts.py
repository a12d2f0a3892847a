"""The scripts of the gallery that ask mechanisms something find what they should, and draw it."""

import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.examples.problems import FOLDER

import sarrus as sr


def of(script: str) -> Any:
    return runpy.run_path(str(FOLDER / f"{script}.py"))["main"]


@pytest.mark.slow
def test_stewart_platform(tmp_path: Path) -> None:
    """The platform follows the closed form; at rest in between, the six legs carry what lies above the motors."""
    run = of("stewart_platform")(tmp_path)
    assert run.success
    assert run["platform"].position[:, 2] == pytest.approx(1.2 + 0.15 * np.sin(2 * run.t), abs=1e-12)
    turn = 2 * np.arctan2(run["platform"].euler[:, 3], run["platform"].euler[:, 0])
    assert turn == pytest.approx(0.25 * np.sin(run.t), abs=1e-12)
    assert {path.name for path in tmp_path.iterdir()} == {
        "stewart_platform.png",
        "stewart_platform-motion.png",
    }


@pytest.mark.slow
def test_uncertain_spring(tmp_path: Path) -> None:
    table, linear = of("uncertain_spring")(tmp_path, count=64)
    assert table.success.all()
    for name, mean, std in zip(linear.responses, linear.values, linear.std, strict=True):
        found = table.found[:, table.responses.index(name)]
        assert mean == pytest.approx(found.mean(), abs=0.1 * std)
        assert std == pytest.approx(found.std(ddof=1), rel=0.1)
    assert (tmp_path / "uncertain_spring.png").stat().st_size > 5000


@pytest.mark.slow
def test_workspaces(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    of("workspaces")(tmp_path)
    told = capsys.readouterr().out
    assert "can reach 31.49751" in told
    assert "can reach 4.16078" in told
    assert "can reach 11.78898" in told
    assert "Solutions of the inverse kinematics: 4 everywhere." in told
    assert "can reach a volume of 350.75" in told
    assert len([*tmp_path.glob("workspace_*.png")]) == 6


@pytest.mark.slow
def test_largest_workspace(tmp_path: Path) -> None:
    before, after = of("largest_workspace")(tmp_path, iterations=1)
    assert before == pytest.approx(1.1055, abs=1e-4)
    assert after > 1.5 * before
    assert (tmp_path / "largest_workspace.png").stat().st_size > 5000


@pytest.mark.slow
def test_workspace_in_a_box(tmp_path: Path) -> None:
    """Two steps of the search, which keep nearly to the box."""
    before, after, room = of("workspace_in_a_box")(tmp_path, iterations=2)
    angles = np.radians([25, 100, 70])
    assert before == pytest.approx(0.4 * 0.35 * (np.cos(angles[0]) - np.cos(angles[1])) * angles[2], rel=1e-6)
    assert after > 4 * before
    assert room > -0.05
    assert (tmp_path / "workspace_in_a_box.png").stat().st_size > 5000


@pytest.mark.parametrize("script", ["implicit_midpoint", "bdf2"])
def test_methods_of_your_own_are_short(script: str) -> None:
    assert len((FOLDER / f"{script}.py").read_text(encoding="utf-8").splitlines()) <= 60


@pytest.mark.slow
def test_implicit_midpoint(tmp_path: Path) -> None:
    """Its energy stays, HHT loses some; derivatives of the last position are those of Radau."""
    runs, gradient, hessian = of("implicit_midpoint")(tmp_path)
    energy = {name: run.total_energy for name, run in runs.items()}
    assert abs(energy["implicit midpoint"]).max() < 0.02
    assert energy["HHT"].min() < -0.05
    assert [len(run.events) for run in runs.values()] == [26, 26]  # every 1.93 s
    system = next(iter(runs.values())).system
    exact = sr.simulate(system, until=1.0, method=sr.Radau(rtol=1e-9, atol=1e-11), store="steps")
    response, numbers = sr.Final("rod.x"), [*gradient.names]
    assert sr.sensitivity(exact, response, numbers).matrix == pytest.approx(gradient.matrix, rel=0.05)
    assert sr.hessian(exact, response, numbers).matrix == pytest.approx(hessian.matrix, rel=0.05)
    assert (tmp_path / "implicit_midpoint.png").stat().st_size > 5000


def test_bdf2(tmp_path: Path) -> None:
    """A stiff spring and two impacts: the last angle and its gradient are those of Radau."""
    run, gradient = of("bdf2")(tmp_path)
    assert run.success
    assert len(run.events) == 2
    stop = sr.Event("rod.x", direction=-1, reset=sr.Impact(0.6), name="stop")
    exact = sr.simulate(
        run.system, until=2.0, method=sr.Radau(rtol=1e-9, atol=1e-11), events=stop, store="steps"
    )
    found = sr.sensitivity(exact, sr.Final("pin.angle"), [*gradient.names])
    assert gradient.values == pytest.approx(found.values, rel=1e-3)
    assert gradient.matrix == pytest.approx(found.matrix, rel=0.02)
    assert (tmp_path / "bdf2.png").stat().st_size > 5000
