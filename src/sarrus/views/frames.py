"""A run at evenly spaced times, for pictures that move."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..algebra import Array
from ..results import Trajectory

MOST = 600  # frames, unless asked otherwise


class Frames(NamedTuple):
    """Evenly spaced times t (n,) [s], and q, v (n, nq) there; p of each body keeps its sign from frame to frame."""

    t: Array
    q: Array
    v: Array

    @property
    def step(self) -> float:
        """Time between two frames [s]; 1 if there is only one."""
        return float(self.t[1] - self.t[0]) if len(self.t) > 1 else 1.0


def frames(run: Trajectory, most: int = MOST) -> Frames:
    """The run at ``most`` times, by the cubic through q and v at the times that it holds.

    Raises
    ------
    ValueError
        If the run holds no state.
    """
    if not len(run.t):
        raise ValueError(f"{run.name}: the run holds no states, so there is nothing to show; {run.message}")
    if len(run.t) == 1 or run.t[-1] <= run.t[0]:
        return Frames(run.t[:1], run.q[:1], run.v[:1])
    t = np.linspace(run.t[0], run.t[-1], max(2, most))
    k = np.clip(np.searchsorted(run.t, t, side="right") - 1, 0, len(run.t) - 2)
    h = np.maximum(run.t[k + 1] - run.t[k], np.finfo(float).tiny)[:, None]
    s = (t - run.t[k])[:, None] / h
    q = _same_signs(run.q)
    signs = np.where(q == run.q, 1.0, -1.0)
    return Frames(t, *_cubic(s, h, q, signs * run.v, k))


def _cubic(s: Array, h: Array, q: Array, v: Array, k: Array) -> tuple[Array, Array]:
    """Hermite's cubic and its rate."""
    q_0, q_1, v_0, v_1 = q[k], q[k + 1], h * v[k], h * v[k + 1]
    value = (1 + 2 * s) * (1 - s) ** 2 * q_0 + s * (1 - s) ** 2 * v_0
    value += s**2 * (3 - 2 * s) * q_1 + s**2 * (s - 1) * v_1
    rate = 6 * s * (1 - s) * (q_1 - q_0) + (1 - s) * (1 - 3 * s) * v_0 + s * (3 * s - 2) * v_1
    return value, rate / h


def _same_signs(q: Array) -> Array:
    """The same rotations with p and not -p where that is nearer to the time before."""
    out = q.copy()
    for at in range(3, q.shape[1], 7):
        p = q[:, at : at + 4]
        flips = np.where(np.einsum("ij,ij->i", p[1:], p[:-1]) < 0, -1.0, 1.0)
        out[1:, at : at + 4] = np.cumprod(flips)[:, None] * p[1:]
    return out


def interpolated(run: Trajectory, values: Array, t: Array) -> Array:
    """Values (nt, n) of a run on straight lines between its times."""
    columns = [np.interp(t, run.t, column) for column in values.T]
    return np.column_stack(columns) if columns else np.zeros((len(t), 0))
