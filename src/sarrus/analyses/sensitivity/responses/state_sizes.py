"""Sizes of states, of which outputs have round-off: displacements and Euler parameters apart, in any unit of length."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....algebra import Array
from ....outputs.recording import States

KINDS = ("q", "v", "a")
SLOPES = 0.05  # of positions over a step: rates of this size have the round-off of polynomials


def state_sizes(states: States, length: float, t: Sequence[Array]) -> dict[str, Array]:
    """The largest states of each kind (nq,), and of rates at least what polynomials make of round-off of positions.

    Parameters
    ----------
    length : of the system, by which rotations move points [m]
    t : nodes of the stretches of a run [s]
    """
    sizes = {kind: _largest(getattr(states, kind), length) for kind in KINDS}
    h = float(np.median(np.concatenate([np.diff(one) for one in t])))
    for n, kind in enumerate(KINDS[1:], start=1):
        sizes[kind] = np.maximum(sizes[kind], SLOPES * sizes["q"] / h**n)
    return sizes


def _largest(x: Array, length: float) -> Array:
    """The largest displacement or Euler parameter, for each coordinate (nq,)."""
    turning, largest = np.arange(x.shape[1]) % 7 >= 3, abs(x).max(axis=0, initial=0.0)
    p = largest[turning].max(initial=0.0)
    return np.asarray(np.where(turning, p, max(largest[~turning].max(initial=0.0), length * p)))
