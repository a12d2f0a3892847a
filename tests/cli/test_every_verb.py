"""What all verbs have in common: one JSON object, exit codes, one sentence for misuse, one spelling of options."""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
from pathlib import Path

import pytest

import sarrus as sr
from sarrus.cli import VERBS, main
from sarrus.cli.parser import build

ARM = """
name: arm
bodies:
  upper: {mass: 1, inertia: [0.01, 0.1, 0.1], position: [0.5, 0, 0]}
  lower: {mass: 1, inertia: [0.01, 0.1, 0.1], position: [1.4, 0, 0]}
joints:
  q1: {type: revolute, bodies: [ground, upper], point: [0, 0, 0], axis: [0, 0, 1]}
  q2: {type: revolute, bodies: [upper, lower], point: [1, 0, 0], axis: [0, 0, 1]}
"""
DRIVERS = """
drivers:
  one: {type: angle, joint: q1, motion: t}
  two: {type: angle, joint: q2, motion: 2*t}
"""
SPRINGS = """
forces:
  s1: {type: rsda, bodies: [ground, upper], point: [0, 0, 0], axis: [0, 0, 1], k: 10, c: 1}
  s2: {type: rsda, bodies: [upper, lower], point: [1, 0, 0], axis: [0, 0, 1], k: 10, c: 1}
"""
STUDY = """
model: sprung.yaml
parameters: {s1.k: [9, 11]}
responses: {end: lower.x}
analysis: {type: simulate, until: 0.05}
"""
OPTIMIZE = """
model: sprung.yaml
parameters: {s1.k: {from: 8, to: 12}}
minimize: integral(lower.y**2)
analysis: {type: simulate, until: 0.05}
"""
TRAILING_ARM = """
name: trailing arm
bodies: {arm: {mass: 10, inertia: [1, 1, 1], position: [-0.4, 0.6, 0]}}
joints: {pivot: {type: revolute, bodies: [ground, arm], point: [0, 0.5, 0], axis: [0, 1, 0]}}
"""
RIG = """
model: trailing_arm.yaml
wheels:
  left: {carrier: arm, centre: [-0.4, 0.7, 0], spindle: [-0.4, 0.6, 0], radius: 0.3}
steps: 2
"""
LINES = {verb: f"{verb} arm.yaml" for verb in VERBS} | {  # a line for each verb that takes more than a model
    "demo": "demo --output plots",
    "run": "run arm.yaml --until 0.05 --steps 5",
    "kinematics": "kinematics driven.yaml --until 0.1 --steps 5",
    "statics": "statics sprung.yaml",
    "modes": "modes sprung.yaml",
    "workspace": "workspace arm.yaml --output lower.x lower.y --limit q1=-1,1 q2=0.2,1 --samples 20",
    "view": "view arm.yaml --output arm.html",
    "study": "study study.yaml --workers 1",
    "sensitivity": "sensitivity sprung.yaml --until 0.05 --response lower.x --wrt s1.k",
    "optimize": "optimize best.yaml",
    "suspension": "suspension rig.yaml",
    "convert": "convert arm.yaml copy.json",
    "schema": "schema",
    "tyre": "tyre car.tir",
    "compile": "compile sprung.yaml --method radau",
    "completion": "completion bash",
}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    files = {"arm": ARM, "driven": ARM + DRIVERS, "sprung": ARM + SPRINGS, "study": STUDY, "best": OPTIMIZE}
    files |= {"trailing_arm": TRAILING_ARM, "rig": RIG}
    for name, text in files.items():
        (tmp_path / f"{name}.yaml").write_text(text)
    sr.load_tyre("passenger_car").save(tmp_path / "car.tir")
    monkeypatch.chdir(tmp_path)
    return tmp_path


COMPILING = {"compile"}  # kernels that no other test needs


