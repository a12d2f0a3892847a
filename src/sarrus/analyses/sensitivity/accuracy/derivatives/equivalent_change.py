"""Errors of derivatives in unstable and chaotic motions: those of a change of the parameters that moves the run alike.

All perturbations of such a motion soon have the direction that grows most. The errors of the states are then, but for a
small rest, the changes that other parameters b + δb would cause, and the derivatives g of a response are those of the
motion with these parameters:

    g(run) - g(exact) = ∂g/∂b δb.

To this come errors that derivatives have by themselves, which are smaller by the growth of the adjoint.

Divided by g, this may be a hundred times the errors of the states over the size of the motion, or a hundredth: second
derivatives stay large when first ones become smaller. Three random sums of states determine δb: their errors, and their
derivatives with respect to the parameters. As only the size of the errors is wanted, ∂g/∂b δb is a difference of two
backward sweeps: of the run, and of its states moved by a small multiple of their changes with δb.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from .....algebra import Array
from .....results import Pieces, StepsTaken
from .....results.motion.steps import stretches
from ...chain.chain import Chain
from ...events.chains import AnyChain
from ...parameters.parameters import Parameters
from ..state_errors import SUMS, SumErrors
from .moved_steps import extremes, moved_event, moved_piece, small_multiple
from .random_changes import TINY

UNSTABLE = 100.0  # growth of the adjoint from which errors of the states may have one direction
REST = 0.2  # part of the errors of the states in other directions up to which they have one
LEAST = 0.01  # part of them that may hide in the errors of chaotic motions: those of regular parts
# Relative errors of second derivatives over those of first ones within the run: 0.1 to 15 of double pendulums over 5 to
# 30 s, with the root of how much smaller the change of a response's first ones is: its second ones are then small
SECOND = 2.0


class EquivalentChange(NamedTuple):
    """A change of the parameters that changes states as their errors do.

    Attributes
    ----------
    direction : change of the parameters (p,), relative to their sizes of length one
    multiple, by_round_off : of this direction: with the effect of all errors, and of round-off
    rest : part of the errors of the states that it does not explain, between 0 and 1
    """

    direction: Array
    multiple: float
    by_round_off: float
    rest: float

    @classmethod
    def of(cls, sum_errors: SumErrors, of_sums: Array, weights: Array) -> EquivalentChange | None:
        """By the derivatives of the sums of states (s, p), for comparable changes of the parameters (p,)."""
        errors, noise = sum_errors.by_steps, float(np.linalg.norm(sum_errors.by_round_off))
        by = of_sums * weights
        if not (np.isfinite(errors).all() and np.isfinite(by).all() and by.any()):
            return None
        main = np.linalg.eigh(by @ by.T)[1][:, -1]  # direction of the sums that changes most
        right, along = main @ by, float(main @ errors)
        size = float(np.linalg.norm(right))
        rest = np.linalg.norm(errors - along * main) / max(np.hypot(np.linalg.norm(errors), noise), TINY)
        multiple, by_round_off = (_limited(x) / size for x in (float(np.hypot(along, noise)), noise))
        return cls(weights * right / size, multiple, by_round_off, float(rest))

    def of_derivatives(self, changes: Array, within: float, order: int) -> Array:
        """Relative errors of derivatives of an order, and by round-off (2, k).

        Parameters
        ----------
        changes : relative changes of first derivatives with a multiple of one (k,)
        within : the same of derivatives within the run
        """
        if order == 2:
            small = np.sqrt(np.divide(within, changes, out=np.ones_like(changes), where=changes > 0))
            changes = np.hypot(changes, SECOND * within * np.maximum(small, 1.0))
        return np.outer([self.multiple, self.by_round_off], changes)


def _limited(errors: float) -> float:
    """Errors of sums of states, which are at most about as large as the motion."""
    return min(errors, float(np.sqrt(SUMS)))


def relative_changes(before: Array, after: Array, weights: Array) -> Array:
    """Changes of derivatives over their sizes (k,), of comparable changes of the parameters."""
    felt = weights > 0
    changes, sizes = (np.linalg.norm((x * weights)[:, felt], axis=1) for x in (after - before, before))
    return np.asarray(np.divide(changes, sizes, out=np.zeros_like(sizes), where=sizes > 0))


def moved_along(
    chain: AnyChain, parameters: Parameters, direction: Array
) -> tuple[StepsTaken | Pieces, float]:
    """The steps of a run, moved by a small multiple of a change of the parameters, and this multiple."""
    steps, system, stages = chain.steps, chain.system, list[Array]()
    db, dq, dv, dc = parameters.along(direction[:, None])
    changes = chain.along(db, dq, dv, dc, stages)
    pieces, parts = stretches(steps), [slice(None)] if isinstance(chain, Chain) else chain.parts
    small = small_multiple(system, [extremes(piece, changes) for piece in pieces], steps.start)
    shift, own = small * changes.shift[:, 0], [changes.part(rows) for rows in parts]
    each = zip(pieces, own, shift[: len(pieces)], stages, strict=True)
    found = [moved_piece(system, piece, small, nodes, db, at, stored) for piece, nodes, at, stored in each]
    if not isinstance(steps, Pieces):
        return found[0], small
    after = [small * nodes.v[0, :, 0] for nodes in own[1:]]
    events = [
        moved_event(system, event, shift[p + 1], (pieces[p], found[p]), after[p] if p < len(after) else 0.0)
        for p, event in enumerate(steps.event_steps)
    ]
    return replace(steps, pieces=tuple(found), event_steps=tuple(events)), small
