"""Tolerances that follow the size of the motion, so that units of a model do not matter: compiled, for all methods."""

from __future__ import annotations

from typing import NamedTuple

from ...._jit.linking.link import compiled
from ....algebra import Array

# Of the largest motion of a system, which that of each body is taken to be at least; of lengths: round-off
LEAST_MOTION, FINEST = 1e-3, 1e-13
GROWTH = 0.25  # power of the number of periods, by which tolerances are divided
LEAST_SHARE = 0.1  # so many times smaller they become at most: at a start from rest the period is unknown
# Periods from which on they fall with this power, so that errors, which grow with the square, stay the same; the least
# of them, and the steps after which the period is known
MANY_PERIODS, STEEP, LEAST_OF_MANY, KNOWN = 200.0, 1.5, 0.04, 1000
TURN = 6.283185307179586  # [rad] of a period
LENGTH, SPAN, SHARE, LARGEST, STEPS, SIZES = 0, 1, 2, 3, 7, 8  # places in `Tolerance.size`
UNUSED = -1.0  # in `Tolerance.states`
NOT_CONTROLLED = 1e150  # a tolerance
MOVES = 8  # columns of `Tolerance.motion`


class Tolerance(NamedTuple):
    """Relative and absolute, of each coordinate and of each velocity; `speed`: 1 if velocities are controlled too.

    Absolute ones that follow the motion are renewed by `follow_motion`:

    share_q, share_v : what they are of its size
    base : q at the start of the run
    bounds : of each body where its position, its Euler parameters and the next body begin (n, 3)
    motion : of each body the largest displacement, rotation and rates of both so far, and the same within a step (n, 8)
    size : characteristic length (0: absolute tolerances stay), duration of the run, the factor for its number of
        periods, the largest displacement, rotation and rates, and the number of attempted steps
    states : of the coordinates of blocks of states, behind those of bodies, the largest value so far, or `UNUSED`
    newton, stalled, stalled_repeated : of the tolerance: what Newton's method may leave; corrections that are taken for
        round-off where they fall no longer; the same where equations repeat others, whose combination may be weak
    slow : contraction at which the matrix is renewed for the next step
    noise : 0 if the round-off of Φ enters velocities by no division by h
    """

    rtol_q: Array
    atol_q: Array
    rtol_v: Array
    atol_v: Array
    speed: float
    share_q: Array
    share_v: Array
    base: Array
    bounds: Array
    motion: Array
    size: Array
    states: Array
    newton: float = 0.03
    stalled: float = 0.0
    stalled_repeated: float = 0.0
    slow: float = 0.3
    noise: float = 1.0


@compiled
def follow_motion(tol: Tolerance, h: float, q: Array, v: Array, a: Array, first: bool) -> None:
    """Absolute tolerances of a step: shares of how far and how fast each body has moved so far, and moves in the step.

    A body that hardly moves has `LEAST_MOTION` of the largest motion; displacements and rotations are compared by the
    system's length. Errors add up over a run: shares fall with the number of its periods. Nothing is asked for below
    round-off.
    """
    length, size = tol.size[LENGTH], tol.size
    if length == 0.0:
        return
    far = measure_motion(tol, h, q, v, a, first)
    by_displacement = periods(size[SPAN], size[LARGEST + 2], size[LARGEST])
    by_rotation = periods(size[SPAN], size[LARGEST + 3], size[LARGEST + 1])
    share = share_of(max(1.0, by_displacement, by_rotation), size[STEPS])
    size[SHARE], size[STEPS] = share, size[STEPS] + 1.0
    follow_states(tol, share, h, v, a, first)
    for i in range(len(tol.motion)):
        for kind in range(2):
            unit = 1.0 if kind == 0 else 1.0 / length
            noise = unit * far
            part = LEAST_MOTION * unit
            moved = part * max(size[LARGEST], length * size[LARGEST + 1])
            fast = part * max(size[LARGEST + 2], length * size[LARGEST + 3])
            moved = max(moved, tol.motion[i, kind], tol.motion[i, 4 + kind])
            fast = max(fast, tol.motion[i, 2 + kind], tol.motion[i, 6 + kind])
            for k in range(tol.bounds[i, kind], tol.bounds[i, kind + 1]):
                tol.atol_q[k] = max(share * tol.share_q[k] * moved, FINEST * noise)
                tol.atol_v[k] = max(share * tol.share_v[k] * fast, FINEST * noise / h)


