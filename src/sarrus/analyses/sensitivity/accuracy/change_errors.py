"""Errors of changes of states: what steps that suit the motion, but not its changes by parameters, do to derivatives.

Steps are chosen for the motion. While it rests they may be longer than the oscillation that a parameter would cause,
and where it meets a contact they do not know that it would meet it earlier. With the defect d of a run and the changes
u' of its states with the parameters b, the derivative of the error ∫ ȳᵀ d dt of a response contains

    ∫ ȳᵀ (∂d/∂u u' + ∂d/∂b b') dt,

which is an error of derivatives even where d vanishes. Random b' give the size of all of them, and as no more is
wanted, the change of d is a difference; numbers of tables and formulas are left out. The part of a step is at most what
the whole change at its end does: where that has decayed, a long step does no harm.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from ....algebra import Array
from ....results import Pieces, StepsTaken
from ....results.motion.steps import stretches
from ....system import System
from ...equations.length import extent
from ..chain.chain import Gradients, Nodes
from ..events.chains import AnyChain
from ..parameters.parameters import Parameters
from .defect import Defect, defect
from .growth import DERIVATIVES, STATES, few

UNEVEN = 20.0  # longest step over the median: of motions that never rest some 3, of those that do 28 and more
LONG = 3.0  # times the median: only such steps are looked at
WRONG_CHANGES = 0.01  # relative errors from which there is a warning: states may be right to all digits
DRAWN = 2  # random changes: normal ones, as those of a length and of its end may cancel each other
TINY = float(np.finfo(float).tiny)
SMALL = 1e-6  # change of positions, over the size of the mechanism


def uneven(steps: StepsTaken | Pieces) -> bool:
    """Whether some steps are far longer than most: only then are errors of changes estimated."""
    h = _lengths(steps)
    return bool(h.max() > UNEVEN * np.median(h))


def of_changes(chain: AnyChain, parameters: Parameters, found: Array, adjoints: Sequence[Array]) -> Array:
    """The relative errors of the derivatives of responses (k,), of which the first columns of the adjoints are."""
    pieces, errors, first = stretches(chain.steps), np.zeros((DRAWN, len(found))), 0
    length = extent(chain.system, pieces[0].start.q)
    weights = without_curves(chain.system, parameters, comparable(parameters, found, chain))
    sizes = np.sqrt(np.sum((found * weights) ** 2, axis=1))
    directions = parameters.along(
        weights[:, None] * np.random.default_rng(1).standard_normal((len(weights), DRAWN))
    )
    changes = chain.along(*directions)
    small = SMALL / (largest_change(chain.system, pieces, changes, length) or 1.0)
    longest = LONG * np.median(_lengths(chain.steps))
    for own, bars in zip(pieces, adjoints, strict=True):
        rows, long = slice(first, first + len(own) + 1), np.flatnonzero(np.diff(own.t) > longest)
        first = rows.stop
        if not len(long):
            continue
        own_bars, here = bars[long, ..., : len(found)], defect(chain.system, own, long)
        for k in range(DRAWN):
            change = {name: getattr(changes, name)[rows, :, k] for name in STATES}
            states = {name: getattr(own, name) + small * x for name, x in change.items()}
            near = replace(own, b=own.b + small * directions[0][:, k], **states)
            there = defect(chain.system, near, long)
            by = Defect((there.before - here.before) / small, (there.after - here.after) / small)
            after = np.concatenate([change["q"], change["v"]], axis=1)[long + 1]
            most = np.einsum("nj,njk->nk", abs(after), abs(own_bars[:, 1]))
            errors[k] += np.clip(by.weighted(own_bars), -most, most).sum(axis=0)
    error = np.sqrt(np.mean(errors**2, axis=0))
    return np.asarray(np.divide(error, sizes, out=np.zeros_like(sizes), where=sizes > 0))


def largest_change(system: System, pieces: Sequence[StepsTaken], changes: Nodes, length: float) -> float:
    """The largest change of positions over a length, of Euler parameters, and of states over their own size."""
    moving = system.moving
    moved = np.abs(changes.q[:, :moving].swapaxes(1, 2).reshape(-1, 7)).max(axis=0)
    sizes = np.max([abs(own.v[:, moving:]).max(axis=0) for own in pieces], axis=0)
    of_states = abs(changes.v[:, moving:]).max(axis=(0, 2))
    shares = np.divide(of_states, sizes, out=np.zeros_like(sizes), where=sizes > 0)
    return float(max(moved[:3].max() / length, moved[3:].max(), shares.max(initial=0.0)))


def without_curves(system: System, parameters: Parameters, weights: Array) -> Array:
    """Zero (p,) for parameters in tables or formulas, stored as curves: these do not move with their places in b."""
    by_b, none = np.zeros((len(system.b), 1)), np.zeros((system.nq, 1))
    by_b[system.nb :, 0] = np.random.default_rng(2).standard_normal(len(system.b) - system.nb)
    by = parameters.gradient(Gradients(by_b, none, none), np.zeros((parameters.c_size, 1)))
    return np.where(by[:, 0] != 0.0, 0.0, weights)


def warnings_of_changes(titles: Iterable[str], relative_errors: Array, order: int = 1) -> Iterator[str]:
    """Return one message for each response whose derivatives of this order have few digits."""
    for title, error in zip(titles, relative_errors, strict=True):
        if not error <= WRONG_CHANGES:
            yield (
                f"{title}: its {DERIVATIVES[order]} have {few(error)}, with a relative error of some {error:.0e}, as "
                "some steps suit the motion, but not its changes by parameters. Choose a smaller max_step, smaller "
                "tolerances, or a method of higher order."
            )


def comparable(parameters: Parameters, found: Array, chain: AnyChain) -> Array:
    """How much parameters may change (p,): by their value; zero lengths by that of the mechanism, others if alone.

    This is in proportion only: the largest effect on a response is one, as squares of tiny values would vanish.
    """
    t, length = chain.steps.t, extent(chain.system, chain.steps.start.q)
    sizes = {"m": length, "m/s": length / float(t[-1] - t[0])}
    weights = np.array(
        [abs(x) or sizes.get(unit, 0.0) for x, unit in zip(parameters.values, parameters.units, strict=True)]
    )
    felt = abs(found).max(axis=0, initial=0.0)
    most = (weights * felt).max(initial=0.0)
    if not most > TINY:
        return np.asarray(np.divide(1.0, felt, out=np.zeros_like(felt), where=felt > 0))
    return np.where(felt > 0, weights / most, 0.0)


def _lengths(steps: StepsTaken | Pieces) -> Array:
    return np.concatenate([np.diff(one.t) for one in stretches(steps)])
