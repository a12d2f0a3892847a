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

from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from typing import Protocol

import numpy as np

from .....algebra import Array
from .....results import Assembly, Pieces, StepsTaken
from .....results.motion.steps import stretches
from .....system import System
from ...chain.chain import Chain, Nodes
from ...events.chains import AnyChain
from ...parameters.parameters import Parameters
from ..defect import Defect, defect
from ..unresolved_modes import UnresolvedModes
from .growth import DERIVATIVES, few
from .moved_steps import extremes, moved_piece, small_multiple
from .random_changes import Directions, Enough, RandomChanges

UNEVEN = 20.0  # longest step over the median: of motions that never rest some 3, of those that do 28 and more
LONG = 3.0  # times the median: only such steps are looked at
# Of the run, a longest step: by methods of order two, a cubic in time has an error of 0.4 %
LARGE = 1 / 15
ROUND_OFF = 1e-6  # of a derivative, between sweeps forward and backward: it has digits
WRONG_CHANGES = 0.01  # relative errors from which there is a warning: states may be right to all digits


def uneven(h: Array, precise: bool) -> bool:
    """Whether some steps are far longer than most, or of order two and a large part of the run.

    Only then errors of changes are estimated; `precise` as in `StepsTaken`.
    """
    return bool(h.max() > UNEVEN * np.median(h) or (not precise and h.max() > LARGE * h.sum()))


class ChangedRun(Protocol):
    """A run that changes with the parameters; its steps are stored or computed again.

    Attributes
    ----------
    first : the chain with which it begins
    span : its start, and its end [s]
    t, h : times of all nodes, and lengths of all steps [s]
    """

    @property
    def first(self) -> Chain: ...
    @property
    def span(self) -> tuple[Assembly, float]: ...
    @property
    def t(self) -> Array: ...
    @property
    def h(self) -> Array: ...

    def weighed(self, directions: Directions) -> Array:
        """The changes of responses (k, n) with changes of the parameters, by a sweep forward."""
        ...

    def given(self) -> Sequence[tuple[Array, Nodes]]:
        """Parts of the run: times of nodes, and gradients of responses by their states."""
        ...

    def prescribed(self) -> Array | bool:
        """Whether responses are prescribed (k,)."""
        ...

    def errors_of_changes(self, random: RandomChanges, longest: float) -> Iterable[Array]:
        """The errors of the changes of responses (k,) by steps longer than this, see `errors_of_changes`."""
        ...


def relative_errors_of_changes(
    run: ChangedRun, parameters: Parameters, found: Array, enough: Enough
) -> Array:
    """The relative errors of derivatives (k, p), by steps that suit the motion, but not its changes (k,)."""
    random = RandomChanges.of(parameters, found, *run.span, _felt(run, parameters, found))
    by_oscillations = random.first_relative(_by_oscillations(run, random, len(found)), found, enough)
    looked_at = random.hidden or uneven(run.h, run.first.steps.precise)
    if not looked_at and not by_oscillations.any():
        return by_oscillations
    prescribed = run.prescribed()

    def whole(by_changes: Array) -> Array:
        return np.where(prescribed, 0.0, np.hypot(by_oscillations, by_changes))

    if not looked_at:
        return whole(by_oscillations * 0.0)
    errors = run.errors_of_changes(random, 0.0 if random.hidden else _longest_suited(run.h))
    return whole(random.first_relative(errors, found, lambda own, count: enough(whole(own), count)))


def _felt(run: ChangedRun, parameters: Parameters, found: Array) -> Array:
    """The parameters (p,) of laws hidden in the motion by which derivatives (k, p) are more than round-off.

    A sweep forward has the same ones.
    """
    which = np.flatnonzero(parameters.hidden & found.any(axis=0))
    felt = np.zeros(len(found.T), dtype=bool)
    if len(which):
        again = run.weighed(parameters.along(np.eye(len(felt))[:, which]))
        felt[which] = np.any(abs(again - found[:, which]) < ROUND_OFF * abs(found[:, which]), axis=0)
    return felt


def _by_oscillations(run: ChangedRun, random: RandomChanges, k: int) -> Iterator[Array]:
    """The errors of the changes of responses (k,) by oscillations that the steps of a run do not resolve."""
    given, first = cache(run.given), run.first
    for modes in UnresolvedModes.of(first, random.directions, run.t, first.steps.precise, random.hidden):
        errors = np.zeros(k)
        for one in modes:
            if len(one.values):
                by_modes = np.sum([one.part(*part) for part in given()], axis=0)
                errors = np.hypot(errors, np.linalg.norm(by_modes, axis=0))
        yield errors


def errors_of_stored_changes(
    chain: AnyChain, random: RandomChanges, adjoints: Sequence[Array], longest: float
) -> Iterator[Array]:
    """Those of a run with stored steps, by the adjoints of responses."""
    pieces, start = stretches(chain.steps), chain.steps.start
    changes = chain.along(*random.directions)
    small = small_multiple(chain.system, [extremes(own, changes) for own in pieces], start)
    parts = [slice(None)] if isinstance(chain, Chain) else chain.parts
    each = [*zip(pieces, adjoints, map(changes.part, parts), strict=True)]
    for column in range(len(random.each)):
        errors = [errors_of_changes(chain.system, *one, random, small, longest, column) for one in each]
        yield np.asarray(np.sum(errors, axis=0))


def _longest_suited(h: Array) -> float:
    """The length of steps from which on they are looked at, by those of all steps."""
    return float(min(LONG * np.median(h), LARGE / UNEVEN * LONG * h.sum()))


def errors_of_changes(
    system: System, steps: StepsTaken, adjoints: Array, changes: Nodes, random: RandomChanges, small: float,
    longest: float, column: int,
) -> Array:  # fmt: skip
    """The errors of one change of responses (k,) by long ones of some steps, whose states change."""
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
