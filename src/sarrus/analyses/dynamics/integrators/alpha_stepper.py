"""The compiled loop of HHT and generalized-α at work on a system."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...._jit.linking.link import link
from ....algebra import Array
from ....linalg.factors import DENSE_BELOW, SingularSystem
from ....linalg.sparse_solver import SingularMatrix
from ....results import Assembly, Steps, StepsTaken
from ....system import System
from ...equations.block_matrix import PRECISE, PlacedMatrix
from ...equations.closure import round_off_of
from ...equations.length import extent
from ..methods.leading_error import Leading
from ..stepping import alpha_loop as loop
from ..stepping.failures import has_laws
from ..stepping.first_step import begin_motion, first_step, saved, take_over
from ..stepping.initialization import independence_at, remember_start
from ..stepping.motion_scale import Tolerance
from ..stepping.newton_matrix import newton_matrix, weigh
from ..stepping.nodes import Nodes
from ..stepping.step_store import StepStore
from ..stepping.stepper import Settings, Tally
from ..time_loop.time_loop import CHUNK
from .implicit import GROUPS, Accelerations, Implicit, entries

RECORD_SIZE = 300_000  # numbers of the record of one chunk of steps, at most
FAR = 1e4  # of the system's size: distances from the origin at which positions have four digits fewer
FIRST_TRIALS = 20  # lengths of the first step that are tried, each at most half of the one before
DEPENDENT_CHUNK = 100  # steps, after which the choice of independent equations is looked at
KINDS = ("RESIDUAL", "MOMENTUM", "FORCE", "JACOBIAN", "INERTIA", "STIFFNESS", "VELOCITY")
REASONS = {  # what failed, and a possible cause where there are forces
    0: (
        "Newton's method met singular matrices",
        ": a force without bounds or a singular configuration may be the cause; smooth it, or change the start",
    ),
    loop.NEWTON: (
        "Newton's method did not converge",
        ": a law with a corner or a very stiff contact may be the cause; smooth it, or give a larger atol",
    ),
    loop.ERROR: (
        "the error control asked for ever smaller steps",
        ": a force is very stiff or not smooth; give a larger atol, or name the times of its jumps in breakpoints",
    ),
}


class AlphaStepper(Implicit):
    """HHT or generalized-α at work on one system: its memory, and the calls of the compiled loop.

    Attributes
    ----------
    t, b, independence, tally : see `Stepper`
    """

    apart = True
    kind: type[StepsTaken] = Steps

    @property
    def _counts_periods(self) -> bool:
        """Whether tolerances depend on the number of periods of a run."""
        return False

    def __init__(self, system: System, scheme: Any, start: Assembly, settings: Settings) -> None:
        self.system, self.scheme, self.settings, self.begin = system, scheme, settings, start
        self.b = (system.b if settings.b is None else settings.b).copy()
        self.t, self.tally = start.t, Tally()
        self._numbers = self.b.copy()
        remember_start(system, start, self.b)
        self.independence = independence_at(system, start)
        self._make()
        nq, m = system.nq, system.m
        self._chunk = int(max(1, min(CHUNK, RECORD_SIZE // (4 * nq + m))))
        self.store = StepStore(system, self._record(self._chunk), self.kind, settings)
        self._tolerance = self._tolerances()
        self._arrays: Any = None
        self._vain = 0

    def _tolerances(self) -> Tolerance:
        """Those of the loop."""
        return self.settings.tolerances.for_loop()

    def _make(self) -> None:
        """The matrix, the compiled loop, and the arrays that it works on."""
        system, nq, m = self.system, self.system.nq, self.system.m
        self.matrix = newton_matrix(system)
        self.matrix.numbers.keep(self.independence.rows)
        self._advance, self._weigh, self._passed = link(loop.advance), weigh, self.scheme
        self._entries: Any = loop.Entries(**entries(system, KINDS))
        rows = (m, nq, nq, nq, nq, m, m, nq + m, nq + m, nq, m, nq + m)
        self._memory: Any = loop.Memory(*(np.zeros(length) for length in rows))
        widths = (nq, nq, nq, nq, m, nq, nq, nq, nq, m, nq, m)
        self._state: Any = loop.State(*(np.zeros(length) for length in widths))
        self._control: loop.Control = loop.Control.zeros()
        self.first_error = Leading(3, self.scheme.error)

    def _record(self, capacity: int) -> Any:
        """Buffers for the steps of one call of the loop, with what only sweeps need if they are stored."""
        nq, m, places = self.system.nq, self.system.m, len(self.system.memory_places)
        corrected = capacity if self.settings.store_steps else 0
        shapes = [*[(capacity,)] * 3, *[(capacity, nq)] * 4, (capacity, m), (corrected, nq), (corrected, m)]
        shapes += [(capacity, places), *[(capacity,)] * 3, (0,)]
        return loop.Record._make(np.zeros(shape) for shape in shapes)

    def restart(self, t: float, q: Array, v: Array, until: float) -> None:
        """Begin at a consistent state: a and λ of the equations of motion, ã = a, a first step of its own."""
        self.t, self._span, self._arrays, self._vain = t, until - t, None, 0
        motion = self._motion()
        try:
            a, lam = motion.acceleration(t, q, v)
        except SingularSystem:
            raise self._explained(q, v) from None
        begin_motion(self._tolerance, self.system, t, q, until if self._counts_periods else None)
        self._begin_at(q, v, a, lam)
        self._memory.noise[:] = round_off_of(self.system.Phi_q(q, t, b=self.b), q)
        control, given = self._control, self.store.given()
        control.clear()
        control.t, control.defect = t, 1.0
        control.h = control.x_h = given[0] if len(given) else self._first_step(motion)
        self._renew_pivots()
        self.store.begin(self.matrix.numbers.left_out, **self._node())

    def _begin_at(self, q: Array, v: Array, a: Array, lam: Array) -> None:
        """The first state."""
        for place in self._state:
            place[:] = 0.0
        for name, value in {"q": q, "v": v, "a": a, "x": a, "lam": lam}.items():
            for place in (getattr(self._state, f"{name}0"), getattr(self._state, f"{name}1")):
                place[:] = value

    def _node(self) -> dict[str, Any]:
        """The present state, as it is stored."""
        state = self._state
        return {"t": self.t, "q": state.q0, "v": state.v0, "a": state.a0, "x": state.x0, "lam": state.lam0}

    def advance(self, stop: float, limit: int) -> Nodes:
        """Steps towards a time, see `Stepper`."""
        if self.independence.rows is not None:
            self._renew_equations()
        state, control, before = self._state, self._control, self._control.copy()
        memory = self.b[self.system.memory_places]
        first = [
            np.array(x, dtype=float)[None] for x in (self.t, state.q0, state.v0, state.a0, state.lam0, memory)
        ]
        if self._arrays is None:
            self._renew_pivots()
        limit = min(limit, self._chunk, limit if self.independence.rows is None else DEPENDENT_CHUNK)
        status, taken = self._advance(
            self._passed, self._entries, self.b, self.system.memory_places, stop, limit, self.settings.max_step, state,
            self._memory, self._arrays, control, self.store.record(), self.settings.store_steps, self._tolerance,
        )  # fmt: skip
        self.t = float(control.t)
        self._count(before)
        self.tally.history.append(self.store.history(taken))
        self._look(status, taken)
        return Nodes._make(
            np.concatenate(x) for x in zip(first, self.store.collect(taken, memory), strict=True)
        )

    def _forget_pivots(self) -> None:
        self._arrays, self.matrix.placed = None, None

    @property
    def host(self) -> PlacedMatrix | None:
        """See `Stepper`."""
        return self.matrix

    def _why_small(self) -> str:
        r = self._state.q0.reshape(-1, 7)[:, :3]
        far = float(abs(r).max(initial=0.0))
        if far > FAR * extent(self.system, self._state.q0) and self._control.x_h < self._finest():
            return (
                f"bodies are {far:.3g} m from the origin, where positions have fewer digits than the tolerances "
                "ask for. Place the model near the origin, give a larger atol, or use Radau()"
            )
        failure, cause = REASONS[int(self._control.failure)]
        return failure + cause if has_laws(self.system) else failure

    def _renew_equations(self) -> None:
        """Where equations are dependent: another independent choice, if the present one has become poor."""
        state = self._state
        if self.independence.renew(self.t, state.q0):
            self.matrix.numbers.keep(self.independence.rows)
            state.lam0[:] = self._motion().acceleration(self.t, state.q0, state.v0)[1]
            state.lam_change[:] = 0.0
            self._arrays = None

    def _renew_pivots(self) -> None:
        """A pivot order for the matrix at the present state."""
        state, h = self._state, self._control.h
        try:
            self._factor(self.t, (state.q0, state.v0, state.a0, state.lam0), loop.weights_of(self.scheme, h))
        except SingularMatrix:
            raise self._explained(state.q0, state.v0) from None
        self._control.beta = 0.0
        self._show_matrix()

    def _factor(self, t: float, state: tuple[Array, ...], weights: tuple[float, float]) -> None:
        """Factor the matrix at a state for a scheme's β' and γ'."""
        self._evaluate(dict(zip(("q", "v", "a", "lam"), state, strict=True)) | {"t": t})
        self._weigh(self.matrix.weights, *weights)
        self.matrix.factor(PRECISE)

    def _factor_motion(self, t: float, q: Array) -> PlacedMatrix:
        """The matrix of the equations of motion at a position, factored."""
        nq, m = self.system.nq, self.system.m
        self._factor(t, (q, np.zeros(nq), np.zeros(nq), np.zeros(m)), (0.0, 0.0))
        return self.matrix

    def _motion(self) -> Accelerations:
        """Large systems have their first accelerations from the matrix of the method, small ones by LAPACK."""
        return self if self.matrix.n >= DENSE_BELOW else super()._motion()

    def acceleration(self, t: float, q: Array, v: Array) -> tuple[Array, Array]:
        """a (nq,) and lam (m,) of the equations of motion at a state.

        Raises
        ------
        SingularSystem
            If they do not exist.
        """
        system, stored = self.system, self.matrix.numbers.left_out == 0.0
        try:
            matrix = self._factor_motion(t, q)
        except SingularMatrix as error:
            raise SingularSystem(str(error)) from None
        force = system.Q(q, v, t, b=self.b) + system.S(q, v, b=self.b)
        found = matrix.solve(np.concatenate([force, stored * system.gamma(q, v, t, b=self.b)]))
        if not np.all(np.isfinite(found)):
            raise SingularSystem("the matrix is singular to working precision")
        return found[: system.nq], found[system.nq :]

    def _evaluate(self, operands: dict[str, Any]) -> None:
        """The numbers of all operators of the matrix."""
        for kind in ("JACOBIAN", "INERTIA", "STIFFNESS"):
            self.matrix.numbers.evaluate(GROUPS[kind], self.b, operands)

    def _show_matrix(self) -> None:
        """The matrix as the loop takes it."""
        self._arrays = loop.matrix_of(self.matrix)

    def _finest(self) -> float:
        """The step at which round-off in Φ, over h, is as large in v as what Newton's method may leave there."""
        state, tolerances = self._state, self.settings.tolerances
        noise = 2 * np.finfo(float).eps * abs(state.q0).max(initial=0.0)
        relative = noise / (tolerances.atol_v + tolerances.rtol_v * abs(state.v0))
        return float(np.sqrt(np.mean(relative**2))) / loop.NEWTON_SHARE

    def _first_step(self, motion: Accelerations) -> float:
        """A step whose error is well below the tolerance: h² a, or h³ ȧ, ȧ by a difference along the motion."""
        if self.settings.first_step:
            return min(self.settings.first_step, self.settings.max_step)
        state, span, (exponent, constant) = self._state, self._span, self.first_error
        if self.settings.tolerances.follow:
            longest = min(0.01 * span, self.settings.max_step)
            return self._within_tolerance(
                motion, first_step(motion, self._tolerance, self.t, state.q0, state.v0, state.a0, longest)
            )
        longest = max(0.01 * span, self._finest())  # the loop cuts a step at the end
        ahead = 1e-5 * span
        q, v = state.q0 + ahead * state.v0, state.v0 + ahead * state.a0
        try:
            a, _ = motion.acceleration(self.t + ahead, q, v)
        except SingularSystem:
            a = state.a0
        slope = (a - state.a0) / ahead if exponent > 2 else a
        size = float(np.sqrt(np.mean((constant * slope / self._tolerance_of_q()) ** 2)))
        guess = 0.4 * size ** (-1 / min(exponent, 3)) if size > 0 else span
        guess = float(min(max(guess, 1e-7 * span), longest, self.settings.max_step))
        return max(self._within_tolerance(motion, guess), min(1e-7 * span, guess))

    def _tolerance_of_q(self) -> Array:
        tolerance = self._tolerance
        return np.asarray(tolerance.atol_q + tolerance.rtol_q * abs(self._state.q0))

    def _within_tolerance(self, motion: Accelerations, h: float) -> float:
        """A first step shortened until its estimated error, h² times the change of a over it, is within the tolerance.

        ȧ vanishes where a spring is released at rest: there it does not predict the steps that follow.
        """
        state, tolerance = self._state, self._tolerance_of_q()
        exponent, constant = self.first_error
        for _ in range(FIRST_TRIALS):
            q, v = state.q0 + h * (state.v0 + 0.5 * h * state.a0), state.v0 + h * state.a0
            try:
                change = motion.acceleration(self.t + h, q, v)[0] - (state.a0 if exponent > 2 else 0.0)
            except SingularSystem:
                return h
            error = constant * h**2 * float(np.sqrt(np.mean((change / tolerance) ** 2)))
            if not error > 1.0:
                break
            h *= min(max(0.8 * error ** (-1 / min(exponent, 3)), 0.1), 0.5)
        return h

    def state(self) -> dict[str, Array]:
        """All that is needed to go on, see `Stepper`."""
        ready = self._arrays is not None
        found = self._saved() | saved(self._tolerance) | self.store.state() | {"noise": self._memory.noise}
        found["correction"] = self._memory.correction
        return found | {f"matrix_{n}": x for n, x in self.matrix.state().items() if ready}

    def resume(self, state: Mapping[str, Array]) -> None:
        """Go on from such a state."""
        self._take_over(state)
        take_over(self._tolerance, state)
        self._memory.noise[:], self._memory.correction[:] = state["noise"], state["correction"]
        self.matrix.numbers.keep(self.independence.rows)
        self.store.resume(state, self.matrix.numbers.left_out)
        found = {name[7:]: array for name, array in state.items() if name.startswith("matrix_")}
        if found:
            self.matrix.resume(**found)
            self._show_matrix()

    def forget(self) -> None:
        """Forget what was stored for derivatives, except the present state."""
        self.store.forget(**self._node())

    def steps(self) -> StepsTaken | None:
        """What was stored for derivatives, or None."""
        message = self.settings.tolerances.greatest(self._tolerance)
        return self.store.steps(scheme=self.scheme, start=self.begin, b=self._numbers, **message)
