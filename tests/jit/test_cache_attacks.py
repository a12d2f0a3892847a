"""Kernels are loaded only from a folder that no other user can write, and never from a damaged file."""

import os
import shutil
import stat
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import sarrus
from sarrus._jit.linking.cache import fingerprint
from sarrus._jit.linking.folders import made_private, private

PACKAGE = Path(sarrus.__file__).parent
NOBODY = 65534
ROOT = hasattr(os, "geteuid") and os.geteuid() == 0
PROGRAM = """
import numpy as np
from sarrus._jit.linking import cache
from sarrus._jit.kernels.driver import compile_source
kernel = compile_source("kernel", ["def f(x):", "    return 2.0 * x"], {})
print(kernel(21.0), cache.stored_value("value", lambda: 7), kernel.stats.cache_hits.total(), cache.folder(), sep="|")
"""
LOOPS = """
from typing import NamedTuple
import numpy as np

class Work(NamedTuple):
    %s: np.ndarray
    %s: np.ndarray

def difference(work):
    return work.first[0] - work.second[0]
"""
VERSIONS = """
import numpy as np, loops
from sarrus._jit.linking.link import compiled, link
kernel = link(compiled(loops.difference))
work = loops.Work(**{"first": np.array([5.0]), "second": np.array([3.0])})
print(kernel(work), kernel.stats.cache_hits.total())
"""

pytestmark = pytest.mark.skipif(not hasattr(os, "geteuid"), reason="this system has no owners of this kind")


