"""Limits of time of tests, on machines of any speed: what a quiet one needs, times how much slower this one is now.

Where a limit guards against growth (a file twice as large takes four times as long), it is some five times what was
measured on a quiet machine; limits of time that a user sets are told by the clock.
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from contextlib import contextmanager

PACE = 0.009  # s of processor time for `_work` on a quiet machine
LATENESS = 3.0  # as many times as long by the clock, where other programs share the processors


def _work() -> None:
    """Objects, texts, numbers: what most of the time of a test goes into."""
    found = {f"name {k}": [k, {"value": k * 0.5}] for k in range(5_000)}
    json.loads(json.dumps(found))
    sorted(found, key=lambda name: name[::-1])


def _pace() -> float:
    start = time.process_time()
    _work()
    return time.process_time() - start


def _check(spent: float, seconds: float, paces: list[float]) -> None:
    slower = max(1.0, max(paces) / PACE)
    assert spent < seconds * slower, (
        f"{spent:.1f} s, on a machine that is {slower:.1f} times slower than usual"
    )


@contextmanager
def within(seconds: float) -> Iterator[None]:
    """Fail where a block takes more processor time than so many seconds of a quiet machine."""
    paces = [_pace()]
    start = time.process_time()
    yield
    spent = time.process_time() - start
    _check(spent, seconds, [*paces, _pace()])


@contextmanager
def within_by_the_clock(seconds: float) -> Iterator[None]:
    """The same of the time by the clock, for what waits or works in other processes."""
    paces = [_pace()]
    start = time.perf_counter()
    yield
    spent = time.perf_counter() - start
    _check(spent, seconds * LATENESS, [*paces, _pace()])
