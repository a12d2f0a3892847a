"""What every method gives: the states at the ends of its steps, between which a motion is a quintic in time."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ...algebra import Array


class Nodes(NamedTuple):
    """States one after another, the first where the steps begin.

    Attributes
    ----------
    t : (n,) rising [s]
    q, v, a : (n, nq)
    lam : (n, m)
    memory : (n, k) what elements remember there
    """

    t: Array
    q: Array
    v: Array
    a: Array
    lam: Array
    memory: Array

    def part(self, rows: slice) -> Nodes:
        """Some of them, one after another."""
        return Nodes._make(array[rows] for array in self)

    def near(self, t: float) -> tuple[Array, Array]:
        """q and v at a time within, not yet on the constraints."""
        k = int(np.clip(np.searchsorted(self.t, t) - 1, 0, len(self.t) - 2))
        h = self.t[k + 1] - self.t[k]
        s = (t - self.t[k]) / h
        slope0, slope1 = h * self.v[k], h * self.v[k + 1]
        bend0, bend1 = 0.5 * h * h * self.a[k], 0.5 * h * h * self.a[k + 1]
        rest, turn, bent = (
            self.q[k + 1] - self.q[k] - slope0 - bend0,
            slope1 - slope0 - 2 * bend0,
            bend1 - bend0,
        )
        c, d, e = 10 * rest - 4 * turn + bent, -15 * rest + 7 * turn - 2 * bent, 6 * rest - 3 * turn + bent
        q = self.q[k] + s * (slope0 + s * (bend0 + s * (c + s * (d + s * e))))
        return q, (slope0 + s * (2 * bend0 + s * (3 * c + s * (4 * d + s * 5 * e)))) / h


def joined(parts: list[Nodes]) -> Nodes:
    """Several chunks as one; where one begins as another ended, that node is kept once."""
    kept = [parts[0], *(_rest(before, part) for before, part in pairwise(parts))]
    return Nodes._make(np.concatenate(columns) for columns in zip(*kept, strict=True))


def _rest(before: Nodes, part: Nodes) -> Nodes:
    """A chunk without its first node, if that is the last of the chunk before."""
    same = part.t[0] == before.t[-1] and np.array_equal(part.v[0], before.v[-1])
    return part.part(slice(1, None)) if same else part
