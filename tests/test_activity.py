"""What takes longer than a second is never silent unless that is asked for."""

import io
import logging
import re
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.system.mechanisms import slider_crank

import sarrus as sr
from sarrus import activity, console
from sarrus._jit.linking import compilation
from sarrus.activity import for_seconds
from sarrus.analyses.optimization.search import reporting
from sarrus.analyses.progress import monitor
from sarrus.cli.progress import Bar

LONG = 0.1  # s


class Terminal(io.StringIO):
    """Standard error that is one."""

    def isatty(self) -> bool:
        return True


@pytest.fixture(autouse=True)
def _soon(monkeypatch: pytest.MonkeyPatch) -> None:
    """Lines appear at once."""
    monkeypatch.setattr(activity, "PATIENCE", 0.01)
    monkeypatch.setattr(activity, "PAUSE", 0.01)
    monkeypatch.delenv(compilation.VARIABLE, raising=False)


@pytest.fixture
def terminal(monkeypatch: pytest.MonkeyPatch) -> Terminal:
    """Standard error of this test: pytest's own is put back after a fixture."""
    stream = Terminal()
    for module in (compilation, console):
        monkeypatch.setattr(module, "sys", SimpleNamespace(stderr=stream))
    return stream


def drawn(stream: Terminal) -> list[str]:
    """The lines that were drawn; the last drawing removes the line."""
    *lines, last = [part.strip() for part in stream.getvalue().split("\r\033[K")]
    assert not last
    assert "\n" not in stream.getvalue()
    return [line for line in lines if line]


def test_an_analysis_shows_its_bar_and_removes_it(terminal: Terminal) -> None:
    with monitor(None, 10.0) as report:
        report(2.5)
        time.sleep(LONG)
    lines = drawn(terminal)
    assert lines
    assert all(re.fullmatch(r"█{7}·{21} simulated 2.5 of 10 s, [\d.]+ s to go", line) for line in lines)


def test_what_is_inside_has_no_line_of_its_own(terminal: Terminal) -> None:
    with monitor(None, 4.0, done="ran", unit=" cases"):
        with monitor(None, 10.0):
            time.sleep(LONG)
        with activity.activity(for_seconds("checking")):
            time.sleep(LONG)
    assert {line.split(",")[0] for line in drawn(terminal)} == {"·" * 28 + " ran 0 of 4 cases"}


def test_what_is_short_is_not_shown(terminal: Terminal, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(activity, "PATIENCE", 3600.0)
    with monitor(None, 10.0) as report:
        report(2.5)
    assert terminal.getvalue() == ""


@pytest.mark.parametrize(
    "within",
    [
        lambda: monitor(False),
        lambda: monitor(lambda reached: None),
        lambda: compilation.showing(False),
        lambda: activity.activity(None),
        lambda: reporting(False),
        lambda: reporting(lambda number, value: None),
    ],
)
def test_it_can_be_silenced(within: Callable[[], Any], terminal: Terminal) -> None:
    with within(), monitor(None, 10.0):
        time.sleep(LONG)
    assert terminal.getvalue() == ""


def test_threads_have_no_lines(terminal: Terminal) -> None:
    with ThreadPoolExecutor(1) as pool:
        pool.submit(lambda: waiting(monitor(None, 10.0))).result()
    assert terminal.getvalue() == ""


def waiting(context: Any) -> None:
    with context:
        time.sleep(LONG)


def test_the_environment_silences_it(terminal: Terminal, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(compilation.VARIABLE, "0")
    with monitor(None, 10.0):
        time.sleep(LONG)
    assert terminal.getvalue() == ""


def test_bars_of_the_shell_are_the_only_ones(terminal: Terminal) -> None:
    logging.getLogger("sarrus").setLevel(logging.INFO)
    with Bar("simulating", 1.0), monitor(None, 10.0):
        time.sleep(LONG)
    assert "simulated" not in terminal.getvalue()


def test_elsewhere_the_log_has_it(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(logging.getLogger("sarrus"), "propagate", True)
    monkeypatch.setattr(logging.getLogger("sarrus"), "handlers", [])  # the command line adds one
    with caplog.at_level(logging.INFO, logger="sarrus"), activity.activity(for_seconds("checking")):
        time.sleep(LONG)
    assert caplog.messages == ["checking, 0 s"]
    assert capsys.readouterr().err == ""


def test_while_kernels_are_compiled_their_line_is_shown(
    terminal: Terminal, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(compilation, "_open", 1)
    with monitor(None, 10.0):
        time.sleep(LONG)
    assert terminal.getvalue() == ""


def test_waiting_for_another_process_is_shown(terminal: Terminal) -> None:
    with compilation.Compilation().waiting() as show:
        assert compilation.compiling()  # no other line is shown
        for seconds in (0.5, 2.4):
            show(seconds)
    assert drawn(terminal) == ["another process compiles a kernel, 2 s"]
    assert not compilation.compiling()


def test_a_search_shows_its_last_simulation(terminal: Terminal) -> None:
    with reporting(None) as report:
        report(3, 0.125)
        time.sleep(LONG)
    assert all(line.startswith("simulation 3: objective 0.125, ") for line in drawn(terminal))


@pytest.mark.parametrize(
    "name", ["simulate", "sensitivity", "check", "error", "film", "page", "study", "states"]
)
def test_analyses_and_drawings_are_activities(
    name: str, terminal: Terminal, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Each asks for one line, whatever it calls."""
    asked = list[str]()

    def watch(line: activity.Line, over: Any) -> None:
        asked.append(line(2.0))

    system = slider_crank()
    run = sr.simulate(system, until=0.05, store="steps", t_eval=np.linspace(0, 0.05, 3))
    monkeypatch.setattr(activity, "_watch", watch)
    end = sr.Final("slider.x")
    whole = sr.Simulation(until=0.01, steps=2)
    calls: dict[str, Callable[[], Any]] = {
        "simulate": lambda: sr.simulate(system, until=0.01),
        "sensitivity": lambda: sr.sensitivity(run, end),
        "check": system.check_derivatives,
        "error": lambda: run.error(end),
        "film": lambda: run.animate(tmp_path / "film.gif", count=2, speed=1.0),
        "page": lambda: run.animate(tmp_path / "page.html", count=2),
        "study": lambda: sr.study(system, {"spring.k": [10.0, 20.0]}, {"x": "max(slider.x)"}, analysis=whole),
        "states": lambda: sr.state_derivatives(run, ["spring.k"]),
    }
    calls[name]()
    words = {"simulate": "simulated", "sensitivity": "differentiated", "check": "checking", "error": "errors",
             "film": "drew", "page": "drawing", "study": "ran", "states": "differentiated"}  # fmt: skip
    assert words[name] in asked[-1]
    assert len(asked) == 1 + (name == "film")  # its frames are computed first
