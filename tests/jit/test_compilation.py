"""Compilation is never silent unless that is asked for: one line on terminals, in notebooks, pipes and logs."""

import io
import itertools
import logging
import re
import sys
import time
from collections.abc import Callable
from typing import Any

import numba
import pytest

from sarrus._jit.linking import compilation
from sarrus._jit.linking.compilation import Compilation, missing, showing
from sarrus._jit.linking.link import compiled, link
from sarrus.analyses.progress import monitor

LINE = r"compiling kernel \d+, once; this call needs \d+ more(, \d+ s left)?"
NUMBERS = itertools.count(time.time_ns())


@pytest.fixture(autouse=True)
def _soon(monkeypatch: pytest.MonkeyPatch) -> None:
    """The line appears at once."""
    monkeypatch.setattr(compilation, "PATIENCE", 0.0)
    monkeypatch.setattr(compilation, "PAUSE", 0.01)
    monkeypatch.setattr(compilation, "REPORTS", 0.0)
    monkeypatch.delenv(compilation.VARIABLE, raising=False)


def fresh(**scope: Any) -> Any:
    """A marked function that no cache has."""
    scope |= {"compiled": compiled, "__name__": __name__}
    called = " + ".join([f"{name}(x)" for name in scope if name.startswith("callee")] or ["x * x"])
    exec(f"@compiled(entry=True)\ndef function(x):\n    return {called} + {next(NUMBERS)}", scope)
    return scope["function"]


def compile_three() -> None:
    """A function that calls two others."""
    link(fresh(callee_1=fresh(), callee_2=fresh()))(1.0)


def calling(*callees: Any) -> Any:
    """A kernel that calls others."""
    scope = {f"f{n}": callee for n, callee in enumerate(callees)}
    exec(f"def root(x):\n    return {' + '.join(f'{name}(x)' for name in scope)}", scope)
    return numba.njit(scope["root"])


class Terminal(io.StringIO):
    """Standard error that is one."""

    def isatty(self) -> bool:
        return True


class Notebook(io.StringIO):
    """Standard error of a notebook, and its display."""

    def __init__(self) -> None:
        super().__init__()
        self.execution_count, self.shown = next(NUMBERS), [""]

    def update(self, content: dict[str, str], **options: Any) -> "Notebook":
        """Show a line in place of the one before."""
        self.shown.append(content["text/plain"])
        return self


Notebook.__module__ = "ipykernel.iostream"


