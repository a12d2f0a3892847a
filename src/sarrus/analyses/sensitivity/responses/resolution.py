"""Outputs that change faster than the steps of a run: panels are halved until samples show how they change.

A short peak of an output, or an oscillation that a formula of the time adds, does not bound the steps of the motion,
and a rule with few samples in each step would miss it. So points between the samples of each panel are compared with
the polynomial through these: many in a long step, only its middle in a short panel.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np

from ....algebra import Array
from ..sampling.pieces import Where
from .panels import LOBATTO, Rule

DEEPEST, MOST = 24, 20_000  # halvings of a panel; panels
LOOKS = 1000  # points of a run, at least, at which deviations are looked for
FEW_STEPS = 30  # of the longest, and of all, in which outputs are compared with those of consistent states
FEW_LOOKS = 200  # points in these steps, three in each at least
# Error of an integral with a rule of four samples, and with the trapezoidal one, over that of the absolute output
INTEGRAL = {4: 1e-5, 2: 1e-2}
SHARE = 0.2  # of that error: panels with more of it for their length are halved
# Error of a rule over the length and the largest output, for deviations of the polynomial: factor, power
ERROR = {4: (0.1, 1.5), 2: (2 / 3, 1.0)}
EXTREME = {4: 1e-5, 2: 5e-2}  # of the range of the output: deviations that matter for an extreme
# Of the largest output: deviations of interpolated states from those of the run
FAITHFUL = {4: 1e-5, 2: 5e-2}
HIGHER = 4.0  # by so many deviations an extreme is beyond the samples

Coarse: TypeAlias = Callable[[Array, Array, Array], Array]


class Ends(NamedTuple):
    """Panels: their steps, and the parts of these at which they begin and end (panels,)."""

    step: Array
    low: Array
    high: Array

    def halves(self) -> Ends:
        """The two of each."""
        middle = 0.5 * (self.low + self.high)
        return Ends(*(np.concatenate(x) for x in ([self.step] * 2, [self.low, middle], [middle, self.high])))

    def at(self, parts: Array) -> tuple[Array, Array]:
        """Steps and parts of them (panels, parts)."""
        part = self.low[:, None] + (self.high - self.low)[:, None] * parts
        return np.broadcast_to(self.step[:, None], part.shape), part

    def chosen(self, which: Array | slice) -> Ends:
        """Some of them."""
        return Ends(self.step[which], self.low[which], self.high[which])


def resolved(
    panels: Ends, lengths: Array, rule: Rule, output: Callable[[Array, Array], Array], coarse: Coarse, noise: float,
    known: Array | None = None,
) -> tuple[Ends, bool]:  # fmt: skip
    """Halves of panels where an output is not resolved, and whether all of it is resolved then.

    Parameters
    ----------
    panels : to begin with
    lengths : of all steps [s]
    output : its values at parts of steps
    coarse : which panels to halve, of their lengths, samples and deviations in the middle, see `Response.coarse`
    noise : deviations that are round-off
    known : samples of the panels (panels, samples), if they are known
    """
    between = LOOKS // len(panels.step) | 1  # an odd number, for the middle
    g, deviations = looked_at(panels, rule, output, noise, between, known)
    for _ in range(DEEPEST):
        wanted = coarse((panels.high - panels.low) * lengths[panels.step], g, deviations)
        if not wanted.any():
            return panels, True
        if len(wanted) + np.count_nonzero(wanted) > MOST:
            return panels, False
        halves, between = panels.chosen(wanted).halves(), between // 2 | 1
        panels = Ends(*(np.concatenate(x) for x in zip(panels.chosen(~wanted), halves, strict=True)))
        found = looked_at(halves, rule, output, noise, between)
        own = zip((g[~wanted], deviations[~wanted]), found, strict=True)
        g, deviations = (np.concatenate(x) for x in own)
    return panels, True  # an output that jumps


def looked_at(
    panels: Ends, rule: Rule, output: Callable[[Array, Array], Array], noise: float, between: int = 1,
    known: Array | None = None,
) -> tuple[Array, Array]:  # fmt: skip
    """Samples of panels, and how far the output deviates from their polynomials at some points between."""
    parts, inner = np.array(rule.parts), np.arange(1, between + 1) / (between + 1)
    g = output(*panels.at(parts)) if known is None else known
    deviations = abs(output(*panels.at(inner)) - g @ _polynomials(parts, inner)).max(axis=1)
    return g, np.where(deviations > noise, deviations, 0.0)


def _polynomials(parts: Array, at: Array) -> Array:
    """Weights of a panel's samples in values of their polynomial (samples, at)."""
    count = len(parts)
    return np.asarray(np.linalg.solve(np.vander(parts, count).T, np.vander(at, count).T))


