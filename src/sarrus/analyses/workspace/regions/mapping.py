"""A map under way: starts are found and curves traced until nothing new is found; it can be stopped and resumed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from ....algebra import Array
from ....model import Model, SarrusError
from ....model.checks.arguments import CHECKS
from ....results.maps.workspace import Component, Status, Verification, Workspace, inside, place_of
from ....system import System
from ...arguments import refuse_for_positions
from ..problem.arguments import functions, refuse_other
from ..problem.formulation import Limits, formulate, refuse_dependent
from ..problem.random_positions import Samples
from ..problem.rows import Problem
from ..problem.settle import allowed, constrained, reach, settle
from ..problem.watch import STARTS, Stop, reached, stopped
from ..tracing.curve import LONGEST
from ..tracing.explore import Branch, Explorer
from ..tracing.starts import Ray, Start, random_start
from .crossing import Crossing, crossing
from .region import Region, component_of, measured

REPEATS = 30  # starts in a row that lead to known curves, until a map counts as complete
MOST_STARTS = 600
ROUNDS = 4  # of tests, or of rays from positions outside, each after what the last one found is traced
DIRECTIONS = 6  # of rays from a position outside
CONFIDENCE = 0.95
BESIDE = 1e-4  # of a critical value: another one that is proposed


Asked = tuple[Model, tuple[Any, ...], Limits | None, Mapping[Any, float] | None]


def _refuse_counts(problem: Problem) -> None:
    name, freedoms = problem.system.name, problem.freedoms
    if len(problem.outputs) != 2:
        message = "See workspace_range for one, workspace_volume for three"
        raise SarrusError(f"output: a map has two outputs, got {len(problem.outputs)}. {message}.")
    if freedoms < 2:
        message = (
            f"{name}: {freedoms} degree{'s' * (freedoms != 1)} of freedom, so that two outputs cover no area"
        )
        raise SarrusError(f"{message}. Fix less, or ask for the range of one output (workspace_range).")


class StartSearch:
    """Random starts of curves, or of single points, until so many in a row lead to known ones.

    Parameters
    ----------
    problem : Problem
    seed : of all random numbers
    repeats : number of consecutive starts without anything new after which the search is complete

    Attributes
    ----------
    met : admissible positions
    in_a_row : number of the last starts that led to what was known
    stop : reason of an early end, if any
    """

    def __init__(self, problem: Problem, seed: int, repeats: int) -> None:
        self.problem, self.seed, self.repeats = problem, seed, repeats
        self.random, self.samples = np.random.default_rng(seed), Samples(problem, seed)
        self.met: list[Array] = []
        self.in_a_row = 0
        self.stop: Stop | None = None

    def take(self, start: Start) -> Literal["new", "known", "lost"]:
        """Take a start, unless what it leads to is known."""
        raise NotImplementedError

    def more(self) -> bool:
        """Make one more start; false if the search is complete, or there is no admissible position."""
        if self.in_a_row >= self.repeats or len(self.met) >= MOST_STARTS:
            return False
        q = next(self.samples, None)
        if q is not None:
            self.begin_at(q)
        return q is not None

    def begin_at(self, q: Array) -> None:
        """Start from an admissible position, alternately by a ray and by Newton's method on random equations."""
        self.met.append(q)
        reached(len(self.met), STARTS)
        by_ray = len(self.met) % 2 == 1 and self.problem.of_outputs
        start = self.ray(q) if by_ray else random_start(self.problem, q, self.random)
        led = "lost" if start is None else self.take(start)
        if led != "lost":
            self.in_a_row = 0 if led == "new" else self.in_a_row + 1

    def ray(self, q: Array) -> Start | None:
        """Return the end of a ray in a random direction."""
        angle = self.random.uniform(0.0, 2 * np.pi)
        return Ray(self.problem, q, np.array([np.cos(angle), np.sin(angle)])).end()

    def outcome(self, what: str, failure: str) -> tuple[Status, str]:
        """The status, and why: an early end, a failure, or the confidence that nothing is missing."""
        if self.stop:
            return self.stop.status, f"{self.stop.reason}, so that {what}s may be missing"
        if not self.met:
            failure = (
                "no position within the limits was found. Widen them, or check that they can be met together"
            )
        if failure:
            return "incomplete", failure
        share = 1 - (1 - CONFIDENCE) ** (1 / max(self.in_a_row, 1))
        message = (
            f"the last {self.in_a_row} starts found no new {what}: with {100 * CONFIDENCE:.0f} % confidence,"
        )
        return "mapped", f"{message} less than {share:.1%} of starts would find one"