def run(program: str, home: Path, *before: str, **environment: str) -> str:
    """What a program prints in a process of its own, with the package at a place."""
    settings = {**os.environ, "PYTHONPATH": str(home), "PYTHONDONTWRITEBYTECODE": "1", **environment}
    command = [*before, sys.executable, "-W", "ignore", "-c", program]
    done = subprocess.run(command, env=settings, text=True, capture_output=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def kernels(home: Path, *before: str, **environment: str) -> tuple[int, Path]:
    """How many kernels came from the cache, and the folder, of a run whose results are right."""
    twice, seven, hits, folder = run(PROGRAM, home, *before, **environment).split("|")
    assert (twice, seven) == ("42.0", "7")
    return int(hits), Path(folder)


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    shutil.copytree(PACKAGE, tmp_path / "home" / "sarrus", ignore=shutil.ignore_patterns("__pycache__"))
    return tmp_path / "home"


DAMAGE: dict[str, Callable[[bytes], bytes]] = {
    "empty": lambda data: b"",
    "truncated": lambda data: data[: len(data) // 2],
    "zeroed": lambda data: bytes(len(data)),
    "zeroed in the middle": lambda data: data[:500] + bytes(200) + data[700:],
    "one bit": lambda data: data[:-9] + bytes([data[-9] ^ 4]) + data[-8:],
    "garbage": lambda data: b"no pickle at all" * 9,
}


@pytest.mark.slow
def test_a_damaged_cache_is_made_anew(tmp_path: Path) -> None:
    place = str(tmp_path / "cache")
    _, folder = kernels(PACKAGE.parent, SARRUS_CACHE_DIR=place)
    files = [file for file in folder.iterdir() if file.suffix in (".kernel", ".value")]
    assert len(files) == 2
    for name, damage in DAMAGE.items():
        for file in files:
            file.write_bytes(damage(file.read_bytes()))
        assert kernels(PACKAGE.parent, SARRUS_CACHE_DIR=place)[0] == 0, name
    assert kernels(PACKAGE.parent, SARRUS_CACHE_DIR=place)[0] == 1


def test_two_versions_on_one_cache(tmp_path: Path) -> None:
    """The kernel's text is the same, the fields of its record stand in another order."""
    homes = [tmp_path / name for name in ("one", "other")]
    for home, fields in zip(homes, [("first", "second"), ("second", "first")], strict=True):
        home.mkdir()
        (home / "loops.py").write_text(LOOPS % fields)
    settings = {"SARRUS_CACHE_DIR": str(tmp_path / "cache")}
    paths = [Path(f"{home}{os.pathsep}{PACKAGE.parent}") for home in homes]
    found = [run(VERSIONS, path, **settings) for path in (*paths, *paths)]
    assert found == ["2.0 0", "2.0 0", "2.0 1", "2.0 1"]


@pytest.mark.skipif(ROOT and not shutil.which("setpriv"), reason="the superuser writes anywhere")
def test_a_package_that_cannot_be_written(copy: Path, tmp_path: Path) -> None:
    """Neither package nor home can be written: the user's own folder among the temporary ones is used again."""
    plain = (
        ["setpriv", "--bounding-set", "-dac_override,-dac_read_search", "--inh-caps", "-all"] if ROOT else []
    )
    home, temporary = tmp_path / "nowhere", tmp_path / "temporary"
    temporary.mkdir(mode=0o700)
    home.mkdir(mode=0o500)
    for path in (copy, *copy.rglob("*")):
        path.chmod(path.stat().st_mode & ~0o222)
    settings = {"HOME": str(home), "XDG_CACHE_HOME": "", "SARRUS_CACHE_DIR": "", "TMPDIR": str(temporary)}
    try:
        hits, folder = kernels(copy, *plain, **settings)
        assert (hits, folder.parent) == (0, temporary / f"sarrus-{os.geteuid()}")
        assert stat.S_IMODE(folder.stat().st_mode) == 0o700
        assert kernels(copy, *plain, **settings) == (1, folder)
    finally:
        for path in (copy, *copy.rglob("*")):
            path.chmod(path.stat().st_mode | 0o200)


def trap(place: Path, owner: int, mode: int) -> Path:
    """A folder of kernels that somebody else has prepared."""
    folder = place / f"kernels-{fingerprint()}"
    folder.mkdir(parents=True)
    folder.chmod(mode)
    if ROOT:
        os.chown(folder, owner, owner)
    return folder


@pytest.mark.parametrize("mode", [0o777, 0o770, 0o1777, 0o755])
def test_a_folder_that_another_user_could_write_is_passed_over(tmp_path: Path, mode: int) -> None:
    foreign = mode == 0o755
    if foreign and not ROOT:
        pytest.skip("only the superuser gives folders away")
    folder = trap(tmp_path / "cache", NOBODY if foreign else os.geteuid(), mode)
    user = tmp_path / "user"
    _, used = kernels(PACKAGE.parent, SARRUS_CACHE_DIR=str(folder.parent), XDG_CACHE_HOME=str(user))
    assert used != folder
    assert not list(folder.iterdir())


def test_a_folder_of_ours_within_one_that_others_can_write_is_passed_over(tmp_path: Path) -> None:
    open_to_all = tmp_path / "open"
    open_to_all.mkdir()
    open_to_all.chmod(0o777)
    mine = open_to_all / "mine"
    mine.mkdir(mode=0o700)
    assert not private(mine)
    open_to_all.chmod(0o1777)  # as /tmp: each can rename only what is their own
    assert private(mine)
    (open_to_all / "link").symlink_to(mine)
    assert not made_private(open_to_all / "link")


def test_a_chosen_folder_that_is_not_used_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from sarrus._jit.linking import cache

    trap(tmp_path, os.geteuid(), 0o777)
    monkeypatch.setenv("SARRUS_CACHE_DIR", str(tmp_path))
    with pytest.warns(RuntimeWarning, match="SARRUS_CACHE_DIR: .* other users"):
        assert cache.folder.__wrapped__() != tmp_path / f"kernels-{fingerprint()}"


def test_folders_that_are_made_for_a_chosen_one_are_private(tmp_path: Path) -> None:
    before = os.umask(0o002)  # as where each user has a group of their own
    try:
        assert made_private(tmp_path / "a" / "b" / "c")
    finally:
        os.umask(before)


WINDING = """
import numpy as np
from sarrus._jit.linking.link import link
from sarrus._jit.kernels.pointer import NONE
from sarrus.analyses.dynamics.dense_output import winding_loop as loop

count = link(loop.count)
work = loop.Work(**{name: np.zeros(1) for name in loop.Work._fields})
work.Phi[0], work.rate[0] = 0.5, 10.0  # no kernels change them
state, turns = np.zeros((2, 1)), np.zeros((2, 1))
b = np.zeros(1)
count(NONE, NONE, b, np.array([True]), np.array([0.0, 1.0]), state, state, np.array([0.5]), turns, work)
print(turns[1, 0], count.stats.cache_hits.total())
"""
EDITS = {  # of a compiled loop outside the sources by which folders of kernels are named; how often 10 rad are around
    "fields": (
        "    rate: Array\n    Phi_t: Array\n    before: Array\n",
        "    before: Array\n    Phi_t: Array\n    rate: Array\n",
        2.0,
    ),
    "constant": ("REVOLUTION = 6.283185307179586", "REVOLUTION = 1.0", 10.0),
    "statement": ("near += 0.5 *", "near += 2.5 *", 8.0),
}


@pytest.mark.slow
@pytest.mark.parametrize("edit", EDITS)
def test_two_packages_on_one_cache(edit: str, copy: Path, tmp_path: Path) -> None:
    """Processes of the package and of an edited copy alternate: each has its own kernel and its own number."""
    source, (before, after, wanted) = (
        copy / "sarrus" / "analyses" / "dynamics" / "dense_output" / "winding_loop.py",
        EDITS[edit],
    )
    text = source.read_text()
    assert text.count(before) == 1
    source.write_text(text.replace(before, after))
    assert fingerprint(copy / "sarrus") == fingerprint(PACKAGE)  # one folder
    settings = {"SARRUS_CACHE_DIR": str(tmp_path / "cache")}
    found = [run_file(WINDING, home, tmp_path, **settings) for home in (PACKAGE.parent, copy) * 2]
    assert found == ["2.0 0", f"{wanted} 0", "2.0 1", f"{wanted} 1"]


def run_file(program: str, home: Path, folder: Path, **environment: str) -> str:
    """As `run`, from a file: sources of functions are read."""
    (folder / "program.py").write_text(program)
    return run("import program", Path(f"{folder}{os.pathsep}{home}"), **environment)