@compiled
def measure_motion(tol: Tolerance, h: float, q: Array, v: Array, a: Array, first: bool) -> float:
    """Bring `motion` and the largest of `size` up to date; returns how far from the origin bodies are."""
    size, far, ahead = tol.size, tol.size[LENGTH], (h if first else 0.0)
    for k in range(LARGEST, STEPS):
        size[k] = 0.0
    for i in range(len(tol.motion)):
        for kind in range(2):
            moved, fast, gain = 0.0, 0.0, 0.0
            for k in range(tol.bounds[i, kind], tol.bounds[i, kind + 1]):
                moved += (q[k] - tol.base[k]) ** 2
                fast += v[k] ** 2
                gain += a[k] ** 2
                far = max(far, abs(q[k]) if kind == 0 else 0.0)
            moved, fast, gain = moved**0.5, fast**0.5, ahead * gain**0.5
            tol.motion[i, kind] = max(tol.motion[i, kind], moved)
            tol.motion[i, 2 + kind] = max(tol.motion[i, 2 + kind], fast)
            tol.motion[i, 4 + kind] = moved + h * (fast + 0.5 * gain)
            tol.motion[i, 6 + kind] = fast + gain
            for k in (kind, 2 + kind):
                size[LARGEST + k] = max(size[LARGEST + k], tol.motion[i, k], tol.motion[i, 4 + k])
    return float(far)


@compiled
def follow_states(tol: Tolerance, share: float, h: float, v: Array, a: Array, first: bool) -> None:
    """The same for first-order states, each in its own unit: shares of the largest value so far.

    A small state has `LEAST_MOTION` of its nominal value. Its coordinate is the integral of it, with the error of the
    state over the time in which the mechanism moves by its size, or the state changes by its own.
    """
    size, begin = tol.size, len(v) - len(tol.states)
    slow = size[SPAN] if size[SPAN] > 0.0 else NOT_CONTROLLED
    for kind in range(2):
        if size[LARGEST + 2 + kind] > 0.0:
            slow = min(slow, size[LARGEST + kind] / size[LARGEST + 2 + kind])
    for k in range(begin, len(v)):
        largest = tol.states[k - begin]
        tol.atol_q[k], tol.atol_v[k] = NOT_CONTROLLED, NOT_CONTROLLED
        if largest != UNUSED:
            largest = max(largest, abs(v[k]) + (h * abs(a[k]) if first else 0.0))
            tol.states[k - begin] = largest
            time = max(min(slow, largest / abs(a[k])) if a[k] != 0.0 else slow, h)
            tol.atol_q[k] = share * tol.share_q[k] * largest * time
            tol.atol_v[k] = share * tol.share_v[k] * largest


@compiled
def share_of(number: float, steps: float) -> float:
    """Return the factor of the tolerances for a number of periods."""
    share = max(number**-GROWTH, LEAST_SHARE)
    if number > MANY_PERIODS and steps >= KNOWN:
        share = max(MANY_PERIODS**-GROWTH * (number / MANY_PERIODS) ** -STEEP, LEAST_OF_MANY)
    return float(share)


@compiled
def periods(span: float, fast: float, moved: float) -> float:
    """Return the number of periods of a vibration with these largest rates and displacements; 0 at rest."""
    return float(span * fast / (TURN * moved)) if moved > 0.0 else 0.0
