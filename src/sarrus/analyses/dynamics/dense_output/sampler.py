"""Consistent states of a motion at given times: on the constraints, with the accelerations and multipliers there."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from copy import copy
from typing import Any

import numpy as np

from ...._jit.linking.link import link
from ....algebra import Array
from ....linalg.sparse_solver import SingularMatrix
from ....system import System
from ....system.cached import once_alike
from ....system.curves.curve_potentials import curve_potentials
from ...equations.block_matrix import PRECISE, PlacedMatrix
from ...equations.minimum_norm import left_out
from ...equations.motion import KKTMatrix
from ...redundancy.redundant_constraints import Independence
from ..stepping.entries import entry_of
from ..stepping.nodes import Nodes
from ..stepping.stepper import FactoredPart, RunFailure
from . import sample_loop as loop

GROUPS = {
    "inertia": ("M",),
    "jacobian": ("Phi_q",),
    "residual": ("Phi", "Phi_qT_lam"),
    "velocity": ("Phi_q_xi", "Phi_t"),
    "momentum": ("M_a", "S"),
    "force": ("Q",),
    "gamma": ("gamma",),
}

PORTION = 400  # states, after which an analysis may be stopped
PARTS = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, loop.POINTS))  # of a step, where its points are


@once_alike
def motion_entries(system: System) -> loop.Entries:
    """The kernels of the equations of motion, for compiled code."""
    groups = (*GROUPS.values(), ("potentials",), ("remembered",))
    return loop.Entries._make([entry_of(system, *names) for names in groups])


def motion_work(system: System) -> loop.Work:
    """Arrays that compiled code works on where it solves the equations of motion."""
    nq, m, places = system.nq, system.m, len(system.memory_places)
    widths = (m, nq, nq, nq, nq, m, m, m, nq + m, nq + m, system.potentials.size, places, m)
    return loop.Work._make([*(np.zeros(width) for width in widths), system.layout.moving.is_length])


def motion_arrays(matrix: PlacedMatrix) -> loop.Matrix:
    """The matrix of the equations of motion, as compiled code takes it."""
    numbers = matrix.numbers
    own = (numbers.values, *numbers.of(("M", "Phi_q")), numbers.row_of, numbers.left_out, matrix.placed)
    return loop.Matrix._make(own)


def samples_at(system: System, times: Array) -> loop.Samples:
    """Buffers for states at these times."""
    nq, m, n = system.nq, system.m, len(times)
    states = (np.zeros((n, width)) for width in (nq, nq, nq, m, 2, 2))
    remembered = (np.zeros((n, width)) for width in (len(system.memory_places), system.counted_coordinates.m))
    return loop.Samples._make([np.array(times, dtype=float), *states, np.zeros(n), *remembered])


class Sampler(FactoredPart):
    """States of one system made consistent, by compiled code.

    Parameters
    ----------
    system : System
    independence : which equations are solved, where some are dependent
    b : the numbers of the elements
    host : a matrix whose pattern contains that of the equations of motion, if there is one
    apart : whether q and v are interpolated apart, see `nodes.between`
    """

    VARIABLES = "independence", "_work.weak", "matrix", "_is_factored"

    def __init__(
        self,
        system: System,
        independence: Independence,
        b: Array,
        host: PlacedMatrix | None = None,
        apart: bool = False,
    ) -> None:
        self.system, self.independence, self.b, self.apart = system, copy(independence), b.copy(), apart
        self.matrix = KKTMatrix(system, host=host)
        self.matrix.numbers.keep(independence.rows)
        self._entries, self._work = motion_entries(system), motion_work(system)
        self._sample = link(loop.sample)
        self._arrays: loop.Matrix | None = None
        self._first: tuple[float, Array, Array] | None = None

    def capacity(self, times: Array) -> loop.Samples:
        """Buffers for states at these times."""
        return samples_at(self.system, times)

    def states(self, nodes: Nodes, times: Array, **options: Any) -> loop.Samples:
        """Return consistent states at rising times between the first node and the last; options as of `fill`."""
        out = self.capacity(times)
        for _ in self.fill(out, nodes, **options):
            pass
        return out

    def fill(
        self,
        out: loop.Samples,
        nodes: Nodes,
        *,
        shortest: bool = True,
        known: loop.Samples | None = None,
        crowded: int | None = None,
        monitored: bool = True,
        rounds: int = loop.REFINEMENTS,
    ) -> Iterator[int]:
        """Fill buffers with states at their times, and yield after each portion how many there are.

        Where equations are dependent, with the `shortest` multipliers, or any. Steps with at least so many states as
        `crowded` have points, between which positions and velocities are interpolated; see `sample_loop.sample`.
        """
        self._begin()
        points, point_of = self._points(out.t, nodes, crowded)
        self._choose(float(nodes.t[0]), nodes.q[0])
        if out.memory.size:
            out.memory[:] = nodes.memory[np.maximum(np.searchsorted(nodes.t, out.t) - 1, 0)]
        done, row, renewed = 0, 0, -1
        while done < len(out.t):
            last = min(done + PORTION, len(out.t))
            if self._arrays is None and renewed < done:  # pivots of another state may not fit
                self._renew(out, done, nodes, row)
                renewed = done
            if self._arrays is None:
                self._leave(out, done, nodes, points, point_of)
                done += 1
            else:
                done, row = self._sample(
                    loop.MotionSolver(self._entries, self._arrays, self._work),
                    self.b,
                    self.system.memory_places,
                    nodes,
                    self.apart,
                    loop.Samples._make(buffer[:last] for buffer in out),
                    done,
                    row,
                    left_out(self.system, self.independence.rows if shortest else None),
                    known or self.capacity(out.t[:0]),
                    points,
                    point_of,
                    monitored,
                    rounds,
                )
                if done < last:
                    self._arrays = None
            yield done

    def _points(self, times: Array, nodes: Nodes, crowded: int | None) -> tuple[loop.Samples, Array]:
        """Projected states at the points of crowded steps, and the first row of each step there, or -1."""
        point_of = np.full(len(nodes.t), -1)
        steps = np.zeros(0, np.int64)
        if crowded is not None:
            steps = np.flatnonzero(np.diff(np.searchsorted(times, nodes.t, side="right")) >= crowded)
        if not len(steps):
            return self.capacity(times[:0]), point_of
        begin, ends = self.state(), nodes.t[steps + 1]
        inside = nodes.t[steps, None] + PARTS * (ends - nodes.t[steps])[:, None]
        points = self.states(
            nodes, np.column_stack([inside[:, :-1], ends]).ravel(), monitored=False, rounds=0
        )
        self.resume(begin)  # choices for other states do not depend on points
        projected = np.isfinite(points.growth.reshape(-1, loop.POINTS)).all(axis=1)
        point_of[steps[projected]] = loop.POINTS * np.flatnonzero(projected)
        return points, point_of

    def energies(self, states: Nodes | loop.Samples) -> Array:
        """Kinetic and potential energies, and the power of moved constraints (n, 3)."""
        places, energy = self.system.memory_places, np.zeros((len(states.t), 3))
        nodes = Nodes(*states[:5], states.memory)
        link(loop.energies_along)(self._entries, self.b, places, nodes, self._work, energy)
        memory = dict(zip(places.tolist(), states.memory.T, strict=True))
        energy[:, 1] += curve_potentials(self.system.populations, self.b, memory, states.t, states.q)
        return energy

    def state_at(self, t: float, q: Array, v: Array, memory: Array) -> loop.Samples:
        """Return one consistent state."""
        node = self.node(t, q, v, memory)
        return self.states(node, node.t)

    def node(self, t: float, q: Array, v: Array, memory: Array) -> Nodes:
        """A state alone, whose accelerations and multipliers are not known."""
        a, lam = np.zeros((1, self.system.nq)), np.zeros((1, self.system.m))
        return Nodes(np.array([t]), q[None].copy(), v[None].copy(), a, lam, memory[None].copy())

    def _leave(self, out: loop.Samples, n: int, nodes: Nodes, points: loop.Samples, point_of: Array) -> None:
        """A state where the equations of motion cannot be solved: as interpolated."""
        t = float(out.t[n])
        first = point_of[np.clip(np.searchsorted(nodes.t, t) - 1, 0, max(len(nodes.t) - 2, 0))]
        if first >= 0:
            loop.interpolate_points(points, first, out, n)
        else:
            out.q[n], out.v[n] = nodes.near(t, self.apart) if len(nodes.t) > 1 else (nodes.q[0], nodes.v[0])
        q, v = out.q[n], out.v[n]
        out.a[n], out.lam[n], out.growth[n] = np.nan, np.nan, np.inf
        system, b = self.system, self.b
        rate = system.Phi_q_xi(q, v, t, b=b) + system.Phi_t(q, t, b=b)
        out.violation[n] = [abs(x).max(initial=0.0) for x in (system.Phi(q, t, b=b), rate)]

    def begin(self, t: float, q: Array, memory: Array) -> None:
        """Choose pivots at a state, as soon as states are wanted."""
        self._first = t, q, memory
        self.matrix.take_order()

    def _begin(self) -> None:
        """Choose the pivots that are to be chosen first."""
        if self._first is None:
            return
        (t, q, memory), self._first = self._first, None
        self.b[self.system.memory_places] = memory
        self._choose(t, q)
        self._factored(t, q)

    def _choose(self, t: float, q: Array) -> None:
        """Choose other independent equations if the present choice is poor."""
        if self.independence.renew(t, q):
            self.matrix.numbers.keep(self.independence.rows)
            self._arrays = None

    def _renew(self, out: loop.Samples, n: int, nodes: Nodes, row: int) -> None:
        """A pivot order for the n-th state, unless its matrix is singular."""
        t = float(out.t[n])
        q = nodes.near(t, self.apart)[0] if len(nodes.t) > 1 else nodes.q[0].copy()
        self._choose(t, q)
        self.b[self.system.memory_places] = nodes.memory[row]
        self._factored(t, q)

    def _factored(self, t: float, q: Array) -> bool:
        """Whether the matrix there could be factored."""
        for name in ("M", "Phi_q"):
            self.matrix.numbers.evaluate((name,), self.b, {"t": t, "q": q})
        try:
            self.matrix.factor(PRECISE)
        except (SingularMatrix, ValueError):
            return False
        self._show_matrix()
        return True

    def _show_matrix(self) -> None:
        """The matrix as the loop takes it."""
        self._arrays = motion_arrays(self.matrix)

    def state(self) -> dict[str, Array]:
        """See `RunPart`."""
        self._begin()
        return super().state()

    def resume(self, state: Mapping[str, Array]) -> None:
        """See `RunPart`: the choices made before, which decide on the last digits."""
        self._first = None
        super().resume(state)
        self.matrix.numbers.keep(self.independence.rows)

    def pushed(self, t: float, q: Array, f: Array) -> Array:
        """w of M w + Φ_qᵀσ = f, Φ_q w = 0: what an impulse f does to v in a consistent state near the last one.

        Raises
        ------
        RunFailure
            In a singular configuration.
        """
        self._begin()
        if not self._factored(t, q):
            raise RunFailure(
                "singular configuration",
                f"the position at t = {t:.6g} s is singular: an impulse has no one answer. "
                "Change the start or the event.",
            )
        right = np.concatenate([f, np.zeros(self.system.m)])
        return self.matrix.solve(right)[: self.system.nq]
