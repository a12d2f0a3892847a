"""Starts of candidate curves: from random positions, along rays of outputs, and where a determinant changes its sign.

A ray moves the outputs along a line until a singularity or limit stops them, on a curve. The largest t with
u = u0 + t e is climbed to along projected gradients with an active set of limits, then found exactly by Newton's method
on G = 0 with the line's equation.

Where the determinant of the gradients of the constraints and of what is lost, so many as there are coordinates, changes
its sign on a random walk, a singular curve was crossed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ....linalg.svd import singular
from ..problem.formulation import DEPENDENT
from ..problem.random_positions import WALK, Samples
from ..problem.rows import Problem
from ..problem.settle import allowed, constrained, newton, settle
from ..problem.watch import check
from .stratum import Active, NoPoint, Stratum, Tangents, correct

STRIDE = 0.12  # of one climbing step, free of units
STEPS = 120
STEEP = 0.25  # length of the projected gradient below which Newton's method is tried
HALVINGS = 24  # between positions on both sides of a singular curve
WALKS = 150


class Start(NamedTuple):
    """A point of a candidate curve and its active limits."""

    key: Active
    x: Array


def random_start(problem: Problem, q: Array, random: np.random.Generator) -> Start | None:
    """A point of a candidate curve with random limits active, from an admissible position; nothing, if it fails."""
    most = problem.freedoms - len(problem.normal) + 1 if problem.of_outputs else 0
    active = _some_limits(problem, random, most)
    stratum = Stratum(problem, active)
    x = onto(stratum, _guess(stratum, q, random))
    if x is None or not allowed(problem, x[: problem.n]) or not problem.built(x[: problem.n]):
        return None
    return Start(active, x)


def _some_limits(problem: Problem, random: np.random.Generator, most: int) -> Active:
    """A random choice of at most so many limits, each at one of its ends."""
    count = int(random.integers(0, min(most, len(problem.limited)) + 1))
    chosen = random.permutation(len(problem.limited))[:count]
    ends = [[end for end in (0, 1) if np.isfinite(problem.bounds[i, end])] for i in chosen]
    return frozenset((int(i), int(random.choice(end))) for i, end in zip(chosen, ends, strict=True))


def _guess(stratum: Stratum, q: Array, random: np.random.Generator) -> Array:
    """A random normal with the multipliers that balance it best."""
    c = random.normal(size=stratum.k)
    J = stratum.problem.jacobian(q)
    lam = -np.linalg.lstsq(J[stratum.pushing].T, J[stratum.normal].T @ c, rcond=None)[0]
    both = np.concatenate([lam, c])
    return np.concatenate([q, both / np.linalg.norm(both)])


def onto(stratum: Stratum, x: Array) -> Array | None:
    """A solution of G(x) = 0 from x by damped steps of least size; nothing, if none is found."""
    return newton(x, stratum.residual, lambda there: stratum.linear(there).G_x)


class Ray:
    """One ray of a problem with one or two outputs.

    Parameters
    ----------
    problem : Problem
    q : scaled position that keeps all limits
    direction : (k,) of the outputs
    """

    def __init__(self, problem: Problem, q: Array, direction: Array) -> None:
        self.problem, self.q = problem, q
        self.e = direction / np.linalg.norm(direction)
        self.across = np.array([[-self.e[1], self.e[0]]]) if len(self.e) == 2 else np.zeros((0, 1))
        self.outputs = problem.m + problem.outputs
        self.u0 = problem.values(q)[self.outputs]
        self.active: dict[int, int] = {}
        self.rows, self.goal = constrained(problem)

    def end(self) -> Start | None:
        """The point at which the outputs can go no further; nothing, if the climb got lost."""
        for _ in range(STEPS):
            check()
            way, multipliers, slope = self._way()
            if slope < STEEP:
                found = self._stopped()
                if found is not None:
                    return found
            if slope < DEPENDENT:
                leave = self._to_leave(multipliers)
                if leave is None:
                    return None
                del self.active[leave]
                continue
            if not self._climb(way / slope, min(STRIDE, max(slope, 0.02) * STRIDE)):
                return None
        return None

    def _way(self) -> tuple[Array, Array, float]:
        """The projected gradient of t, the multipliers of the active limits, its length."""
        p, J = self.problem, self.problem.jacobian(self.q)
        limits = [p.m + p.limited[i] for i in self.active]
        A = np.concatenate([J[self.rows], self.across @ J[self.outputs], J[limits]])
        g = self.e @ J[self.outputs]
        y = np.linalg.lstsq(A.T, g, rcond=1e-10)[0]
        way = g - A.T @ y
        size = float(np.linalg.norm(g)) or 1.0
        return way / size, -y[len(y) - len(limits) :], float(np.linalg.norm(way)) / size

    def _to_leave(self, multipliers: Array) -> int | None:
        """The active limit that it pays most to leave."""
        gains = {i: -m * (1 - 2 * end) for (i, end), m in zip(self.active.items(), multipliers, strict=True)}
        best = max(gains, key=lambda i: gains[i], default=None)
        return best if best is not None and gains[best] > 0 else None

    def _climb(self, way: Array, stride: float) -> bool:
        """One step up, no further than to the next limit; false where there is no way."""
        p = self.problem
        before = float(self.e @ p.values(self.q)[self.outputs])
        for _ in range(12):
            there = self._onto(self.q + stride * way, self.active)
            if there is not None and np.linalg.norm(there - self.q) < 3 * stride:
                margins = p.margins(p.values(there))
                beyond = [
                    (i, end) for i, end in np.argwhere(margins < -1e-9).tolist() if i not in self.active
                ]
                if not beyond:
                    gain = float(self.e @ p.values(there)[self.outputs]) - before
                    if gain > 0:
                        self.q = there
                        return True
                else:
                    i, end = min(beyond, key=lambda one: margins[one[0], one[1]])
                    if self._stop_at(there, i, end):
                        return True
            stride *= 0.5
        return False

    def _stop_at(self, there: Array, i: int, end: int) -> bool:
        """The limit becomes active, at the position in between where it is reached."""
        p = self.problem
        m_here = p.margins(p.values(self.q))[i, end]
        m_there = p.margins(p.values(there))[i, end]
        share = m_here / (m_here - m_there) if m_here > m_there else 1.0
        found = self._onto(self.q + share * (there - self.q), {**self.active, i: end})
        if found is None or not allowed(p, found):
            return False
        self.q, self.active[i] = found, end
        return True

    def _onto(self, q: Array, active: dict[int, int]) -> Array | None:
        p = self.problem
        rows = np.concatenate([self.rows, p.m + p.limited[list(active)]]).astype(int)
        goal = np.concatenate([self.goal, [p.bounds[i, end] for i, end in active.items()]])
        return settle(p, q, rows, goal, steps=8)

    def _stopped(self) -> Start | None:
        """The exact point nearby where the outputs cannot go on along the ray."""
        key: Active = frozenset(self.active.items())
        stratum = Stratum(self.problem, key)
        if stratum.dimension < 0:
            return None
        x = self._exact(stratum)
        if x is None:
            return None
        q, lam, c = stratum.parts(x)
        if not allowed(self.problem, q) or not self.problem.built(q):
            return None
        pushes = -lam[len(lam) - len(stratum.active) :] * stratum.signs * np.sign(c @ self.e)
        return None if np.any(pushes > 1e-9) else Start(key, x)

    def _exact(self, stratum: Stratum) -> Array | None:
        """On the ray's line for two outputs; for one, such points are single."""
        guess = self._with_multipliers(stratum)
        if not len(self.across):
            return onto(stratum, guess)
        try:
            return correct(stratum, guess, self._line, steps=12)[0]
        except NoPoint:
            return None

    def _with_multipliers(self, stratum: Stratum) -> Array:
        J = self.problem.jacobian(self.q)
        g = self.e @ J[stratum.normal]
        A = np.concatenate([J[stratum.rows], self.across @ J[stratum.normal]])
        y = -np.linalg.lstsq(A.T, g, rcond=1e-10)[0]
        count = len(stratum.pushing)
        both = np.concatenate([y[:count], self.e + y[count:] @ self.across])
        return np.concatenate([self.q, both / np.linalg.norm(both)])

    def _line(self, x: Array, linear: Tangents) -> tuple[float, Array]:
        """The outputs are on the ray's line."""
        gradient = np.zeros(len(x))
        gradient[: self.problem.n] = self.across[0] @ linear.J[self.outputs]
        return float(self.across[0] @ (linear.values[self.outputs] - self.u0)), gradient


