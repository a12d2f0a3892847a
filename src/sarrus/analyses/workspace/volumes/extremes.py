"""Critical values of one output: positions at which it is stationary for all motions that limits allow."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import groupby, pairwise
from typing import Any, Literal

import numpy as np

from ....algebra import Array
from ....linalg.threads import one_thread_if_small
from ....model import SarrusError
from ....model.announcement import announce, reports_warnings
from ....results.maps.workspace import TRACED
from ....results.maps.workspace_volume import CriticalValue, WorkspaceRange
from ....system import System
from ...arguments import refuse_for_positions
from ...progress import Progress
from ..problem.arguments import functions
from ..problem.formulation import Limits, formulate, refuse_dependent
from ..problem.rows import Problem
from ..problem.settle import reach
from ..problem.watch import STARTS, stopped, watched
from ..regions.crossing import examine
from ..regions.mapping import REPEATS, StartSearch
from ..tracing.starts import Ray, Start
from ..tracing.stratum import SAME, Stratum, apart

MOST_ALIKE = 8  # positions stored with one value and the same active limits


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
    progress: bool | Progress | None = None,
    time_limit: float | None = None,
) -> WorkspaceRange:
    """Compute the intervals of values that one output can reach, and what limits them.

    Parameters
    ----------
    system, limits, fixed, seed, repeats : see `sarrus.workspace`
    output : one function of the position, such as ``"slider.x"``
    progress : True for a line on the terminal, or a function that is called with the number of starts so far
    time_limit : seconds of the clock after which it ends with the status "time limit" and what was found

    Returns
    -------
    WorkspaceRange

    Raises
    ------
    SarrusError
        If a name is unknown or the mechanism cannot be assembled within its limits.
    """
    refuse_for_positions(system, "workspace_range")
    problem = formulate(system, functions(output), limits=limits, fixed=fixed)
    if len(problem.outputs) != 1:
        raise SarrusError(
            f"output: a range has one output, got {len(problem.outputs)}. See workspace for two."
        )
    refuse_dependent(problem)
    search = Extremes(problem, seed, repeats)
    with watched(progress, done="tried", unit=STARTS, time_limit=time_limit):
        search.stop = stopped(search.run)
    found = search.result()
    if not found.success:
        announce([f"{system.name}: the range of {found.output} is not complete. {found.message}."])
    return found


class Extremes(StartSearch):
    """The critical positions of one output; see `StartSearch`.

    Attributes
    ----------
    found : at most `MOST_ALIKE` of each family of positions with one value and the same active limits
    """

    def __init__(self, problem: Problem, seed: int, repeats: int) -> None:
        super().__init__(problem, seed, repeats)
        self.found: list[Start] = []

    def run(self) -> None:
        """Search until nothing new is found."""
        while self.more():
            pass

    def begin_at(self, q: Array) -> None:
        """Start from an admissible position; the direction of a ray is drawn at every start."""
        self._direction = self.random.choice((-1.0, 1.0), size=1)
        super().begin_at(q)

    def ray(self, q: Array) -> Start | None:
        """Return the end of a ray towards higher or lower values."""
        return Ray(self.problem, q, self._direction).end()

    def take(self, start: Start) -> Literal["new", "known"]:
        """Keep another position; one of a family of positions with the same value adds nothing."""
        n, value = self.problem.n, self._value(start.x[: self.problem.n])
        alike = [one for one in self.found if one.key == start.key]
        if any(apart(one.x[:n], start.x[:n]) < SAME for one in alike):
            return "known"
        family = [one for one in alike if abs(self._value(one.x[:n]) - value) < TRACED]
        if len(family) < MOST_ALIKE:
            self.found.append(start)
        return "known" if family else "new"

    def _value(self, q: Array) -> float:
        return float(self.problem.values(q)[self.problem.m + self.problem.outputs[0]])

    def values(self) -> list[float]:
        """Return the values of the output at all critical positions, without units."""
        return [self._value(start.x[: self.problem.n]) for start in self.found]

    def result(self) -> WorkspaceRange:
        """The intervals that can be reached, with their ends."""
        p, critical = self.problem, sorted(map(self._critical, self.found), key=lambda one: one.value)
        one = p.table[p.outputs[0]]
        ends = distinct([each.value for each in critical], TRACED * p.units[p.outputs[0]])
        can = [self._can(low, high, critical) for low, high in pairwise(ends)]
        few = f"{len(self.met)} starts found {len(self.found)} ends, too few. Check that limits or singularities end it"
        status, message = self.outcome("end", "" if self.in_a_row >= self.repeats else few)
        return WorkspaceRange(
            p.system.name,
            one.title,
            "rad" if one.kind == "angle" else "m",
            _merged(ends, can),
            tuple(critical),
            status,
            f"{message[0].upper()}{message[1:]}",
            self,
        )

    def _critical(self, start: Start) -> CriticalValue:
        p, stratum = self.problem, Stratum(self.problem, start.key)
        seen, q = examine(stratum, start.x), start.x[: self.problem.n]
        active = tuple(limit_names(p, stratum.active))
        side = int(seen.side * np.sign(start.x[-1]))
        value = self._value(q) * p.units[p.outputs[0]]
        return CriticalValue(float(value), side, active, stratum.dimension > 0, q * p.scale, seen.sure)

    def _can(self, low: float, high: float, critical: list[CriticalValue]) -> bool:
        """Whether values between two neighbouring critical ones can be reached."""
        near = 1e-9 * (1 + abs(low) + abs(high))
        below = [c for c in critical if abs(c.value - low) < near]
        above = [c for c in critical if abs(c.value - high) < near]
        if any(c.sure and c.side >= 0 for c in below) or any(c.sure and c.side <= 0 for c in above):
            return True
        unit = float(self.problem.units[self.problem.outputs[0]])
        if any(low < self._value(q) * unit < high for q in self.met):
            return True
        target, random = np.array([0.5 * (low + high) / unit]), np.random.default_rng(self.seed)
        doubtful = not all(c.sure for c in (*below, *above))
        return doubtful and reach(self.problem, target, np.array(self.met), random) is not None


def limit_names(problem: Problem, active: Iterable[tuple[int, int]]) -> list[str]:
    """Active limits by name, such as "q1.angle lowest"."""
    return [f"{problem.table[problem.limited[i]].name} {('lowest', 'highest')[end]}" for i, end in active]


def distinct(values: Iterable[float], near: float) -> list[float]:
    """Values by size that are not near to the one before."""
    found: list[float] = []
    for value in sorted(values):
        if not found or value - found[-1] > near:
            found.append(value)
    return found


def _merged(ends: list[float], can: list[bool]) -> tuple[tuple[float, float], ...]:
    """Neighbouring intervals that can be reached, joined."""
    runs = groupby(zip(pairwise(ends), can, strict=True), key=lambda one: one[1])
    spans = [[pair for pair, _ in run] for reached, run in runs if reached]
    return tuple((span[0][0], span[-1][1]) for span in spans)


def search_of(found: WorkspaceRange) -> Extremes:
    """The search that found a range."""
    assert isinstance(found.search, Extremes)
    return found.search
