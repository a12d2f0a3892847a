"""States at which responses are taken, consistent as those of `Trajectory`, with their derivatives.

Between the nodes of a method, and for those of order two at the nodes too, velocities do not satisfy the constraints
exactly, and accelerations and multipliers not the equations of motion: all differ by the error of the run. A run
reports states that do, see `dynamics.sampler`; so do responses that read them, and their derivatives are those of what
is reported.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...algebra import Array
from ...outputs.recording import Key, States
from ...results import Pieces, StepsTaken
from ...system import System
from ...system.curve_derivatives import CurveDerivatives, Entries
from ...system.time_derivatives import TimeDerivatives, timed
from ..dynamics.nodes import Nodes as NodesOfRun
from ..dynamics.sampler import Sampler
from ..equations.minimum_norm import MinimumNorm
from ..redundancy.redundant_constraints import Independence
from . import consistent_loop as loop
from .chain import Nodes
from .consistent_sweep import ConsistentSweep
from .curve_lagrangian import CurveLagrangian
from .node_loop import Given
from .pieces import PieceSampling
from .reported import Changes, Place, Reported
from .sampling import Sampling, apart

READ = ("q", "v", "a", "lam")


class Operator(NamedTuple):
    """The derivatives by numbers of curves of an operator of an equation: of `equation` from row `first` on."""

    equation: str
    first: int
    height: int
    sign: float
    by: Entries


class Motion(NamedTuple):
    """How states change: given ones and consistent ones; what was solved for; changes of the numbers and the times."""

    given: Given
    found: Given
    solved: loop.Solved
    b: Array
    t: Array


class LagrangianChanges:
    """The changes of the gradients of ℓ (`shares`) at all times along a motion.

    Attributes
    ----------
    b, t : those by the parameters and by the times, summed over all that were evaluated
    """

    def __init__(
        self, sweep: ConsistentSweep, curves: CurveLagrangian, motion: Motion, memory: Mapping[int, Array]
    ) -> None:
        self._sweep, self._curves, self._motion, self._memory = sweep, curves, motion, memory
        self.b, self.t = np.zeros(len(motion.b)), np.zeros(len(motion.t))

    def __call__(self, kind: str, **given: Array) -> loop.Changes:
        """Those by the states and the multipliers; `given` as for `ConsistentSweep.changes`."""
        found, by_b = self._sweep.changes(kind, self._motion.b, **given)
        self.b += by_b
        if not self._curves:
            return found
        times = {"t": self._sweep.record.t, "t_dot": self._motion.t}
        added = self._curves.change(kind, self._sweep.b, self._motion.b, self._memory, **times, **given)
        self.b += added.b
        self.t += added.t
        rows = {name: getattr(found, name) + getattr(added, name) for name in ("q", "v", "a", "lam")}
        return found._replace(**rows | {"lam": rows["lam"] * (1.0 - self._sweep.record.left_out)})


class Chosen(Independence):
    """The independent equations that a step has solved, which stay.

    Parameters
    ----------
    system : System
    left_out : (m,) 1 for equations that others imply
    """

    def __init__(self, system: System, left_out: Array) -> None:
        self._system = system
        self.kept = np.flatnonzero(left_out == 0.0) if left_out.any() else None
        if self.kept is not None:
            self._minimum = MinimumNorm(system, self.kept)

    def renew(self, t: float, q: Array) -> bool:
        """No other choice is made."""
        return False


class ConsistentSampling(Sampling):
    """The states at some times of a run, consistent; the rest of `Sampling` is that of what they are made of.

    Parameters
    ----------
    system, steps : the run
    of : the states before
    """

    def __init__(self, system: System, steps: StepsTaken | Pieces, of: Sampling) -> None:
        self._system, self._run, self._of = system, steps, of
        self.moves = of.moves

    @property
    def t(self) -> Array:
        """The times (nt,). [s]"""
        return self._of.t

    @property
    def memory(self) -> dict[int, Array]:
        """What elements remember at the times (nt,), by place among the numbers."""
        return self._of.memory

    def spread_time(self, bar: Array, nodes: Nodes, column: int) -> None:
        """Add the gradient by the times themselves, where they move."""
        self._of.spread_time(bar, nodes, column)

    def gathered_time(self, nodes: Nodes, column: int) -> Array:
        """The change of the times, where they move."""
        return self._of.gathered_time(nodes, column)

    @cached_property
    def _pieces(self) -> list[tuple[StepsTaken, Array]]:
        """The stretches between events, and which times lie in each, rising."""
        t = self.t
        if not isinstance(self._of, PieceSampling):
            assert not isinstance(self._run, Pieces)
            return [(self._run, np.argsort(t, kind="stable"))]
        assert isinstance(self._run, Pieces)
        order = np.lexsort([t, self._of.piece])
        places = enumerate(self._run.pieces)
        found = ((piece, order[self._of.piece[order] == p]) for p, piece in places)
        return [(piece, rows) for piece, rows in found if len(rows)]

    @cached_property
    def _record(self) -> loop.Record:
        """The consistent states, and what they are made of."""
        before, system, t, between = self._of.states, self._system, self.t, self._of.between_nodes
        q, v, a, lam = (np.zeros((len(t), n)) for n in (system.nq, system.nq, system.nq, system.m))
        left_out, memory = np.zeros(lam.shape), np.zeros((len(t), len(system.memory_places)))
        first = self._pieces[0][0]
        for piece, rows in self._pieces:
            remembered = np.concatenate([piece.memory, piece.memory[-1:]])
            nodes = NodesOfRun(piece.t, piece.q, piece.v, piece.a, piece.lam, remembered)
            steps = np.clip(np.searchsorted(piece.t, t[rows]) - 1, 0, len(piece) - 1)
            memory[rows] = piece.memory[steps]
            if len(piece.left_out):
                left_out[rows] = piece.left_out[steps + 1]
            for choice in np.unique(left_out[rows], axis=0):
                own = rows[(left_out[rows] == choice).all(axis=1)]
                found = Sampler(system, Chosen(system, choice), piece.b, apart=apart(piece)).states(
                    nodes, t[own]
                )
                q[own], v[own], a[own], lam[own] = found.q, found.v, found.a, found.lam
        dq = (q - before.q) * between[:, None]
        defined = np.isfinite(a).all(axis=1) & np.isfinite(lam).all(axis=1)
        return loop.Record(
            t=t.astype(float), q=q, v=v, a=a, lam=lam, q0=q - dq, dq=dq, dv=v - before.v,
            sigma=np.zeros(lam.shape), rho=np.zeros(lam.shape), between=between.astype(float),
            defined=defined.astype(float), left_out=left_out, places=first.places, memory=memory,
        )  # fmt: skip

    @cached_property
    def states(self) -> States:
        """The states there."""
        record = self._record
        return States(record.t, record.q, record.v, record.a, lambda: record.lam)

    @cached_property
    def _sweep(self) -> ConsistentSweep:
        record = self._record
        lam = record.lam.copy()
        for row in np.flatnonzero(record.left_out.any(axis=1)).tolist():
            lam[row] = self._of_choice(row)
        return ConsistentSweep(self._system, self._run.b, record._replace(lam=lam))

    def _of_choice(self, row: int) -> Array:
        """The multipliers of independent equations (m,) with the constraint forces of those reported."""
        system, record, b = self._system, self._record, self._run.b.copy()
        b[record.places] = record.memory[row]
        J = system.Phi_q(record.q[row], float(record.t[row]), b=b)
        minimum = MinimumNorm(system, np.flatnonzero(record.left_out[row] == 0.0))
        minimum.null(J)
        return minimum.forces((J.T @ record.lam[row])[:, None])[:, 0]

    @cached_property
    def _minimum(self) -> Reported:
        """The least multipliers at the times."""
        record, steps = self._sweep.record, self._pieces[0][0]
        there = {name: getattr(record, name) for name in ("t", "q", "v", "a", "lam", "memory")}
        left_out = record.left_out.astype(bool)
        alone = replace(steps, h=np.zeros(len(record.t)), left_out=left_out, **there)
        return Reported(self._system, alone, self._moving)

    @cached_property
    def _moving(self) -> bool:
        """Whether events move times, on which the system depends by itself."""
        return self.moves and timed(self._system)

    @cached_property
    def _memory(self) -> dict[int, Array]:
        """What elements remember at the times, by place in b."""
        return dict(zip(self._record.places.tolist(), self._record.memory.T, strict=True))

    @cached_property
    def _second(self) -> CurveLagrangian:
        """Second derivatives by the parameters of curves, and by the times."""
        return CurveLagrangian(self._system, True, self._moving)

    @cached_property
    def _curves(self) -> list[Operator]:
        """What depends on numbers of curves, and on times that move."""
        of = TimeDerivatives(self._system) if self._moving else CurveDerivatives(self._system)
        if not of:
            return []
        record, nq, m, memory = self._sweep.record, self._system.nq, self._system.m, self._memory

        def part(equation: str, first: int, sign: float, name: str, q: Array, **given: Array) -> Operator:
            by = of(name, self._run.b, memory, q=q, t=record.t, **given)
            return Operator(equation, first, m if first else nq, sign, by)

        q0, q, v = record.q0, record.q, record.v
        return [
            part("node", 0, 1.0, "Phi_qT_lam", q, lam=record.lam),
            part("node", 0, -1.0, "Q", q, v=v),
            part("node", nq, 1.0, "Phi_q_xi", q, xi=record.a),
            part("node", nq, -1.0, "gamma", q, v=v),
            part("velocity", 0, 1.0, "Phi_qT_lam", q0, lam=record.rho),
            part("velocity", nq, 1.0, "Phi_q_xi", q, xi=v),
            part("velocity", nq, 1.0, "Phi_t", q),
            part("position", 0, 1.0, "Phi_qT_lam", q0, lam=record.sigma),
            part("position", nq, 1.0, "Phi", q),
        ]

    def along(self, dots: Nodes, b: Array, column: int) -> Motion:
        """The changes of the states with those of the nodes in one column, and of the numbers (len(b), 1)."""
        sweep, of = self._sweep, self._of
        given = sweep.states()
        for kind in ("q", "v"):
            for n in range(self._system.nq):
                getattr(given, kind)[:, n, 0] = of.gathered(kind, n, dots, column)
        t_dot = of.gathered_time(dots, column) if self._moving else np.zeros(len(self.t))
        found, solved = sweep.forward(given, b[: len(self._run.b)], self._sources(b, t_dot))
        for row in np.flatnonzero(self._record.left_out.any(axis=1)).tolist():
            slopes = self._minimum.slopes(Place(0, row))
            if slopes is not None:
                change = Changes(found.q[row], b, t_dot[row : row + 1])
                found.lam[row] = slopes.along(change, found.lam[row])
        return Motion(given, found, solved, b[:, 0], t_dot)

    def _sources(self, b: Array, t_dot: Array) -> loop.Solved | None:
        """The changes of the equations with numbers of curves, and with the times."""
        if not self._curves:
            return None
        found, size = self._sweep.solved(), len(self._run.b)
        own = np.append(b[:size], np.zeros((1, b.shape[1])), axis=0)
        for equation, first, height, sign, by in self._curves:
            moved = by.along(own, height)[:, :, 0] + by.along_column(size, t_dot, height)
            getattr(found, equation)[:, first : first + height, 0] += sign * moved
        return found

    def all_gathered(self, keys: Iterable[Key], nodes: Nodes, b: Array, column: int) -> dict[Key, Array]:
        """See `Sampling`."""
        found = self.along(nodes, b[:, column : column + 1], column).found
        return {(kind, n): getattr(found, kind)[:, n, 0] for kind, n in keys}

    def spread_all(
        self, bars: Mapping[Key, Array], nodes: Nodes, column: int, turned: loop.Turned | None = None
    ) -> Array:
        """See `Sampling`; `turned` is what the change of an adjoint takes."""
        given = self._given(bars)
        t_bar, by_b = self._through_minimum(given)
        kept = self._sweep.solved()
        found, by_own = self._sweep.backward(given, kept, turned)
        for (kind, n), bar in self._by_places(found).items():
            self._of.spread(kind, n, bar, nodes, column)
        size = len(self._run.b)
        for equation, first, height, sign, by in self._curves:
            weights = sign * getattr(kept, equation)[:, first : first + height]
            by_own = by_own - by.gradient(weights, size + 1)[:size]
            t_bar = t_bar - by.by_column(size, weights[:, :, 0])
        if self._moving:
            self._of.spread_time(t_bar, nodes, column)
        return by_own + by_b

    def _given(self, bars: Mapping[Key, Array]) -> Given:
        """Gradients by coordinates as arrays."""
        given = self._sweep.states()
        for (kind, n), bar in bars.items():
            getattr(given, kind)[:, n, 0] += bar
        return given

    def _by_places(self, given: Given) -> dict[Key, Array]:
        """Gradients by q₀ and v₀ as those by their coordinates."""
        pairs = [(kind, getattr(given, kind)) for kind in ("q", "v")]
        return {
            (kind, n): x[:, n, 0] for kind, x in pairs for n in np.flatnonzero(x.any(axis=(0, 2))).tolist()
        }

    def _through_minimum(self, given: Given) -> tuple[Array, Array]:
        """Turn gradients by the least multipliers into those of independent equations; those by times and numbers."""
        t_bar, by_b = np.zeros(len(self.t)), np.zeros((len(self._run.b), 1))
        dependent = self._record.left_out.any(axis=1) & given.lam.any(axis=(1, 2))
        for row in np.flatnonzero(dependent).tolist():
            slopes = self._minimum.slopes(Place(0, row))
            if slopes is not None:
                to = Changes(given.q[row], by_b, t_bar[row : row + 1])
                given.lam[row] = slopes.transposed(given.lam[row], to)
        return t_bar, by_b

    def turned(
        self, bars: Mapping[Key, Array], motion: Motion, dots: Nodes, nodes: Nodes
    ) -> tuple[loop.Turned, Array]:
        """What the change of the adjoint of these gradients takes along a motion; of those by the numbers (len(b),).

        `dots` are the changes of the nodes; gradients that change as times move are added to those by `nodes`.
        """
        sweep, record = self._sweep, self._sweep.record
        kept = sweep.solved()
        given, _ = sweep.backward(self._given(bars), kept)
        if self.moves:
            self._of.spread_along(self._by_places(given), dots, nodes)
        nq = self._system.nq
        (y, z), (w, zeta), (w2, zeta2) = (
            (x[:, :nq, 0], x[:, nq:, 0]) for x in (kept.node, kept.velocity, kept.position)
        )
        dots_of = {f"{name}_dot": getattr(motion.found, name)[:, :, 0] for name in READ}
        q_dot, v_dot = dots_of["q_dot"], dots_of["v_dot"]
        q0_dot, v0_dot = motion.given.q[:, :, 0], motion.given.v[:, :, 0]
        rho_dot, sigma_dot = motion.solved.velocity[:, nq:, 0], motion.solved.position[:, nq:, 0]
        changes = LagrangianChanges(sweep, self._second, motion, self._memory)
        node = changes("motion", q=record.q, v=record.v, a=record.a, lam=record.lam, xi=y, nu=z, **dots_of)
        rate = {"q": record.q0, "q_dot": q0_dot}
        moved = changes(
            "impulse", **rate, xi=w, lam=record.rho, lam_dot=rho_dot, a=record.dv, a_dot=v_dot - v0_dot
        )
        drift = changes("rate", q=record.q, q_dot=q_dot, nu=-zeta, v=record.v, v_dot=v_dot)
        put = changes(
            "impulse", **rate, xi=w2, lam=record.sigma, lam_dot=sigma_dot, a=record.dq,
            a_dot=(q_dot - q0_dot) * record.between[:, None],
        )  # fmt: skip
        place = changes("place", q=record.q, q_dot=q_dot, nu=zeta2)
        if self._moving:
            self._of.spread_time(-changes.t, nodes, 0)
        found = loop.Turned(
            node=np.concatenate([node.a, node.lam], axis=1),
            node_q=node.q,
            node_v=node.v,
            velocity=np.concatenate([moved.a + drift.v, moved.lam], axis=1),
            position=np.concatenate([put.a + place.q, put.lam], axis=1),
            q=drift.q,
            q0=moved.q + put.q - put.a,
            v0=-moved.a,
        )
        return loop.Turned._make(np.ascontiguousarray(x)[:, :, None] for x in found), changes.b
