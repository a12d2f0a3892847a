"""Forward dynamics and its derivatives, of a chain of seven joints: calls from Python and from Numba code.

    python -m benchmarks.forward_dynamics

Least processor time of a call in several batches; the difference is what Python adds. Also allocations in Numba code.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from typing import Any

os.environ["NUMBA_NRT_STATS"] = "1"

import numpy as np
from benchmarks.linearize import JOINTS, arm
from numba import njit
from numba.core.runtime import rtsys

import sarrus as sr

BATCHES, CALLS = 30, 500
WRT = ["link3.mass", "joint4.point.x"]


def in_python(call: Callable[[], object]) -> Callable[[int], None]:
    """Calls from Python."""

    def batch(count: int) -> None:
        for _ in range(count):
            call()

    return batch


def in_numba(function: Any, data: Any, arguments: tuple[Any, ...]) -> Callable[[int], None]:
    """The same calls from Numba code.

    Raises
    ------
    AssertionError
        If they allocate memory.
    """

    @njit
    def calls(count: int, data: Any, arguments: Any) -> None:
        for _ in range(count):
            function(data, *arguments)

    calls(2, data, arguments)
    before = rtsys.get_allocation_stats().alloc
    calls(CALLS, data, arguments)
    assert rtsys.get_allocation_stats().alloc - before < CALLS / 10
    return lambda count: calls(count, data, arguments)


def least(*batches: Callable[[int], None]) -> list[float]:
    """The least processor time of a call of each kind [µs], in batches that alternate."""
    found = [np.inf] * len(batches)
    for _ in range(BATCHES):
        for k, batch in enumerate(batches):
            began = time.process_time()
            batch(CALLS)
            found[k] = min(found[k], 1e6 * (time.process_time() - began) / CALLS)
    return found


def main() -> None:
    """The table of the documentation."""
    system = arm()
    start = sr.assemble(system, rates={"joint0": 0.3, "joint3": -0.2})
    q, v, b = start.q.copy(), start.v.copy(), system.b
    a, lam, f = np.zeros(system.nq), np.zeros(system.m), system.forward_dynamics
    names, state = [f"joint{k}.angle" for k in range(JOINTS)], (1e-3, b, 0.0, q, v)
    independent = f.in_coordinates(names)
    rates = np.zeros(len(independent.states))
    rows: list[tuple[str, Callable[[], object], Any, tuple[Any, ...]]] = [
        ("a, λ", lambda: f(q, v), f, (*state, a, lam)),
        (
            "rates in independent coordinates",
            lambda: independent.rates(q, v),
            independent.rates,
            (*state, rates),
        ),
    ]
    for wrt in ((), WRT):
        one, more = f.differentiated(wrt), f.in_coordinates(names, wrt)
        every, of = np.zeros((len(a) + len(lam), 1 + 2 * len(q) + len(wrt))), f"{len(wrt)} parameters"
        rows.append((f"derivatives, {of}", lambda one=one: one(q, v), one, (*state, every)))
        rows.append((f"A, B and E, {of}", lambda more=more: more(q, v), more, state))
    for title, call, function, arguments in rows:
        call()
        times = least(in_python(call), in_numba(function.function, function.data, arguments))
        print(
            f"{title}: {times[0]:.1f} µs from Python, {times[1]:.1f} from Numba, {times[0] - times[1]:.1f} between"
        )


if __name__ == "__main__":
    main()
