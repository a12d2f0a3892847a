"""States at which responses are taken, consistent as those of `Trajectory`, with their derivatives.

Between the nodes of a method, and for those of order two at the nodes too, velocities do not satisfy the constraints
exactly, and accelerations and multipliers not the equations of motion: all differ by the error of the run. A run
reports states that do, see `dynamics.dense_output.sampler`; so do responses that read them, and their derivatives are
those of what is reported.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ....outputs.recording import Key
from ....results import Segments, StepsTaken
from ....system import System
from ....system.curves.time_derivatives import timed
from ..chain.chain import Nodes
from ..lagrangians.curves import CurveLagrangian
from ..steps.second_order import changes_along
from ..steps.sweep import PerOperation
from ..steps.sweep_loop import NodeArrays
from .consistent_states import ConsistentStates, ConsistentSweep
from .reported import Reporter
from .sampling import Sampling
from .settled import settled


class StateChanges(NamedTuple):
    """Changes of states: of the states, the stages, the parameters (len(b),) and the times."""

    found: NodeArrays
    stages: PerOperation
    b: Array
    t: Array


class ConsistentSampling(Sampling):
    """The states at some times of a run, consistent; the rest of `Sampling` is that of what they are made of.

    Parameters
    ----------
    system, steps : the run
    of : the states before
    """

    def __init__(self, system: System, steps: StepsTaken | Segments, of: Sampling) -> None:
        self._system, self._run, self._of = system, steps, of
        self.moves = of.moves

    @property
    def t(self) -> Array:
        """The times (nt,). [s]"""
        return self._of.t

    @property
    def memory(self) -> dict[int, Array]:
        """State variables of elements at the times (nt,), by index among the parameters."""
        return self._of.memory

    def spread_time(self, bar: Array, nodes: Nodes, column: int) -> None:
        """Add the gradient by the times themselves, where they move."""
        self._of.spread_time(bar, nodes, column)

    def gathered_time(self, nodes: Nodes, column: int) -> Array:
        """The change of the times, where they move."""
        return self._of.gathered_time(nodes, column)

    @cached_property
    def _rows(self) -> list[tuple[StepsTaken, Array]]:
        """The segments between events, and which times lie in each, rising."""
        t = self.t
        if not isinstance(self._run, Segments):
            return [(self._run, np.argsort(t, kind="stable"))]
        order = np.lexsort([t, self._of.segment])
        places = enumerate(self._run.segments)
        found = ((segment, order[self._of.segment[order] == p]) for p, segment in places)
        return [(segment, rows) for segment, rows in found if len(rows)]

    @cached_property
    def _record(self) -> ConsistentStates:
        """The consistent states, and what they are made of."""
        before, system, t, between = self._of, self._system, self.t, self._of.between_nodes
        q, v, a, lam = (np.zeros((len(t), n)) for n in (system.nq, system.nq, system.nq, system.m))
        left_out, memory = np.zeros(lam.shape), np.zeros((len(t), len(system.memory_places)))
        for segment, rows in self._rows:
            for into, found in zip(
                (q, v, a, lam, left_out, memory), settled(system, segment, t[rows]), strict=True
            ):
                into[rows] = found
        dq = (q - before.q) * between[:, None]
        defined = np.isfinite(np.concatenate([a, lam], axis=1)).all(axis=1)
        return ConsistentStates(
            b=self._run.b, t=t.astype(float), q=q, v=v, a=a, lam=lam, q0=q - dq, dq=dq, dv=v - before.v,
            sigma=np.zeros(lam.shape), rho=np.zeros(lam.shape), between=between, defined=defined,
            left_out=left_out, places=self._rows[0][0].places, memory=memory,
        )  # fmt: skip

    @cached_property
    def q(self) -> Array:
        """Coordinates there (nt, nq)."""
        return self._record.q

    @cached_property
    def v(self) -> Array:
        """Velocities there (nt, nq)."""
        return self._record.v

    @cached_property
    def a(self) -> Array:
        """Accelerations there (nt, nq)."""
        return self._record.a

    def lam(self) -> Array:
        """Multipliers there (nt, m)."""
        return self._record.lam

    @cached_property
    def _solved(self) -> ConsistentStates:
        """With the multipliers that the operations solve for."""
        return self._record.of_independent(self._system).with_multipliers(self._system)

    @cached_property
    def _sweep(self) -> ConsistentSweep:
        return ConsistentSweep(self._system, self._solved, self._moving)

    @cached_property
    def _minimum(self) -> Reporter:
        """The least multipliers at the times."""
        return self._least(self._moving)

    def _least(self, moving: bool) -> Reporter:
        record, steps = self._solved, self._rows[0][0]
        there = {name: getattr(record, name) for name in ("t", "q", "v", "a", "lam", "memory")}
        left_out = record.left_out.astype(bool)
        alone = replace(steps, h=np.zeros(len(record.t)), left_out=left_out, **there)
        return Reporter(self._system, alone, moving)

    @cached_property
    def _moving(self) -> bool:
        """Whether events move times, on which the system depends by itself."""
        return self.moves and timed(self._system)

    def along(self, dots: Nodes, b: Array, column: int) -> StateChanges:
        """The changes of the states with those of the nodes in one column, and of the numbers (len(b), 1)."""
        sweep, of = self._sweep, self._of
        every = np.arange(self._system.nq)
        q, v = (of.gathered(kind, every, dots, column)[:, :, None] for kind in ("q", "v"))
        t_dot = of.gathered_time(dots, column) if self._moving else np.zeros(len(self.t))
        found, stages = sweep.along({"q0": q, "q": q, "v": v}, b[: len(self._run.b)], t_dot)
        reported = found._replace(lam=self._minimum.along(found, b, t_dot[:, None]))
        return StateChanges(reported, stages, b[:, 0], t_dot)

    def rates(self) -> NodeArrays:
        """The derivatives of the states by the time, along the motion."""
        record, depends = self._record, timed(self._system)
        q, v, still = record.v[:, :, None], record.a[:, :, None], np.zeros((len(self._run.b), 1))
        sweep, ones = ConsistentSweep(self._system, self._solved, depends), np.ones(len(self.t))
        found, _ = sweep.along({"q0": q, "q": q, "v": v}, still, ones)
        return found._replace(lam=self._least(depends).along(found, still, ones[:, None]))

    def all_gathered(
        self, keys: Iterable[Key], nodes: Nodes, b: Array, c: Array, column: int
    ) -> dict[Key, Array]:
        """See `Sampling`."""
        found = self.along(nodes, b[:, column : column + 1], column).found
        return {(kind, n): getattr(found, kind)[:, n, 0] for kind, n in keys}

    def spread_all(
        self, bars: Mapping[Key, Array], nodes: Nodes, column: int, sources: PerOperation | None = None
    ) -> Array:
        """See `Sampling`; `sources` are those of the change of an adjoint."""
        given, t_bar = self._given(bars), np.zeros((len(self.t), 1))
        by_b = self._minimum.transposed(given, t_bar)
        found = self._sweep.back(given, sources)
        for kind in ("q", "v"):
            self._of.spread(kind, np.arange(self._system.nq), getattr(found, kind)[:, :, 0], nodes, column)
        if self._moving:
            self._of.spread_time(t_bar[:, 0] + found.t, nodes, column)
        return found.b + by_b

    def _given(self, bars: Mapping[Key, Array]) -> NodeArrays:
        """Gradients by coordinates as arrays."""
        given = self._sweep.nodes()
        for (kind, n), bar in bars.items():
            getattr(given, kind)[:, n, 0] += bar
        return given

    def turned(
        self, bars: Mapping[Key, Array], motion: StateChanges, dots: Nodes, nodes: Nodes
    ) -> tuple[PerOperation, Array]:
        """Sources of the change of the adjoint of these gradients along a motion; of those by the numbers (len(b),).

        `dots` are the changes of the nodes; gradients that change as times move are added to those by `nodes`.
        """
        curves, back = CurveLagrangian(self._system, True, self._moving), self._sweep.back(self._given(bars))
        if self.moves:
            places = product(("q", "v"), range(self._system.nq))
            through = {(kind, n): getattr(back, kind)[:, n, 0] for kind, n in places}
            self._of.spread_along(through, dots, nodes)
        found = changes_along(self._sweep.record, motion.b, motion.stages, back.solved, curves, motion.t)
        if self._moving:
            self._of.spread_time(-found.t, nodes, 0)
        return found.sources, found.b
