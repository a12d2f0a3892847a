"""Initial rates of joints, in models, model files and the shell."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import sarrus as sr
from sarrus.cli import main
from sarrus.model.words import describe

FILE = """name: arm
bodies:
  crank: {mass: 1, inertia: [1, 1, 1], position: [0.5, 0, 0]}
  block: {mass: 1, inertia: [1, 1, 1], position: [1, 1, 0]}
joints:
  pin: {type: revolute, bodies: [ground, crank], point: [0, 0, 0], axis: [0, 0, 1]}
  sleeve: {type: cylindrical, bodies: [ground, block], point: [1, 1, 0], axis: [1, 0, 0]}
"""
RATES = "rates: {pin: 30 rpm, sleeve.displacement: 20 cm/s, sleeve.angle: 2}\n"


def written(folder: Path, text: str) -> Path:
    file = folder / "arm.yaml"
    file.write_text(text)
    return file


def test_rates_of_a_file_are_the_velocities_of_the_start(tmp_path: Path) -> None:
    system = sr.System(sr.load(written(tmp_path, FILE + RATES)))
    run = sr.simulate(system, until=0.5)
    assert run["crank"].angular_velocity_body[0] == pytest.approx([0, 0, np.pi])
    assert run["crank"].velocity[0] == pytest.approx([0, np.pi / 2, 0])
    assert run["block"].velocity[-1] == pytest.approx([0.2, 0, 0])
    assert run["block"].angular_velocity_body[0] == pytest.approx([2.0, 0, 0])


def test_rates_add_to_those_of_the_model_and_give_way_to_velocities(tmp_path: Path) -> None:
    system = sr.System(sr.load(written(tmp_path, FILE + RATES)))
    other = sr.assemble(system, rates={"pin": 1.0})
    assert system.joint("pin")["angle"].rate(other.q, other.v) == pytest.approx(1.0)
    assert system.joint("sleeve")["displacement"].rate(other.q, other.v) == pytest.approx(0.2)
    assert sr.assemble(system, v=np.zeros(system.nq)).v == pytest.approx(np.zeros(system.nq))


def test_studies_begin_with_the_rates(tmp_path: Path) -> None:
    model = sr.load(written(tmp_path, FILE + RATES))
    analysis = sr.Simulation(until=0.5)
    found = sr.study(model, {"crank.mass": [1.0]}, {"y": "final(block.x)"}, analysis=analysis, workers=1)
    assert found["y"] == pytest.approx([1.1])
    spread = sr.uncertainty(model, {"block.mass": sr.Range(1, 2)}, {"y": "final(block.x)"}, analysis=analysis)
    assert spread.values == pytest.approx([1.1])


@pytest.mark.parametrize(
    ("rates", "told"),
    [
        (
            "{pn: 1}",
            r'arm.yaml:8: .*there is no joint "pn" with an angle or a displacement. Did you mean "pin"',
        ),
        ("{sleeve: 1}", r"Give sleeve.displacement or sleeve.angle|Give sleeve.angle or sleeve.displacement"),
        ("{pin: 3 m/s}", "rates: pin must be in rad/s, or another unit of that kind"),
        ("{sleeve.displacement: 30 rpm}", "must be in m/s"),
        ("{pin: .nan}", "pin"),
        ("[1, 2]", "rates"),
    ],
)
def test_wrong_rates_are_refused(tmp_path: Path, rates: str, told: str) -> None:
    text = FILE + f"rates: {rates}\n"
    with pytest.raises(sr.ModelError, match=told):
        sr.load(written(tmp_path, text))


def test_a_model_checks_its_rates(tmp_path: Path) -> None:
    model = sr.load(written(tmp_path, FILE))
    for rates in ({"pn": 1.0}, {"pin": np.nan}, {"pin": "fast"}, [1.0]):
        with pytest.raises(sr.ModelError, match="rates"):
            sr.System(replace(model, rates=rates))  # type: ignore[arg-type]


def test_the_shell_takes_rates(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = str(written(tmp_path, FILE + RATES))
    words = [
        "run",
        file,
        "--until",
        "0.5",
        "--rate",
        "pin=60 rpm",
        "sleeve.displacement=-0.1",
        "-q",
        "--json",
    ]
    assert main(words) == 0
    bodies = json.loads(capsys.readouterr().out)["bodies"]
    assert bodies["crank"]["angular_velocity_body"][2] == pytest.approx(2 * np.pi, rel=1e-4)
    assert bodies["block"]["velocity"][0] == pytest.approx(-0.1)
    for wrong, told in (("pin", "JOINT=VALUE"), ("pin=1 m/s", "must be in rad/s"), ("pn=1", "Did you mean")):
        assert main(["run", file, "--rate", wrong, "-q"]) == 2
        message = capsys.readouterr().err
        assert told in message
        assert Path(file).name not in message, "it was on the command line"


def test_rates_of_included_files_count_under_their_prefixes(tmp_path: Path) -> None:
    written(tmp_path, FILE + RATES)
    whole = tmp_path / "two.yaml"
    whole.write_text(
        "name: two\ninclude:\n  - {file: arm.yaml, prefix: l_}\n  - {file: arm.yaml, prefix: r_}\n"
    )
    model = sr.load(whole)
    assert model.rates == pytest.approx({
        f"{side}_{name}": rate
        for side in "lr"
        for name, rate in {"pin": np.pi, "sleeve.displacement": 0.2, "sleeve.angle": 2.0}.items()
    })  # fmt: skip
    assert sr.assemble(sr.System(model)).v[0:3] == pytest.approx([0, np.pi / 2, 0])
    assert "initial rates [rad/s, m/s]: l_pin = 3.14159, l_sleeve.displacement = 0.2" in describe(model)
    whole.write_text("name: two\ninclude: [arm.yaml]\nrates: {pin: 1}\n")
    with pytest.raises(sr.ModelError, match=r'two\.yaml:2: .*brings a second rate of "pin"'):
        sr.load(whole)


def test_rates_follow_from_parameters(tmp_path: Path) -> None:
    text = (
        FILE + "parameters: {speed: 30 rpm, twice: 2*speed}\nrates: {pin: twice, sleeve.displacement: 0.2}\n"
    )
    file = written(tmp_path, text)
    for parameters, rate in (({}, 2 * np.pi), ({"speed": 1.0}, 2.0)):
        system = sr.System(sr.load(file, parameters=parameters))
        run = sr.simulate(system, until=0.1, store="steps")
        assert run["pin.angle.rate"][0] == pytest.approx(rate)
    found = sr.study(
        sr.load(file), {"speed": [1.0, 2.0]}, {"w": "initial(pin.angle.rate)"}, analysis=sr.Simulation(0.1)
    )
    assert found["w"] == pytest.approx([2, 4])
    gradient = sr.sensitivity(run, "pin.angle", ["speed", "rates.sleeve.displacement"])
    assert gradient.matrix == pytest.approx(np.array([[0.2, 0.0]]), rel=1e-9)
    assert gradient.units[1] == "m/s"
    with pytest.raises(sr.ModelError, match=r"rates: sleeve\.displacement must be in m/s"):
        sr.load(written(tmp_path, text.replace("0.2", "speed")))
