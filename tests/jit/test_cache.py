"""Compiled kernels last, and never lie: concurrent starts, edits of the sources, installs that cannot be written."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from numba import typeof
from numba.core.registry import cpu_target

import sarrus
from sarrus._jit.linking import cache
from sarrus._jit.linking.cache import KernelCache, fingerprint
from sarrus._jit.linking.sources import NO_KERNELS, SOURCES

PACKAGE = Path(sarrus.__file__).parent
PROGRAM = """
import sarrus as sr
from sarrus import mechanisms
from sarrus._jit.linking import cache
system = sr.System(sr.load(mechanisms.path("slider_crank")))
print(repr(float(abs(system.Phi_q(system.q0).data).sum())), system.group("Phi_q").compiled.stats.cache_hits.total())
print(cache.folder())
"""


def start(home: Path, **environment: str) -> "subprocess.Popen[str]":
    settings = {**os.environ, "PYTHONPATH": str(home), "PYTHONDONTWRITEBYTECODE": "1", **environment}
    return subprocess.Popen(
        [sys.executable, "-c", PROGRAM],
        env=settings,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )


def finish(process: "subprocess.Popen[str]") -> tuple[float, int, Path]:
    """The sum that the program prints, how many kernels came from the cache, and the cache folder."""
    out, err = process.communicate(timeout=300)
    assert process.returncode == 0, err
    total, hits, folder = out.split()
    return float(total), int(hits), Path(folder)


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """A copy of the package, alone in a folder."""
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(PACKAGE, tmp_path / "home" / "sarrus", ignore=ignored)
    return tmp_path / "home"


def test_two_processes_on_an_empty_cache(tmp_path: Path) -> None:
    place = str(tmp_path / "cache")
    both = [start(PACKAGE.parent, SARRUS_CACHE_DIR=place) for _ in range(2)]
    (first, hits, folder), (second, others, _) = [finish(process) for process in both]
    assert first == second
    assert hits + others == 1  # one compiles, the other waits for it
    assert folder.parent == Path(place)
    assert finish(start(PACKAGE.parent, SARRUS_CACHE_DIR=place))[:2] == (first, 1)


@pytest.mark.slow
def test_an_edit_of_any_source_is_seen(copy: Path, tmp_path: Path) -> None:
    place = str(tmp_path / "cache")
    before, _, old = finish(start(copy, SARRUS_CACHE_DIR=place))
    source = copy / "sarrus" / "euler.py"
    text = source.read_text(encoding="utf-8")
    assert "(2 * d0 * a + cross(d, a))" in text
    source.write_text(
        text.replace("(2 * d0 * a + cross(d, a))", "(3 * d0 * a + cross(d, a))"), encoding="utf-8"
    )
    after, hits, new = finish(start(copy, SARRUS_CACHE_DIR=place))
    assert hits == 0
    assert new != old
    assert abs(after - before) > 0.1
    source.write_text(text, encoding="utf-8")
    assert finish(start(copy, SARRUS_CACHE_DIR=place))[:2] == (before, 1)


@pytest.mark.parametrize("pattern", SOURCES)
def test_a_file_of_every_pattern_counts(pattern: str, copy: Path) -> None:
    """An edit changes the fingerprint, in folders within folders too; taken back, it is the old one."""
    package = copy / "sarrus"
    before = fingerprint(package)
    sources = [
        file
        for file in sorted(package.glob(pattern))
        if file.relative_to(package).as_posix() not in NO_KERNELS
    ]
    for source in sources[:: 1 if "*" not in pattern else 5]:
        text = source.read_bytes()
        source.write_bytes(text + b"\n")
        assert fingerprint(package) != before, source
        source.write_bytes(text)
    assert fingerprint(package) == before


@pytest.mark.parametrize("folder", [pattern.split("/")[0] for pattern in SOURCES if "**" in pattern])
def test_a_new_file_counts(folder: str, copy: Path) -> None:
    package = copy / "sarrus"
    before = fingerprint(package)
    (package / folder / "within").mkdir()
    (package / folder / "within" / "new.py").write_text("")
    assert fingerprint(package) != before


def test_what_kernels_do_not_depend_on_does_not_count(copy: Path) -> None:
    package = copy / "sarrus"
    before = fingerprint(package)
    (package / "model" / "new.py").write_text("")
    assert fingerprint(package) == before


@pytest.mark.slow
def test_an_install_that_cannot_be_written_uses_the_users_cache(copy: Path, tmp_path: Path) -> None:
    (copy / "sarrus" / "__pycache__").write_text("a file where a folder would have to be made")
    user = tmp_path / "user"
    settings = {"XDG_CACHE_HOME": str(user), "SARRUS_CACHE_DIR": ""}
    _, hits, folder = finish(start(copy, **settings))
    assert folder.parent == user / "sarrus"
    assert hits == 0
    assert finish(start(copy, **settings))[1] == 1


def test_without_any_folder_it_still_runs(copy: Path, tmp_path: Path) -> None:
    (copy / "sarrus" / "__pycache__").write_text("")
    blocked = tmp_path / "blocked"
    blocked.write_text("")
    settings = {"XDG_CACHE_HOME": str(blocked), "SARRUS_CACHE_DIR": str(blocked), "TMPDIR": str(tmp_path)}
    (tmp_path / f"sarrus-{os.geteuid()}").write_text("")
    _, _, folder = finish(start(copy, **settings))
    assert folder.parent == tmp_path
    assert not folder.exists()  # of that process alone


def test_a_kernel_of_a_long_name_has_a_short_file_name() -> None:
    from sarrus._jit.kernels.driver import compile_source

    one, other = (compile_source("Phi_q_" * 60 + end, ["def f(x):", "    return x + 1"], {}) for end in "ab")
    assert one(1.0) == 2.0
    assert len(one.py_func.__name__) < 80
    assert one.py_func.__name__ != other.py_func.__name__


def test_stored_values_are_computed_once() -> None:
    from sarrus._jit.linking.cache import folder, stored_value

    made: list[int] = []
    name = f"of_a_test_{os.getpid()}"
    found = [stored_value(name, lambda: made.append(1) or [[1, 2]]) for _ in range(2)]  # type: ignore[func-returns-value]
    (folder() / f"{name}.value").unlink()
    assert found == [[[1, 2]], [[1, 2]]]
    assert made == [1]


def test_records_with_other_fields_are_told_apart() -> None:
    """Two versions of the package share a folder where their kernels are the same."""

    class One(NamedTuple):
        first: np.ndarray
        second: np.ndarray

    class Other(NamedTuple):
        second: np.ndarray
        first: np.ndarray

    def add(record: One) -> float:
        return float(record.first[0] - record.second[0])

    Other.__name__, Other.__qualname__ = One.__name__, One.__qualname__
    codegen, pair = cpu_target.target_context.codegen(), (np.zeros(1), np.ones(1))
    cache: Any = KernelCache(add)  # type: ignore[no-untyped-call]
    keys = [cache._index_key((typeof(record(*pair)),), codegen) for record in (One, Other)]
    assert keys[0] != keys[1]


def test_records_that_are_no_longer_there_are_forgotten(monkeypatch: pytest.MonkeyPatch) -> None:
    def gone(*arguments: Any) -> None:
        raise ModuleNotFoundError("a module of another version")

    cache: Any = KernelCache(test_records_with_other_fields_are_told_apart)  # type: ignore[no-untyped-call]
    monkeypatch.setattr(cache._cache_file, "load", gone)
    assert cache.load_overload((), cpu_target.target_context) is None


TWO_KERNELS = """
from numba import njit
from sarrus._jit.linking.cache import KernelCache

