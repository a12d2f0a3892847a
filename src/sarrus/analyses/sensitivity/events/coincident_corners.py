"""Corners of several forces at the same time, which do not stay together where parameters change.

A step ends at one of them. Where the others move away from it, second derivatives lack the squares of these times, with
the changes of slopes at the corners.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ....algebra import Array
from ....results import StepsTaken
from ...dynamics.events.force_corners import Corner, ForceCorners
from ...dynamics.inputs.force_arguments import END
from ...dynamics.stepping.nodes import Nodes
from ..parameters.parameters import Parameters
from .first_order import EventDerivatives
from .functions import Recorded
from .piece_chain import PieceChain

APART = 1e-3  # of the times by which corners move
MOVES = 1e-9  # of the run, by relative changes of the parameters: less is round-off


def leaving_corners(chain: PieceChain, parameters: Parameters) -> list[str]:
    """Return a message for each force whose corners leave those of another one where the parameters change."""
    corners, pieces = ForceCorners(chain.system, lengths=False), chain.steps.pieces
    triples = enumerate(zip(chain.event_steps, pieces, pieces[1:], strict=False))
    pairs = [(p, other) for p, three in triples for other in _others(corners, *three)]
    if not pairs:
        return []
    times, found = _Times(chain, parameters), dict[str, None]()
    for p, other in pairs:
        derived = chain.event_steps[p]
        own = derived.event.function
        if isinstance(own, Corner) and times.differ(p, derived.recorded(own), derived.recorded(other)):
            found[" and ".join(sorted({own.owner, other.owner}))] = None
    return [
        f"{names}: two forces set in or end at the same time, but at different times where the parameters change, so "
        "that second derivatives are wrong. Move one of them a little."
        for names in found
    ]


def _others(
    corners: ForceCorners, derived: EventDerivatives, before: StepsTaken, after: StepsTaken
) -> Iterator[Corner]:
    """The corners between the end of a section of steps, which ends at one of them, and the start of the next one."""
    own = derived.event.function
    if not isinstance(own, Corner) or own.length:
        return
    names = ("t", "q", "v", "a", "lam")
    states = [np.concatenate([getattr(before, name)[-2:], getattr(after, name)[:2]]) for name in names]
    memory = np.repeat([before.memory[-1], after.memory[0]], 2, axis=0)
    values, acts = corners.all_at(Nodes._make([*states, memory]), before.b, END, False)
    passed = (values[:, 1] > 0) != (values[:, 2] > 0)
    yield from (corners.all[n] for n in np.flatnonzero(passed & acts.any(axis=1)))


class _Times:
    """Changes of the times of corners with the parameters."""

    def __init__(self, chain: PieceChain, parameters: Parameters) -> None:
        changes = parameters.along(np.eye(len(parameters.names)))
        self._chain, self._nodes = chain, chain.along(*changes)
        self._of_b, _, _, self._of_c = changes
        self._sizes = np.where(parameters.values == 0, 1.0, abs(parameters.values))
        self._least = MOVES * float(chain.steps.t[-1] - chain.steps.t[0])

    def differ(self, p: int, one: Recorded, other: Recorded) -> bool:
        """Whether those of two corners at the end of a section of steps do."""
        (first, rate), (second, other_rate) = (self._of(p, psi) for psi in (one, other))
        if rate == 0 or other_rate == 0:  # as of max(0, x) at x = 0, beside the corner of x
            return False
        first, second = first / rate * self._sizes, second / other_rate * self._sizes
        least = np.maximum(self._least, APART * np.maximum(abs(first), abs(second)))
        return bool(np.any(abs(first - second) > least))

    def _of(self, p: int, psi: Recorded) -> tuple[Array, float]:
        """The changes of a function of the state at the end of a section (k,), and its rate."""
        slopes, nodes, end = psi.slopes, self._nodes, self._chain.parts[p].stop - 1
        rates = self._chain.event_steps[p].rates
        change = slopes.q @ nodes.q[end] + slopes.v @ nodes.v[end] + slopes.b @ self._of_b
        change = change + slopes.c @ self._of_c[: slopes.c.shape[1]] + slopes.t * nodes.shift[p]
        rate = slopes.q @ rates[0] + slopes.v @ rates[1] + slopes.t[:, 0]
        return np.asarray(change[0]), float(rate[0])
