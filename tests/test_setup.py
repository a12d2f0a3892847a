"""`dev.py`, which sets up a clone: the environment, and the pip that fills it."""

import subprocess
import sys
from pathlib import Path

import dev
import pytest


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder for the environment."""
    monkeypatch.setattr(dev, "VENV", tmp_path)
    monkeypatch.setattr(dev, "BIN", tmp_path / dev.BIN.name)
    monkeypatch.setattr(dev, "PYTHON", str(tmp_path / dev.BIN.name / Path(dev.PYTHON).name))
    return tmp_path


def printed(command: list[str]) -> str:
    """What a program prints."""
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return done.stdout.strip()


def test_pip_of_this_python_fills_an_empty_environment(place: Path) -> None:
    assert dev.make_venv() == 0
    assert not [*dev.BIN.glob("pip*")]
    assert dev.pip()[:4] == [sys.executable, "-m", "pip", "--python"]
    assert not printed([*dev.pip(), "list"])  # of the packages here, it sees none


@pytest.mark.slow
def test_environment_has_its_own_pip_where_this_python_has_none(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    answers = iter([True, False, True, True])
    monkeypatch.setattr(dev, "succeeds", lambda command: (printed(command), next(answers))[1])
    assert dev.make_venv() == 0
    assert dev.pip() == [dev.PYTHON, "-m", "pip"]
    assert printed([*dev.pip(), "list"]).splitlines()[-2].startswith("pip")
