"""Runs of one problem by Sarrus and by Exudyn, in turns: processor seconds, steps, and the error at the end."""

from __future__ import annotations

import time
import tracemalloc
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from dynamics_problems import Problem
from exudyn_told import Exudyn, Told

import sarrus as sr

REPEATS, ENOUGH = 15, 0.1  # most runs in a turn; s, after which there is none more
ROUNDS = 2  # turns of each code
MORE, TRIES = 1.05, 4  # steps, where as many are wanted as an error asks for; how often still more are tried
CHANGE = 0.01  # of the error: what a looser Newton's method may change in the end
OURS = (1e-8, 1e-7, 1e-6, 1e-5)  # tolerances that decide, with equal steps, how far Newton's method goes
THEIRS = (  # their default first
    {"relativeTolerance": 1e-8, "absoluteTolerance": 1e-10},
    {"relativeTolerance": 1e-6, "absoluteTolerance": 1e-8},
    {"relativeTolerance": 1e-4, "absoluteTolerance": 1e-6},
)
LARGE = 500  # coordinates above which the dense solver of Exudyn is not tried
METHODS = (sr.GeneralizedAlpha(0.9), sr.GeneralizedAlpha(0.9, stabilized=True), sr.Radau())


class Run(NamedTuple):
    """What a run took, with what settings, and its error: the largest distance of a point from the reference [m]."""

    seconds: float
    steps: int
    error: float
    told: str
    end: Any = None  # the points

    @property
    def microseconds_a_step(self) -> float:
        return 1e6 * self.seconds / max(self.steps, 1)

    def as_dict(self) -> dict[str, Any]:
        return {
            **self._asdict(),
            "end": np.ravel(self.end).tolist(),
            "microseconds_a_step": self.microseconds_a_step,
        }


