"""The chain of a run with events differentiated: stretches of steps, and between them what the events do."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from ...algebra import Array
from ...results import Pieces
from ...system import System
from .chain import Chain, Gradients, Nodes, through
from .pieces import sampling_of
from .radau_chain import RadauChain
from .recording import Angles
from .turn import TurnDerivatives

KINDS = ("q", "v", "a")


class PieceChain:
    """The derivatives of one run with events that was simulated with ``keep_steps=True``; see `Chain`.

    Parameters
    ----------
    system, steps : the run
    chains : of its stretches
    """

    def __init__(self, system: System, steps: Pieces, chains: Sequence[Chain | RadauChain]) -> None:
        self.system, self.steps, self._chains = system, steps, chains
        ends = steps.first + [len(piece) for piece in steps.pieces]
        self._parts = [slice(first, end + 1) for first, end in zip(steps.first, ends, strict=True)]

    @property
    def _joints(self) -> int:
        """How many numbers the joints' coordinates have, with the restitutions."""
        return len(self.system.joint_coordinates.b) + len(self.steps.restitutions)

    @cached_property
    def _turns(self) -> list[Array]:
        """The matrices of all events."""
        pairs = zip(self._chains, self.steps.turns, strict=False)
        names, angles = list(self.steps.restitutions), Angles(self.system, sampling_of(self.steps).states)
        return [
            TurnDerivatives(self.system, chain.steps, turn, names, angles).matrix for chain, turn in pairs
        ]

    def along(self, db: Array, dq: Array, dv: Array, dc: Array | None = None) -> Nodes:
        """The derivatives of all states for changes of the numbers and of the guess, and of joints' numbers."""
        found, nq = Nodes.zeros(self.steps, db.shape[1]), self.system.nq
        held = np.zeros((self._joints, db.shape[1])) if dc is None else dc
        q, v = self._chains[0].assembly.along(db, dq=dq, dv=dv)
        for p, (chain, part) in enumerate(zip(self._chains, self._parts, strict=True)):
            moving = chain.curves.width > len(db)
            own = chain.along_from(q, v, np.concatenate([db, found.shift[p : p + 1]]) if moving else db)
            for name in (*KINDS, "lam"):
                getattr(found, name)[part] = getattr(own, name)
            if p < len(self._turns):
                ends = np.concatenate([getattr(own, kind)[e] for e in (-2, -1) for kind in KINDS])
                moved = self._turns[p] @ np.concatenate([ends, db, held, found.shift[p : p + 1]])
                q, v = moved[:nq], moved[nq:-1]
                found.shift[p + 1] = found.shift[p] + moved[-1]
        return found

    def gradients(self, given: Nodes) -> Gradients:
        """Gradients of responses whose gradients by the states and by the times of events are given."""
        nq, k, size = self.system.nq, given.q.shape[2], len(self.system.b)
        q, v = np.zeros((nq, k)), np.zeros((nq, k))
        b, c = np.zeros((size, k)), np.zeros((self._joints, k))
        shift = given.shift.copy()
        for p in range(len(self._chains) - 1, -1, -1):
            own = given.part(self._parts[p])
            if p < len(self._turns):
                bars = self._turns[p].T @ np.concatenate([q, v, shift[p + 1 : p + 2]])
                shift[p] += shift[p + 1] + bars[-1]
                ends = bars[: 6 * nq].reshape(2, 3, nq, k)
                for e in (0, 1):
                    for place, kind in enumerate(KINDS):
                        getattr(own, kind)[e - 2] += ends[e, place]
                b += bars[6 * nq : 6 * nq + size]
                c += bars[6 * nq + size : -1]
            q, v, by_b = self._chains[p].by_start(own)
            b += by_b[:size]
            shift[p] += by_b[size:].sum(axis=0)
        by_b, by_q, by_v = through(self._chains[0].assembly, q, v)
        return Gradients(b + by_b, by_q, by_v, c)
