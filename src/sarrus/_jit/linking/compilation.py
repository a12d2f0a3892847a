"""Progress of compilation: one line for all kernels that are compiled, whoever asked for them.

Numba reports each function that the cache does not have. How many an analysis will need is not known in advance; what
one call of compiled code still needs is known from its globals:

    compiling kernel 12, once; this call needs 19 more, 20 s left

A kernel that calls no other, such as an operator, is only numbered: ``compiling kernel 8, once``. The line is redrawn
on a terminal and in a notebook; elsewhere the logger ``sarrus.compilation`` has it at level INFO from time to time. It
appears after a second of compilation. ``SARRUS_PROGRESS=0`` and `showing(False)` silence it.
"""

from __future__ import annotations

import logging
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from threading import Event, Lock, Thread
from typing import Any

from ...console import is_terminal, report

VARIABLE = "SARRUS_PROGRESS"
PATIENCE = 1.0  # s of compilation in this process before the line appears
PAUSE = 0.2  # s between two drawings
REPORTS = 20.0  # s between two messages where no line can be redrawn
LOGGER = logging.getLogger("sarrus.compilation")
_shown: ContextVar[bool | None] = ContextVar("shown", default=None)
_open = 0  # kernels that are being compiled


def allowed() -> bool:
    """Whether the environment allows progress to be shown."""
    return os.environ.get(VARIABLE, "").strip().lower() not in ("0", "no", "off", "false")


def is_shown() -> bool:
    """Whether progress is shown in this context."""
    return _shown.get() is not False and allowed()


def compiling() -> bool:
    """Whether a kernel is being compiled."""
    return _open > 0


@contextmanager
def showing(wanted: bool | None) -> Iterator[None]:
    """Show compilation in this context: True, on standard error also if that is no terminal; False, nowhere.

    With None the setting of an outer context is valid.
    """
    token = _shown.set(_shown.get() if wanted is None else wanted)
    try:
        yield
    finally:
        _shown.reset(token)


def missing(root: Any) -> list[Any]:
    """A kernel and those that it calls, without those that are compiled and what only those call."""
    found: dict[int, Any] = {}
    waiting = [root]
    while waiting:
        kernel = waiting.pop()
        if id(kernel) not in found and not kernel.overloads:
            found[id(kernel)] = kernel
            scope = kernel.py_func.__globals__
            names = kernel.py_func.__code__.co_names
            waiting += [scope[name] for name in names if hasattr(scope.get(name), "py_func")]
    return list(found.values())


class Compilation:
    """State of this process's compilation, shown in one line.

    Attributes
    ----------
    done : kernels compiled since the process began
    """

    def __init__(self) -> None:
        self.done = 0
        self._size = 0.0  # of code compiled
        self._spent = 0.0  # s of compilation until a kernel was ready, or the last one began
        self._moment = 0.0  # when that was
        self._reported = -REPORTS
        self._open: list[Any] = []
        self._calls = False  # whether the kernel that began first calls others that are compiled with it
        self._over, self._counting = Event(), Lock()
        self._watching: Thread | None = None

    def begin(self, kernel: Any) -> None:
        """The compilation of a kernel begins; those that it calls follow within it."""
        global _open
        _open += 1
        self._open.append(kernel)
        if len(self._open) > 1:
            return
        self._calls = len(missing(kernel)) > 1
        self._moment, self._over = time.perf_counter(), Event()
        if is_shown():
            self._watching = Thread(target=self._watch, args=(kernel, bool(_shown.get())), daemon=True)
            self._watching.start()

    def end(self, success: bool) -> None:
        """The compilation of the kernel that began last is over."""
        global _open
        _open -= 1
        now = time.perf_counter()
        self._spent, self._moment = self._spent + now - self._moment, now
        with self._counting:
            self._size += _size(self._open.pop())
            self.done += success
        if not self._open and self._watching is not None:
            self._over.set()
            self._watching.join()
            self._watching = None

    @contextmanager
    def waiting(self) -> Iterator[Callable[[float], None]]:
        """Yield the function that shows for how many seconds another process has been compiling the same kernel."""
        global _open
        live, drawn = redrawable(), False

        def show(seconds: float) -> None:
            nonlocal drawn
            if seconds > PATIENCE and not self._open and is_shown():
                drawn = True
                self._show(f"another process compiles a kernel, {seconds:.0f} s", live, bool(_shown.get()))

        _open += 1  # no other line is shown meanwhile
        try:
            yield show
        finally:
            _open -= 1
            if drawn and live:
                draw("")

    def text(self, root: Any) -> str:
        """The line while a kernel and what it calls are compiled; without a time once the estimate has passed."""
        with self._counting:
            done, rest = self.done, {*missing(root), *self._open}
        line = f"compiling kernel {done + bool(rest)}, once"
        if not self._calls:
            return line
        line = f"{line}; this call needs {max(len(rest) - 1, 0)} more"
        size = sum(map(_size, rest))
        left = self._spent * size / self._size - (time.perf_counter() - self._moment) if self._size else 0.0
        return f"{line}, {left:.0f} s left" if left >= 1 and len(rest) > 1 else line

    def _watch(self, root: Any, forced: bool) -> None:
        live, drawn = redrawable(), False
        pause = max(PATIENCE - self._spent, 0.0)
        while not self._over.wait(pause):
            self._show(self.text(root), live, forced)
            pause, drawn = PAUSE, True
        if drawn and live:
            draw("")

    def _show(self, text: str, live: bool, forced: bool) -> None:
        if live:
            draw(f"  {text}")
        elif time.perf_counter() - self._reported > REPORTS:
            self._reported = time.perf_counter()
            if forced:
                report(f"  {text}")
            else:
                LOGGER.info(text)


def _size(kernel: Any) -> int:
    """Size of the byte code, which the compilation time grows with."""
    return len(kernel.py_func.__code__.co_code)


def redrawable() -> bool:
    """Whether a line can be redrawn: on a terminal and in a notebook."""
    return is_terminal() or type(sys.stderr).__module__.startswith("ipykernel")


def draw(text: str) -> None:
    """The line in place of the one before; notebooks know no control sequence."""
    report("\r\033[K" + text if is_terminal() else f"\r{'':70}\r{text}", end="")
