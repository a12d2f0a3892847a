"""A wheel with kernels, in an environment of its own, with an empty cache and an empty home.

The wheel is the newest in `dist/` that was made from these sources (`make wheel`); without one these tests are skipped.
If the environment variable SARRUS_WHEELS names a folder, they fail without one. Of a wheel that was built with some of
the actions, those are tested.
"""

import json
import os
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path

import numpy as np
import pytest
from distribution.kernels import RUN

from sarrus._jit.linking.processor import levels
from sarrus._jit.linking.shipped import identity

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parent.parent
LARGEST = 60e6  # bytes
LONGEST = 3.0  # s of processor time that a first call may take longer than a second
SHARED = 1.7  # times that where other programs share the processors; the least of some tries is taken
TRIES = 3
DEMO = 10.0  # s of processor time
FIRST = (
    *("simulate", "sensitivity", "hessian", "equilibrium", "modes", "linearize"),
    *("kinematics", "workspace", "view"),
)


def _fits(wheel: Path) -> bool:
    """Whether a wheel has kernels for this processor, made from these sources."""
    with zipfile.ZipFile(wheel) as opened:
        for level in levels():
            name = f"sarrus/_kernels/{level.name}/index.json"
            if {name, f"sarrus/_kernels/{level.name}/{RUN}"} <= {*opened.namelist()}:
                return bool(json.loads(opened.read(name))["identity"] == identity(level.name))
    return False


@pytest.fixture(scope="module")
def wheel() -> Path:
    named = os.environ.get("SARRUS_WHEELS")
    found = sorted(
        Path(named or ROOT / "dist").resolve().glob("*.whl"), key=lambda file: file.stat().st_mtime
    )
    fitting = [file for file in found if _fits(file)]
    assert fitting or not named, f"{named} has no wheel with kernels for this processor and these sources"
    if not fitting:
        pytest.skip("there is no wheel with kernels of these sources; `make wheel` builds one")
    return fitting[-1]


@pytest.fixture(scope="module")
def actions(wheel: Path) -> list[str]:
    """The actions whose kernels the wheel holds, of the level that this processor uses."""
    with zipfile.ZipFile(wheel) as opened:
        names = [f"sarrus/_kernels/{level.name}/{RUN}" for level in levels()]
        (first, *_) = [name for name in names if name in opened.namelist()]
        return list(json.loads(opened.read(first)))


def _needs(name: str, actions: list[str]) -> None:
    if name not in actions:
        pytest.skip(f"the wheel was built without the action {name}")


@pytest.fixture(scope="module")
def python(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An environment with the wheel, that finds all other packages where this one has them."""
    folder = tmp_path_factory.mktemp("environment")
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(folder)], check=True)
    places = sysconfig.get_paths(vars={"base": str(folder), "platbase": str(folder)})
    pip = [sys.executable, "-m", "pip", "--python", str(folder), "install", "-q"]
    subprocess.run([*pip, "--no-index", "--no-deps", str(wheel)], check=True, cwd=folder)
    for place in {places["purelib"], places["platlib"]}:
        (Path(place) / "others.pth").write_text(str(Path(np.__file__).parent.parent))
    return Path(places["scripts"]) / "python"


def _output(*command: str, home: Path, **settings: str) -> str:
    """What a program prints that has nothing but its environment, an empty home and an empty cache."""
    given = {name: os.environ[name] for name in ("PATH", "SYSTEMROOT") if name in os.environ}
    given |= {
        "HOME": str(home),
        "USERPROFILE": str(home),
        "SARRUS_CACHE_DIR": str(home / "cache"),
        **settings,
    }
    done = subprocess.run(command, cwd=home, env=given, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr + done.stdout
    return done.stdout


def _compiled(home: Path) -> list[str]:
    return [file.name for file in home.rglob("*.kernel")]


def test_wheel_is_small(wheel: Path) -> None:
    assert wheel.stat().st_size <= LARGEST


@pytest.mark.parametrize("name", FIRST)
def test_first_call_waits_for_no_compiler(
    name: str, actions: list[str], python: Path, tmp_path: Path
) -> None:
    _needs(name, actions)
    script, waits = ROOT / "distribution" / "actions.py", list[float]()
    for _ in range(TRIES):
        home = tmp_path / str(len(waits))
        home.mkdir()
        found = json.loads(_output(str(python), str(script), name, home=home))
        waits.append(found[1] - found[2])
        assert _compiled(home) == []
        if waits[-1] <= SHARED * LONGEST:
            break
    assert min(waits) <= SHARED * LONGEST, waits


def test_demo(actions: list[str], python: Path, tmp_path: Path) -> None:
    _needs("demo", actions)
    before = os.times()
    _output(str(python.parent / "sarrus"), "demo", home=tmp_path)
    after = os.times()
    spent = after.children_user + after.children_system - before.children_user - before.children_system
    assert spent <= SHARED * DEMO
    assert _compiled(tmp_path) == []


def test_users_own_processor_is_compiled_for_without_kernels(python: Path, tmp_path: Path) -> None:
    """Another target than the level's: the kernels of the wheel are not used, and results agree."""
    program = (
        "import sarrus as sr; from sarrus import mechanisms; "
        "s = sr.System(sr.load(mechanisms.path('slider_crank'))); print(repr(float(abs(s.Phi_q(s.q0).data).sum())))"
    )
    first = _output(str(python), "-c", program, home=tmp_path)
    assert _compiled(tmp_path) == []
    settings = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
    again = _output(str(python), "-c", program, home=tmp_path, **settings)
    assert _compiled(tmp_path) != []
    assert float(first) == pytest.approx(float(again), rel=1e-13)
