"""A motion at any time: what `simulate(..., dense_output=True)` gives as `Trajectory.sol`."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..algebra import Array


class State(NamedTuple):
    """A consistent state; with the times along the first axis where several were asked for.

    Attributes
    ----------
    t : [s]
    q, v, a : (nq,)
    lam : (m,)
    """

    t: Any
    q: Array
    v: Array
    a: Array
    lam: Array


class Solution:
    """The whole motion: ``sol(t)`` is the state at a time or at several.

    Between the ends of steps q is a quintic in t through q, v and a, or, of HHT and generalized-α, a cubic through q
    and v, and v one through v and a; the state is then put onto the constraints, and its accelerations and multipliers
    solve the equations of motion. Where velocities jump, those after it are given.

    Attributes
    ----------
    t_min, t_max : where it is known [s]
    """

    def __init__(self, nodes: Any, sampler: Any) -> None:
        self._nodes, self._sampler = nodes, sampler
        self.t_min, self.t_max = float(nodes.t[0]), float(nodes.t[-1])
        self._jumps = np.flatnonzero(np.diff(nodes.t) == 0) + 1

    def __call__(self, t: ArrayLike) -> State:
        """The state at t.

        Raises
        ------
        ValueError
            For a time before the start or after the end.
        """
        times = np.asarray(t, dtype=float)
        flat = times.reshape(-1)
        if np.any((flat < self.t_min) | (flat > self.t_max)) or np.any(np.isnan(flat)):
            raise ValueError(
                f"the motion is known from t = {self.t_min:g} to {self.t_max:g} s, not at all of {t!r}"
            )
        order = np.argsort(flat, kind="stable")
        found = [self._between(flat[order], *piece) for piece in self._pieces(flat[order])]
        back = np.argsort(order, kind="stable")
        q, v, a, lam = (np.concatenate([getattr(x, n) for x in found])[back] for n in ("q", "v", "a", "lam"))
        return State(times, q, v, a, lam) if times.ndim else State(float(times), q[0], v[0], a[0], lam[0])

    def _pieces(self, times: Array) -> list[tuple[int, int, int, int]]:
        """Between jumps: the first time and the one behind the last, the first node and the one behind the last."""
        cuts = [0, *self._jumps, len(self._nodes.t)]
        ends = [0, *np.searchsorted(times, self._nodes.t[self._jumps], side="left"), len(times)]
        return [(ends[n], ends[n + 1], cuts[n], cuts[n + 1]) for n in range(len(cuts) - 1)]

    def _between(self, times: Array, first: int, last: int, begin: int, end: int) -> Any:
        return self._sampler.states(self._nodes.part(slice(begin, end)), times[first:last])
