"""The source distribution builds a wheel, and the wheel works in an environment of its own, away from the clone."""

import os
import shutil
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
OTHERS = [
    version
    for version in ("3.11", "3.12", "3.13")
    if version != f"{sys.version_info[0]}.{sys.version_info[1]}"
]
NOT_OFFERED = ("No matching distribution", "Could not fetch", "Connection")  # what pip says
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


def interpreter(version: str) -> str | None:
    """A Python of this version, also one of pyenv that its shims do not run."""
    shims = [Path(place) for place in os.environ["PATH"].split(os.pathsep) if Path(place).name == "shims"]
    named = [found for found in [shutil.which(f"python{version}")] if found]
    managed = [
        str(own) for place in shims for own in (place.parent / "versions").glob(f"{version}.*/bin/python")
    ]
    for found in (*named, *managed):
        if subprocess.run([found, "-c", "import venv"], capture_output=True, check=False).returncode == 0:
            return found
    return None


@pytest.mark.parametrize("version", OTHERS)
def test_wheel_works_with_other_versions_of_python(version: str, built: Path, tmp_path: Path) -> None:
    """With the packages that are installed for them; the motion is the same."""
    found = interpreter(version)
    if found is None:
        pytest.skip(f"there is no Python {version}")
    told(found, "-m", "venv", str(tmp_path / "environment"), folder=tmp_path)
    places = sysconfig.get_paths(
        vars={"base": str(tmp_path / "environment"), "platbase": str(tmp_path / "environment")}
    )
    own, (wheel,) = str(Path(places["scripts"]) / "python"), built.glob("*.whl")
    install = [own, "-m", "pip", "install", "-q", "--no-compile", str(wheel)]
    done = subprocess.run(install, cwd=tmp_path, capture_output=True, text=True, check=False)
    if done.returncode and any(sign in done.stderr for sign in NOT_OFFERED):
        pytest.skip(f"packages for Python {version} are not offered here")
    assert done.returncode == 0, done.stderr
    program = """
import sys
import sarrus as sr
run = sr.simulate(sr.System(sr.load("slider_crank")), until=0.5)
print(f"{sys.version_info[0]}.{sys.version_info[1]}", run.status, run["slider.x"][-1].hex())
"""
    one, other = (told(each, "-c", program, folder=tmp_path).split() for each in (own, sys.executable))
    assert one[:2] == [version, "finished"]
    assert float.fromhex(one[2]) == pytest.approx(float.fromhex(other[2]), rel=1e-9)
