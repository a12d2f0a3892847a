"""Radau IIA at work on one system: its memory, its matrices, and the calls of the compiled loop of `radau_loop`."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np

from ..._jit.driver import compiled_function
from ..._jit.pointer import run
from ...algebra import Array
from ...results import Assembly
from ...system import System
from ..factored import SingularSystem
from ..linear import SingularMatrix
from ..motion import Motion
from . import placed
from . import radau_loop as loop
from .alpha_loop import Tolerance
from .entries import entry_of
from .nodes import Nodes
from .placed import LEFT_OUT, UNIT, Numbers, Part, PlacedMatrix
from .stabilized_matrix import FACTORS, MATRICES, compiled_solver, newton_parts, weigh
from .started import independence_at
from .stepper import Settings, Tally, Trouble
from .tolerance import Tolerances
from .trouble import singular, trouble_of

CHUNK = 200  # steps for one call of the compiled loop
DEPENDENT_CHUNK = 20  # steps, after which the choice of independent equations is looked at
ROOM = 4_000_000  # numbers of the record of one chunk of steps, at most
PATIENCE = 12  # calls of the loop without a step, after which the position is called singular
GROUPS = {
    "RESIDUAL": ("Phi", "Phi_qT_lam"),
    "MOMENTUM": ("M_a", "S"),
    "FORCE": ("Q",),
    "VELOCITY": ("Phi_q_xi", "Phi_t"),
    "JACOBIAN": ("Phi_q", "Phi_qT_lam_q"),
    "INERTIA": ("M", "M_a_q", "S_q", "S_v"),
    "STIFFNESS": ("Q_q", "Q_v"),
    "TURNING": ("gamma_v",),
    "BENDING": ("Phi_q", "gamma"),
}
CALLS = {  # scalars and arrays that each takes
    "RESIDUAL": (1, 4),
    "MOMENTUM": (0, 5),
    "FORCE": (1, 3),
    "VELOCITY": (1, 4),
    "JACOBIAN": (1, 4),
    "INERTIA": (0, 7),
    "STIFFNESS": (1, 4),
    "TURNING": (1, 3),
    "BENDING": (1, 4),
    "REMEMBER": (1, 2),
}
KINDS = ("real", "pair", "motion")


def motion_parts(nq: int, m: int) -> list[Part]:
    """[M Φ_qᵀ; Φ_q 0], with a 1 for every equation left out."""
    below, above = Part("Phi_q", nq, 0), Part("Phi_q", 0, nq, transposed=True)
    return [Part("M", 0, 0), below, above, Part(LEFT_OUT, nq, nq)]


@cache
def _compiled() -> Any:
    """The time loop: the same code for every system; drivers are called by their address."""
    known: dict[str, Any] = {name: run(*counts) for name, counts in CALLS.items()}
    known |= compiled_solver()
    known["weigh"] = compiled_function(weigh)
    inner = (
        "stages",
        "residual",
        "evaluate",
        "factor",
        "scaled",
        "unscaled",
        "size",
    )
    outer = ("improve", "newton", "estimate", "lagrange", "predict", "first_guess", "accept", "smooth")
    for name in (*inner, *outer, "motion", "keep", "remember", "advance"):
        known[name] = compiled_function(getattr(loop, name), **known)
    return known["advance"]


class RadauStepper:
    """Radau IIA at work, see `Stepper`."""

    def __init__(self, system: System, scheme: loop.Scheme, start: Assembly, settings: Settings) -> None:
        self.system, self.scheme, self.settings = system, scheme, settings
        self.tolerance, self.enough = inner_tolerances(settings.tolerances)
        self.t, self.tally, self._vain = 0.0, Tally(), 0
        self.b = system.b.copy()
        system.remember(start.q, self.b, 0.0)
        self.independence = independence_at(system, start)
        self._loop = _compiled()
        entries = [entry_of(system, *names) for names in (*GROUPS.values(), ("remembered",))]
        self._index = loop.Indices._make(entries)
        self._make_matrices()
        nq, m, places = system.nq, system.m, len(system.memory_places)
        widths = [nq] * 3 + [m] * 2 + [nq] * 4 + [m]
        shapes = [(nq,)] * 3 + [(3, width) for width in widths]
        self._state = loop.State._make(np.zeros(shape) for shape in shapes)
        self._chunk = int(max(1, min(CHUNK, ROOM // (4 * nq + m))))
        room = self._chunk
        rows = [(room,)] * 2 + [(room, width) for width in (nq, nq, nq, m, places, 3)]
        self._record = loop.Record._make(np.zeros(shape) for shape in rows)
        self._control = loop.Control(np.zeros(8), np.zeros(6, dtype=np.int64))
        self._memory = _memory(nq, m)
        self._arrays: loop.Matrices | None = None

    def restart(self, t: float, q: Array, v: Array, until: float) -> None:
        """Begin at a consistent state."""
        self.t, self._span, self._arrays, self._vain = t, until - t, None, 0
        try:
            a, lam = self._motion().acceleration(t, q, v)
        except SingularSystem:
            raise self._explained(q, v) from None
        for place in self._state:
            place[:] = 0.0
        state, numbers = self._state, self._control.numbers
        state.q0[:], state.v0[:], state.a0[:], state.lam_before[:] = q, v, a, lam
        self._last = a.copy(), lam.copy()
        numbers[:] = 0.0
        numbers[0], numbers[1] = t, self._first_step()

    def advance(self, stop: float, limit: int) -> Nodes:
        """Steps towards a time, see `Stepper`."""
        self._renew_equations()
        if self._arrays is None:
            self._renew_pivots()
        state, control, before = self._state, self._control, self._control.counts.copy()
        memory = self.b[self.system.memory_places]
        first = [np.array(x, dtype=float)[None] for x in (self.t, state.q0, state.v0, *self._last, memory)]
        limit = min(limit, self._chunk, limit if self.independence.kept is None else DEPENDENT_CHUNK)
        status, taken = self._loop(
            self.scheme, self._index, self.b, self.system.memory_places, stop, limit, self.settings.max_step, state,
            self._memory, self._arrays, control, self._record, self.tolerance, self.enough,
        )  # fmt: skip
        self.t, record = float(control.numbers[0]), self._record
        steps, rejected, residuals, matrices = (int(x) for x in (control.counts - before)[:4])
        self.tally.add(steps, rejected, residuals, matrices, 3 * matrices)
        self.tally.history.append(np.column_stack([record.t[:taken], record.h[:taken], record.told[:taken]]))
        self._look(status, taken)
        taken_nodes = (getattr(record, name)[:taken] for name in Nodes._fields)
        nodes = Nodes._make(np.concatenate(x) for x in zip(first, taken_nodes, strict=True))
        self._last = nodes.a[-1], nodes.lam[-1]
        return nodes

    def _look(self, status: int, taken: int) -> None:
        """What comes of a call of the loop."""
        self._vain = 0 if taken else self._vain + 1
        state = self._state
        if status == loop.REPIVOT:
            self._arrays = None
            if self._vain > 1:  # new pivots did not help: a shorter step may
                self._control.numbers[1] *= 0.25
            if self._vain > PATIENCE:
                raise self._explained(state.q0, state.v0)
        if status == loop.TOO_SMALL and not taken:
            told = (
                f"steps become too small near t = {self.t:.6g} s: Newton's method or the error control asks for ever "
                "smaller steps; a force is not smooth there: name the times of its jumps in breakpoints, or smooth it"
            )
            raise self._explained(state.q0, state.v0, Trouble("step too small", told))

    def _motion(self) -> Motion:
        motion = Motion(self.system, self.independence.kept)
        motion.b[:] = self.b
        return motion

    def state(self) -> dict[str, Array]:
        """All that is needed to go on, see `Stepper`."""
        found = {f"state_{name}": array for name, array in zip(loop.State._fields, self._state, strict=True)}
        if self._arrays is not None:
            for kind in KINDS:
                shown = getattr(self._arrays, kind)
                found |= {f"{kind}_{name}": getattr(shown, name) for name in FACTORS}
        numbers = np.array([self.t, self._span, self._vain])
        found |= {
            "b": self.b,
            "numbers": self._control.numbers,
            "counts": self._control.counts,
            "own": numbers,
        }
        found |= {"last_a": self._last[0], "last_lam": self._last[1]}
        return found | {"tally": self.tally.counts(), "null": self.independence.state()}

    def resume(self, state: Mapping[str, Array]) -> None:
        """Go on from such a state."""
        self.independence.resume(state["null"])
        self._keep()
        for name, array in zip(loop.State._fields, self._state, strict=True):
            array[:] = state[f"state_{name}"]
        self.b[:], self._control.numbers[:] = state["b"], state["numbers"]
        self._control.counts[:] = state["counts"]
        self.t, self._span, self._vain = float(state["own"][0]), float(state["own"][1]), int(state["own"][2])
        self.tally, self._arrays, self._last = (
            Tally.of(state["tally"]),
            None,
            (state["last_a"], state["last_lam"]),
        )
        if "real_factors" in state:
            kinds = zip(KINDS, (self.real, self.pair, self.motion), strict=True)
            self._show([matrix.resumed(*(state[f"{kind}_{n}"] for n in FACTORS)) for kind, matrix in kinds])

    def _show(self, placed_anew: list[placed.Placed]) -> None:
        """The matrices as the loop takes them."""
        views = self.numbers.views
        shown = (self.numbers.values, *(views[name] for name in MATRICES), self._row_of, views[LEFT_OUT])
        self._arrays = loop.Matrices._make([*shown, *placed_anew])

    def steps(self) -> None:
        """No steps are kept."""

    def _make_matrices(self) -> None:
        system, nq, m = self.system, self.system.nq, self.system.m
        self.numbers = Numbers(system, (*MATRICES, UNIT, LEFT_OUT))
        self.real = PlacedMatrix(self.numbers, 2 * (nq + m), newton_parts(nq, m))
        self.pair = PlacedMatrix(self.numbers, 2 * (nq + m), newton_parts(nq, m), complex)
        self.motion = PlacedMatrix(self.numbers, nq + m, motion_parts(nq, m))
        self._row_of = self.numbers.entries("Phi_q")[0]
        self._keep()

    def _keep(self) -> None:
        left_out = self.numbers.views[LEFT_OUT]
        left_out[:] = 0.0 if self.independence.kept is None else 1.0
        left_out[[] if self.independence.kept is None else self.independence.kept] = 0.0

    def _explained(self, q: Array, v: Array, otherwise: Trouble | None = None) -> Trouble:
        """Why there are no further steps."""
        told = otherwise or singular(self.t, [])
        return trouble_of(self.system, self.b, self.t, q, v, self.independence, self._span, told)

    def _renew_equations(self) -> None:
        """Where equations are dependent: another independent choice, if the present one has become poor."""
        state, t = self._state, float(self._control.numbers[0])
        if self.independence.renew(t, state.q0):
            self._keep()
            a, lam = self._motion().acceleration(t, state.q0, state.v0)
            self._last, state.lam_before[:] = (a, lam), lam
            self._control.numbers[6], self._arrays = 0.0, None

    def _renew_pivots(self) -> None:
        """Pivot orders for the matrices at the present state."""
        system, state, views = self.system, self._state, self.numbers.views
        t, h = float(self._control.numbers[0]), float(self._control.numbers[1])
        operands = {"t": t, "q": state.q0, "v": state.v0, "a": state.a0, "lam": state.lam_before[2]}
        for kind in ("JACOBIAN", "INERTIA", "STIFFNESS", "TURNING"):
            group = system.group(*GROUPS[kind])
            group.run(self.b, *(operands[k] for k in group.operands), *(views[name] for name in group.names))
        views["Phi_q"][views[LEFT_OUT][self._row_of] > 0] = 0.0
        for matrix, s in ((self.real, self.scheme.gamma / h), (self.pair, self.scheme.pair / h)):
            weigh(matrix.weights, 1.0 / (s * s), 1.0 / s)
        try:
            placed_anew = [matrix.placed() for matrix in (self.real, self.pair, self.motion)]
        except SingularMatrix:
            raise self._explained(state.q0, state.v0) from None
        self._show(placed_anew)
        self._control.numbers[2], self._control.numbers[7] = 0.0, 1.0

    def _first_step(self) -> float:
        """A step whose estimated error, of order h⁴, is below the tolerance; a change of slope gives the scale."""
        if self.settings.first_step:
            return min(self.settings.first_step, self.settings.max_step)
        state, ahead = self._state, 1e-5 * self._span
        q, v = state.q0 + ahead * state.v0, state.v0 + ahead * state.a0
        try:
            a, _ = self._motion().acceleration(self.t + ahead, q, v)
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
    atol = given.atol_q * inner_q / given.rtol_q, given.atol_v * inner_v / given.rtol_v
    return Tolerance(inner_q, atol[0], inner_v, atol[1], 1.0), enough


def _memory(nq: int, m: int) -> loop.Memory:
    whole, small = 2 * (nq + m), nq + m
    shapes = (m, nq, nq, nq, nq, nq, m, m, m, (3, whole), whole, whole)
    last = (small, small, nq)
    pair = [np.zeros(whole, dtype=complex) for _ in range(2)]
    return loop.Memory._make([*(np.zeros(s) for s in shapes), *pair, *(np.zeros(s) for s in last)])
