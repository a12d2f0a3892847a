"""Positions near the motion where constraints are dependent, the constraints concerned, and undefined states."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ....algebra import Array
from ....model.errors import listed
from ....system import System
from ...redundancy.redundant_constraints import Independence
from ..dense_output.sample_loop import Samples
from ..stepping.failures import NEARLY, redundant_rows


class Nearness:
    """Positions of one run at which constraints were nearly dependent, among the states that are given out.

    It is seen by the growth of these states, see `sample_loop.growth_of`: far above the least one so far. Then the rows
    are looked for by singular values, once for every approach, where it is closest.

    Attributes
    ----------
    times : where each approach was closest [s]
    undefined : times of states with values that are not finite, which no such position explains [s]
    """

    def __init__(self, system: System, first: Independence) -> None:
        self._system, self._first = system, first
        self.times: list[float] = []
        self.undefined: list[float] = []
        self._rows: list[str] = []
        self._doubtful: list[float] = []
        self._least, self._most, self._t, self._q = np.inf, 0.0, 0.0, np.zeros(system.nq)

    def look(self, samples: Samples) -> None:
        """Take further states, in the order of time."""
        growth, undefined = samples.growth, _undefined(samples)
        self._least = min(self._least, growth.min(initial=np.inf))
        close, before = growth > self._least / NEARLY**2, -1
        self.undefined += samples.t[undefined & ~close].tolist()
        for n in np.flatnonzero(close).tolist():
            if n > before + 1:
                self._leave()
            if growth[n] > self._most:
                self._most, self._t, self._q = float(growth[n]), float(samples.t[n]), samples.q[n].copy()
            before = n
            if undefined[n]:
                self._doubtful.append(float(samples.t[n]))
        if len(close) and not close[-1]:
            self._leave()

    def _leave(self) -> None:
        rows = redundant_rows(self._system, self._q, self._t, self._first) if self._most else []
        if rows:
            self.times.append(self._t)
            self._rows = self._rows or rows
        else:
            self.undefined += self._doubtful
        self._most, self._doubtful = 0.0, []

    def message(self) -> str:
        """Return the addition to the message of a run that reached its end."""
        self._leave()
        if not self.times:
            return ""
        times = listed([f"{t:.6g}" for t in self.times])
        return (
            f"; near t = {times} s constraints are nearly dependent, among {listed(self._rows)}: the motion "
            "went on smoothly, multipliers there mean little"
        )

    def undefined_message(self) -> str:
        """Return a warning of undefined states, after `message`; empty if there are none."""
        if not self.undefined:
            return ""
        cause = (
            "a force is not a finite number, or accelerations are not determined there. Look for a root or a division "
            "by zero in the forces, or change the output times or rtol"
        )
        return (
            f"{self._system.name}: values are not finite at {len(self.undefined)} of the output times, the first t = "
            f"{min(self.undefined):.6g} s: {self._first.nearly or cause}."
        )

    def state(self) -> dict[str, Array]:
        """Return the data that a continued run needs."""
        numbers = np.array([self._least, self._most, self._t])
        found = {"near_times": np.array(self.times), "near_rows": np.array(self._rows, dtype="U")}
        found |= {"undefined": np.array(self.undefined), "near_undefined": np.array(self._doubtful)}
        return found | {"near_numbers": numbers, "near_q": self._q}

    def resume(self, state: Mapping[str, Array]) -> None:
        """Go on from such a state."""
        self.times, self._rows = state["near_times"].tolist(), state["near_rows"].tolist()
        self.undefined, self._doubtful = state["undefined"].tolist(), state["near_undefined"].tolist()
        self._least, self._most, self._t = state["near_numbers"].tolist()
        self._q = state["near_q"]


def _undefined(samples: Samples) -> Array:
    """Which states have values that are not finite."""
    states = (samples.q, samples.v, samples.a, samples.lam)
    return np.asarray(~np.all([np.isfinite(x).all(axis=1) for x in states], axis=0))