def about_extreme(ends: Ends, piece: Array, sign: int, output: Callable[[Array, Array], Array]) -> Ends:
    """The panel with the extreme sample and its neighbours, in the order of time.

    Parameters
    ----------
    piece : the stretch between events in which each step lies
    sign : 1 for a maximum, -1 for a minimum
    """
    ends = ends.chosen(np.lexsort((ends.low, ends.step)))
    return _beside(ends, piece, sign * output(*ends.at(np.array(LOBATTO.parts))), wide=True)[0]


def narrowed(
    ends: Ends, piece: Array, sign: int, output: Callable[[Array, Array], Array], noise: float, precise: bool
) -> Ends:
    """The panels about an extreme, halved until a polynomial through all of their samples shows the output to `noise`.

    In long steps that is where cubics through the samples of each panel deviate by the root of this, relative to the
    output: three panels have a polynomial of more than twice the degree. Shorter ones would lose digits of its second
    derivative. Short steps of methods that are not `precise` have a polynomial each, and cubics show it.
    """
    for _ in range(DEEPEST):
        ends = ends.chosen(np.lexsort((ends.low, ends.step)))
        g, deviations = looked_at(ends, LOBATTO, output, 0.0)
        ends, near = _beside(ends, piece, sign * g, wide=True)
        if not deviations[near].max() > (np.sqrt(noise * abs(g).max()) if precise else noise):
            break
        ends = ends.halves()
    return ends


def _beside(ends: Ends, piece: Array, g: Array, wide: bool = False) -> tuple[Ends, Array]:
    """The panel with the largest sample, and those beside this sample, or all beside the panel; with their places."""
    n, sample = np.unravel_index(np.argmax(g), g.shape)
    every = np.arange(len(g))
    near = (every >= n - (wide or sample == 0)) & (every <= n + (wide or sample == g.shape[1] - 1))
    near &= piece[ends.step] == piece[ends.step[n]]
    return ends.chosen(near), near


def coarse_for_integral(h: Array, g: Array, deviations: Array) -> Array:
    """Return the panels that make an integral inaccurate."""
    errors, allowed = errors_of_integral(h, g, deviations)
    return np.asarray((errors * h.sum() > SHARE * allowed * h) & (errors.sum() > allowed))


def errors_of_integral(h: Array, g: Array, deviations: Array) -> tuple[Array, float]:
    """Estimated errors of the parts of an integral (panels,), and the largest sum of them that is allowed."""
    count, largest = g.shape[1], max(abs(g).max(), deviations.max())
    factor, power = ERROR[count]
    errors = factor * h * largest * (deviations / (largest or 1.0)) ** power
    return errors, INTEGRAL[count] * float(h @ abs(g).mean(axis=1))


def coarse_for_extreme(g: Array, deviations: Array) -> Array:
    """Return the panels that may contain a larger value."""
    tops, span = g.max(axis=1) + HIGHER * deviations, max(np.ptp(g), deviations.max())
    return np.asarray((deviations > EXTREME[g.shape[1]] * span) & (tops >= g.max()))


def every_step(count: int) -> Ends:
    """So many steps as panels."""
    return Ends(np.arange(count), np.zeros(count), np.ones(count))


def of_steps(g: Array, samples: int, counts: list[int]) -> Array:
    """The samples of all steps (steps, samples), of a response that is sampled as by `within`."""
    inner = samples - 1
    rows = np.concatenate([g[:-1].reshape(-1, inner), g[inner::inner, None]], axis=1)
    ends = np.cumsum(np.array(counts) + 1)[:-1] - 1  # steps of no length between stretches
    return np.delete(rows, ends, axis=0)


def unused(_: Where) -> list[Array]:
    """The arguments of absolute values of an output that has none."""
    return []
