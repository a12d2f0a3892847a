"""Defects of stiff steps, whose adjoint is not linear within the step.

Of a direction that decays by e⁻ᶻ within a step, the adjoint there is ȳ(s) = e^(-z (1 - s)) ȳ₁: effects of the first
parts of the step have decayed at its end. The defect is zero at both ends of a step, so that for large z

    h ∫ ȳᵀ d ds = -h ȳ₁ᵀ d'(1) / z²,    but with an adjoint that is linear from 0 to ȳ₁    h ȳ₁ᵀ ∫ s d ds,

which is larger by a factor of the size of z², and of any sign. Such steps are found by what their method leaves of ȳ₁
before them: Radau IIA at most 1/15 for z > 2.7, and 3/z for large z. They are divided, see `divided_steps`.

Where a stiff direction rotates, linear adjoints are not small there. If filtered ones make the largest contributions to
a response much smaller, and then all contributions together, they weigh all steps. In a motion that is not stiff, the
defect changes its sign within a step, and its mean is far smaller: a single contribution may be small by accident.

Whether a motion about a state may be fast: a cheap test before what only fast motions need.

Random changes of a state have components of the same size, displacements in parts of the extent of the system. A mode
of any direction, frequency and damping accelerates some coordinate by it, also one of few bodies among many.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ....linalg.factors import SingularSystem
from ....results import StepsTaken
from ....results.motion.steps import part_of
from ....system import System
from ....system.curves.curve_derivatives import CurveDerivatives
from ..chain.start import Start
from .defect import FEW, Defect
from .divided_steps import parts_in_errors, whole_steps

LEFT = 0.3  # of the weight of the defect after a stiff step: before it at most
BENT = 0.5  # of this weight: least difference between its change in a stiff step and in the step before
MATTERS = 0.05  # of the error by all other steps: a stiff step whose weights change by less stays as it is
ROUND_OFF = 10.0  # of its effect on the response: the same
# Steps of the largest contributions to all responses together, and to each, to find whether a motion is stiff
COMPARED, LEAST_COMPARED = 16, 4
LOOKED_AT = 2  # of these steps, those of the largest contributions: whether they may be stiff
SHORT = 0.5  # of a radian per step: slower motions are not stiff
STIFF = 0.2  # of the largest contributions: what filtered adjoints leave at most in a stiff motion
STIFF_RUN = 0.3  # of all contributions: the same
BLOCK = 1000  # steps whose states between nodes are stored at once
DIVIDED = 2  # steps for each response, those of the largest changes; others change by the same factor
DECAY = 3.0  # z R(-z) of Radau IIA for large z
LARGE = 0.3  # of the error: a step that contributes more is divided, too
ROUNDS = 4
HALVINGS = (5, 20)  # of a step, at least and at most
TINY = float(np.finfo(float).tiny)
DRAWS = 4  # random changes of states: for a mode to have a small part in one of them is not rare


class Changes(NamedTuple):
    """Changes of the weights of defects within stiff steps, of others zero (n, k).

    decayed : whether little of the weight is left before a step
    left : what is left of the weight, or of its change
    """

    sizes: Array
    decayed: Array
    left: Array

    @classmethod
    def of(cls, steps: StepsTaken, own: Defect, adjoints: Array) -> Changes:
        """Those in the steps of a stretch, by the adjoints before and after them (n, 2, 2 nq, k).

        Methods of order two do not damp stiff directions within a step, and have no stiff steps in this sense.
        """
        before, after = np.einsum("nj,nejk->enk", own.after, adjoints)
        change, expected = after - before, after - before
        rates = (adjoints[:-1, 1] - adjoints[:-1, 0]) / steps.h[:-1, None, None]
        expected[1:] = steps.h[1:, None] * np.einsum("nj,njk->nk", own.after[1:], rates)
        decayed, bend = abs(before) < LEFT * abs(after), abs(change - expected)
        stiff = decayed | (bend > BENT * np.maximum(abs(before), abs(after)))
        sizes = np.where(decayed, abs(change), bend)
        left = np.minimum(_ratio(expected, change), _ratio(before, after))
        return cls(np.where(stiff & steps.precise, sizes, 0.0), decayed, left)


def weighted_defects(
    system: System, pieces: Sequence[StepsTaken], adjoints: Sequence[Array], defects: Sequence[Defect], noise: Array
) -> Array:  # fmt: skip
    """The part of each step of all stretches in the error of each response (n, k), by the adjoints of stretches.

    Stiff steps near to the `noise` of round-off (k,) stay as they are.
    """
    linear = np.concatenate([own.weighted(bars) for own, bars in zip(defects, adjoints, strict=True)])
    triples = zip(pieces, defects, adjoints, strict=True)
    sizes, decayed, left = map(np.concatenate, zip(*(Changes.of(*one) for one in triples), strict=True))
    linear, sizes = _filtered(system, pieces, adjoints, defects, linear, sizes, noise)
    others = abs(np.where(sizes > 0.0, 0.0, linear).sum(axis=0))
    sizes = np.where(sizes > np.maximum(MATTERS * others, ROUND_OFF * noise), sizes, 0.0)
    decayed &= sizes > 0.0
    found, shares = np.full(linear.shape, np.nan), linear
    for _ in range(ROUNDS):
        rows, columns = _largest(sizes, DIVIDED)
        if not len(rows):
            break
        halvings = int(np.clip(np.ceil(np.log2(DECAY / left[rows, columns].min())), *HALVINGS))
        found[rows, columns] = _divided(system, pieces, adjoints, (rows, columns), halvings)
        shares = _completed(found, linear, decayed)
        large = abs(shares) > LARGE * abs(shares.sum(axis=0))
        sizes = np.where(large & np.isnan(found), sizes, 0.0)
    return shares


def _filtered(
    system: System, pieces: Sequence[StepsTaken], adjoints: Sequence[Array], defects: Sequence[Defect],
    linear: Array, sizes: Array, noise: Array,
) -> tuple[Array, Array]:  # fmt: skip
    """The parts of steps in errors (n, k), filtered where the motion is stiff, and changes, not larger there.

    A few steps take little longer together than some of them alone.
    """
    large = np.where(abs(linear).sum(axis=0) > ROUND_OFF * noise, abs(linear), 0.0)
    rows = np.unique(_largest(large, max(COMPARED // linear.shape[1], LEAST_COMPARED))[0])
    largest = _largest(large.max(axis=1, keepdims=True), LOOKED_AT)[0]
    if not any(_may_be_stiff(system, pieces, int(row)) for row in largest):
        return linear, sizes
    found, every = np.zeros_like(linear), np.arange(len(linear))
    first = every if len(every) <= FEW else rows
    found[first] = _whole(system, pieces, adjoints, defects, first)
    if not np.any(_left(found[rows], linear[rows]) < STIFF):
        return linear, sizes
    if len(others := np.setdiff1d(every, first)):
        found[others] = _whole(system, pieces, adjoints, defects, others)
    stiff = _left(found, linear) < STIFF_RUN
    shares = np.where(stiff & (abs(found) < abs(linear)), found, linear)
    return shares, np.where(stiff, np.minimum(sizes, abs(shares)), sizes)


def _may_be_stiff(system: System, pieces: Sequence[StepsTaken], row: int) -> bool:
    """Whether some motions at the start of a step may be much shorter than the step."""
    for own in pieces:
        if row < len(own):
            start = Start(system, part_of(own, row, 1), CurveDerivatives(system), by_numbers=False)
            return fast_motions(start, SHORT / float(own.h[row]))
        row -= len(own)
    return False


def _left(filtered: Array, linear: Array) -> Array:
    """The contributions (n, k) of steps by filtered adjoints over those by linear ones (k,)."""
    return _ratio(*(abs(x).sum(axis=0) for x in (filtered, linear)))


def _whole(
    system: System, pieces: Sequence[StepsTaken], adjoints: Sequence[Array], defects: Sequence[Defect], rows: Array
) -> Array:  # fmt: skip
    """The parts of some steps in errors (n, k) by filtered adjoints."""
    found, first = list[Array](), 0
    for own, bars, defect in zip(pieces, adjoints, defects, strict=True):
        which = rows[(rows >= first) & (rows < first + len(own))] - first
        known = defect.states if len(which) == len(own) and own.precise else None
        blocks = np.split(which, np.arange(BLOCK, len(which), BLOCK))
        found += [whole_steps(system, own, block, bars[block], known) for block in blocks if len(block)]
        first += len(own)
    return np.concatenate(found)


def _completed(found: Array, linear: Array, decayed: Array) -> Array:
    """The parts in errors (n, k) that have been found, not nan, and those by linear adjoints.

    Where the adjoint has decayed, the latter are smaller by the same factor as those that have been found.
    """
    known = ~np.isnan(found)
    sizes = (abs(np.where(known, x, 0.0)).sum(axis=0) for x in (found, linear))
    return np.where(known, found, np.where(decayed & known.any(axis=0), _ratio(*sizes) * linear, linear))


def _divided(
    system: System,
    pieces: Sequence[StepsTaken],
    adjoints: Sequence[Array],
    at: tuple[Array, Array],
    halvings: int,
) -> Array:
    """The parts of steps in errors, at these numbers of steps and of responses."""
    (rows, columns), first = at, 0
    found = np.empty(len(rows))
    for own, bars in zip(pieces, adjoints, strict=True):
        here = (rows >= first) & (rows < first + len(own))
        if here.any():
            which = rows[here] - first
            found[here] = parts_in_errors(system, own, which, bars[which, 1, :, columns[here]].T, halvings)
        first += len(own)
    return found


def _ratio(x: Array, y: Array) -> Array:
    with np.errstate(over="ignore"):  # more than the largest number is much, too
        return np.asarray(np.maximum(abs(x), TINY) / np.maximum(abs(y), TINY))


def _largest(sizes: Array, count: int) -> tuple[Array, Array]:
    """The places of the largest sizes (n, k) above zero in each column: rows, and columns."""
    rows = np.argsort(-sizes, axis=0, kind="stable")[:count]
    columns = np.broadcast_to(np.arange(sizes.shape[1]), rows.shape)
    chosen = sizes[rows, columns] > 0.0
    return rows[chosen], columns[chosen]


def fast_motions(start: Start, omega: float) -> bool:
    """Whether there may be modes faster than omega [rad/s] at a state.

    Mechanisms whose motion is prescribed, or that are stuck, have none.
    """
    if not start.freedom:
        return False
    by_q, by_v = _signs(len(start.units)) * start.units
    try:
        return fast_changes(start, by_q, omega * by_v, np.zeros((start.width, DRAWS)), omega, rounds=1)
    except SingularSystem:
        return False


@cache
def _signs(size: int) -> Array:
    """Random signs of changes of coordinates and velocities (2, size, DRAWS)."""
    return np.random.default_rng(5).choice([-1.0, 1.0], (2, size, DRAWS))


def fast_changes(start: Start, q: Array, v: Array, none: Array, omega: float, rounds: int) -> bool:
    """Whether changes of states (nq, k) may contain motions faster than omega, by the accelerations that they cause.

    In further rounds, these are caused by the rates of the changes.
    """
    for _ in range(rounds):
        a = start.along(q, v, none)[0]
        of_q, of_v, of_a = (float(abs(x / start.units).max()) for x in (q, v, a))
        if of_a > omega * max(omega * of_q, of_v):
            return True
        q, v = v, a
    return False
