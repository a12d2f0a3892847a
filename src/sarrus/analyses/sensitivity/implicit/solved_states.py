"""States that equations determine, with their derivatives: the interface of all analyses that are not simulations."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import csr_array

from ....algebra import Array
from ....outputs.motion import states_of
from ....outputs.recording import Angles, Key, States
from ....results import Assembly, Modes, StateSpace, StepsTaken, Trajectory
from ....system import System
from ...redundancy.redundant_constraints import Independence
from ..chain.chain import Nodes
from ..parameters.contradictions import contradicted, contradictions
from ..parameters.parameters import Parameters
from ..sampling.sampling import Sampling
from ..sampling.segments import Instants
from ..steps.sweep_loop import NodeArrays

KINDS = ("q", "v", "a", "lam")
LOOKS = 3  # states at which redundant constraints are searched for contradictions


class Moves(NamedTuple):
    """Changes of parameters of the elements, of the guess of an assembly and of parameters of the joints' coordinates.

    Or gradients by them; (…, 1) each.
    """

    b: Array
    q: Array
    v: Array
    c: Array

    def column(self, k: int) -> Moves:
        """One of several columns."""
        return Moves._make(np.ascontiguousarray(x[:, k : k + 1]) for x in self)


class Slopes(NamedTuple):
    """Gradients by the states, by the parameters of the elements, and by those of the joints' coordinates."""

    q: Array
    v: Array
    a: Array
    lam: Array
    b: Array
    c: Array


class StateAnalysis(ABC):
    """Quantities that are derived from one state: modes, or matrices of a linearization.

    Attributes
    ----------
    result : `Modes` or `StateSpace`
    """

    result: Modes | StateSpace

    @abstractmethod
    def gradient(self, key: Key, bar: float) -> Slopes:
        """The gradient of what has the derivative `bar` by one of the quantities."""


class SolvedStates(ABC):
    """The states y = (q, v, a, λ) of a result at some times, which equations F(y, b) = 0 determine.

    Parameters
    ----------
    system : System
    states : of the result
    memory : (nt, k) state variables of elements at the times
    angles : of the whole result, with their revolutions
    """

    about: StateAnalysis | None = None  # what is derived from the state, where this is the result

    def __init__(self, system: System, states: States, memory: Array, angles: Angles | None = None) -> None:
        self.system, self.states, self.memory = system, states, memory
        self.angles = angles or Angles(system, states)
        self.steps = as_steps(system, states, memory, system.b, _left_out(system, states.t, states.q))

    @abstractmethod
    def along(self, moves: Moves) -> NodeArrays:
        """The changes of the states, with those of any multipliers of redundant constraints."""

    @abstractmethod
    def gradient(self, by: NodeArrays) -> Moves:
        """The gradients of what has these gradients by the states, with the same multipliers."""

    def undefined(self, parameters: Parameters) -> Array:
        """True for parameters whose change alone makes redundant constraints contradict each other."""
        system, (t, q, *_) = self.system, self.states
        if not self.steps.left_out.any():
            return np.zeros(len(parameters.names), dtype=bool)
        rows = np.unique(np.linspace(0, len(t) - 1, LOOKS).astype(int))
        sums = np.concatenate([contradictions(system, system.b, t[n], q[n]) for n in rows], axis=1)
        return contradicted(parameters, sums, np.zeros((system.nq, sums.shape[1])))

    def derived_along(self, keys: list[Key], change: NodeArrays, moves: Moves) -> dict[Key, Array]:
        """The changes of what is derived from the state, by key."""
        found = dict[Key, Array]()
        for key in keys:
            assert self.about
            by = self.about.gradient(key, 1.0)
            states = sum(float(getattr(by, name) @ getattr(change, name)[0, :, 0]) for name in KINDS)
            found[key] = np.array([states + by.b @ moves.b[:, 0] + by.c @ moves.c[: len(by.c), 0]])
        return found

    def through_derived(self, bars: Mapping[Key, Any], by: NodeArrays) -> Moves:
        """Add the gradients by the states of what has gradients by derived quantities; those by all else."""
        moves = self.no_moves()
        for key, bar in bars.items():
            assert self.about
            found = self.about.gradient(key, float(bar))
            for name in KINDS:
                getattr(by, name)[0, :, 0] += getattr(found, name)
            moves.b[:, 0] += found.b
            moves.c[: len(found.c), 0] += found.c
        return moves

    def no_moves(self) -> Moves:
        system = self.system
        c = len(system.joint_coordinates.b) + len(system.model.rates)
        sizes = len(system.b), system.nq, system.nq, c
        return Moves._make(np.zeros((size, 1)) for size in sizes)

    def zeros(self) -> NodeArrays:
        """Zeros for changes of the states, or gradients by them."""
        widths = (self.system.nq, self.system.nq, self.system.nq, self.system.m)
        return NodeArrays._make(np.zeros((len(self.states.t), width, 1)) for width in widths)