def square(x):
    return x * x

square = njit(square)
square._cache = KernelCache(square.py_func)
print(square(3.0), square.stats.cache_hits.total())
(stored,) = square.overloads.values()
print(getattr(stored.library, "_parsed", None) is None)
print(njit(lambda x: square(x) + 1.0)(3.0), stored.library._get_module_for_linking() is not None)
"""


def test_code_that_calls_a_stored_kernel_is_linked_with_its_module(tmp_path: Path) -> None:
    program = tmp_path / "program.py"
    program.write_text(TWO_KERNELS, encoding="utf-8")
    settings = {**os.environ, "PYTHONPATH": str(PACKAGE.parent), "SARRUS_CACHE_DIR": str(tmp_path / "cache")}
    for hits in (0, 1):
        found = subprocess.run([sys.executable, program], env=settings, capture_output=True, text=True)
        assert found.stdout.split() == ["9.0", str(hits), "True", "10.0", "True"], found.stderr


def test_the_least_recently_used_kernels_are_removed(tmp_path: Path) -> None:
    for n in range(5):
        (tmp_path / f"{n}.kernel").write_bytes(bytes(100))
        os.utime(tmp_path / f"{n}.kernel", (n, n))
    (tmp_path / "a.value").write_bytes(bytes(1000))
    os.utime(tmp_path / "0.kernel")  # used just now
    cache.shrink(tmp_path, 350)
    assert sorted(file.name for file in tmp_path.iterdir()) == ["0.kernel", "3.kernel", "4.kernel", "a.value"]
    cache.shrink(tmp_path, 0)
    assert [file.name for file in tmp_path.iterdir()] == ["a.value"]


def test_folders_of_others_are_not_stale_kernels(tmp_path: Path) -> None:
    ours, others = tmp_path / f"kernels-{'0' * 20}", tmp_path / "kernels-linux"
    for folder in (ours, others):
        folder.mkdir()
        os.utime(folder, (0, 0))
    cache._forget_stale(tmp_path, keep="kernels-now")
    assert not ours.exists()
    assert others.exists()
