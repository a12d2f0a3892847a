"""Radau IIA at work on one system: its memory, its matrices, and the calls of the compiled loop of `radau_loop`."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...._jit.linking.link import link
from ....algebra import Array
from ....linalg.factors import SingularSystem
from ....linalg.sparse_solver import SingularMatrix
from ....results import Assembly, RadauSteps, StepsTaken
from ....system import System
from ...equations.block_matrix import FACTORS, LEFT_OUT, UNIT, Numbers, PlacedMatrix
from ..stepping.first_step import begin_motion, first_step, saved, take_over
from ..stepping.initialization import independence_at, remember_start
from ..stepping.motion_scale import Tolerance
from ..stepping.newton_matrix import motion_parts
from ..stepping.nodes import Nodes
from ..stepping.stabilized_matrix import MATRICES, newton_parts, weigh
from ..stepping.step_store import StepStore
from ..stepping.stepper import Settings, Tally
from ..stepping.tolerance import Tolerances
from . import radau_loop as loop
from .implicit import GROUPS, Accelerations, Implicit, entries

CHUNK = 200  # steps for one call of the compiled loop
DEPENDENT_CHUNK = 20  # steps, after which the choice of independent equations is looked at
# Of what Newton's method may leave, where steps are stored; and what it may leave of the states at most,
# however large tolerances are
EXACT, LEFT = 1e-4, 1e-11
RECORD_SIZE = 4_000_000  # numbers of the record of one chunk of steps, at most


class RadauStepper(Implicit):
    """Radau IIA at work, see `Stepper`."""

    factorizations = 3

    def __init__(self, system: System, scheme: loop.Scheme, start: Assembly, settings: Settings) -> None:
        self.system, self.scheme, self.settings = system, scheme, settings
        self.tolerance, self.enough = inner_tolerances(settings.tolerances)
        if settings.store_steps:
            least = float(min(self.tolerance.share_q.min(), self.tolerance.share_v.min()))
            self.enough = min(self.enough * EXACT, LEFT / least)
        self.t, self.tally, self._vain, self.begin = start.t, Tally(), 0, start
        self.b = (system.b if settings.b is None else settings.b).copy()
        self._numbers = self.b.copy()
        remember_start(system, start, self.b)
        self.independence = independence_at(system, start)
        self._loop = link(loop.advance)
        self._index = loop.Indices(**entries(system, GROUPS))
        self._make_matrices()
        nq, m = system.nq, system.m
        widths = [nq] * 3 + [m] * 2 + [nq] * 4 + [m]
        shapes = [(nq,)] * 3 + [(3, width) for width in widths]
        self._state = loop.State._make(np.zeros(shape) for shape in shapes)
        self._chunk = int(max(1, min(CHUNK, RECORD_SIZE // (4 * nq + m))))
        self.store = StepStore(
            system, _record(system, self._chunk, settings.store_steps), RadauSteps, settings
        )
        self._control: loop.Control = loop.Control.zeros()
        self._memory = _memory(nq, m, self.numbers.views[UNIT])
        self._arrays: loop.Matrices | None = None

    def restart(self, t: float, q: Array, v: Array, until: float) -> None:
        """Begin at a consistent state."""
        self.t, self._span, self._arrays, self._vain = t, until - t, None, 0
        motion = self._motion()
        try:
            a, lam = motion.acceleration(t, q, v)
        except SingularSystem:
            raise self._explained(q, v) from None
        for place in self._state:
            place[:] = 0.0
        begin_motion(self.tolerance, self.system, t, q, until)
        state, control = self._state, self._control
        state.q0[:], state.v0[:], state.a0[:], state.lam_before[:] = q, v, a, lam
        self._last = a.copy(), lam.copy()
        control.clear()
        given = self.store.given()
        control.t, control.h = t, given[0] if len(given) else self._first_step(motion)
        self.store.begin(self.numbers.left_out, t=t, q=q, v=v, a=a, lam=lam)

    def advance(self, stop: float, limit: int) -> Nodes:
        """Steps towards a time, see `Stepper`."""
        self._renew_equations()
        if self._arrays is None:
            self._renew_pivots()
        assert self._arrays is not None
        state, control, before = self._state, self._control, self._control.copy()
        memory = self.b[self.system.memory_places]
        first = [np.array(x, dtype=float)[None] for x in (self.t, state.q0, state.v0, *self._last, memory)]
        limit = min(limit, self._chunk, limit if self.independence.rows is None else DEPENDENT_CHUNK)
        status, taken = self._loop(
            self.scheme, self._index, self.b, self.system.memory_places, stop, limit, self.settings.max_step, state,
            self._memory, self._arrays, control, self.store.record(), self.settings.store_steps, self.tolerance,
            self.enough,
        )  # fmt: skip
        self.t = float(control.t)
        self._count(before)
        self.tally.history.append(self.store.history(taken))
        self._look(status, taken)
        taken_nodes = self.store.collect(taken, memory)
        nodes = Nodes._make(np.concatenate(x) for x in zip(first, taken_nodes, strict=True))
        self._last = nodes.a[-1], nodes.lam[-1]
        return nodes

    def _why_small(self) -> str:
        return (
            "Newton's method or the error control asks for ever smaller steps; a force is not smooth there: name the "
            "times of its jumps in breakpoints, or smooth it"
        )

    def state(self) -> dict[str, Array]:
        """All that is needed to go on, see `Stepper`."""
        found = (
            self._saved()
            | saved(self.tolerance)
            | {"last_a": self._last[0], "last_lam": self._last[1]}
            | self.store.state()
        )
        for kind, matrix in self._matrices().items() if self._arrays is not None else ():
            found |= {f"{kind}_{name}": array for name, array in matrix.state().items()}
        return found

    def resume(self, state: Mapping[str, Array]) -> None:
        """Go on from such a state."""
        self._take_over(state)
        take_over(self.tolerance, state)
        self.numbers.keep(self.independence.rows)
        self.store.resume(state, self.numbers.left_out)
        self._last = state["last_a"], state["last_lam"]
        if "real_factors" in state:
            for kind, matrix in self._matrices().items():
                matrix.resume(*(state[f"{kind}_{name}"] for name in FACTORS))
            self._show()

    def forget(self) -> None:
        """Forget what was stored for derivatives, except the present state."""
        state, (a, lam) = self._state, self._last
        self.store.forget(t=self.t, q=state.q0, v=state.v0, a=a, lam=lam)

    def _matrices(self) -> dict[str, PlacedMatrix]:
        return {"real": self.real, "pair": self.pair, "motion": self.motion}

    def _show(self) -> None:
        """The matrices as the loop takes them."""
        numbers, placed = self.numbers, (matrix.placed for matrix in self._matrices().values())
        shown = (numbers.values, *numbers.of(MATRICES), numbers.row_of, numbers.left_out)
        self._arrays = loop.Matrices._make([*shown, *placed])

    @property
    def host(self) -> PlacedMatrix | None:
        """See `Stepper`."""
        return self.motion

    def steps(self) -> StepsTaken | None:
        """What was stored for derivatives, or None."""
        message = self.settings.tolerances.greatest(self.tolerance)
        return self.store.steps(scheme=self.scheme, start=self.begin, b=self._numbers, **message)

    def _make_matrices(self) -> None:
        system, nq, m = self.system, self.system.nq, self.system.m
        self.numbers = Numbers(system, (*MATRICES, UNIT, LEFT_OUT))
        self.real = PlacedMatrix(self.numbers, 2 * (nq + m), newton_parts(nq, m))
        self.pair = PlacedMatrix(self.numbers, 2 * (nq + m), newton_parts(nq, m), complex)
        self.motion = PlacedMatrix(self.numbers, nq + m, motion_parts(nq))
        self.numbers.keep(self.independence.rows)

    def _renew_equations(self) -> None:
        """Where equations are dependent: another independent choice, if the present one has become poor."""
        state, t = self._state, float(self._control.t)
        if self.independence.renew(t, state.q0):
            self.numbers.keep(self.independence.rows)
            a, lam = self._motion().acceleration(t, state.q0, state.v0)
            self._last, state.lam_before[:] = (a, lam), lam
            self._control.stages_h, self._arrays = 0.0, None

    def _renew_pivots(self) -> None:
        """Pivot orders for the matrices at the present state."""
        state, t, h = self._state, float(self._control.t), float(self._control.h)
        operands = {"t": t, "q": state.q0, "v": state.v0, "a": state.a0, "lam": state.lam_before[2]}
        for kind in ("JACOBIAN", "INERTIA", "STIFFNESS", "TURNING"):
            self.numbers.evaluate(GROUPS[kind], self.b, operands)
        for matrix, s in ((self.real, self.scheme.gamma / h), (self.pair, self.scheme.pair / h)):
            weigh(matrix.weights, 1.0 / (s * s), 1.0 / s)
        try:
            for matrix in self._matrices().values():
                matrix.choose_pivots()
        except SingularMatrix:
            raise self._explained(state.q0, state.v0) from None
        self._show()
        self._control.factored_h, self._control.new_pivots = 0.0, True

    def _first_step(self, motion: Accelerations) -> float:
        """A step whose estimated error, of order h⁴, is below the tolerance; a change of slope gives the scale."""
        if self.settings.first_step:
            return min(self.settings.first_step, self.settings.max_step)
        state, ahead = self._state, 1e-5 * self._span
        if self.settings.tolerances.follow:
            return first_step(
                motion,
                self.tolerance,
                self.t,
                state.q0,
                state.v0,
                state.a0,
                min(0.01 * self._span, self.settings.max_step),
            )
        q, v = state.q0 + ahead * state.v0, state.v0 + ahead * state.a0
        try:
            a, _ = motion.acceleration(self.t + ahead, q, v)
        except SingularSystem:
            a = state.a0
        jerk = (a - state.a0) / ahead / (self.tolerance.atol_v + self.tolerance.rtol_v * abs(state.v0))
        size = float(np.sqrt(np.mean(jerk**2)))
        guess = 0.1 * size ** (-1 / 3) if size > 0 else self._span
        return float(min(max(guess, 1e-7 * self._span), 0.01 * self._span, self.settings.max_step))


def inner_tolerances(given: Tolerances) -> tuple[Tolerance, float]:
    """The tolerances of the error estimate, and what Newton's method may leave of them.

    The estimate is of order 4 in h, the error of order 6: steps are controlled as in Hairer and Wanner's RADAU5, with
    0.1 rtol^(2/3) in the place of rtol.
    """
    inner_q, inner_v = (0.1 * rtol ** (2 / 3) for rtol in (given.rtol_q, given.rtol_v))
    inner = float(min(inner_q.min(), inner_v.min()))
    enough = float(max(1e-14 / inner, min(0.03, inner**0.5)))
    return given.for_loop(inner_q / given.rtol_q, inner_v / given.rtol_v, speed=True), enough


def _record(system: System, capacity: int, stages: bool) -> loop.Record:
    """Buffers for the steps of one call of the loop, with their stages where they are requested."""
    nq, m, places, stored = system.nq, system.m, len(system.memory_places), capacity if stages else 0
    shapes: list[tuple[int, ...]] = [(capacity,)] * 2 + [
        (capacity, width) for width in (nq, nq, nq, m, places)
    ]
    shapes += [(capacity,)] * 3
    shapes += [(stored, 3, width) for width in (nq, nq, m, m)] + [(0,)]
    return loop.Record._make(np.zeros(shape) for shape in shapes)


def _memory(nq: int, m: int, unit: Array) -> loop.Memory:
    whole, small = 2 * (nq + m), nq + m
    shapes = (m, nq, nq, nq, nq, nq, m, m, m, (3, whole), whole, whole)
    last = (small, small, nq)
    pair = [np.zeros(whole, dtype=complex) for _ in range(2)]
    return loop.Memory._make([*(np.zeros(s) for s in shapes), *pair, *(np.zeros(s) for s in last), unit])
