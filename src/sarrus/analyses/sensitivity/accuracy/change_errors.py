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

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ....results import Assembly, Pieces, StepsTaken
from ....results.motion.steps import stretches
from ....system import System
from ...equations.length import extent
from ...position.assembly_derivatives import NoDerivative
from ..chain.chain import Chain, Gradients, Nodes
from ..events.chains import AnyChain
from ..parameters.parameters import Parameters
from .defect import Defect, defect
from .growth import DERIVATIVES, few
from .moved_steps import extremes, moved_piece, small_multiple
from .unresolved_modes import UnresolvedModes

UNEVEN = 20.0  # longest step over the median: of motions that never rest some 3, of those that do 28 and more
LONG = 3.0  # times the median: only such steps are looked at
WRONG_CHANGES = 0.01  # relative errors from which there is a warning: states may be right to all digits
DRAWN = 2  # random changes: no mere signs, as those of a length and of its end may cancel each other
TINY = float(np.finfo(float).tiny)


def uneven(h: Array) -> bool:
    """Whether some steps are far longer than most: only then are errors of changes estimated."""
    return bool(h.max() > UNEVEN * np.median(h))


def of_changes(chain: AnyChain, parameters: Parameters, found: Array, adjoints: Sequence[Array]) -> Array:
    """The relative errors of the derivatives of responses (k,), of which the first columns of the adjoints are."""
    pieces, start = stretches(chain.steps), chain.steps.start
    random = RandomChanges.of(parameters, found, start, float(chain.steps.t[-1]))
    changes = chain.along(*random.directions)
    small = small_multiple(chain.system, [extremes(own.v, changes) for own in pieces], start)
    longest, parts = (
        longest_suited(lengths(chain.steps)),
        [slice(None)] if isinstance(chain, Chain) else chain.parts,
    )
    each = zip(pieces, (own[..., : len(found)] for own in adjoints), map(changes.part, parts), strict=True)
    errors = [random.errors(chain.system, *one, small, longest) for one in each]
    return random.relative(np.sum(errors, axis=0), found)


def of_oscillations(
    chain: Chain, parameters: Parameters, found: Array, t: Array, given: Callable[[], GivenParts]
) -> Array:
    """The relative errors of derivatives of responses (k,) by oscillations that the steps of a run do not resolve.

    Parameters
    ----------
    chain : with which the run begins
    t : of all its nodes [s]
    given : asked for only if there are such oscillations
    """
    random = RandomChanges.of(parameters, found, chain.steps.start, float(t[-1]))
    try:
        modes = UnresolvedModes.of(chain, random.directions, t, chain.steps.precise)
    except NoDerivative:  # redundant equations allow changes of the parameters only together
        return np.zeros(len(found))
    if not any(len(own.values) for own in modes):
        return np.zeros(len(found))
    parts, prescribed = given()
    each = [[own.part(*part) for own in modes] for part in parts]
    errors = [np.linalg.norm(np.sum(own, axis=0), axis=0) for own in zip(*each, strict=True)]
    return np.where(prescribed, 0.0, random.relative(np.array(errors), found))


class GivenParts(NamedTuple):
    """Parts of a run: times of nodes, and gradients of responses by their states; whether these are prescribed (k,)."""

    parts: Sequence[tuple[Array, Nodes]]
    prescribed: Array | bool


def longest_suited(h: Array) -> float:
    """The length of steps from which on they are looked at, by those of all steps."""
    return LONG * float(np.median(h))


class RandomChanges(NamedTuple):
    """Random changes of the parameters.

    Attributes
    ----------
    weights : (p,) of comparable changes
    directions : of the numbers and the guess of the assembly, as `Chain.along` takes them
    """

    weights: Array
    directions: tuple[Array, Array, Array, Array]

    @classmethod
    def of(cls, parameters: Parameters, found: Array, start: Assembly, until: float) -> RandomChanges:
        """Of the parameters that derivatives (k, p) are by, of a run from a start to a time."""
        weights = without_curves(parameters, comparable(parameters, found, start, until))
        random = np.random.default_rng(1).standard_normal((len(weights), DRAWN))
        random = random / np.sqrt(np.mean(random**2, axis=1, keepdims=True))
        return cls(weights, parameters.along(weights[:, None] * random))

    def errors(
        self, system: System, steps: StepsTaken, adjoints: Array, changes: Nodes, small: float, longest: float
    ) -> Array:
        """Errors of the changes of responses (DRAWN, k) by long ones of some steps, whose states change."""
        long = np.flatnonzero(np.diff(steps.t) > longest)
        errors = np.zeros((DRAWN, adjoints.shape[-1]))
        if not len(long):
            return errors
        own, here = adjoints[long], defect(system, steps, long)
        for k in range(DRAWN):
            there = defect(system, moved_piece(steps, small, changes, self.directions[0], column=k), long)
            by = Defect((there.before - here.before) / small, (there.after - here.after) / small)
            after = np.concatenate([changes.q[..., k], changes.v[..., k]], axis=1)[long + 1]
            most = np.einsum("nj,njk->nk", abs(after), abs(own[:, 1]))
            errors[k] = np.clip(by.weighted(own), -most, most).sum(axis=0)
        return errors

    def relative(self, errors: Array, found: Array) -> Array:
        """Relative errors of derivatives (k, p) by the errors of the changes of a whole run (k,)."""
        error, sizes = np.sqrt(np.mean(errors**2, axis=0)), np.linalg.norm(found * self.weights, axis=1)
        return np.asarray(np.divide(error, sizes, out=np.zeros_like(sizes), where=sizes > 0))


def without_curves(parameters: Parameters, weights: Array) -> Array:
    """Zero (p,) for parameters in tables or formulas, stored as curves: these do not move with their places in b."""
    system = parameters.system
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


def comparable(parameters: Parameters, found: Array, start: Assembly, until: float) -> Array:
    """How much parameters may change (p,): by their value; zero lengths by that of the mechanism, others if alone.

    This is in proportion only: the largest effect on a response is one, as squares of tiny values would vanish.
    """
    length = extent(parameters.system, start.q)
    sizes = {"m": length, "m/s": length / (until - start.t)}
    weights = np.array(
        [abs(x) or sizes.get(unit, 0.0) for x, unit in zip(parameters.values, parameters.units, strict=True)]
    )
    felt = abs(found).max(axis=0, initial=0.0)
    most = (weights * felt).max(initial=0.0)
    if not most > TINY:
        return np.asarray(np.divide(1.0, felt, out=np.zeros_like(felt), where=felt > 0))
    return np.where(felt > 0, weights / most, 0.0)


def lengths(steps: StepsTaken | Pieces) -> Array:
    """Those of all steps (n,). [s]"""
    return np.concatenate([np.diff(one.t) for one in stretches(steps)])