class Compared:
    """One problem: its reference, and all runs of both codes."""

    def __init__(self, problem: Problem, python: str | None) -> None:
        self.problem, self.reference = problem, problem.known
        self.agreement = self._find_reference() if problem.referenced else None
        self.peer = (
            Exudyn(python, Told(problem.system, problem.start, problem.points, problem.others))
            if python
            else None
        )
        self._solvers = ("sparse",) if problem.system.nq > LARGE else ("dense", "sparse")

    def _find_reference(self) -> float:
        """By `Radau` at 1e-10 if none is known, and how far away it is at 1e-9."""
        ends = [self._simulated(sr.Radau(), tol, self.problem.stops)[1] for tol in (1e-9, 1e-10)]
        self.reference = ends[1] if self.reference is None else np.array(self.reference)
        return distance(ends[0] - self.reference)

    def _simulated(
        self, method: Any, tol: float, stops: Iterable[float] = ()
    ) -> tuple[sr.Trajectory, Any, float]:
        p = self.problem
        began = time.process_time()
        run = sr.simulate(
            p.system, p.start, until=p.until, t_eval=[p.until],
            method=replace(method, rtol=tol, atol=tol, max_step=p.longest), events=tuple(stops),
        )  # fmt: skip
        taken = time.process_time() - began
        return run, p.end(run) if run.success else np.full(3 * len(p.points), np.nan), taken

    def error(self, end: Any) -> float:
        return np.nan if self.reference is None else distance(np.asarray(end) - self.reference)

    def ours(self, method: Any, tol: float) -> Run:
        """One run of Sarrus."""
        run, end, taken = self._simulated(method, tol)
        return Run(taken, run.nsteps, self.error(end), f"{method!r}, {tol:g}", end)

    def theirs(self, steps: int, solver: str, newton: dict[str, float]) -> Run:
        """One run of Exudyn."""
        assert self.peer
        found = self.peer.run(steps=steps, until=self.problem.until, solver=solver, newton=newton)
        if "trouble" in found:
            return Run(np.inf, steps, np.inf, found["trouble"])
        told = f"{solver}, Newton's method to {newton['relativeTolerance']:g}"
        end = np.concatenate(found["end"])
        return Run(found["seconds"], steps, self.error(end), told, end)

    def equal_steps(self, steps: int) -> tuple[Run, Run | None, Run | None]:
        """Both codes with so many equal steps, in turns, each with the loosest Newton's method that does as well.

        The third is the first run of Exudyn with its own tolerances.
        """
        method = sr.GeneralizedAlpha(0.9, step=self.problem.until / steps)
        mine: list[Callable[[], Run]] = [lambda t=t: self.ours(method, t) for t in OURS]
        other: list[Callable[[], Run]] = []
        if self.peer:
            other = [lambda s=s, n=n: self.theirs(steps, s, n) for n in THEIRS for s in self._solvers]
        tried = [[(quickest(run), run) for run in code] for code in (mine, other) if code]
        chosen = [as_good(code) for code in tried]
        again = [[quickest(run) for _, run in chosen] for _ in range(ROUNDS - 1)]
        best = [least([first, *(turn[k] for turn in again)]) for k, (first, _) in enumerate(chosen)]
        if not self.peer:
            return best[0], None, None
        return best[0], best[1], least(run for run, _ in tried[1][: len(self._solvers)])

    def variable_steps(self) -> Iterator[Run]:
        """All methods with steps that they choose."""
        if self.reference is not None:
            for method in METHODS:
                for tol in self.problem.tolerances:
                    yield quickest(lambda m=method, t=tol: self.ours(m, t))

    def memory(self) -> float:
        """The most that a run of two steps has allocated, for each body."""
        p = self.problem
        end, method = p.until / 100, sr.GeneralizedAlpha(0.9, step=p.until / 200)
        tracemalloc.start()
        sr.simulate(p.system, p.start, until=end, t_eval=[end], method=method)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return peak / len(p.system.bodies)

    def found(self) -> dict[str, Any]:
        """Everything, for print and ratios."""
        p = self.problem
        self.ours(sr.GeneralizedAlpha(0.9, step=p.until / p.steps[0]), OURS[0])  # compiled, or found
        rows = [(steps, *self.equal_steps(steps)) for steps in p.steps]
        equal = [
            {
                "steps": steps,
                "sarrus": mine.as_dict(),
                "exudyn": _dict(other),
                "exudyn_as_it_comes": _dict(usual),
            }
            for steps, mine, other, usual in rows
        ]
        alone = [run for row in rows for run in self._as_exact(*row[:3])]
        free = [run.as_dict() for run in (*alone, *self.variable_steps())]
        if self.peer:
            self.peer.close()
        told = {"problem": p.name, "coordinates": p.system.nq, "reference_to": self.agreement}
        return {**told, "equal_steps": equal, "sarrus_alone": free}

    def _as_exact(self, steps: int, mine: Run, other: Run | None) -> list[Run]:
        """With as many equal steps as Sarrus needs for the error of Exudyn: as order 2 lets expect, else some more."""
        found: list[Run] = []
        if other is None or not other.error < mine.error < np.inf:
            return found
        more = MORE * steps * (mine.error / other.error) ** 0.5
        for _ in range(TRIES):
            method = sr.GeneralizedAlpha(0.9, step=self.problem.until / np.ceil(more))
            found += [quickest(lambda m=method, t=t: self.ours(m, t)) for t in OURS[1:3]]
            if min(run.error for run in found) <= other.error:
                break
            more *= 1.25
        return found


def _dict(run: Run | None) -> dict[str, Any] | None:
    return run.as_dict() if run else None


def distance(apart: Any) -> float:
    """The largest over all points."""
    return float(np.linalg.norm(np.reshape(apart, (-1, 3)), axis=1).max())


def least(runs: Iterable[Run]) -> Run:
    return min(runs, key=lambda run: run.seconds)


def quickest(run: Callable[[], Run]) -> Run:
    """The quickest of some runs, one after another, which warms the caches for both codes."""
    found = [run()]
    while len(found) < REPEATS and sum(one.seconds for one in found) < ENOUGH:
        found.append(run())
    return least(found)


def as_good(runs: list[tuple[Run, Callable[[], Run]]]) -> tuple[Run, Callable[[], Run]]:
    """The quickest whose end is that of the first, with the tightest tolerance, but for a part of its error."""
    first = runs[0][0]
    limit = CHANGE * (first.error if first.error > 0 else 1e-5)  # m, where there is no reference

    def same(run: Run) -> bool:
        return run is first or (np.isfinite(run.seconds) and distance(run.end - first.end) <= limit)

    return min((pair for pair in runs if same(pair[0])), key=lambda pair: pair[0].seconds)
