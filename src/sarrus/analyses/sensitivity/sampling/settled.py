"""States of one segment of a run as it reports them, with the choice of independent equations of each of its steps."""

from __future__ import annotations

from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from ....algebra import Array
from ....results import StepsTaken
from ....system import System
from ...dynamics.dense_output.sample_loop import REFINEMENTS, Samples
from ...dynamics.dense_output.sampler import Sampler
from ...dynamics.stepping.nodes import Nodes
from ...equations.block_matrix import PlacedMatrix
from ...equations.minimum_norm import MinimumNorm
from ...redundancy.redundant_constraints import Independence
from .sampling import apart

# Matrices with pivots that were chosen for a run; states for estimates of its errors take them, if they fit
PIVOTS: WeakKeyDictionary[StepsTaken, PlacedMatrix] = WeakKeyDictionary()


class StateSet(NamedTuple):
    """States at some times (nt, ...), equations that were left out there, and what elements remember."""

    q: Array
    v: Array
    a: Array
    lam: Array
    left_out: Array
    memory: Array


class ChosenEquations(Independence):
    """The independent equations that a step has solved, which stay.

    Parameters
    ----------
    system : System
    left_out : (m,) 1 for equations that others imply
    """

    def __init__(self, system: System, left_out: Array) -> None:
        self._system = system
        self.rows = np.flatnonzero(left_out == 0.0) if left_out.any() else None
        if self.rows is not None:
            self._minimum = MinimumNorm(system, self.rows)

    def renew(self, t: float, q: Array) -> bool:
        """No other choice is made."""
        return False


def settled(system: System, steps: StepsTaken, t: Array, *, shortest: bool = True) -> StateSet:
    """States at rising times between its nodes or at them.

    With the `shortest` multipliers where equations are dependent, and refined; or any, solved for once with the pivots
    of the last call for these steps, as most of the time goes there.
    """
    remembered = np.concatenate([steps.memory, steps.memory[-1:]])
    nodes = Nodes(steps.t, steps.q, steps.v, steps.a, steps.lam, remembered)
    left_out, redundant, n, m = np.zeros((len(t), system.m)), len(steps.left_out) > 0, system.nq, system.m
    if redundant:
        step = np.clip(np.searchsorted(steps.t, t) - 1, 0, len(steps) - 1)
        left_out[:] = steps.left_out[step + 1]

    def consistent(choice: Array, t: Array) -> Samples:
        chosen, host = ChosenEquations(system, choice), None if shortest else PIVOTS.get(steps)
        sampler = Sampler(system, chosen, steps.b, host=host, apart=apart(steps))
        rounds = REFINEMENTS if shortest else 1
        found = sampler.states(nodes, t, shortest=shortest, monitored=False, rounds=rounds)
        if host is None and not shortest:
            PIVOTS[steps] = sampler.matrix
        return found

    choices, number = _choices(left_out) if redundant else (left_out[:1], np.zeros(len(t), np.int64))
    if len(choices) == 1:
        alone = consistent(choices[0], t)
        return StateSet(alone.q, alone.v, alone.a, alone.lam, left_out, alone.memory)
    q, v, a, lam, memory = (np.zeros((len(t), width)) for width in (n, n, n, m, steps.memory.shape[1]))
    found = StateSet(q, v, a, lam, left_out, memory)
    for k, choice in enumerate(choices):
        own = number == k
        there = consistent(choice, t[own])
        for name in ("q", "v", "a", "lam", "memory"):
            getattr(found, name)[own] = getattr(there, name)
    return found


def _choices(left_out: Array) -> tuple[Array, Array]:
    """The different rows, and which of them each row is; most rows repeat the one before."""
    changes = np.append(True, np.any(left_out[1:] != left_out[:-1], axis=1))
    found, of = np.unique(left_out[changes], axis=0, return_inverse=True)
    return found, of.ravel()[np.cumsum(changes) - 1]
