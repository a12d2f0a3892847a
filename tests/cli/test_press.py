"""A driven press from the shell: verbs by other words, parameters, units, plots of a prescribed motion."""

from pathlib import Path

import numpy as np
import pytest

from sarrus.cli import main

PRESS = """
name: press
gravity: [0, 0, -9.81]
parameters: {r: 60 mm, l: 0.3, n: 60 rpm}
bodies:
  crank: {mass: 12, inertia: [0.03, 0.03, 0.05]}
  ram: {mass: 40, inertia: [1, 1, 1], position: [0, 0, -sqrt(l^2 - r^2)]}
joints:
  main: {type: revolute, bodies: [ground, crank], point: [0, 0, 0], axis: [1, 0, 0]}
  guide: {type: translational, bodies: [ground, ram], point: [0, 0, -sqrt(l^2 - r^2)], axis: [0, 0, 1]}
  rod: {type: distance, points: [{body: crank, at: [0, r, 0]}, {body: ram, at: [0, 0, 0]}], length: l}
drivers:
  motor: {type: angle, joint: main, motion: n*t}
"""


@pytest.fixture
def press(tmp_path: Path) -> str:
    file = tmp_path / "press.yaml"
    file.write_text(PRESS)
    return str(file)


def height(angle: np.ndarray, r: float = 0.06) -> np.ndarray:
    return r * np.sin(angle) - np.sqrt(0.3**2 - (r * np.cos(angle)) ** 2)


def test_parameters_units_and_plots_of_a_prescribed_motion(press: str, tmp_path: Path) -> None:
    table, figure = tmp_path / "press.csv", tmp_path / "press.png"
    wanted = ["--set", "r=80 mm", "n=120 rpm", "--until", "500 ms", "--steps", "50"]
    outputs = ["--csv", str(table), "--columns", "t", "motor.torque", "ram.z"]
    drawn = ["--plot", "motor.torque.x", "ram.z", "--figure", str(figure)]
    assert main(["kinematics", press, *wanted, *outputs, *drawn]) == 0
    with table.open() as lines:
        names = lines.readline().strip().split(",")
    assert names == [
        "t [s]",
        "motor.torque.x [N m]",
        "motor.torque.y [N m]",
        "motor.torque.z [N m]",
        "ram.z [m]",
    ]
    t, torque, _, _, z = np.loadtxt(table, delimiter=",", skiprows=1).T
    assert t[-1] == pytest.approx(0.5)
    assert z == pytest.approx(height(4 * np.pi * t, 0.08), abs=1e-12)
    assert np.trapezoid(torque, 4 * np.pi * t) == pytest.approx(0.0, abs=1e-2)  # the work of a revolution
    assert figure.stat().st_size > 10_000


def refused(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    assert main(list(words)) == 2
    return capsys.readouterr().err.strip()


def test_what_is_meant_is_named(press: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert "there is no verb 'simulate'. Did you mean \"run\"?" in refused(capsys, "simulate", press)
    assert 'Did you mean "optimize"?' in refused(capsys, "fit", press)
    assert 'Did you mean "statics"?' in refused(capsys, "static", press)
    assert 'Did you mean "kinematics"?' in refused(capsys, "kinematic", press)
    assert "must be a positive finite number, but is 2 kg" in refused(capsys, "run", press, "--until", "2 kg")
    assert 'there is no parameter "rr"' in refused(capsys, "run", press, "--set", "rr=2")
    assert "must be NAME=VALUE" in refused(capsys, "run", press, "--set", "r")


def test_a_driven_mechanism_has_no_modes(press: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["modes", press]) == 1
    assert "has no degree of freedom, and so no modes" in capsys.readouterr().out


def test_round_off_is_not_a_torque(press: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["kinematics", press, "--steps", "20"]) == 0
    rod = next(line for line in capsys.readouterr().out.splitlines() if line.strip().startswith("rod "))
    assert rod.endswith("torque up to 0 N m")


def test_figures_of_a_study(press: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Without --plot all responses are drawn."""
    study = tmp_path / "study.yaml"
    study.write_text(
        f"model: {press}\nparameters: {{ram.mass: [30, 40]}}\n"
        "responses: {load: max(motor.torque.x), low: min(ram.z)}\nanalysis: {type: kinematics, until: 1}\n"
    )
    figure = tmp_path / "study.png"
    for plot in ([], ["--plot", "load"]):
        assert (
            main(["study", str(study), "--folder", str(tmp_path / "cases"), "--figure", str(figure), *plot])
            == 0
        )
        assert figure.stat().st_size > 5_000
        figure.unlink()
    assert "there is no response 'lod'" in refused(
        capsys,
        "study",
        str(study),
        "--folder",
        str(tmp_path / "cases"),
        "--figure",
        str(figure),
        "--plot",
        "lod",
    )
