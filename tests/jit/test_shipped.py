"""Kernels in the package: used on a processor that has their level, never when damaged or made from other sources."""

import json
import shutil
from pathlib import Path

import pytest
from tests.jit.test_cache import PACKAGE, finish, start

from sarrus._jit.kernels.vector import LANES
from sarrus._jit.linking.cache import contents
from sarrus._jit.linking.processor import LEVELS, lanes_of_target, levels
from sarrus._jit.linking.shipped import CONTENT, INDEX, Shipped, identity, pack, shipped

pytestmark = pytest.mark.skipif(not levels(), reason="this processor has none of the levels")


@pytest.fixture(scope="module")
def packed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, float]:
    """A copy of the package with its kernels, and what the program prints that needs them."""
    home = tmp_path_factory.mktemp("shipped")
    shutil.copytree(PACKAGE, home / "sarrus", ignore=shutil.ignore_patterns("__pycache__", "_kernels"))
    level = levels()[-1].name
    settings = {"NUMBA_CPU_NAME": level, "NUMBA_CPU_FEATURES": ""}
    total, hits, folder = finish(start(home, SARRUS_CACHE_DIR=str(home / "cache"), **settings))
    assert hits == 0
    pack(contents(folder), home / "sarrus" / "_kernels" / level, level)
    return home, total


@pytest.fixture
def home(packed: tuple[Path, float], tmp_path: Path) -> Path:
    """A copy with kernels, elsewhere, where all files are new."""
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(packed[0] / "sarrus", tmp_path / "sarrus", ignore=ignored, copy_function=shutil.copyfile)
    return tmp_path


def place(home: Path) -> Path:
    (folder,) = (home / "sarrus" / "_kernels").iterdir()
    return folder


def run(home: Path, **settings: str) -> tuple[float, int, list[Path]]:
    """What the program prints, how many kernels were found, and what was compiled."""
    total, hits, folder = finish(start(home, SARRUS_CACHE_DIR=str(home / "cache"), **settings))
    return total, hits, list(folder.glob("*.kernel"))


def test_nothing_is_compiled(home: Path, packed: tuple[Path, float]) -> None:
    assert run(home) == (packed[1], 1, [])


def test_what_is_damaged_is_compiled(home: Path, packed: tuple[Path, float]) -> None:
    file = place(home) / CONTENT
    file.write_bytes(bytes(255 - byte for byte in file.read_bytes()))
    total, hits, made = run(home)
    assert (total, hits) == (pytest.approx(packed[1], rel=1e-14), 0)
    assert made


@pytest.mark.slow
@pytest.mark.parametrize("text", ["", "[]", "{}", "{", '{"identity": 3}'])
def test_without_an_index_kernels_are_compiled(home: Path, text: str) -> None:
    (place(home) / INDEX).write_text(text)
    assert run(home)[1] == 0


def test_kernels_of_other_sources_are_not_used(home: Path) -> None:
    source = home / "sarrus" / "euler.py"
    source.write_text(source.read_text(encoding="utf-8") + "\n", encoding="utf-8")
    assert run(home)[1] == 0


@pytest.mark.slow
def test_kernels_of_another_target_are_not_used(home: Path) -> None:
    assert run(home, NUMBA_CPU_NAME="generic", NUMBA_CPU_FEATURES="")[1] == 0


def test_a_kernel_is_verified_by_itself(tmp_path: Path) -> None:
    files = {"a": b"first " * 100, "b": b"second " * 100}
    pack(files.items(), tmp_path / "level", "level")
    entries = json.loads((tmp_path / "level" / INDEX).read_text())["entries"]
    found = Shipped(tmp_path / "level", "level", 4, "triple", entries)
    assert [found.read(name) for name in ("a", "b", "c")] == [files["a"], files["b"], None]
    content = bytearray((tmp_path / "level" / CONTENT).read_bytes())
    content[entries["b"][0] + 3] ^= 1
    (tmp_path / "level" / CONTENT).write_bytes(content)
    assert [found.read(name) for name in ("a", "b")] == [files["a"], None]


def test_identity_names_the_level_and_the_sources(home: Path) -> None:
    first, second = (identity(level.name, home / "sarrus") for level in LEVELS[:2])
    assert first != second
    assert identity(LEVELS[0].name) == first  # another folder, other times, the same sources


def test_lanes_are_those_of_the_kernels() -> None:
    assert LANES == (shipped().lanes if shipped() else lanes_of_target())
    assert {level.name: level.lanes for level in LEVELS}["x86-64-v4"] == 8
