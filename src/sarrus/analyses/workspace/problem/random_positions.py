"""Random admissible positions: from the mechanism with opened loops, shaken, or by random walks, within all limits."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ....algebra import Array
from ....system import System
from ...equations.nullspace import normalizations
from .rows import Problem
from .settle import allowed, constrained, drawn_in, settle
from .watch import check

LEAPS, LEAP = 6, 1.6  # of the opened mechanism, for each of its freedoms, free of units
STRIDE, STRIDES = 0.8, 3  # of a walk, free of units
WALK = 21  # positions of a walk, with the assembled one from which it starts
TRIES = 80  # per position that is found
KNOWN = 60  # positions from which walks start


class Samples:
    """An endless iterator of random positions that satisfy constraints and limits.

    Some are assembled from random guesses, so that all assembly modes are found, half of them where guesses succeed;
    the others are walked to from a position found before. Positions with axes turned round are left out, see
    `Handedness`.
    """

    def __init__(self, problem: Problem, seed: int | tuple[int, int] = 0) -> None:
        self._problem, self._random = problem, np.random.default_rng(seed)
        self._rows, self._goal = constrained(problem)
        self._near = problem.system.q0 / problem.scale
        self._tree = np.flatnonzero(np.isin(problem.independent, tree_rows(problem.system)))
        drawn = settle(problem, self._near, self._rows, self._goal)
        self._known = [] if drawn is None else [drawn]
        self._guesses, self._good = 2, 1

    def __iter__(self) -> Iterator[Array]:
        return self

    def __next__(self) -> Array:
        for _ in range(TRIES):
            check()
            q = self._one()
            if q is not None:
                full = len(self._known) >= KNOWN
                self._known[self._random.integers(0, KNOWN) if full else len(self._known) :] = [q]
                return q
        raise StopIteration

    def _one(self) -> Array | None:
        share = min(0.5, max(0.03, self._good / self._guesses))
        walks = bool(self._known) and self._random.random() > share
        q: Array | None = self._walked() if walks else self._settled(self._guess())
        q = None if q is None else self._settled(self._aimed(q))
        q = None if q is None else drawn_in(self._problem, q, self._rows, self._goal, self._random)
        fits = q is not None and allowed(self._problem, q) and self._problem.built(q)
        self._guesses += not walks
        self._good += fits and not walks
        return q if fits else None

    def _settled(self, q: Array) -> Array | None:
        return settle(self._problem, q, self._rows, self._goal)

    def _guess(self) -> Array:
        """A position of the mechanism with its loops opened, moved far at random from the model's."""
        q: Array = self._near
        longest = LEAP * float(np.sqrt(max(1, self._problem.n - len(self._tree))))
        for _ in range(LEAPS):
            there = self._stride(q, longest * float(self._random.random()), self._tree)
            q = q if there is None else there
        return q

    def walks(self, count: int, length: int = WALK) -> Iterator[list[Array]]:
        """So many admissible positions, in random walks from one each: cheaper, but neighbours are related."""
        while count > 0 and (q := next(self, None)) is not None:
            walk = [q]
            while len(walk) < min(length, count):
                there = self._stride(q, STRIDE * float(self._random.random()))
                if there is not None and allowed(self._problem, there) and self._problem.built(there):
                    q = there
                walk.append(q)
            yield walk
            count -= len(walk)

    def _walked(self) -> Array | None:
        """Return a position from a random walk that starts at a known one."""
        q: Array | None = self._known[self._random.integers(len(self._known))]
        for _ in range(STRIDES):
            q = None if q is None else self._stride(q, STRIDE)
        return q

    def _stride(self, q: Array, length: float, rows: Array | None = None) -> Array | None:
        """A step in a random direction of motion, and back onto the constraints or some of them."""
        rows = self._rows if rows is None else rows
        A = self._problem.jacobian(q)[rows]
        way = self._random.normal(size=len(q))
        way -= np.linalg.lstsq(A, A @ way, rcond=1e-10)[0]
        there = q + length * way / max(float(np.linalg.norm(way)), 1e-300)
        goal = self._goal if rows is self._rows else np.zeros(len(rows))
        return settle(self._problem, there, rows, goal)

    def _aimed(self, q: Array) -> Array:
        """Towards random values of as many limited functions as there are degrees of freedom."""
        p = self._problem
        both = self._random.permutation(np.flatnonzero(np.all(np.isfinite(p.bounds), axis=1)))[: p.freedoms]
        ends = p.bounds[both]
        wanted = ends[:, 0] + self._random.random(len(ends)) * (ends[:, 1] - ends[:, 0])
        rows = np.concatenate([self._rows, p.m + p.limited[both]])
        found = settle(p, q, rows, np.concatenate([self._goal, wanted]), steps=25) if len(ends) else None
        return q if found is None else found


def tree_rows(system: System) -> Array:
    """Rows of Φ of joints that close no loop, in the model's order, and of the Euler parameters."""
    part = np.arange(len(system.layout.owners) + 1)  # by body, the ground first: what joints connect so far
    pattern, found = system.Phi_q(system.q0), [np.flatnonzero(normalizations(system))]
    for joint in system.model.joints:
        rows = system.rows.get(joint.name, np.zeros(0, dtype=int))
        bodies = np.unique(system.layout.owner_of[pattern[rows].indices] + 1)
        ends = part[bodies if len(bodies) != 1 else [0, *bodies]]
        if len(np.unique(ends)) == len(ends):
            found.append(rows)
            part[np.isin(part, ends)] = min(ends, default=0)
    return np.sort(np.concatenate(found)).astype(int)