@pytest.mark.parametrize(
    "verb", [pytest.param(verb, marks=[pytest.mark.slow] * (verb in COMPILING)) for verb in sorted(VERBS)]
)
def test_json_is_one_object(verb: str, folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    found = main([*LINES[verb].split(), "--json", "--quiet"])
    told = capfd.readouterr()
    answer = json.loads(told.out)
    assert told.err == ""
    assert answer["verb"] == verb
    assert answer["exit_code"] == found
    assert answer["success"] == (found == 0)
    assert found == 0
    assert verb in ("schema", "completion") or answer["message"]


@pytest.mark.parametrize("verb", sorted(VERBS))
def test_misuse_of_every_verb_is_one_sentence_and_code_2(
    verb: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([verb, "--no-such-option"]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.startswith("sarrus: ")
    assert told.err.count("\n") == 1


@pytest.mark.parametrize("verb", sorted(set(VERBS) - {"demo", "schema", "completion"}))
def test_a_missing_file_is_code_2_in_words_and_in_json(
    verb: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = [word.replace(".yaml", "_none.yaml").replace(".tir", "_none.tir") for word in LINES[verb].split()]
    assert main([*words, "--json"]) == 2
    told = capsys.readouterr()
    assert "does not exist" in told.err
    assert json.loads(told.out)["error"] == told.err.removeprefix("sarrus: ").strip()


def test_one_spelling_for_one_thing() -> None:
    """Options of the same name say the same in every verb, but for their defaults and what they are of."""
    (verbs,) = (a for a in build(VERBS)._actions if isinstance(a, argparse._SubParsersAction))
    spelled: dict[str, set[tuple[object, object]]] = {}
    for child in verbs.choices.values():
        for action in child._actions:
            for name in action.option_strings:
                if name in ("--csv", "--figure", "--seed", "--rtol", "--atol", "--steps", "--time"):
                    spelled.setdefault(name, set()).add((action.type, action.metavar))
    assert {name: len(kinds) for name, kinds in spelled.items()} == dict.fromkeys(spelled, 1)


def test_a_shipped_mechanism_by_its_name(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["view", "slider_crank", "--output", "crank.html"]) == 0
    assert (folder / "crank.html").is_file()


def test_what_does_not_move_is_told(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "arm.yaml", "--until", "0.05", "--steps", "5"]) == 0
    assert "nothing moved" in capsys.readouterr().out


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish", "tcsh", "powershell"])
def test_completion_is_a_script_of_its_shell(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["completion", shell]) == 0
    script = capsys.readouterr().out
    for verb in VERBS:
        assert verb in script
    program = shutil.which(shell)
    if program is not None and shell != "powershell":
        subprocess.run([program, "-n"], input=script, text=True, check=True)


@pytest.mark.parametrize("more", [["lower.y", "--inputs", "q1", "q2", "--field", "solutions"], []])
@pytest.mark.parametrize("limit", ["1e-6", "0.05"])
def test_a_workspace_ends_at_its_time_limit(
    limit: str, more: list[str], folder: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """Of one output and of two, before and after the first curve; what would be drawn over the map is left out."""
    words = ["workspace", "arm.yaml", "--output", "lower.x", *more, "--limit", "q1=-1,1", "q2=0.2,1"]
    assert main([*words, "--time-limit", limit, "--json"]) == 1
    out, err = capfd.readouterr()
    assert json.loads(out)["status"] == "time limit"
    assert f"time limit of {limit} s" in err.replace("1e-06", "1e-6")


def test_compile_runs_every_analysis(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["compile", "sprung.yaml", "--method", "radau", "--json", "-q"]) == 0
    names = {name.removeprefix("arm: ") for name in json.loads(capfd.readouterr().out)["analyses"]}
    of_runs = {"simulation", "gradient", "direct derivatives", "Hessian", "derivatives of states"}
    others = {"operators", "assembly", "equilibrium", "modes", "kinematics", "check of derivatives"}
    assert names == others | {f"{name} by radau" for name in of_runs}
