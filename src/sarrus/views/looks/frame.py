"""Frames of what is drawn and moves, but is no body: their coordinates are behind those of the bodies."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...algebra import Array
from ...euler import G
from ...model.coordinates import slice_of
from ...system.structure.population import GROUND
from .part import place_of


class MovingFrame(NamedTuple):
    """A frame, and its coordinates [r; p] (n, 7) at times t (n,), of q and v (n, nq)."""

    name: str
    coordinates: Callable[[Array, Array, Array], Array]


def lifted(name: str, height: Callable[[float], float]) -> MovingFrame:
    """The global frame, at a height [m] that is a function of time."""

    def coordinates(t: Array, q: Array, v: Array) -> Array:
        frames = np.tile(GROUND, (len(t), 1))
        frames[:, 2] = [float(height(at)) for at in t.tolist()]
        return frames

    return MovingFrame(name, coordinates)


def spun(name: str, body: int, point: Array, axis: Array, place: int) -> MovingFrame:
    """The frame of a wheel whose spin W about an axis of its carrier is a state.

    The integral of W is a coordinate of the block of the state, so that the angle relative to the carrier is that
    coordinate less ∫ ω·s dt, of the carrier's angular velocity ω and the spin axis s, by the trapezoidal rule: it is
    small unless the carrier turns about s. The rotation by this angle θ follows that of the carrier,

        p cos(θ/2) + Gᵀ(p) s sin(θ/2),    ω·s = 2 (Gᵀ s)·ṗ

    Parameters
    ----------
    name : of the tyre
    body : number of the carrier
    point, axis : the wheel centre [m] and s in the axes of the carrier (3,)
    place : of W in v, and of its integral in q
    """
    own = slice_of(body - 1)

    def coordinates(t: Array, q: Array, v: Array) -> Array:
        p = q[:, own][:, 3:]
        turn = np.array([G(row).T @ axis for row in p])
        rate = 2 * np.sum(turn * v[:, own][:, 3:], axis=1)
        carried = np.append(0.0, np.cumsum(np.diff(t) * (rate[1:] + rate[:-1]) / 2))
        half = (q[:, place] - carried)[:, None] / 2
        centre = place_of(q, body, point)
        return np.column_stack([centre, p * np.cos(half) + turn * np.sin(half)])

    return MovingFrame(name, coordinates)