def can_change(problem: Problem) -> bool:
    """Whether there are as many gradients as coordinates."""
    stratum = Stratum(problem, frozenset())
    return len(stratum.pushing) + len(stratum.normal) == problem.n


def changes(problem: Problem, seed: int) -> Iterator[Start]:
    """Points of singular curves without active limits, on random walks."""
    for walk in Samples(problem, seed).walks(WALKS * WALK):
        yield from changes_along(problem, walk)


def changes_along(problem: Problem, walk: Sequence[Array]) -> Iterator[Start]:
    """Points of singular curves without active limits, from admissible positions of a walk on both sides of them."""
    stratum = Stratum(problem, frozenset())
    rows = np.concatenate([stratum.pushing, stratum.normal])
    signs = [_sign(problem, rows, q) for q in walk]
    for n in np.flatnonzero(np.diff(signs)).tolist():
        x = _between(stratum, rows, walk[n], walk[n + 1])
        if x is not None and allowed(problem, x[: problem.n]) and problem.built(x[: problem.n]):
            yield Start(stratum.key, x)


def _sign(problem: Problem, rows: Array, q: Array) -> float:
    return float(np.linalg.slogdet(problem.jacobian(q)[rows])[0])


def _between(stratum: Stratum, rows: Array, a: Array, b: Array) -> Array | None:
    """A point of a singular curve between positions with different signs; nothing, if no motion leads there."""
    problem = stratum.problem
    held, goal = constrained(problem)
    sign = _sign(problem, rows, a)
    for _ in range(HALVINGS):
        middle = settle(problem, 0.5 * (a + b), held, goal, steps=12)
        if middle is None:
            return None
        a, b = (middle, b) if _sign(problem, rows, middle) == sign else (a, middle)
    pushes = singular(problem.jacobian(a)[rows])[0][:, -1]
    return onto(stratum, np.concatenate([a, pushes]))
