"""Results of every method: the states at the ends of its steps, and the interpolated motion between them."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ...._jit.linking.link import compiled
from ....algebra import Array


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

    def near(self, t: float, apart: bool) -> tuple[Array, Array]:
        """q and v at a time within, not yet on the constraints."""
        k = int(np.clip(np.searchsorted(self.t, t) - 1, 0, len(self.t) - 2))
        h = float(self.t[k + 1] - self.t[k])
        if h == 0.0:  # a step shorter than round-off of the time
            return self.q[k + 1], self.v[k + 1]
        found = np.zeros((3, 1, self.q.shape[1]))  # as one entry, which is an array
        q, v, a = (x[k : k + 2] for x in (self.q, self.v, self.a))
        between(q[:1], v[:1], a[:1], q[1:], v[1:], a[1:], (t - self.t[k]) / h, h, apart, *found)
        return found[0, 0], found[1, 0]


@compiled
def between(
    q0: Array, v0: Array, a0: Array, q1: Array, v1: Array, a1: Array, s: float, h: float, apart: bool, q: Array,
    v: Array, a: Array,
) -> None:  # fmt: skip
    """q, v and a at the part s of a step of length h, of the states at its ends.

    By the polynomial of degree five that has q, v and a there, and its derivatives. Or q and v `apart`: q by the
    cubic that has q and v there, v by that which has v and a, a by the slope of that one: nodes of a method of order
    two are errors of that order away from one motion, and a derivative loses none of it that is made of its own kind
    and the next.
    """
    for k in range(len(q)):
        slope0, slope1 = h * v0[k], h * v1[k]
        bend0, bend1 = 0.5 * h * h * a0[k], 0.5 * h * h * a1[k]
        way = q1[k] - q0[k]
        if apart:
            gain = slope1 - slope0
            c, d = 3.0 * way - 2.0 * slope0 - slope1, slope0 + slope1 - 2.0 * way
            q[k] = q0[k] + s * (slope0 + s * (c + s * d))
            c, d = 3.0 * gain - 4.0 * bend0 - 2.0 * bend1, 2.0 * (bend0 + bend1) - 2.0 * gain
            v[k] = (slope0 + s * (2.0 * bend0 + s * (c + s * d))) / h
            a[k] = (2.0 * bend0 + s * (2.0 * c + s * 3.0 * d)) / (h * h)
        else:
            rest = way - slope0 - bend0
            event_step, bent = slope1 - slope0 - 2.0 * bend0, bend1 - bend0
            c = 10.0 * rest - 4.0 * event_step + bent
            d = -15.0 * rest + 7.0 * event_step - 2.0 * bent
            e = 6.0 * rest - 3.0 * event_step + bent
            q[k] = q0[k] + s * (slope0 + s * (bend0 + s * (c + s * (d + s * e))))
            v[k] = (slope0 + s * (2.0 * bend0 + s * (3.0 * c + s * (4.0 * d + s * 5.0 * e)))) / h
            a[k] = (2.0 * bend0 + s * (6.0 * c + s * (12.0 * d + s * 20.0 * e))) / (h * h)


def joined(parts: list[Nodes]) -> Nodes:
    """Several chunks as one; where one begins as another ended, that node is included once."""
    stored = [parts[0], *(_rest(before, part) for before, part in pairwise(parts))]
    return Nodes._make(np.concatenate(columns) for columns in zip(*stored, strict=True))


def _rest(before: Nodes, part: Nodes) -> Nodes:
    """A chunk without its first node, if that is the last of the chunk before."""
    same = part.t[0] == before.t[-1] and np.array_equal(part.v[0], before.v[-1])
    return part.part(slice(1, None)) if same else part
