"""Study files, and the verb that runs them."""

import json
from pathlib import Path

import pytest

from sarrus import mechanisms
from sarrus.cli import main
from sarrus.model import ModelError, load
from sarrus.studies.file import read_study_file

STUDY = """\
name: springs
model: crank.yaml
parameters:
  spring.k: {from: 5 N/m, to: 15, count: 3}
  rod.mass: [0.5, 2]
responses:
  reach: max(slider.x) - min(slider.x)
  end: slider.x
analysis: {type: simulate, until: 0.2, steps: 50, method: {type: hht, alpha: -0.1}}
"""


def written(folder: Path, text: str) -> Path:
    (folder / "crank.yaml").write_text(mechanisms.path("slider_crank").read_text())
    (folder / "springs.yaml").write_text(text)
    return folder / "springs.yaml"


def test_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, table, figure = written(tmp_path, STUDY), tmp_path / "s.csv", tmp_path / "s.png"
    line = ["study", str(file), "--workers", "1"]
    assert main([*line, "--csv", str(table), "--figure", str(figure), "--plot", "end"]) == 0
    told = capsys.readouterr()
    assert "springs: 6 cases, " in told.out
    assert len(table.read_text().splitlines()) == 7
    assert figure.stat().st_size > 10_000
    assert main([*line, "--json", "-q", "--linear"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["statistics"]["end"]["mean"] == pytest.approx(sum(found["columns"]["end"]) / 6)
    assert found["linear"].keys() == {"reach", "end"}
    assert found["linear"]["end"]["mean"] == pytest.approx(found["statistics"]["end"]["mean"], rel=1e-2)
    assert found["folder"] == str(tmp_path / "springs")


def test_a_study_in_which_all_fails_is_a_failure(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = written(tmp_path, STUDY.replace("[0.5, 2]", "[-1, -2]"))
    assert main(["study", str(file), "--workers", "1"]) == 1
    assert "mass must be greater than 0" in capsys.readouterr().out


WRONG = [
    (
        "model: crank.yaml",
        "modell: crank.yaml",
        "springs.yaml:2: a study has no key 'modell'. Did you mean \"model\"?",
    ),
    (
        "rod.mass:",
        "rod.mas:",
        "springs.yaml:3: study, parameters: slider-crank has no parameter 'rod.mas'. Did you mean",
    ),
    ("[0.5, 2]", "[0.5, heavy]", "springs.yaml:5: study, parameters.rod.mass: 'heavy'"),
    (
        "[0.5, 2]",
        "[0.5, 2 m]",
        "springs.yaml:5: study, parameters.rod.mass: rod.mass expects kg, but '2 m' is in m",
    ),
    ("to: 15", "too: 15", "springs.yaml:4: study, parameters.spring.k: its keys are from, too"),
    ("max(slider.x) -", "max(slider.x", "springs.yaml:6: study, responses: response 'reach' holds a formula"),
    ("until: 0.2,", "", "springs.yaml:9: study, analysis: the analysis simulate needs an end time"),
    (
        "alpha: -0.1",
        "alfa: -0.1",
        "springs.yaml:9: study, analysis: the method hht has no key 'alfa'. Did you mean",
    ),
    ("model: crank.yaml", "model: none.yaml", "none.yaml: does not exist"),
    ("responses:\n", "", "springs.yaml: the file lacks the key 'responses'. Add it, as in 'responses: {end"),
]


@pytest.mark.parametrize(("old", "new", "told"), WRONG, ids=[new for _, new, _ in WRONG])
def test_what_is_wrong_is_told_with_its_line(tmp_path: Path, old: str, new: str, told: str) -> None:
    assert old in STUDY
    with pytest.raises(ModelError) as raised:
        read_study_file(written(tmp_path, STUDY.replace(old, new)), load)
    assert told in str(raised.value)
