"""Steps towards equilibrium along the free directions: Newton's, and the same bent downhill and limited in length."""

from __future__ import annotations

import math

import numpy as np

from ...algebra import Array
from .balance import Balance

PUSH = 1e-6  # displacement along an unstable direction, in parts of the model's size
TINY = 1e-300
SHARE = 1e-10  # of the force: what along a neutral direction is round-off


def newton_step(now: Balance) -> Array:
    """Z y with H y = g; nothing along neutral directions (nq,)."""
    if now.system.states:
        sizes = np.maximum(abs(now.H).max(axis=1), TINY)  # forces and rates of states have different units
        return np.asarray(now.Z @ np.linalg.lstsq(now.H / sizes[:, None], now.g / sizes, rcond=None)[0])
    spectrum = now.spectrum
    keep = spectrum.vectors[:, ~spectrum.neutral]
    return np.asarray(now.Z @ (keep @ np.linalg.lstsq(keep.T @ now.H @ keep, keep.T @ now.g, rcond=None)[0]))


def slide_step(now: Balance, scale: Array, radius: float) -> Array:
    """Z y with (H + σ W) y = g, for the smallest σ ≥ 0 that makes H + σ W positive and no change too large (nq,).

    Where σ is 0 this is Newton's step. With a large σ it is the motion through a very viscous fluid.
    """
    spectrum = now.spectrum
    lowest = spectrum.squares[~spectrum.neutral].min(initial=np.inf)
    if lowest > 0 and not _drifts(now):
        step = newton_step(now)
        if _size(step, scale) <= radius:
            return step
    return _bent(now, scale, radius)


def _drifts(now: Balance) -> bool:
    """Whether a force acts along a direction without stiffness."""
    share = now.spectrum.vectors.T @ now.g
    loose = abs(share[now.spectrum.neutral]).max(initial=0.0)
    return bool(loose > SHARE * np.linalg.norm(abs(now.Z @ now.spectrum.vectors).T @ now.force_terms))


def _bent(now: Balance, scale: Array, radius: float) -> Array:
    """Bisection for σ on a logarithmic scale."""
    squares, share = now.spectrum.squares, _shaken(now, scale)
    top = float(abs(squares).max(initial=0.0)) or 1.0
    floor = max(0.0, -squares.min(initial=0.0))

    def step(sigma: float) -> Array:
        return np.asarray(now.Z @ (now.spectrum.vectors @ (share / (squares + floor + sigma))))

    low, high = 1e-14 * top, top
    while _size(step(high), scale) > radius:
        high *= 10
    for _ in range(60):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if _size(step(middle), scale) > radius else (low, middle)
    return step(high)


def _shaken(now: Balance, scale: Array) -> Array:
    """The forces on the vibration modes; a little is added on unstable ones, where they might be exactly zero.

    It is the force of a displacement by `PUSH` along the mode.
    """
    share = now.spectrum.vectors.T @ now.g
    unstable = (now.spectrum.squares < 0) & ~now.spectrum.neutral
    sizes = abs((now.Z @ now.spectrum.vectors) / scale[:, None]).max(axis=0)
    least = PUSH * abs(now.spectrum.squares) / sizes
    push = np.where(share < 0, -1.0, 1.0) * least
    return np.asarray(np.where(unstable & (abs(share) < least), push, share))


def _size(step: Array, scale: Array) -> float:
    return float(abs(step / scale).max(initial=0.0))