class WorkspaceMap(StartSearch):
    """Incremental computation of a workspace: iterate over traced curves, stop at any time, and continue.

    Parameters
    ----------
    system, output, limits, fixed : see `sarrus.workspace`
    seed : of all random numbers
    repeats : number of consecutive starts without a new curve after which the map is complete
    longest : longest step along curves, without units; smaller values give more points

    Attributes
    ----------
    problem : the equations; `asked` what they were made of
    explorer : the graph of curves
    in_a_row : number of the last starts that led to known curves
    stop : reason of an early end, if any
    """

    def __init__(
        self,
        system: System,
        output: Iterable[Any],
        *,
        limits: Limits | None = None,
        fixed: Mapping[Any, float] | None = None,
        seed: int = 0,
        repeats: int = REPEATS,
        longest: float = LONGEST,
    ) -> None:
        refuse_for_positions(system, "WorkspaceMap")
        wanted = functions(output)
        for name, value in (("seed", seed), ("repeats", repeats), ("longest", longest)):
            CHECKS[name](name, value)
        problem = formulate(system, wanted, limits=limits, fixed=fixed)
        _refuse_counts(problem)
        refuse_dependent(problem)
        self.asked: Asked = (system.model, wanted, limits, fixed)
        self._begin(problem, seed, repeats, longest)

    def _begin(self, problem: Problem, seed: int, repeats: int, longest: float) -> None:
        super().__init__(problem, seed, repeats)
        self.explorer = Explorer(problem, longest=longest)
        self._crossed: list[tuple[Branch, Crossing]] = []  # the branches so far
        self._region: tuple[tuple[int, int, bool], Region] | None = None

    def options(self) -> dict[str, Any]:
        """The options of `sarrus.workspace` for the same map."""
        _, _, limits, fixed = self.asked
        own = {"seed": self.seed, "repeats": self.repeats, "longest": self.explorer.longest}
        return {"limits": limits, "fixed": fixed, **own}

    @classmethod
    def of(
        cls, problem: Problem, seed: int = 0, repeats: int = REPEATS, longest: float = LONGEST
    ) -> WorkspaceMap:
        """Return the map of a formulated problem."""
        found = cls.__new__(cls)
        found._begin(problem, seed, repeats, longest)
        return found

    def __iter__(self) -> Iterator[Branch]:
        return self

    def __next__(self) -> Branch:
        """The next curve, with new starts where the last are exhausted."""
        self.stop = None
        while True:
            for branch in self.explorer:
                return branch
            if self.explorer.endless or not self.more():
                raise StopIteration

    def run(self) -> WorkspaceMap:
        """Trace all curves."""
        for _ in self:
            pass
        return self

    def tried(self) -> WorkspaceMap:
        """Trace all curves until the time limit passes or the user interrupts."""
        self.stop = stopped(self.run)
        return self

    def take(self, start: Start) -> Literal["new", "known", "lost"]:
        """Begin a curve at a start, unless it is on a known one."""
        return self.explorer.start(*start)

    def look_around(self, q: Array) -> None:
        """Trace what rays from a position outside lead to; if they find nothing new, its cell can be reached."""
        starts = [self.ray(q) for _ in range(DIRECTIONS)]
        led = [self.explorer.start(*start) for start in starts if start is not None]
        if "new" not in led:
            self.met.append(q)
        self.explorer.run()

    def position_at(self, place: ArrayLike) -> Array | None:
        """Return a position (nq,) with given outputs (2,) within all limits, or None."""
        p = self.problem
        known = [point.x[: p.n] for branch in self.branches for point in branch.points]
        target = place_of(place) / p.units[p.outputs]
        q = reach(p, target, np.array([*self.met, *known]), np.random.default_rng(self.seed))
        return None if q is None else q * p.scale

    @property
    def branches(self) -> list[Branch]:
        """The curves so far, without those of zero length."""
        return [branch for branch in self.explorer.branches if len(branch.points) > 1]

    @property
    def is_closed(self) -> bool:
        """Whether every curve so far ends where others begin, and is part of the boundary."""
        lost = self.explorer.open or any(branch.failure for branch in self.explorer.branches)
        return not lost and self.region().is_consistent

    def region(self) -> Region:
        """The plane divided by the curves so far."""
        branches = self.branches
        mark = (len(branches), len(self.met), self.stop is None)
        if self._region is None or self._region[0] != mark:
            known = {id(branch): found for branch, found in self._crossed}
            self._crossed = [(branch, known.get(id(branch)) or crossing(branch)) for branch in branches]
            found = [one for _, one in self._crossed]
            whole = self.stop is None
            region = Region(self.problem, branches, found, np.array(self.met), self.seed, whole)
            self._region = mark, region
        return self._region[1]

    def positions_outside(self) -> list[Array]:
        """Return known admissible positions outside of the region of the curves so far."""
        return self.region().positions_outside if self.branches else []

    def result(self, verification: Verification | None = None) -> Workspace:
        """Return the result so far."""
        p, region = self.problem, self.region()
        units, names = p.units[p.outputs], [p.table[k].name for k in p.limited]
        status, message = self._status(region, verification)
        one, other = (p.table[k] for k in p.outputs)
        known = status == "mapped"
        unit = float(units.prod()) if known else np.nan
        parts = tuple(component_of(part, units, known) for part in region.components())
        return Workspace(
            p.system.name,
            (one.title, other.title),
            (one.unit, other.unit),
            tuple(region.curves(names)),
            region.area * unit,
            region.area_error() * unit,
            measured(region.perimeter, units) if known else np.nan,
            parts,
            self._drawn(parts),
            status,
            message,
            verification,
            self,
        )

    def _drawn(self, parts: Sequence[Component]) -> int | None:
        """The part in which the model's own position lies."""
        p = self.problem
        q = settle(p, p.system.q0 / p.scale, *constrained(p))
        if q is None or not allowed(p, q):
            return None
        place = (p.values(q)[p.m + p.outputs] * p.units[p.outputs])[None]
        return next((n for n, part in enumerate(parts) if inside(list(part.loops), place)[0]), None)

    def _status(self, region: Region, tests: Verification | None) -> tuple[Status, str]:
        status, message = self.outcome("curve", "" if self.stop else self._failure(region, tests))
        more = ". Go on with its `map`, or allow more time" if self.stop else ""
        if status == "mapped":
            message = f"mapped. {message[0].upper()}{message[1:]}"
        return status, f"{self.problem.system.name}: {message}{more}"

    def _failure(self, region: Region, tests: Verification | None) -> str:
        """Return the reason why a map is not complete."""
        branches = self.explorer.branches
        lost = [branch.failure for branch in branches if branch.failure]
        if self.explorer.endless:
            return self._endless()
        if not branches:
            return "no boundary curve was found. Check that a limit or a singularity ends it"
        if self.explorer.open or self.in_a_row < self.repeats:
            return "the map is not complete. Go on with it, or give it more starts"
        if lost:
            message = f"{len(lost)} of {len(branches)} curves were lost, the first because {lost[0]}"
            return f"{message}. Use smaller steps (`longest`)"
        if not region.is_consistent:
            return "the boundary curves are inconsistent. Use smaller steps (`longest`)"
        failed = tests is not None and not tests.success
        return "a test failed. See the verification" if failed else ""

    def _endless(self) -> str:
        """Where a function is held at a critical value: the mechanism is singular on a whole curve."""
        p = self.problem
        held = [(p.table[k].name, p.fixed[k]) for k in p.fixed if k not in p.locked]
        message = "the mechanism is singular on whole curves of configurations, where boundary curves cross without end"
        if not held:
            return f"{message}. Change its dimensions a little, or map other outputs"
        name, value = held[-1]
        beside = value + BESIDE * (abs(value) or p.size)
        return f"{message}: {name} = {value:.9g} is a critical value. Fix it beside, such as at {beside:.9g}"


def map_of(found: Any) -> WorkspaceMap:
    """The map that a workspace was made from.

    Raises
    ------
    TypeError
        For something else than a workspace.
    """
    refuse_other(found, Workspace, complete=False)
    assert isinstance(found.map, WorkspaceMap)
    return found.map
