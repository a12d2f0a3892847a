"""Positions where constraints are dependent: at the start of a run and near its motion; undefined states."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ....algebra import Array
from ....model.errors import listed
from ....results import Assembly
from ....system import System
from ....system.cached import once
from ...redundancy.degrees_of_freedom import STRAIGHT, largest_curvature
from ...redundancy.redundant_constraints import Independence
from ..dense_output.sample_loop import Samples
from ..stepping.failures import NEARLY, redundant_rows
from ..stepping.stepper import RunPart

PROBES = 3  # random motions and combinations of equations: one alone could miss by chance


class Nearness(RunPart):
    """Positions of one run at which constraints were nearly dependent, among the states that are given out.

    It is seen by the growth of these states, see `sample_loop.growth_of`: far above the least one so far. Then the rows
    are looked for by singular values, once for every approach, where it is closest.

    Attributes
    ----------
    times : where each approach was closest [s]
    undefined : times of states with values that are not finite, which no such position explains [s]
    """

    VARIABLES = "times", "undefined", "_rows", "_doubtful", "_least", "_most", "_t", "_q"

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


def _undefined(samples: Samples) -> Array:
    """Which states have values that are not finite."""
    states = (samples.q, samples.v, samples.a, samples.lam)
    return np.asarray(~np.all([np.isfinite(x).all(axis=1) for x in states], axis=0))


def initial_warnings(system: System, start: Assembly, first: Independence) -> Iterator[str]:
    """Yield what a user should know before a run from this state."""
    t = start.asked.t if start.asked else 0.0
    freedom = system.nq - system.m + first.known
    if first.nearly:
        yield f"{system.name}: {first.nearly}."
    if freedom == 0 and not driven(system):
        yield (
            f"{system.name}: nothing can move, since the model has no degrees of freedom and no driver. Remove "
            "constraints, or use `equilibrium` for the forces in a structure."
        )
    elif freedom and first.known and rank_changes(system, start.q, t, first):
        yield (
            f"{system.name}: the constraints lose rank in the initial configuration: it has {freedom} degree"
            f"{'' if freedom == 1 else 's'} of freedom there and fewer nearby, and the motion may follow any branch. "
            "Start from another configuration."
        )


@once
def driven(system: System) -> bool:
    """Whether a constraint depends on time."""
    return any(p.count and p.kind.rows and p.kind.timed for p in system.populations)


def rank_changes(system: System, q: Array, t: float, first: Independence) -> bool:
    """Whether the rank of Φ_q changes along some motion that is possible at a position.

    It does not if ηᵀ (Φ_qᵀ n)_q ξ = 0 for all motions ξ and η and all combinations n of equations with nᵀΦ_q = 0, which
    is tried for random ones.
    """
    random, unit = np.random.default_rng(0), system.layout.scales(first.length)
    sizes = first.row_lengths(q, t)
    curvature = largest_curvature(system, q, t, sizes, unit) or 1.0
    for _ in range(PROBES):
        n = first.vanishing(q, t, random)
        n = n / np.linalg.norm(n * sizes)
        xi, eta = (xi / np.linalg.norm(xi / unit) for xi in first.motions(q, t, unit, random))
        if abs(eta @ (system.Phi_qT_lam_q(q, n, t) @ xi)) > STRAIGHT * curvature:
            return True
    return False
