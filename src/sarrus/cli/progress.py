"""A progress bar on the terminal; in a file or pipe, one line when it begins and one when it is done."""

from __future__ import annotations

import time
from contextlib import ExitStack
from types import TracebackType

from .._jit.linking.compilation import allowed
from ..activity import activity
from ..console import is_terminal, report
from .terminal import is_quiet

WIDTH = 28


class Bar:
    """``with Bar("compiling kernels", 30) as bar: bar.step("Phi_q")``."""

    def __init__(self, title: str, total: float) -> None:
        self.title, self.total = title, total
        self._done, self._start, self._shown = 0.0, time.perf_counter(), 0.0
        self._inner = ExitStack()
        self._quiet = is_quiet() or not allowed()
        self._live = is_terminal() and not self._quiet

    def __enter__(self) -> Bar:
        self._inner.enter_context(activity(None))  # analyses within it have no bars of their own
        self._show("")
        if not self._live and not self._quiet:
            report(f"  {self.title} ...")
        return self

    def __exit__(self, kind: type[BaseException] | None, value: object, trace: TracebackType | None) -> None:
        self._inner.close()
        if self._live:
            report("\r\033[K", end="")
        if self._quiet:
            return
        taken = time.perf_counter() - self._start
        report(f"  {self.title}: {'stopped after' if kind else 'done in'} {taken:.1f} s")

    def step(self, what: str = "") -> None:
        """Report that the next of `total` steps begins."""
        self._show(what)
        self._done += 1

    def reach(self, value: float) -> None:
        """So much of `total` is done."""
        self._done = value
        if time.perf_counter() - self._shown > 0.1:
            self._show("")

    def _show(self, what: str) -> None:
        if self._live:
            full = min(int(WIDTH * self._done / self.total), WIDTH)
            bar = "█" * full + "·" * (WIDTH - full)
            report(f"\r\033[K  {self.title} {bar} {what or self._to_go()}", end="")
            self._shown = time.perf_counter()

    def _to_go(self) -> str:
        """The time that is left, once a tenth is done."""
        part = self._done / self.total
        if not 0.1 <= part < 1:
            return ""
        return f"{(time.perf_counter() - self._start) * (1 - part) / part:.0f} s to go"
