"""Of processes that share a cache one compiles a kernel; none waits for one that is gone, has failed or is stopped."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from sarrus._jit.linking import compilation_locks
from sarrus._jit.linking.compilation_locks import CompilationLocks

HOLDER = """
import os, sys, time
from pathlib import Path
from sarrus._jit.linking.compilation_locks import CompilationLocks
CompilationLocks(Path(sys.argv[1])).acquire("kernel", lambda seconds: None)
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
        assert 0 < seconds_of_waiting(tmp_path) <= 0.3 < time.monotonic() - began


@needs_fork
def test_a_kernel_that_cannot_be_compiled_is_unlocked(tmp_path: Path) -> None:
    with running(FAILURE, SARRUS_CACHE_DIR=str(tmp_path)) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "refused\n"
        (file,) = tmp_path.glob("kernels-*/compiling.lock")
        locked = Path("/proc/locks")
        if locked.exists():
            assert f":{file.stat().st_ino} " not in locked.read_text()


def test_without_locks_everybody_compiles(tmp_path: Path) -> None:
    """In a folder that is not there no file can be locked."""
    assert seconds_of_waiting(tmp_path / "nowhere") == 0
