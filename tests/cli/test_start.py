"""A start is written alike in study and optimization files and behind ``--start``."""

from __future__ import annotations

import json
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

import sarrus as sr
from sarrus import mechanisms
from sarrus.cli import main
from sarrus.studies.file import read_study_file
from sarrus.studies.optimization import read_optimization_file

MODEL = mechanisms.path("slider_crank")
RATES = {"rates": {"pin": 1.0}}
STUDY = """\
model: crank.yaml
parameters: {spring.k: [9, 11]}
responses: {end: slider.x, gain: slider.x - initial(slider.x)}
analysis:
  type: simulate
  until: 0.3
  start: {rates: {pin: 1 rad/s}}
"""
BEST = """\
model: crank.yaml
parameters: {spring.k: {from: 5, to: 20}}
minimize: (slider.velocity.x)**2
iterations: 2
analysis:
  type: simulate
  until: 0.3
  start: {rates: {pin: 1}}
"""


def end(start: object, until: float = 0.3) -> float:
    """Where the slider is at the end of a run."""
    return float(sr.simulate(sr.System(sr.load(MODEL)), start, until=until).coordinate("slider.x")[-1])


def written(folder: Path, text: str) -> Path:
    (folder / "crank.yaml").write_text(MODEL.read_text())
    (folder / "file.yaml").write_text(text)
    return folder / "file.yaml"


def test_the_shell_takes_rates_and_saved_runs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run = ["run", str(MODEL), "--until", "0.3", "--json", "-q", "--start"]
    assert main([*run, "rates.pin=1"]) == 0
    found = json.loads(capsys.readouterr().out)["bodies"]["slider"]["position"][0]
    assert found == pytest.approx(end(RATES), abs=1e-9)
    assert abs(found - end(None)) > 1e-3
    sr.simulate(sr.System(sr.load(MODEL)), RATES, until=0.2, t_eval=[0.1, 0.2], save=tmp_path / "run.sarrus")
    for more in ([], ["t=0.1"]):
        assert main([*run, f"run={tmp_path / 'run.sarrus'}", *more]) == 0
        assert json.loads(capsys.readouterr().out)["bodies"]["slider"]["position"][0] == pytest.approx(
            found, abs=1e-4
        )
    wanted = ["--response", "slider.x", "--wrt", "spring.k", "--json", "-q"]
    assert main(["sensitivity", str(MODEL), "--until", "0.3", *wanted, "--start", "rates.pin=1 rad/s"]) == 0
    value = json.loads(capsys.readouterr().out)["responses"]["slider.x"]["value"]
    assert value == pytest.approx(found, abs=1e-6)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("rates.pim=1", "start: slider-crank has no output 'pim'. Choose from pin."),
        ("rates.pin=1 m/s", "start: pin must be in rad/s"),
        ("spin=1", "start: there is no key 'spin'. Give"),
        ("run=nowhere", "nowhere"),
        ("t=2", "until must be a time in s after the start at 2"),
        ("pin", "must be a name and a value such as rates.pin=5"),
    ],
)
def test_a_wrong_start_is_refused_by_the_shell(
    given: str, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    ended = 2
    with suppress(SystemExit):
        ended = main(["run", str(MODEL), "--start", given, "-q"])
    assert ended == 2
    told = capsys.readouterr()
    assert message in told.out + told.err


def test_files_take_the_same(tmp_path: Path) -> None:
    sought = read_optimization_file(written(tmp_path, BEST), sr.load).solved()
    assert sought.run is not None
    k = dict(zip(sought.names, sought.x, strict=True))["spring.k"]
    system = sr.System(sr.load(MODEL))
    problem = sr.Problem(system, sr.Final("slider.x"), ["spring.k"], until=0.3, start=RATES)
    assert sought.run.coordinate("slider.x")[-1] == pytest.approx(problem.values(np.array([k]))[0], abs=1e-7)
    sr.simulate(sr.System(sr.load(MODEL)), RATES, until=0.2, save=tmp_path / "drop.sarrus")
    final = sr.load_run(tmp_path / "drop.sarrus").final
    by_run = STUDY.replace("{rates: {pin: 1 rad/s}}", "{run: drop.sarrus}")
    for text, start in ((STUDY, RATES), (by_run, final)):
        asked = read_study_file(written(tmp_path, text), sr.load)
        table = sr.study(
            asked.task.source.model, {"spring.k": [10]}, {"end": "slider.x"}, analysis=asked.task.run
        )
        assert table["end"][0] == pytest.approx(end(start), abs=1e-6)


@pytest.mark.parametrize("verb", ["study", "optimize"])
@pytest.mark.parametrize("option", ["--total-time-limit", "--time-limit"])
def test_the_limit_of_the_whole_has_its_name(
    verb: str, option: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """That of Python; its old spelling is taken, too."""
    file = written(tmp_path, STUDY if verb == "study" else BEST)
    main([verb, str(file), option, "1e-6", "-q"])
    told = capsys.readouterr()
    assert "time limit of 1e-06 s" in (told.out + told.err).replace("1e-6", "1e-06")


@pytest.mark.parametrize("text", [STUDY, BEST])
@pytest.mark.parametrize(
    ("start", "message"),
    [
        ("{rates: {pim: 1}}", "start: slider-crank has no output 'pim'. Choose from pin."),
        ("{run: nowhere}", "nowhere"),
        ("{t: 0.5}", "until must be a time in s after the start at 0.5"),
        ("5", "q must be"),
    ],
)
def test_a_wrong_start_has_its_line(tmp_path: Path, text: str, start: str, message: str) -> None:
    file = written(tmp_path, text[: text.index("start: ")] + f"start: {start}\n")
    read = read_study_file if text is STUDY else read_optimization_file
    with pytest.raises(sr.ModelError, match=rf"file.yaml:{4 if text is STUDY else 5}: .*{message}"):
        read(file, sr.load)