def on_terminal(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The lines that compilation draws on a terminal."""
    monkeypatch.setattr(sys, "stderr", stream := Terminal())
    compile_three()
    assert "\n" not in stream.getvalue()
    return stream.getvalue().split("\r\033[K")


def in_notebook(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Those that it shows in a notebook, where standard error would be red."""
    IPython = pytest.importorskip("IPython")
    monkeypatch.setattr(sys, "stderr", stream := Notebook())
    monkeypatch.setattr(IPython, "get_ipython", lambda: stream)
    monkeypatch.setattr(IPython.display, "display", stream.update)
    compile_three()
    assert stream.getvalue() == ""
    return stream.shown


@pytest.mark.parametrize("lines", [on_terminal, in_notebook])
def test_a_line_is_redrawn_and_removed(
    lines: Callable[[pytest.MonkeyPatch], list[str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    *drawn, last = [part.strip() for part in lines(monkeypatch)]
    assert last == ""
    seen = [text for text in drawn if text]
    assert all(re.fullmatch(LINE, text) for text in seen)
    counts = [tuple(map(int, re.findall(r"\d+", text)[:2])) for text in seen]
    assert counts == sorted(counts)
    (total,) = {number + more for number, more in counts}
    assert {number for number, _ in counts} <= {total - 2, total - 1, total}


def test_elsewhere_the_log_has_it(
    capsys: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(logging.getLogger("sarrus"), "propagate", True)
    monkeypatch.setattr(logging.getLogger("sarrus"), "handlers", [])  # the command line adds one
    with caplog.at_level(logging.INFO, logger="sarrus"):
        compile_three()
    assert caplog.messages
    assert all(re.fullmatch(LINE, text) for text in caplog.messages)
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("way", ["progress=False", "showing(False)", "environment"])
@pytest.mark.parametrize("kind", [Terminal, io.StringIO])
def test_it_can_be_silenced(
    way: str, kind: type[io.StringIO], caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    stream = kind()
    monkeypatch.setattr(logging.getLogger("sarrus"), "propagate", True)
    monkeypatch.setattr(logging.getLogger("sarrus"), "handlers", [])  # the command line adds one
    monkeypatch.setattr(sys, "stderr", stream)
    if way == "environment":
        monkeypatch.setenv("SARRUS_PROGRESS", "0")
    contexts: dict[str, Callable[[], Any]] = {
        "progress=False": lambda: monitor(False),
        "showing(False)": lambda: showing(False),
        "environment": lambda: showing(None),
    }
    with caplog.at_level(logging.INFO, logger="sarrus"), contexts[way]():
        compile_three()
    assert stream.getvalue() == ""
    assert caplog.messages == []


def test_a_bar_in_a_pipe_has_lines_of_it(capsys: pytest.CaptureFixture[str]) -> None:
    with monitor(True, 1.0) as report:
        compile_three()
        report(1.0)
    *lines, last = capsys.readouterr().err.splitlines()
    assert lines
    assert all(re.fullmatch(f"  {LINE}", line) for line in lines)
    assert "simulated 1 of 1 s" in last


def test_what_is_short_is_not_shown(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(compilation, "PATIENCE", 3600.0)
    with showing(True):
        compile_three()
    assert capsys.readouterr().err == ""


def test_a_kernel_that_cannot_be_compiled_does_not_count(capsys: pytest.CaptureFixture[str]) -> None:
    def total() -> int:
        """Of kernels that the last line has and expects."""
        with showing(True):
            compile_three()
        found = re.findall(r"kernel (\d+), once; this call needs (\d+) more", capsys.readouterr().err)
        return sum(map(int, found[-1]))

    before = total()
    with pytest.raises(numba.core.errors.TypingError):
        link(fresh(callee_1=fresh()))("a text")
    assert total() == before + 3


def test_the_time_left_follows_from_the_code_that_is_compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is left takes as long as what is done, in the ratio of its code; no time is shown once that has passed."""
    now = [0.0]
    monkeypatch.setattr(compilation.time, "perf_counter", lambda: now[0])
    monkeypatch.setenv(compilation.VARIABLE, "0")
    one, other = numba.njit(fresh()), numba.njit(fresh())
    root = calling(other)
    size = [len(kernel.py_func.__code__.co_code) for kernel in (one, other, root)]
    shown = Compilation()
    shown.begin(one)
    assert shown.text(one) == "compiling kernel 1, once"
    now[0] = 10.0
    shown.end(success=True)
    shown.begin(root)
    left = 10.0 * (size[1] + size[2]) / size[0]
    assert shown.text(root) == f"compiling kernel 2, once; this call needs 1 more, {left:.0f} s left"
    now[0] = 15.0
    assert shown.text(root) == f"compiling kernel 2, once; this call needs 1 more, {left - 5:.0f} s left"
    now[0] = 100.0
    assert shown.text(root) == "compiling kernel 2, once; this call needs 1 more"
    shown.end(success=True)  # later tests of this process would wait for it


def test_what_is_missing_are_callees_that_are_not_compiled() -> None:
    callees = [numba.njit(fresh()) for _ in range(2)]
    root = calling(*callees)
    assert {id(kernel) for kernel in missing(root)} == {id(root), *map(id, callees)}
    callees[0](1.0)
    assert {id(kernel) for kernel in missing(root)} == {id(root), id(callees[1])}
    root(1.0)
    assert missing(root) == []
