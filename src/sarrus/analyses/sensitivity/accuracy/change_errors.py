"""Errors of changes of states: what steps that suit the motion, but not its changes by parameters, do to derivatives.

Steps are chosen for the motion. While it rests they may be longer than the oscillation that a parameter would cause,
and where it meets a contact they do not know that it would meet it earlier. With the defect d of a run and the changes
u' of its states with the parameters b, the derivative of the error ∫ ȳᵀ d dt of a response contains

    ∫ ȳᵀ (∂d/∂u u' + ∂d/∂b b') dt,

which is an error of derivatives even where d vanishes. Random b' give the size of all of them, and as no more is
wanted, the change of d is a central difference: states that move to one side leave the constraints by the square of
their change, which large adjoints would magnify. The part of a step is at most what the whole change at its end does:
where that has decayed, a long step does no harm. Steps know nothing of laws with an amplitude of zero. If derivatives
by such constants are asked for, all steps are looked at.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ....results import Pieces, StepsTaken
from ....results.motion.steps import stretches
from ....system import System
from ..chain.chain import Chain, Nodes
from ..events.chains import AnyChain
from .defect import Defect, defect
from .growth import DERIVATIVES, few
from .moved_steps import extremes, moved_piece, small_multiple
from .random_changes import Enough, RandomChanges
from .unresolved_modes import UnresolvedModes

UNEVEN = 20.0  # longest step over the median: of motions that never rest some 3, of those that do 28 and more
LONG = 3.0  # times the median: only such steps are looked at
# Of the run, a longest step: by methods of order two, a cubic in time has an error of 0.4 %
LARGE = 1 / 15
WRONG_CHANGES = 0.01  # relative errors from which there is a warning: states may be right to all digits


def uneven(h: Array, precise: bool) -> bool:
    """Whether some steps are far longer than most, or of order two and a large part of the run.

    Only then errors of changes are estimated; `precise` as in `StepsTaken`.
    """
    return bool(h.max() > UNEVEN * np.median(h) or (not precise and h.max() > LARGE * h.sum()))


def of_changes(
    chain: AnyChain, random: RandomChanges, found: Array, adjoints: Sequence[Array], enough: Enough
) -> Array:
    """The relative errors of the derivatives of responses (k,), of which the first columns of the adjoints are."""
    pieces, start = stretches(chain.steps), chain.steps.start
    changes = chain.along(*random.directions)
    small = small_multiple(chain.system, [extremes(own, changes) for own in pieces], start)
    longest, parts = (
        0.0 if random.hidden else longest_suited(lengths(chain.steps)),
        [slice(None)] if isinstance(chain, Chain) else chain.parts,
    )
    of_responses = [own[..., : len(found)] for own in adjoints]
    each = [*zip(pieces, of_responses, map(changes.part, parts), strict=True)]

    def by_change(column: int) -> Array:
        errors = [errors_of_changes(chain.system, *one, random, small, longest, column) for one in each]
        return np.asarray(np.sum(errors, axis=0))

    return random.first_relative(map(by_change, range(len(random.each))), found, enough)


def of_oscillations(
    chain: Chain,
    random: RandomChanges,
    found: Array,
    t: Array,
    given: Callable[[], GivenParts],
    enough: Enough,
) -> Array:
    """The relative errors of derivatives of responses (k,) by oscillations that the steps of a run do not resolve.

    Parameters
    ----------
    chain : with which the run begins
    t : of all its nodes [s]
    given : asked for only if there are such oscillations
    """
    asked = cache(given)

    def by_modes(modes: Sequence[UnresolvedModes]) -> Array:
        errors = np.zeros(len(found))
        for one in modes:
            if len(one.values):
                by = np.sum([one.part(*part) for part in asked().parts], axis=0)
                errors = np.hypot(errors, np.linalg.norm(by, axis=0))
        return np.where(asked().prescribed, 0.0, errors) if errors.any() else errors

    every = UnresolvedModes.of(chain, random.directions, t, chain.steps.precise, random.hidden)
    return random.first_relative(map(by_modes, every), found, enough)


class GivenParts(NamedTuple):
    """Parts of a run: times of nodes, and gradients of responses by their states; whether these are prescribed (k,)."""

    parts: Sequence[tuple[Array, Nodes]]
    prescribed: Array | bool


def longest_suited(h: Array) -> float:
    """The length of steps from which on they are looked at, by those of all steps."""
    return float(min(LONG * np.median(h), LARGE / UNEVEN * LONG * h.sum()))


def errors_of_changes(
    system: System, steps: StepsTaken, adjoints: Array, changes: Nodes, random: RandomChanges, small: float,
    longest: float, column: int,
) -> Array:  # fmt: skip
    """Errors of the changes of responses (k,) by long ones of some steps, whose states change with one of the changes."""
    long, db = np.flatnonzero(np.diff(steps.t) > longest), random.directions[0]
    if not len(long):
        return np.zeros(adjoints.shape[-1])
    own = adjoints[long]
    moved = (moved_piece(system, steps, step, changes, db, column=column) for step in (small, -small))
    there, back = (defect(system, one, long) for one in moved)
    by = Defect((there.before - back.before) / (2 * small), (there.after - back.after) / (2 * small))
    after = np.concatenate([changes.q[..., column], changes.v[..., column]], axis=1)[long + 1]
    most = np.einsum("nj,njk->nk", abs(after), abs(own[:, 1]))
    return np.asarray(np.clip(by.weighted(own), -most, most).sum(axis=0))


def warnings_of_changes(titles: Iterable[str], relative_errors: Array, order: int = 1) -> Iterator[str]:
    """Return one message for each response whose derivatives of this order have few digits."""
    for title, error in zip(titles, relative_errors, strict=True):
        if not error <= WRONG_CHANGES:
            yield (
                f"{title}: its {DERIVATIVES[order]} have {few(error)}, with a relative error of some {error:.0e}, as "
                "some steps suit the motion, but not its changes by parameters. Choose a smaller max_step, smaller "
                "tolerances, or a method of higher order."
            )


def lengths(steps: StepsTaken | Pieces) -> Array:
    """Those of all steps (n,). [s]"""
    return np.concatenate([np.diff(one.t) for one in stretches(steps)])
