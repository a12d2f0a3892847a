"""`load(..., parameters=...)` and `--set` take values of parts by the names of derivatives, as studies do."""

from pathlib import Path

import pytest

import sarrus as sr
from sarrus.cli import main

TEXT = """
parameters: {k0: 30, group: {c: 2}}
bodies:
  rod: {mass: 2, inertia: [1, 2, 2.5], position: [0.1, 0, 0]}
forces:
  spring:
    type: tsda
    points: [{body: ground, at: [-2, 0, 0]}, {body: rod, at: [0, 0, 0]}]
    k: k0
    length: 2
    c: (0.1 s)*spring.k
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "model.yaml"
    path.write_text(TEXT)
    return path


def test_values_of_parts_and_what_follows_from_them(file: Path) -> None:
    new = {"spring.k": "2 N/cm", "rod.mass": 3.0, "rod.inertia.xx": 1.5, "rod.position.x": 0.2, "group.c": 4}
    model = sr.load(file, parameters=new)
    spring, rod = model.forces[0], model.bodies[0]
    assert (spring.k, spring.c) == (200.0, 20.0)
    assert (rod.mass, next(iter(rod.inertia)), rod.position[0]) == (3.0, 1.5, 0.2)
    assert model.parameters["group.c"] == 4


def test_the_shell_takes_them(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", str(file), "--set", "spring.k=20", "rod.mass=4 kg"]) == 0
    assert main(["check", str(file), "--set", "spring.kk=20"]) != 0
    assert 'there is no parameter "spring.kk". Did you mean "spring.k"?' in capsys.readouterr().err


def test_components_need_numbers(file: Path) -> None:
    with pytest.raises((sr.ModelError, TypeError), match=r"rod\.position\.x must be a number"):
        sr.load(file, parameters={"rod.position.x": [0.2]})
    assert sr.load(file, parameters={"rod.position.x": "20 cm"}).bodies[0].position[0] == 0.2
