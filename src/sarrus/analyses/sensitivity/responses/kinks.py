"""Kinks of outputs: where the argument of an absolute value changes its sign within a run.

`np.abs`, `np.maximum`, `np.minimum`, `np.clip` are absolute values of something (`model.tape`), which notes them. A
rule for integrals is exact on polynomials, and loses its order where a kink is inside a panel; steps are split there.
The kink moves with the design, but as the output is continuous, the integral does not change with its place.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ..sampling.pieces import Course, Where
from .panels import Panels, Rule
from .resolution import Ends

SEARCHED = np.linspace(0.0, 1.0, 5)  # [-] of a step, between which a change of sign is looked for
# Of the values beside it: an extreme nearer to zero is looked at itself, there may be two roots
GRAZING = 0.1
SAME = 1e-9  # [-] of a step: kinks nearer to each other, or to a node, are one; as times are a node's in `sampling`
ITERATIONS, ROOT = 60, 1e-13  # of the search for a root; [-] of a step to which it is found
MOST = 0.5  # changes of sign a step, from which on it is that of round-off: of something that is always zero
FAINT = 1e4  # times the round-off of what it is computed from
FEW = 8  # kinks that no one takes for noise

Arguments = Callable[[Where], list[Array]]


class Steps(NamedTuple):
    """All steps of a run: begin and end [s], the stretch between events, whether an event moves their end."""

    begin: Array
    end: Array
    piece: Array
    last: Array

    @classmethod
    def of(cls, course: Course) -> Steps:
        """Return the kinks of a run."""
        begin, end = (np.concatenate([t[part] for t in course.t]) for part in (slice(-1), slice(1, None)))
        counts = [len(t) - 1 for t in course.t]
        piece = np.repeat(np.arange(len(counts)), counts)
        return cls(begin, end, piece, np.append(np.diff(piece) > 0, True))

    def where(self, step: Array, part: Array) -> Where:
        """Times within them, at parts of their lengths."""
        begin, end = self.begin[step], self.end[step]
        t = np.where(part == 1, end, begin + part * (end - begin))
        return Where(t, self.piece[step], np.where(self.last[step], part, 0.0))


class Layout(NamedTuple):
    """Samples of an output with kinks.

    Attributes
    ----------
    panels : between its kinks
    where : the samples
    sides : (kinks, samples) the signs of the arguments
    noisy : whether an argument is zero to round-off, so that its sign means nothing
    """

    panels: Panels
    where: Where
    sides: Array
    noisy: bool


def between_kinks(steps: Steps, arguments: Arguments, noise: Sequence[float]) -> tuple[Ends, bool]:
    """Panels between the kinks of an output, of its arguments at any times; and whether one is no more than noise."""
    step, part, noisy = _roots(steps, arguments, noise)
    step, part = _cut(len(steps.begin), step, part)
    same = step[1:] == step[:-1]
    return Ends(step[:-1][same], part[:-1][same], part[1:][same]), noisy


def layout(steps: Steps, ends: Ends, arguments: Arguments, rule: Rule, noisy: bool = False) -> Layout:
    """Return the samples of an output in panels."""
    inner, low, high = ends.chosen(np.lexsort((ends.low, ends.step)))
    sides = np.sign(np.reshape(arguments(steps.where(inner, 0.5 * (low + high))), (-1, len(inner))))
    near = steps.piece[inner[1:]] == steps.piece[inner[:-1]]
    smooth = near & np.all(sides[:, 1:] == sides[:, :-1], axis=0)
    count, shared = len(rule.parts), np.append(0, smooth.astype(np.int64))
    first = np.cumsum(count - shared) - count
    at = first[:, None] + np.arange(count)
    panel = np.zeros(at[-1, -1] + 1, dtype=np.int64)
    panel[at] = np.arange(len(inner))[:, None]
    parts = np.zeros(len(panel))
    parts[at] = low[:, None] + (high - low)[:, None] * np.array(rule.parts)
    parts[at[:, -1]] = high  # not low + (high - low)
    panel[at[:, -1]] = np.arange(
        len(inner)
    )  # a shared sample is the end of a step: the next begins at a part 0
    joints = at[:-1, -1][near & ~smooth]
    panels = Panels(first, rule.shares, joints)
    return Layout(panels, steps.where(inner[panel], parts), sides[:, panel], noisy or not np.all(sides))


def _cut(count: int, step: Array, part: Array) -> tuple[Array, Array]:
    """The ends of all panels, of all steps and of kinks inside of them: steps, and parts of them, rising."""
    inside = (part > SAME) & (part < 1 - SAME)
    every = np.arange(count)
    step = np.concatenate([every, step[inside], every])
    part = np.concatenate([np.zeros(count), part[inside], np.ones(count)])
    order = np.lexsort((part, step))
    step, part = step[order], part[order]
    apart = np.append(True, (np.diff(step) > 0) | (np.diff(part) > SAME))
    return step[apart], part[apart]


def _roots(steps: Steps, arguments: Arguments, noise: Sequence[float]) -> tuple[Array, Array, bool]:
    """Return the steps and parts of steps where arguments change sign."""
    count, width = len(steps.begin), len(SEARCHED)
    every = np.repeat(np.arange(count), width)
    values = [x.reshape(count, width) for x in arguments(steps.where(every, np.tile(SEARCHED, count)))]
    found = [_brackets(x) for x in values]
    grazing = [_grazing(x) for x in values]
    noisy = [
        abs(x).max() <= FAINT * least and np.count_nonzero(np.diff(np.sign(x))) > max(FEW, MOST * count)
        for x, least in zip(values, noise, strict=True)
    ]
    stored = [k for k, noise in enumerate(noisy) if not noise]
    brackets = [(k, found[k]) for k in stored] + [
        (k, side) for k in stored for side in _about(steps, arguments, k, values[k], grazing[k])
    ]
    if not any(len(b.step) for _, b in brackets):
        return np.zeros(0, dtype=np.int64), np.zeros(0), any(noisy)
    kink = np.concatenate([np.full(len(b.step), k) for k, b in brackets])
    every_one = Bracket._make(np.concatenate(x) for x in zip(*(b for _, b in brackets), strict=True))
    return every_one.step, _refined(steps, arguments, kink, every_one), any(noisy)


class Bracket(NamedTuple):
    """Parts of steps between which an argument changes its sign, and its values there."""

    step: Array
    low: Array
    high: Array
    at_low: Array
    at_high: Array


def _brackets(x: Array) -> Bracket:
    """Return the brackets between neighbours (steps, parts)."""
    step, k = np.nonzero(x[:, :-1] * x[:, 1:] < 0)
    return Bracket(step, SEARCHED[k], SEARCHED[k + 1], x[step, k], x[step, k + 1])


def _grazing(x: Array) -> tuple[Array, Array, Array]:
    """Steps, parts, and places of the middle of three neighbours of one sign about an extreme next to zero."""
    before, here, after = x[:, :-2], x[:, 1:-1], x[:, 2:]
    bend, slope = after - 2 * here + before, 0.5 * (after - before)
    with np.errstate(divide="ignore", invalid="ignore"):
        ahead = -slope / bend
        depth = here + 0.5 * slope * ahead
    same = (before * here > 0) & (here * after > 0) & (abs(ahead) <= 1)
    step, k = np.nonzero(same & (depth * np.sign(here) < GRAZING * np.minimum(abs(before), abs(after))))
    return step, k + 1, (SEARCHED[1] * ahead)[step, k]


def _about(
    steps: Steps, arguments: Arguments, kink: int, x: Array, grazing: tuple[Array, Array, Array]
) -> list[Bracket]:
    """Those on both sides of such an extreme, where it is behind zero."""
    step, k, ahead = grazing
    if not len(step):
        return []
    middle = SEARCHED[k] + ahead
    there = arguments(steps.where(step, middle))[kink]
    across = there * x[step, k] < 0
    step, k, middle, there = step[across], k[across], middle[across], there[across]
    low, high = SEARCHED[k - 1], SEARCHED[k + 1]
    return [
        Bracket(step, low, middle, x[step, k - 1], there),
        Bracket(step, middle, high, there, x[step, k + 1]),
    ]


def _refined(steps: Steps, arguments: Arguments, kink: Array, given: Bracket) -> Array:
    """The roots in all brackets at once, by the Illinois method."""
    step, low, high, at_low, at_high = (np.array(x) for x in given)
    rows, root = np.arange(len(step)), 0.5 * (low + high)
    for _ in range(ITERATIONS):
        before, root = root, (low * at_high - high * at_low) / (at_high - at_low)
        here = np.array(arguments(steps.where(step, root)))[kink, rows]
        done = (here == 0) | (abs(root - before) <= ROOT)
        if np.all(done):
            break
        same = here * at_high > 0
        at_low = np.where(same, 0.5 * at_low, at_high)
        low = np.where(same, low, high)
        high, at_high = root, here
        low = np.where(done, root, low)
        at_low, at_high = np.where(done, -1.0, at_low), np.where(done, 1.0, at_high)
        high = np.where(done, root, high)
    return np.asarray(root)