class StatesAt(Sampling):
    """Some of the states, by their places, as responses read them."""

    def __init__(self, solved: SolvedStates, rows: Array) -> None:
        self._solved, self._rows, t = solved, rows, solved.states.t[rows]
        super().__init__(solved.steps, Instants(t, np.zeros(len(t), np.int64), np.zeros(len(t))))

    @property
    def nodes_of_multipliers(self) -> Array:
        return self._rows

    @property
    def memory(self) -> dict[int, Array]:
        places, rows = self._solved.system.memory_places, self._rows
        return dict(zip(places.tolist(), self._solved.memory[rows].T, strict=False))

    def lam(self) -> Array:
        return np.asarray(self._solved.states.lam()[self._rows])

    def _new_map(self, kind: str, order: int) -> dict[str, csr_array]:
        rows, count = self._rows, len(self._solved.states.t)
        each = np.arange(len(rows))
        return {kind: csr_array((np.ones(len(rows)), (each, rows)), shape=(len(rows), count))}

    def all_gathered(
        self, keys: Iterable[Key], nodes: Nodes, b: Array, c: Array, column: int
    ) -> dict[Key, Array]:
        """See `Sampling`; also the changes of what is derived from a single state."""
        wanted = list(keys)
        found = super().all_gathered([key for key in wanted if key[0] in KINDS], nodes, b, c, column)
        moves = self._solved.no_moves()._replace(b=b[:, column : column + 1], c=c[:, column : column + 1])
        derived = [key for key in wanted if key[0] not in KINDS]
        return found | self._solved.derived_along(derived, nodes.column(column), moves)


def states_at(system: System, run: Trajectory, rows: Array) -> tuple[States, Array, Angles]:
    """The states of a run at some of its times, what elements remember there, and its angles."""
    whole, lam = states_of(run), np.asarray(run.lam)[rows]
    t, q, v, a = (x[rows] for x in whole[:4])
    chosen = States(t, q, v, a, lambda: lam)
    counted = len(run.revolutions) == len(run.t)
    angles = Angles(system, whole, revolutions=run.revolutions if counted else None)
    places = len(system.memory_places)
    memory = (
        run.memory[rows]
        if run.memory.shape[1] == places
        else np.tile(system.b[system.memory_places], (len(rows), 1))
    )
    return chosen, memory, angles


def as_steps(system: System, states: States, memory: Array, b: Array, left_out: Array) -> StepsTaken:
    """The states as those of a run, with the equations that others imply (nt, m)."""
    t, q, v, a, lam = *states[:4], states.lam()
    count, none = len(t), np.zeros((len(t), 0))
    return StepsTaken(
        scheme=None, start=Assembly(q[0], v[0], True, "", 0.0, 0), b=b, t=t, h=np.zeros(count), q=q, v=v, a=a,
        lam=lam, left_out=left_out, places=system.memory_places, memory=memory, stages=none,
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
