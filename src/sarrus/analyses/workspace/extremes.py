"""Critical values of one output: positions at which it stands still against all motions that limits allow."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import pairwise
from typing import Any

import numpy as np

from ...algebra import Array
from ...model import SarrusError, reports_warnings
from ...results.workspace_range import CriticalValue, WorkspaceRange
from ...system import System
from ..misuse import refuse_other_system
from ..threads import one_thread_if_small
from .crossing import examine
from .formulate import Limits, formulate
from .mapping import CONFIDENCE, MOST_STARTS, REPEATS
from .newton import Tally
from .problem import Problem
from .ray import Ray
from .reach import reach
from .same import SAME, apart
from .sample import Samples
from .seeds import Start, random_start
from .stratum import Stratum

ONE = 1e-7  # free of units: nearer values are one
MOST_ALIKE = 8  # positions with one value and the same active limits that are kept
TRIES = 20


@reports_warnings
@one_thread_if_small
def workspace_range(
    system: System,
    output: Any,
    *,
    limits: Limits | None = None,
    fixed: Mapping[Any, float] | None = None,
    seed: int = 0,
    repeats: int = REPEATS,
    strict: bool = False,
) -> WorkspaceRange:
    """The values that one output can take: from where it stops to where it stops.

    Parameters
    ----------
    system, limits, fixed, seed, repeats : see `sarrus.workspace`
    output : one function of the position, such as ``"slider.x"``
    strict : raise the first warning as a `StrictError`

    Returns
    -------
    WorkspaceRange

    Raises
    ------
    SarrusError
        If a name is unknown or the mechanism cannot be assembled within its limits.
    """
    refuse_other_system(system, "workspace_range")
    outputs: Iterable[Any] = output if isinstance(output, tuple | list) else (output,)
    problem = formulate(system, outputs, limits=limits, fixed=fixed)
    if len(problem.outputs) != 1:
        raise SarrusError(f"a range is of one output, not {len(problem.outputs)}; see workspace for two")
    return Search(problem, seed, repeats).result()


class Search:
    """Random starts until nothing new is found."""

    def __init__(self, problem: Problem, seed: int, repeats: int) -> None:
        self.problem, self.seed = problem, seed
        self.found: list[Start] = []
        self.met: list[Array] = []
        random, tally, self.in_a_row = np.random.default_rng(seed), Tally(), 0
        for _, q in zip(range(MOST_STARTS), Samples(problem, seed), strict=False):
            self.met.append(q)
            direction = np.array([random.choice((-1.0, 1.0))])
            by_ray = len(self.met) % 2 == 1
            start = (
                Ray(problem, q, direction, tally).end() if by_ray else random_start(problem, q, random, tally)
            )
            if start is not None:
                self.in_a_row = 0 if self._is_new(start) else self.in_a_row + 1
            if self.in_a_row >= repeats:
                break
        self.complete = self.in_a_row >= repeats

    def _is_new(self, start: Start) -> bool:
        """Whether it is another position; one of a family of positions with the same value tells nothing new."""
        n, value = self.problem.n, self._value(start.x[: self.problem.n])
        alike = [one for one in self.found if one.key == start.key]
        if any(apart(one.x[:n], start.x[:n]) < SAME for one in alike):
            return False
        family = [one for one in alike if abs(self._value(one.x[:n]) - value) < ONE]
        if len(family) < MOST_ALIKE:
            self.found.append(start)
        return not family

    def _value(self, q: Array) -> float:
        return float(self.problem.values(q)[self.problem.m + self.problem.outputs[0]])

    def values(self) -> list[float]:
        """Of the output at all critical positions, free of units."""
        return [self._value(start.x[: self.problem.n]) for start in self.found]

    def result(self) -> WorkspaceRange:
        """The intervals that can be reached, with their ends."""
        p, critical = self.problem, self._critical()
        one = p.table[p.outputs[0]]
        ends = _different([each.value for each in critical], ONE * p.units[p.outputs[0]])
        can = [self._can(low, high, critical) for low, high in pairwise(ends)]
        return WorkspaceRange(
            p.system.name,
            one.name,
            "rad" if one.kind == "angle" else "m",
            _merged(ends, can),
            tuple(critical),
            "mapped" if self.complete and self.found else "incomplete",
            self._message(),
            self,
        )

    def _message(self) -> str:
        if not self.found:
            return "No end was found; is there a limit or a singularity at all?"
        share = 1 - (1 - CONFIDENCE) ** (1 / max(self.in_a_row, 1))
        told = f"The last {self.in_a_row} starts led to nothing new, so with {CONFIDENCE:.0%} confidence"
        return f"{told} ends that were missed attract less than {share:.1%} of starts"

    def _critical(self) -> list[CriticalValue]:
        found = [self._one(start) for start in self.found]
        return sorted(found, key=lambda one: one.value)

    def _one(self, start: Start) -> CriticalValue:
        p, stratum = self.problem, Stratum(self.problem, start.key)
        seen, q = examine(stratum, start.x), start.x[: self.problem.n]
        active = tuple(
            f"{p.table[p.limited[i]].name} {('lowest', 'highest')[end]}" for i, end in stratum.active
        )
        side = int(seen.side * np.sign(start.x[-1]))
        value = self._value(q) * p.units[p.outputs[0]]
        return CriticalValue(float(value), side, active, stratum.dimension > 0, q * p.scale, seen.sure)

    def _can(self, low: float, high: float, critical: list[CriticalValue]) -> bool:
        """Whether values between two neighbouring critical ones can be reached."""
        near = 1e-9 * (1 + abs(low) + abs(high))
        told = [c for c in critical if c.sure]
        if any(c.side >= 0 and abs(c.value - low) < near for c in told):
            return True
        if any(c.side <= 0 and abs(c.value - high) < near for c in told):
            return True
        unit = float(self.problem.units[self.problem.outputs[0]])
        inside = [low < self._value(q) * unit < high for q in self.met]
        target = np.array([0.5 * (low + high) / unit])
        random = np.random.default_rng(self.seed)
        return any(inside) or reach(self.problem, target, np.array(self.met), TRIES, random) is not None


def _different(values: list[float], near: float) -> list[float]:
    found: list[float] = []
    for value in sorted(values):
        if not found or value - found[-1] > near:
            found.append(value)
    return found


def _merged(ends: list[float], can: list[bool]) -> tuple[tuple[float, float], ...]:
    """Neighbouring intervals that can be reached, joined."""
    found: list[tuple[float, float]] = []
    for low, high, ok in zip(ends, ends[1:], can, strict=False):
        if ok and found and found[-1][1] == low:
            found[-1] = (found[-1][0], high)
        elif ok:
            found.append((low, high))
    return tuple(found)
