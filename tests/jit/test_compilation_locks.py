"""Of processes that share a cache one compiles a kernel; none waits for one that is gone, has failed or is stopped."""

import errno
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from filelock import FileLock
from numba import float64, njit

from sarrus._jit.linking import cache, compilation_locks
from sarrus._jit.linking.cache import KernelCache
from sarrus._jit.linking.compilation_locks import CompilationLocks

HOLDER = """
import os, sys, time
from pathlib import Path
from sarrus._jit.linking.compilation_locks import CompilationLocks
locks = CompilationLocks(Path(sys.argv[1]))
for name in ("kernel", "next kernel"):
    locks.acquire(name, lambda seconds: None)
print(os.getpid() if os.fork() else "", flush=True)  # the child lives on, without the lock
time.sleep(60)
"""
FAILURE = """
import sys
from numba import njit
from numba.core.errors import TypingError
from sarrus._jit.linking.cache import KernelCache

@njit
def added(x):
    return x + "text"

added._cache = KernelCache(added.py_func)
try:
    added(1.0)
except TypingError:
    print("refused", flush=True)
sys.stdin.read()
"""
IS_FREE = """
import sys
from pathlib import Path
from sarrus._jit.linking.compilation_locks import CompilationLocks
CompilationLocks(Path(sys.argv[1])).acquire(sys.argv[2], lambda seconds: sys.exit(3))
"""
needs_fork = pytest.mark.skipif(not hasattr(os, "fork"), reason="processes cannot be forked or stopped here")


@contextmanager
def running(program: str, *arguments: str, **environment: str) -> Iterator["subprocess.Popen[str]"]:
    """A program in a session of its own, all of whose processes end with the context."""
    process = subprocess.Popen(
        [sys.executable, "-c", program, *arguments],
        env={**os.environ, **environment},
        text=True,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        start_new_session=True,
    )
    try:
        yield process
    finally:
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()


def holder_of(process: "subprocess.Popen[str]") -> int:
    """The process that holds the lock, once it does."""
    assert process.stdout is not None
    return int("".join(process.stdout.readline() for _ in range(2)))


def seconds_of_waiting(folder: Path) -> float:
    """How long this process waits for the lock, as it reports itself."""
    reports = [0.0]
    locks = CompilationLocks(folder)
    locks.acquire("other kernel", lambda seconds: pytest.fail("another kernel is not locked"))
    locks.acquire("kernel", reports.append)
    return reports[-1]


@needs_fork
def test_a_killed_holder_keeps_no_lock(tmp_path: Path) -> None:
    with running(HOLDER, str(tmp_path)) as process:
        os.kill(holder_of(process), signal.SIGKILL)
        process.wait()
        assert seconds_of_waiting(tmp_path) < 10  # its child sleeps for 60 s


@needs_fork
def test_a_stopped_holder_is_waited_for_in_vain_but_not_for_ever(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(compilation_locks, "PATIENCE", 0.3)
    with running(HOLDER, str(tmp_path)) as process:
        os.kill(holder_of(process), signal.SIGSTOP)
        began = time.monotonic()
        assert 0 < seconds_of_waiting(tmp_path) <= 0.3 + compilation_locks.PAUSE
        assert time.monotonic() - began > 0.3


@needs_fork
def test_a_kernel_that_cannot_be_compiled_is_unlocked(tmp_path: Path) -> None:
    with running(FAILURE, SARRUS_CACHE_DIR=str(tmp_path)) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "refused\n"
        (file,) = tmp_path.glob("kernels-*/*.lock")
        FileLock(file).acquire(blocking=False)  # nobody else has it


@needs_fork
def test_a_stopped_holder_is_waited_for_once_and_own_locks_are_released(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(compilation_locks, "PATIENCE", 0.3)
    locks = CompilationLocks(tmp_path)
    locks.acquire("own kernel", lambda seconds: pytest.fail("nobody else compiles it"))
    with running(HOLDER, str(tmp_path)) as process:
        os.kill(holder_of(process), signal.SIGSTOP)
        locks.acquire("kernel", lambda seconds: None)
        locks.acquire("next kernel", lambda seconds: pytest.fail("waited for the same holder twice"))
    is_free = [sys.executable, "-c", IS_FREE, str(tmp_path), "own kernel"]
    assert subprocess.run(is_free, check=False).returncode == 3
    locks.release("own kernel")
    assert subprocess.run(is_free, check=False).returncode == 0


def test_where_locking_is_refused_it_is_tried_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    tried: list[float] = []

    def refusing(lock: FileLock, timeout: float, *others: object, **settings: object) -> None:
        tried.append(timeout)
        raise OSError(errno.ENOLCK, "no locks available")

    monkeypatch.setattr(FileLock, "acquire", refusing)
    locks = CompilationLocks(tmp_path)
    for name in ("kernel", "next kernel"):
        locks.acquire(name, lambda seconds: pytest.fail("nobody compiles it"))
    assert len(tried) == 1


@pytest.mark.parametrize("failure", [KeyboardInterrupt, RuntimeError])
def test_a_kernel_that_cannot_be_loaded_after_waiting_is_unlocked(
    failure: type[BaseException], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Another process stored it meanwhile."""
    kernel, held = njit(lambda x: 2 * x), set[str]()

    def acquire(name: str, waiting: Any) -> None:
        held.add(name)

    def load(sig: Any, context: Any) -> None:
        if held:
            raise failure

    stored = KernelCache(kernel.py_func)
    locks = SimpleNamespace(acquire=acquire, release=held.remove)
    monkeypatch.setattr(cache, "_locks", lambda: locks)
    monkeypatch.setattr(stored, "_load_overload", load)
    monkeypatch.setattr(stored._files, "file", lambda key: tmp_path)
    with pytest.raises(failure):
        stored.load_overload((float64,), kernel.targetctx)
    assert not held


def test_without_locks_everybody_compiles(tmp_path: Path) -> None:
    """In a folder that is not there no file can be locked."""
    assert seconds_of_waiting(tmp_path / "nowhere") == 0
