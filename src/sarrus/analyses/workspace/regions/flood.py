"""All positions of a mechanism with its outputs at given places: those that are known lead to their neighbours.

A position is moved to the next place, and along the motions that leave the outputs where they are, by Newton's method
from a linear prediction; what is new spreads in turn. So one position fills its way of assembly.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence

import numpy as np

from ....algebra import Array
from ....linalg.svd import singular
from ....model.coordinates import WIDTH
from ..problem.rows import Problem
from ..problem.settle import allowed, constrained, settle
from ..problem.watch import CELLS, reached

SAME = 1e-3  # free of units: positions nearer to each other are one, where they are single
STRIDE = 0.15  # free of units: of motions that leave the outputs where they are
SINGULAR = 1e-9  # of a singular value relative to the largest
HALVINGS = 12  # of a stride that ends at a limit


class Flood:
    """Positions at places; `spread` them until nothing is new.

    Parameters
    ----------
    problem : Problem
    places : (count, 2) values of the outputs, free of units
    neighbours : of every place

    Attributes
    ----------
    at : positions of each place
    strides : of each place, pairs of positions that a motion joins which leaves the outputs where they are
    """

    def __init__(self, problem: Problem, places: Array, neighbours: Sequence[Sequence[int]]) -> None:
        self.problem, self.places, self.neighbours = problem, places, neighbours
        rows, self._goal = constrained(problem)
        self._rows = np.concatenate([rows, problem.m + problem.outputs])
        self.at: list[list[Array]] = [[] for _ in places]
        self.strides: list[list[tuple[Array, Array]]] = [[] for _ in places]
        self._open: deque[tuple[int, Array]] = deque()
        self._filled = 0
        self._apart = 0.5 * STRIDE if problem.freedoms > len(problem.outputs) else SAME

    def take(self, k: int, q: Array) -> bool:
        """Move a position to a place and keep it there, if that is possible and it is new."""
        there = self._settled(k, q)
        return there is not None and self._keep(k, there)

    def spread(self) -> None:
        """Go on from all positions until nothing is new."""
        while self._open:
            reached(self._filled, CELLS)
            k, q = self._open.popleft()
            inverse, still = self._inverse(q)
            for other in self.neighbours[k]:
                step = inverse[:, -self.places.shape[1] :] @ (self.places[other] - self.places[k])
                near = max(0.5 * float(np.linalg.norm(step)), self._apart)
                if self._known(other, q + step, near) is None:
                    self.take(other, q + step)
            for way in (*still, *-still):
                self._stride(k, q, way)

    def _keep(self, k: int, q: Array) -> bool:
        if self._known(k, q, self._apart) is not None:
            return False
        self._filled += not self.at[k]
        self.at[k].append(q)
        self._open.append((k, q))
        return True

    def _stride(self, k: int, q: Array, way: Array) -> None:
        """A motion that leaves the outputs where they are, up to the next position or to a limit."""
        known = self._known(k, q + STRIDE * way, self._apart)
        there = self._settled(k, q + STRIDE * way) if known is None else known
        if there is None:
            there = self._last(k, q, way)
        elif known is None:
            self._keep(k, there)
        self.strides[k].append((q, there))

    def _last(self, k: int, q: Array, way: Array) -> Array:
        """The farthest position along a stride that keeps the limits."""
        low, high, found = 0.0, 1.0, q
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            there = self._settled(k, q + middle * STRIDE * way)
            low, high, found = (low, middle, found) if there is None else (middle, high, there)
        return found

    def _settled(self, k: int, q: Array) -> Array | None:
        there = settle(self.problem, q, self._rows, np.concatenate([self._goal, self.places[k]]), steps=12)
        if there is None or not allowed(self.problem, there) or not self.problem.built(there):
            return None
        return there

    def _known(self, k: int, q: Array, near: float) -> Array | None:
        """The position of a place that is nearest to another one, if it is near."""
        if not self.at[k]:
            return None
        away = _distances(np.array(self.at[k]), q)
        nearest = int(np.argmin(away))
        return self.at[k][nearest] if away[nearest] < near else None

    def _inverse(self, q: Array) -> tuple[Array, Array]:
        """The least motion for changes of all rows, and the motions that change none."""
        left, sizes, right = singular(self.problem.jacobian(q)[self._rows])
        good = sizes > SINGULAR * sizes[0]
        inverse = (right[: len(sizes)].T[:, good] / sizes[good]) @ left.T[good]
        return inverse, right[len(self._rows) :]


def _distances(known: Array, q: Array) -> Array:
    """Return the distances of positions (count, n) from another one, without units and signs of Euler parameters."""
    d = (known - q).reshape(len(known), -1, WIDTH) ** 2
    flipped = (known + q).reshape(len(known), -1, WIDTH)[..., 3:] ** 2
    turned = np.minimum(d[..., 3:].sum(axis=2), flipped.sum(axis=2))
    return np.asarray(np.sqrt(d[..., :3].sum(axis=(1, 2)) + turned.sum(axis=1)))


def around(inside: Array) -> Iterator[list[int]]:
    """For each cell of a grid that is inside, in the grid's order, the numbers of those beside it."""
    number = np.full(np.add(inside.shape, 2), -1)
    number[1:-1, 1:-1][inside] = np.arange(int(inside.sum()))
    for i, j in np.argwhere(inside) + 1:
        beside = (number[i - 1, j], number[i + 1, j], number[i, j - 1], number[i, j + 1])
        yield [int(n) for n in beside if n >= 0]
