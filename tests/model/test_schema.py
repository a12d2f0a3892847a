"""The JSON Schema against a validator: the shipped models and the examples pass, misspelt ones do not."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from sarrus import mechanisms
from sarrus.model.file import schema
from sarrus.model.file.load import load, read

GUIDE = Path(__file__).parents[2] / "docs" / "model-file.md"
EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.yaml"))
FULL = """\
name: all of it
include: [a.yaml, {file: b.yaml, prefix: b_, parameters: {l: 2*l}}]
parameters: {l: 20 mm, group: {a: 1, b: "${l}*2"}}
points: {A: [0, l, 1 m]}
gravity: [0, 0, -9.81 m/s^2]
bodies:
  rod: {mass: 2 kg, inertia: [1, 1 kg m^2, l], position: A, orientation: {axis: [0, 0, 1], angle: 30 deg}}
joints:
  pin: {type: revolute, bodies: [ground, rod], point: A, axis: [0, 0, 1]}
forces:
  s: {type: tsda, points: [{body: rod, at: [0, 0, l]}, {body: ground, global: A}], k: {table: [[0 mm, 1], [1, 2 N]]},
      length: 1 m, c: 3 N s/m}
"""


@pytest.fixture(scope="module")
def validator() -> Draft202012Validator:
    Draft202012Validator.check_schema(schema())
    return Draft202012Validator(schema())


def plain(path: Path) -> Any:
    """Return a file's data as any YAML reader gives it."""
    return json.loads(json.dumps(read(path).data))


@pytest.mark.parametrize("name", [*mechanisms.names(), *mechanisms.suspensions()])
def test_the_shipped_models_are_valid(name: str, validator: Draft202012Validator) -> None:
    validator.validate(plain(mechanisms.path(name)))


def test_all_forms_are_valid(tmp_path: Path, validator: Draft202012Validator) -> None:
    (tmp_path / "m.yaml").write_text(FULL)
    validator.validate(plain(tmp_path / "m.yaml"))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("mass: 2 kg", "mas: 2 kg"),
        ("mass: 2 kg", "mass: true"),
        ("mass: 2 kg", "mass: [1]"),
        ("point: A", "point: [1, 2]"),
        ("prefix:", "prefx:"),
        ("type: revolute", "type: revolut"),
        ("parameters: {l: 20 mm", "parameters: {l: [1]"),
        ("[[0 mm, 1], [1, 2 N]]", "[[0 mm, 1], [1]]"),
        ("length: 1 m,", ""),
        ("name: all of it", "name: [all, of, it]"),
    ],
)
def test_wrong_files_are_not(old: str, new: str, tmp_path: Path, validator: Draft202012Validator) -> None:
    assert old in FULL
    (tmp_path / "m.yaml").write_text(FULL.replace(old, new, 1))
    assert not validator.is_valid(plain(tmp_path / "m.yaml"))


def test_bodies_may_come_from_included_files(validator: Draft202012Validator) -> None:
    assert validator.is_valid({"name": "car", "include": ["axle.yaml"]})
    assert not validator.is_valid({"name": "car"})


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_the_examples_are_valid_and_load(path: Path, validator: Draft202012Validator) -> None:
    validator.validate(plain(path))
    assert load(path).name


def test_a_file_without_a_name_has_its_own(tmp_path: Path, validator: Draft202012Validator) -> None:
    (tmp_path / "axle.yaml").write_text("bodies:\n  a: {mass: 1, inertia: [1, 1, 1]}\n")
    validator.validate(plain(tmp_path / "axle.yaml"))
    assert load(tmp_path / "axle.yaml").name == "axle"


def test_the_schema_tells_editors_the_units() -> None:
    definitions = schema()["$defs"]
    assert definitions["Body"]["properties"]["mass"]["description"] == "[kg]"
    assert definitions["TSDA"]["properties"]["length"]["type"] == ["number", "string"]
    assert "unit" not in json.dumps(definitions["Revolute"]["properties"]["axis"])
