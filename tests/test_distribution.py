"""The source distribution builds a wheel, and the wheel works in an environment of its own, away from the clone."""

import os
import subprocess
import sys
import sysconfig
import tarfile
import zipfile
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("build")
pytest.importorskip("hatchling")
pytestmark = pytest.mark.slow

ROOT = Path(__file__).parent.parent
DATA = (".yaml", ".json", ".typed", ".html", ".js", ".css", ".txt")


def told(*command: str, folder: Path) -> str:
    """What a program prints; its complaint, if it fails."""
    here = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(command, cwd=folder, env=here, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr + done.stdout
    return done.stdout


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with both; the wheel is built from the source distribution."""
    folder = tmp_path_factory.mktemp("dist")
    told(sys.executable, "-m", "build", "--no-isolation", "--outdir", str(folder), str(ROOT), folder=folder)
    return folder


@pytest.fixture(scope="module")
def python(built: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An environment with the wheel, that finds all other packages where this one has them."""
    folder = tmp_path_factory.mktemp("environment")
    told(sys.executable, "-m", "venv", "--without-pip", str(folder), folder=folder)
    places = sysconfig.get_paths(vars={"base": str(folder), "platbase": str(folder)})
    (wheel,) = built.glob("*.whl")
    pip = [sys.executable, "-m", "pip", "--python", str(folder), "install", "-q"]
    told(*pip, "--no-index", "--no-deps", str(wheel), folder=folder)
    (Path(places["purelib"]) / "others.pth").write_text(str(Path(np.__file__).parent.parent))
    return Path(places["scripts"]) / "python"


def test_wheel_holds_every_file_of_the_package(built: Path) -> None:
    (wheel,) = built.glob("*.whl")
    names = set(zipfile.ZipFile(wheel).namelist())
    sources = (file for file in (ROOT / "src/sarrus").rglob("*") if file.suffix in (".py", *DATA))
    kept = {file.relative_to(ROOT / "src").as_posix() for file in sources if "__pycache__" not in file.parts}
    assert kept <= names


def test_source_distribution_holds_what_a_clone_needs(built: Path) -> None:
    (archive,) = built.glob("*.tar.gz")
    with tarfile.open(archive) as opened:
        names = {name.partition("/")[2] for name in opened.getnames()}
    assert {
        "Makefile",
        "dev.py",
        "LICENSE",
        "tests/test_import.py",
        "docs/index.md",
        "benchmarks/chain.py",
    } <= names


def test_wheel_works_away_from_the_clone(python: Path, tmp_path: Path) -> None:
    place = told(str(python), "-c", "import sarrus; print(sarrus.__file__)", folder=tmp_path)
    assert Path(place.strip()).is_relative_to(python.parent.parent)
    command = str(python.parent / "sarrus")
    copy = "from sarrus import mechanisms; print(mechanisms.path('slider_crank').read_text())"
    (tmp_path / "crank.yaml").write_text(told(str(python), "-c", copy, folder=tmp_path))
    assert "reached the end" in told(command, "run", "crank.yaml", "--until", "0.1", folder=tmp_path)
    assert told(command, "schema", folder=tmp_path).startswith("{")
