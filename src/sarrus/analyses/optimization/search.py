"""Objective and constraints as a solver sees them: scaled variables, a barrier where no simulation succeeds."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from copy import copy
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from ... import console
from ..._jit.linking.compilation import showing
from ...activity import activity
from ...algebra import Array
from ...model.announcement import announce
from ...model.checks.arguments import Number, in_si
from ...model.quantity import is_list
from ...model.show import suggest
from ..progress import duration
from .constraint import Within, gap
from .point import DesignError, Point
from .problem import Problem

Pair = tuple[float | None, float | None]
Bounds = Mapping[str, Pair] | Sequence[Pair]
Report: TypeAlias = Callable[[int, float], None]
Progress: TypeAlias = Report | bool
PATIENCE = 25  # designs in a row that cannot be simulated before the search is given up
SLIGHT = 1e-3  # [-] of the objective's size: the least rise of the wall
ROUND_OFF = 1e-12  # [-] of the objective: a gradient that is the rounding of nothing
SMALL_GAP = 1e-7  # [-] of a limit, which a better design may miss: interior-point methods end so near
FIRST = 0.3  # [-] the scaled gradient at a start: solvers try a step of that size first, in sizes of the variables
PRESSING = 1e-3  # [-] of the gradient: the least size of an objective whose gradient is balanced by limits
log = logging.getLogger("sarrus.optimize")


class SearchFailure(Exception):
    """Too many designs in a row could not be simulated."""


class Gradients(NamedTuple):
    """At a design z (p,) the gradient of the objective (p,), and those of the constrained responses (c, p)."""

    z: Array
    slope: Array
    others: Array


def _by_name(names: Sequence[str], argument: str, values: Any) -> Mapping[str, Any]:
    """Bounds or scales by the names of the variables; a key is a name as in wrt, and a full name has priority."""
    if values is None:
        return {}
    named, each = isinstance(values, Mapping), "a pair (low, high)" if argument == "bounds" else "a size"
    if not (all(isinstance(key, str) for key in values) if named else is_list(values)):
        raise ValueError(
            f"{argument}: it is {values!r:.60}. Give {each} for each variable, or a dict by name."
        )
    if not named:
        if len(values) != len(names):
            message = f"{argument}: there are {len(values)} for {len(names)} variables."
            raise ValueError(f"{message} Give {each} for each, or a dict by name.")
        return dict(zip(names, values, strict=True))
    by_name: dict[str, Any] = {}
    for key in sorted(values, key=len):
        places = [key] if key in names else [name for name in names if name.startswith(f"{key}.")]
        if not places:
            raise ValueError(f"{argument}: {key!r} is no design variable. {suggest(key, names)}")
        by_name |= dict.fromkeys(places, values[key])
    return by_name


class Variables:
    """Design variables x and a solver's z = x / scale, between limits.

    Parameters
    ----------
    names, x0 : of the variables, and where they start
    bounds : lower and upper limits by name, None for none; or one pair for each variable, as SciPy has them
    scale : sizes by name; by default the value at the start, or half of the range where that is 0, or 1
    units : of the variables, for limits and sizes that are texts, "2 kN/m"

    Raises
    ------
    ValueError
        For limits or scales of unknown variables, and limits that are not in order.
    """

    def __init__(
        self,
        names: Sequence[str],
        x0: Array,
        bounds: Bounds | None,
        scale: Mapping[str, float] | None,
        units: Sequence[str] | None = None,
    ) -> None:
        self.names = tuple(names)
        if not names:
            raise ValueError(
                "wrt names no number that may change. Name at least one, or leave it out for all."
            )
        bounds, scale = _by_name(names, "bounds", bounds), _by_name(names, "scale", scale)
        unit_of = {name: unit or None for name, unit in zip(names, units or [""] * len(names), strict=True)}
        self.limits = np.array([_limit(name, bounds.get(name), unit_of[name]) for name in names]).reshape(
            -1, 2
        )
        self.x0 = np.clip(x0, self.limits[:, 0], self.limits[:, 1])
        for name, value, used in zip(names, x0, self.x0, strict=True):
            if value != used:
                about = f"{name}: its value {value:.6g} is outside of its bounds"
                announce([f"{about}. The search starts at {used:.6g}."])
        self.scale = _scales(self.x0, self.limits)
        for name, given in scale.items():
            what = f"the scale of {name}"
            Number(positive=True)(what, size := in_si(what, given, unit_of[name]))
            self.scale[self.names.index(name)] = size

    @property
    def z0(self) -> Array:
        return np.asarray(self.x0 / self.scale)

    def of(self, z: Array) -> Array:
        """The design variables, clipped to the limits, of which a solver may be short by round-off."""
        return np.asarray(np.clip(np.asarray(z) * self.scale, self.limits[:, 0], self.limits[:, 1]))

    @property
    def ends(self) -> Array:
        """The limits, scaled (p, 2)."""
        return np.asarray(self.limits / self.scale[:, None])

    def free_gradient(self, z: Array, slope: Array) -> Array:
        """The part of a scaled gradient that does not press against the limits."""
        low, high = self.ends.T
        return np.asarray(z - np.clip(z - slope, low, high))

    def signed(self, problem: Problem) -> Variables:
        """The same, with 0 as the missing limit of a variable that the model accepts with one sign only."""
        signed = copy(self)
        signed.limits = self.limits.copy()
        for k, x in enumerate(self.x0):
            for side, sign in enumerate((-1.0, 1.0)):
                if np.isinf(self.limits[k, side]) and sign * x <= 0:
                    beyond = self.x0.copy()
                    beyond[k] = sign * np.finfo(float).tiny
                    if not problem.accepts(beyond):
                        signed.limits[k, side] = 0.0
        return signed

    def beginning(self, x: Array) -> Variables:
        """The same with another start."""
        moved = copy(self)
        moved.x0 = x.copy()
        return moved

    def random(self, generator: np.random.Generator) -> Array:
        """A design with every variable equally probable between its limits.

        Raises
        ------
        ValueError
            If one has no limits.
        """
        for name, limits in zip(self.names, self.limits, strict=True):
            if not np.all(np.isfinite(limits)):
                raise ValueError(
                    f"{name}: several starts need both bounds of every variable. Give the one it lacks."
                )
        return np.asarray(generator.uniform(*self.limits.T))


class Search:
    """Objective and constraints of z for a solver, finite for every design.

    Where a design cannot be simulated the objective is a wall: a parabola that begins at the last iterate with its
    slope, and is higher than everything seen, so that solvers step back. So is a design that is nearer to one that
    failed than to all that were simulated; a restart forgets those that failed.

    Parameters
    ----------
    problem : whose first `count` responses are summed, the others constrained
    variables : Variables
    constraints : Within
    progress : called with the number of the simulation and the objective

    Attributes
    ----------
    initial : the variables at the start (p,)
    gradients : all that were computed, by the bytes of their designs
    origin, size : a solver sees the objective without the origin and divided by the size, so that its tolerances mean
        the same for f and a·f + b; see `normalize`
    """

    def __init__(
        self,
        problem: Problem,
        variables: Variables,
        constraints: Sequence[Within] = (),
        progress: Report | None = None,
    ) -> None:
        self.problem, self.variables, self.constraints = problem, variables.signed(problem), constraints
        self.count = len(problem.titles) - len(constraints)
        self._reports: list[tuple[float, float]] = []
        self._reported: int | None = None  # place of the iterate in the last line of the log
        self.trace: list[Array] = []
        self.failures: list[str] = []
        self.best: Point | None = None
        self._best = (np.inf, np.inf)
        self._in_a_row = 0
        self._known: list[tuple[Array, str]] = []  # designs z, and the message of each that failed
        self._seen: dict[bytes, int] = {}
        self.gradients: dict[bytes, Gradients] = {}
        self._progress, self.began = progress, time.perf_counter()
        self.anchor, self.initial = variables.z0, variables.x0
        problem.at(variables.x0).values  # noqa: B018  the first design must be one that can be simulated
        self.origin = self.value(self.anchor)
        self.size = abs(self.origin) or 1.0

    def normalize(self, slope: Array, rest: float) -> None:
        """Take the objective at a solver's start for its origin, and its gradient there for its size.

        Parameters
        ----------
        slope : that gradient (p,)
        rest : the size of what multipliers of limits leave of it
        """
        self.origin = self.value(self.variables.z0)
        steepness = float(np.linalg.norm(slope))
        if steepness > ROUND_OFF * abs(self.origin):
            self.size = max(rest, PRESSING * steepness) / FIRST
        else:
            self.size = abs(self.origin) or 1.0

    def restart(self) -> None:
        """Let a solver begin anew at the best design."""
        assert self.best is not None
        self.variables = self.variables.beginning(self.best.x)
        self.anchor, self._in_a_row = self.variables.z0, 0
        self._known = [(self.anchor, "")]

    def point(self, z: Array) -> Point:
        """The design.

        Raises
        ------
        Infeasible
            If there is none, or its assembly has no derivatives; or if the nearest known design failed.
        """
        if failure := self._nearest_failure(z):
            raise DesignError(failure)
        design = self.problem.at(self.variables.of(z))
        if not design.nearest:
            raise DesignError(f"its assembly has no derivatives: {design.start.message}")
        return design

    def _nearest_failure(self, z: Array) -> str:
        """Return the message of the known design nearest to z; empty if it was simulated."""
        if not self._known:
            return ""
        return min(self._known, key=lambda known: float(np.linalg.norm(known[0] - z)))[1]

    def value(self, z: Array) -> float:
        """The objective.

        Raises
        ------
        TimeLimit
            If the time of the whole search has passed.
        """
        self.problem.refuse_late()
        try:
            point = self.point(z)
            values = point.values
        except DesignError as error:
            self.problem.refuse_late()
            self._fail(z, str(error))
            return self._wall(z)[0]
        self._known.append((np.array(z), ""))
        objective = float(values[: self.count].sum())
        self._note(z, point, objective, gap(values[self.count :], self.constraints))
        return objective

    def slope(self, z: Array) -> Array:
        """Its gradient by z (p,).

        Raises
        ------
        TimeLimit
            If the time of the whole search has passed.
        Infeasible
            If the last iterate, whose slope replaces that of designs without derivatives, has none itself.
        """
        try:
            matrix = self.point(z).slopes
        except DesignError:
            self.problem.refuse_late()
            if np.array_equal(z, self.anchor):
                raise
            return self._wall(z)[1]
        scaled = np.asarray(matrix * self.variables.scale)
        slope = np.asarray(scaled[: self.count].sum(axis=0))
        self.noted(z, slope, scaled[self.count :])
        return slope

    def scaled_value(self, z: Array) -> float:
        """The objective as a solver sees it."""
        return (self.value(z) - self.origin) / self.size

    def scaled_slope(self, z: Array) -> Array:
        """Its gradient by z (p,)."""
        return self.slope(z) / self.size

    def noted(self, z: Array, slope: Array, others: Array | None = None) -> None:
        """Remember the gradient of the objective at a design, and those of the constrained responses."""
        rows = np.zeros((0, len(slope))) if others is None else others
        self.gradients[np.asarray(z).tobytes()] = Gradients(np.array(z), slope, rows)

    def _steepness(self, key: bytes) -> float:
        """The size of the gradient at a design, as far as it does not press against bounds; NaN if not asked for."""
        if (known := self.gradients.get(key)) is None:
            return np.nan
        return float(np.linalg.norm(self.variables.free_gradient(known.z, known.slope)))

    @property
    def values(self) -> Array:
        """The objective of each simulation (n,)."""
        return np.array([value for value, _ in self._reports])

    @property
    def history(self) -> Array:
        """For each simulation the objective, the norm of its gradient (NaN without one), and the gap (n, 3)."""
        sizes = map(self._steepness, self._seen)
        return np.array(
            [[value, size, short] for (value, short), size in zip(self._reports, sizes, strict=True)]
        )

    def curved(
        self, z: Array, direction: Array, objective: float = 1.0, others: Array | None = None
    ) -> Array:
        """A Hessian by z times a direction (p,); at a wall that of the last iterate.

        Parameters
        ----------
        objective, others : the weights of the objective and of the constrained responses (c,), by default none of them
        """
        scale = self.variables.scale
        try:
            point = self.point(z)
            point.values  # noqa: B018
        except DesignError:
            point = self.point(self.anchor)
        weights = np.append(np.full(self.count, objective), 0.0 if others is None else others)
        rows = (w * point.curved(direction * scale, row) for row, w in enumerate(weights) if w)
        return np.asarray(sum(rows, np.zeros_like(scale)) * scale)

    def curvature(self, z: Array, objective: float, others: Array) -> Array:
        """The whole of that Hessian, symmetric (p, p), by a product for each variable."""
        every = np.eye(len(self.variables.names))
        columns = np.array([self.curved(z, direction, objective, others) for direction in every])
        return np.asarray(0.5 * (columns + columns.T))

    def others(self, z: Array) -> Array:
        """The constrained responses; where there are none, those of the last iterate."""
        try:
            return self.point(z).values[self.count :]
        except DesignError:
            return self.point(self.anchor).values[self.count :]

    def other_slopes(self, z: Array) -> Array:
        """Their gradients by z (c, p)."""
        try:
            matrix = self.point(z).slopes
        except DesignError:
            matrix = self.point(self.anchor).slopes
        return np.asarray(matrix[self.count :] * self.variables.scale)

    def iterate(self, z: Array) -> None:
        """A solver has accepted a design."""
        place = self._seen.get(np.asarray(z).tobytes())
        if place is None or place == self._reported:  # a step of SLSQP that failed; a solver that restarts
            return
        self._reported = place
        self.anchor = np.array(z)
        size = self._steepness(np.asarray(z).tobytes())
        steepness = "" if np.isnan(size) else f", free gradient {size:.3g}"  # solvers ask for it later
        log.info("simulation %d: objective %.9g%s", place + 1, self._reports[place][0], steepness)

    def _wall(self, z: Array) -> tuple[float, Array]:
        """A value above all others and its gradient, from the slope at the last iterate."""
        step = np.asarray(z) - self.anchor
        length = max(float(step @ step), np.finfo(float).tiny)
        slope = self.slope(self.anchor)
        fall = max(abs(float(slope @ step)), SLIGHT * self.size)
        top = max(report[0] for report in self._reports)
        return top + fall, np.asarray(3 * fall * step / length)

    def _fail(self, z: Array, message: str) -> None:
        if not self._nearest_failure(z):
            self._known.append((np.array(z), message))
            is_new = not self._in_a_row and message not in self.failures  # the others are in `failures`
            level = logging.WARNING if is_new else logging.DEBUG
            self.failures.append(message)
            log.log(level, "a design cannot be simulated, stepping back: %s", message)
        self._in_a_row += 1
        if self._in_a_row >= PATIENCE:
            raise SearchFailure(message)

    def _note(self, z: Array, point: Point, value: float, short: float) -> None:
        """Write an evaluation down, and keep the best: first in its constraints, then in its objective."""
        self._in_a_row = 0
        if np.asarray(z).tobytes() in self._seen:
            return
        self._seen[np.asarray(z).tobytes()] = len(self._reports)
        self._reports.append((value, short))
        self.trace.append(point.x.copy())
        best_short, best = self._best[0], self._best[1]
        if short < best_short - SMALL_GAP or (short <= max(best_short, SMALL_GAP) and value < best):
            self._best, self.best = (short, value), point
        if self._progress:
            self._progress(len(self._reports), value)


@contextmanager
def reporting(progress: Progress | None) -> Iterator[Report]:
    """Yield the function that reports each simulation and its objective; see `optimize`."""
    shown = _print if progress is True else progress or None
    last = [""]

    def report(number: int, value: float) -> None:
        last[0] = f"simulation {number}: objective {value:.9g}"
        if callable(shown):
            shown(number, value)

    def line(taken: float) -> str:
        return f"{last[0] or 'optimizing'}, {duration(taken)}"

    with showing(False if progress is False else None), activity(None if shown else line):
        yield report


def _print(number: int, value: float) -> None:
    console.report(f"simulation {number}: objective {value:.9g}")


def _limit(name: str, bounds: Any, unit: str | None) -> tuple[float, float]:
    if bounds is not None and np.shape(bounds) != (2,):
        raise ValueError(
            f"the bounds of {name} are two numbers, but are {bounds}. Give (low, high), with None for none."
        )
    ends = zip(bounds if bounds is not None else (None, None), (-np.inf, np.inf), strict=True)
    what = f"a bound of {name}"
    given = [none if end is None else in_si(what, end, unit) for end, none in ends]
    for end in given:
        Number(infinite=True)(what, end)
    limits = float(given[0]), float(given[1])
    if not limits[0] < limits[1]:
        remedy = "Leave it out of the variables" if limits[0] == limits[1] else "Exchange them"
        raise ValueError(
            f"the bounds of {name} must rise, but are {limits[0]:g} and {limits[1]:g}. {remedy}."
        )
    return limits


def _scales(x: Array, limits: Array) -> Array:
    """The size of each variable: its value, or half its range, or 1."""
    finite = np.all(np.isfinite(limits), axis=1)
    width = np.ones(len(x))
    width[finite] = (limits[finite, 1] - limits[finite, 0]) / 2
    return np.where(x != 0, abs(x), width)
