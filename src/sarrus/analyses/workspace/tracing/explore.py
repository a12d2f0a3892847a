"""All candidate curves connected with given starts: an iterator with a queue of open ends."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ....algebra import Array
from ...progress import TimeLimit
from ..problem.rows import Problem
from ..problem.watch import POINTS, reached
from .curve import LONGEST, Trace
from .event import Event
from .point import Point, Step
from .stratum import Active, NoPoint, Stratum, signs
from .vertex import Half, Vertex, halves, loses_rank, seed, vertex_of

# Configurations at which constraints are dependent; where these are a curve, they have no end
MOST_SINGULAR = 16
ON_CURVE = 1e-4  # of unknowns from a curve's interpolation, free of units


@dataclass(eq=False)
class Branch:
    """A curve of candidates between two vertices: its points, with the limits that are active."""

    stratum: Stratum
    points: list[Point]
    start: Vertex
    end: Vertex
    failure: str = ""

    def steps(self) -> list[Step]:
        return [Step(a, b) for a, b in zip(self.points, self.points[1:], strict=False)]

    def holds(self, x: Array) -> bool:
        """Whether a point is on it."""
        flipped = [signs(self.stratum, x, p.x) * x for p in self.points]
        near = sorted(range(len(flipped)), key=lambda k: float(np.linalg.norm(flipped[k] - self.points[k].x)))
        return any(self._between(k + shift, flipped[k]) for k in near[:3] for shift in (-1, 0))

    def _between(self, k: int, x: Array) -> bool:
        if not 0 <= k < len(self.points) - 1:
            return False
        step = Step(self.points[k], self.points[k + 1])
        tau = float(step.a.t @ (x - step.a.x)) / step.length if step.length else 0.0
        return -0.01 <= tau <= 1.01 and float(np.linalg.norm(x - step.x(tau))) < ON_CURVE


class Explorer:
    """The graph of candidate curves: iterate over it for one branch after another, stop, look, and go on.

    Attributes
    ----------
    branches, vertices : so far
    open : half curves that have not been followed yet
    endless : whether so many curves cross at singular configurations that they would never end
    """

    def __init__(self, problem: Problem, *, longest: float = LONGEST) -> None:
        self.problem, self.longest = problem, longest
        self.branches: list[Branch] = []
        self.vertices: list[Vertex] = []
        self.open: deque[tuple[Vertex, Half]] = deque()
        self.endless = False
        self._singular = 0
        self._strata: dict[Active, Stratum] = {}

    def stratum(self, key: Active) -> Stratum:
        """The equations for a set of active limits."""
        if key not in self._strata:
            self._strata[key] = Stratum(self.problem, key)
        return self._strata[key]

    def start(self, key: Active, x: Array) -> Literal["new", "known", "lost"]:
        """Take a point of a candidate curve as a start, unless its curve is known; lost if none passes through it."""
        if any(branch.stratum.key == key and branch.holds(x) for branch in self.branches):
            return "known"
        try:
            self._add(seed(self.stratum(key), x))
        except NoPoint:
            return "lost"
        return "new"

    def _add(self, vertex: Vertex) -> None:
        self.vertices.append(vertex)
        self.open.extend((vertex, half) for half in vertex.halves)

    def __iter__(self) -> Iterator[Branch]:
        return self

    def __next__(self) -> Branch:
        while self.open and not self.endless:
            vertex, half = self.open.popleft()
            if not half.done:
                return self._follow(vertex, half)
        raise StopIteration

    def run(self) -> None:
        """Follow all open ends."""
        for _ in self:
            pass

    def _follow(self, vertex: Vertex, half: Half) -> Branch:
        stratum = self.stratum(half.key)
        try:
            closes = vertex.kind == "seed"
            trace = Trace(stratum, half.point, half.own, closes, longest=self.longest).follow()
        except (TimeLimit, KeyboardInterrupt):
            self.open.appendleft((vertex, half))  # to be followed when the map goes on
            raise
        half.done = True
        end = self._end(stratum, trace, vertex)
        branch = Branch(stratum, trace.points, vertex, end, trace.failure)
        self.branches.append(branch)
        reached(sum(len(one.points) for one in self.branches), POINTS)
        return branch

    def _end(self, stratum: Stratum, trace: Trace, start: Vertex) -> Vertex:
        event = trace.event
        if event is None:
            lost = Vertex("loose", trace.points[-1].x[: stratum.n], stratum.key, None, trace.points[-1].u)
            self.vertices.append(lost)
            return lost
        found = start if event.kind == "closed" else self._vertex(stratum, event)
        arrived = found.half(stratum.key, event.point.x[: stratum.n], -event.point.t[: stratum.n])
        if arrived is not None:
            arrived.done = True
        return found

    def _vertex(self, stratum: Stratum, event: Event) -> Vertex:
        found, c = vertex_of(stratum, event), event.point.c
        known = next((vertex for vertex in self.vertices if vertex.is_same(found, c)), None)
        if known is not None:
            return known
        found.halves = list(halves(self.stratum, stratum, event.point, found))
        self._add(found)
        self._singular += found.kind == "branch" and loses_rank(stratum, found.q)
        self.endless = self._singular > MOST_SINGULAR
        return found
