"""States that equations determine, with their derivatives: the interface of all analyses that are not simulations."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any

import numpy as np

from ....algebra import Array
from ....outputs import Outputs
from ....outputs.recording import Angles, Key, States
from ....results import Assembly, StepsTaken
from ....system import System
from ...redundancy.redundant_constraints import Independence
from ..parameters.parameters import Parameters
from ..parameters.undefined import contradicted, contradictions
from ..sampling.reported import Changes, Place, Reported
from ..steps.sweep_loop import NodeArrays

KINDS = ("q", "v", "a", "lam")
LOOKS = 3  # states at which redundant constraints are searched for contradictions


class SolvedStates(ABC):
    """The states y = (q, v, a, λ) of a result at some times, which equations F(y, b) = 0 determine.

    Parameters
    ----------
    system : System
    states : of the result
    memory : (nt, k) state variables of elements at the times
    angles : of the whole result, with their revolutions
    """

    modes: Any = None  # the `Modes` about the state, where these are the result

    def __init__(self, system: System, states: States, memory: Array, angles: Angles | None = None) -> None:
        self.system, self.states, self.memory, self._angles = system, states, memory, angles
        self.steps = _as_steps(system, states, memory)
        self.reported = Reported(system, self.steps, moving=False)

    @abstractmethod
    def along(self, db: Array) -> NodeArrays:
        """The changes of the states for a change of the parameters (len(b), 1)."""

    @abstractmethod
    def gradient(self, by: NodeArrays) -> Array:
        """The gradient by the parameters (len(b), 1) of what has these gradients by the states."""

    def undefined(self, parameters: Parameters) -> Array:
        """True for parameters whose change alone makes redundant constraints contradict each other."""
        system, (t, q, *_) = self.system, self.states
        if not self.reported.redundant:
            return np.zeros(len(parameters.names), dtype=bool)
        rows = np.unique(np.linspace(0, len(t) - 1, LOOKS).astype(int))
        sums = np.concatenate([contradictions(system, system.b, t[n], q[n]) for n in rows], axis=1)
        return contradicted(parameters, sums, np.zeros((system.nq, sums.shape[1])))

    def outputs(self, parameters: Parameters) -> Outputs:
        """The outputs of the states, recorded."""
        memory = dict(zip(self.system.memory_places.tolist(), self.memory.T, strict=False))
        found = Outputs(self.system, self.states, self.system.b, parameters.number, self._angles, memory)
        found.modes = self.modes
        return found

    def modal_along(self, keys: list[Key], change: NodeArrays, db: Array) -> dict[Key, Any]:
        """The changes of what modes have, by key, with those of the states and the parameters."""
        return {}

    def through_modes(self, bars: Mapping[Key, Any], by: NodeArrays) -> Array:
        """Add the gradients by the states of what has gradients by modes; that by the parameters (len(b), 1)."""
        return np.zeros((len(self.system.b), 1))

    def zeros(self) -> NodeArrays:
        """Zeros for changes of the states, or gradients by them."""
        widths = (self.system.nq, self.system.nq, self.system.nq, self.system.m)
        return NodeArrays._make(np.zeros((len(self.states.t), width, 1)) for width in widths)

    def shorten(self, change: NodeArrays, db: Array) -> None:
        """Turn changes of multipliers of redundant constraints into those of the least ones."""
        for row, slopes, time in self._slopes():
            change.lam[row] = slopes.along(Changes(change.q[row], db, time), change.lam[row])

    def unshorten(self, by: NodeArrays) -> Array:
        """Turn gradients by the least multipliers into those by any; that by the parameters (len(b), 1)."""
        by_b = np.zeros((len(self.system.b), 1))
        for row, slopes, time in self._slopes():
            if by.lam[row].any():
                by.lam[row] = slopes.transposed(by.lam[row], Changes(by.q[row], by_b, time))
        return by_b

    def _slopes(self) -> Any:
        for row in np.flatnonzero(self.steps.left_out.any(axis=1)).tolist():
            slopes = self.reported.slopes(Place(0, row))
            if slopes is not None:
                yield row, slopes, np.zeros(1)


def _as_steps(system: System, states: States, memory: Array) -> StepsTaken:
    """The states as those of a run, with the equations that others imply."""
    t, q, v, a, lam = *states[:4], states.lam()
    count, none = len(t), np.zeros((len(t), 0))
    return StepsTaken(
        scheme=None, start=Assembly(q[0], v[0], True, "", 0.0, 0), b=system.b, t=t, h=np.zeros(count), q=q, v=v, a=a,
        lam=lam, left_out=_left_out(system, t, q), places=system.memory_places, memory=memory, stages=none,
        removed=np.zeros(count), correction=none, impulse=none, order=3, rtol=0.0, atol=0.0,
    )  # fmt: skip


def _left_out(system: System, t: Array, q: Array) -> Array:
    """1 for equations that others imply (nt, m)."""
    found, choice = np.zeros((len(t), system.m), dtype=bool), Independence(system, q[0], float(t[0]))
    for row in range(len(t) if choice.rows is not None else 0):
        choice.renew(float(t[row]), q[row])
        found[row] = True
        found[row, choice.rows] = False
    return found
