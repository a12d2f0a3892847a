"""Described methods at work: the run of every `Description`, also of a user's."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...._jit.linking.link import link
from ....algebra import Array
from ....defaults import RTOL_OF_ORDER_2
from ....linalg.factors import SingularSystem
from ....linalg.sparse_solver import SingularMatrix
from ....results import Assembly, StepsTaken
from ....system import System
from ...equations.block_matrix import PRECISE, Numbers, PlacedMatrix
from ...equations.length import extent, kinematic_weights
from ...equations.motion import KKTMatrix
from ...equations.paired_matrix import PairedMatrix, none_paired
from ...equations.projection import round_off_of
from ..dense_output.sample_loop import MotionSolver
from ..dense_output.sampler import motion_arrays, motion_entries, motion_work
from ..events.switching_functions import no_switching
from ..methods.collocation import RADAU
from ..methods.description import Affine, Description, FilteredEstimate
from ..methods.leading_error import ErrorTerm, leading_errors
from ..step_loop import loop
from ..step_loop.crossing import Crossing, Switching
from ..step_loop.equations import evaluate
from ..step_loop.newton import NEWTON_SHARE
from ..step_loop.records import Control, Matrix, Memory, Record, Run, State
from ..step_loop.step_store import StepStore
from ..stepping.entries import entry_of
from ..stepping.failures import failure_of, has_laws, singular
from ..stepping.nodes import Nodes
from ..stepping.step_control import StepControl
from ..stepping.stepper import (
    CHUNK,
    FactoredPart,
    RunFailure,
    Settings,
    Stepper,
    Tally,
    independence_at,
    remember_start,
)
from ..stepping.tolerance import FOLLOWED, Given, Tolerances, begin_motion, first_step
from .layout import filtered_tolerance, kernels_of, layout_of

PATIENCE = 12  # calls of the loop without a step, after which the position is called singular
RECORD_SIZE = 300_000  # numbers of the record of one chunk of steps, at most
FAR = 1e4  # of the system's size: distances from the origin at which positions have four digits fewer
DEPENDENT_CHUNK = 100  # steps, after which the choice of independent equations is looked at
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
        ": a force is very stiff or not smooth; give a larger atol, or name the times of its jumps among the events",
    ),
}


class StepMethod(StepControl):
    """Interface of methods whose steps can be prescribed, and stored for derivatives."""

    def stepper(self, system: System, start: Assembly, settings: Settings) -> Stepper:
        """The method at work, see `Stepper`."""
        raise NotImplementedError


@dataclass(frozen=True)
class DescribedMethod(StepMethod):
    """A method that is given by its description, with the control of its steps.

    Parameters
    ----------
    description : Description
    rtol, atol, max_step, first_step : see `StepControl`; `rtol` is 1e-6 by default

    Raises
    ------
    TypeError
        If it is no description.
    """

    description: Description
    rtol: Given = field(default=RTOL_OF_ORDER_2, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        given: Any = self.description
        if not isinstance(given, Description):
            raise TypeError(
                f"DescribedMethod needs a Description, got {given!r}. Give one, such as sr.HHT().description, "
                "or give the method itself."
            )

    def stepper(self, system: System, start: Assembly, settings: Settings) -> DescribedStepper:
        """The method at work, see `Stepper`."""
        return DescribedStepper(system, self.description, start, settings)


@dataclass(frozen=True)
class Radau(StepMethod):
    """Radau IIA method of order 5 with variable steps: implicit, stiffly accurate and L-stable. The default.

    Three stages on the stabilized index-2 (GGL) equations, see `methods.collocation`.

    All stages are solved together by Newton's method; one real and one complex matrix are factored for them.

    Parameters
    ----------
    rtol, atol, max_step, first_step : see `StepControl`
    """

    def stepper(self, system: System, start: Assembly, settings: Settings) -> DescribedStepper:
        """The method at work, see `Stepper`."""
        return DescribedStepper(system, RADAU, start, settings)


class DescribedStepper(FactoredPart):
    """A described method at work on one system: its memory, and the calls of the compiled loop.

    Parameters
    ----------
    system : System
    scheme : its description
    start, settings : of the run

    Attributes
    ----------
    t, b, independence, tally, apart : see `Stepper`
    evaluations, factorizations : of the equations of motion for each residual, and of the matrices for each evaluation

    Raises
    ------
    TypeError, ValueError
        If the description is not one of a method.
    """

    VARIABLES = (
        "independence", "t", "_span", "_vain", "b", "tally", "_state.x", "_state.r", "_state.v_given", "_state.past",
        "_state.past_a", "_control", "_crossing", *FOLLOWED, "_memory.noise", "_memory.correction", "store", "matrix",
        "_of_motion", "_pair", "_is_factored",
    )  # fmt: skip
    passes_kinks = True

    def __init__(self, system: System, scheme: Description, start: Assembly, settings: Settings) -> None:
        self.system, self.scheme, self.settings, self.begin = system, scheme, settings, start
        self.b = (system.b if settings.b is None else settings.b).copy()
        self.t, self.tally = start.t, Tally()
        self._numbers = self.b.copy()
        remember_start(system, start, self.b)
        self.independence = independence_at(system, start)
        self._layout = layout_of(system, scheme)
        self._program, (self._first_error, later) = self._layout.program, leading_errors(scheme)
        self._split = len(self._program.T) > 0
        self.evaluations, self.factorizations = (3, 2) if self._split else (1, 1)
        self.apart = later.exponent <= ErrorTerm(3, 0.0).exponent
        self._make_matrices()
        self._make_memory(0 if scheme.error else max(later.exponent - 2, 0))
        self._chunk = int(max(1, min(CHUNK, RECORD_SIZE // (4 * system.nq + system.m))))
        self.store = StepStore(system, self._record(self._chunk), settings, self.matrix.numbers.left_out)
        given, error = settings.tolerances, scheme.error
        self._filtered = isinstance(error, FilteredEstimate)
        self._tolerance = (
            filtered_tolerance(given, error) if isinstance(error, FilteredEstimate) else given.for_loop()
        )
        self._arrays: Matrix | None = None
        self._vain, self._span = 0, 0.0
        self.switching, self._crossing = no_switching(system.nq), Crossing.zeros()
        self.switched: Crossing | None = None

    def _make_matrices(self) -> None:
        """The matrices of a step and of the equations of motion, and the compiled loop."""
        system, of_matrix = self.system, self._layout.of_matrix
        numbers = Numbers(system, of_matrix.names, of_matrix.like)
        self.matrix = PlacedMatrix(numbers, of_matrix.n, of_matrix.parts)
        self._pair = PairedMatrix(self.matrix, of_matrix.parts) if self._split else None
        self._of_motion = KKTMatrix(system)
        self._keep(self.independence.rows)
        self._advance = link(loop.advance)
        self._entries, self._remembered = kernels_of(system, self.scheme), entry_of(system, "remembered")

    def _make_memory(self, past: int) -> None:
        """The arrays that the loop works on, with as many past nodes as its estimate needs."""
        system, nq, m, n = self.system, self.system.nq, self.system.m, self._layout.tables.n
        x, one = np.zeros(self._layout.size), self._layout.of_matrix.n if self._split else 0
        right = x[self._program.right : self._program.right + n]
        own = [np.zeros(width) for width in (n, m, nq + m)]
        self._memory = Memory._make([right, *own, kinematic_weights(system), np.zeros(one), np.zeros(one)])
        self._motion_kernels, self._work = motion_entries(system), motion_work(system)
        views = {name: x[place] for name, place in self._layout.nodes.items()}
        others = {"v_given": np.zeros(nq), "past": np.zeros(past), "past_a": np.zeros((past, nq))}
        self._state = State(x=x, r=np.zeros(len(self._program.tape)), **views, **others)
        self._control: Control = Control.zeros()

    def _keep(self, rows: Array | None) -> None:
        """Solve only the equations in these places."""
        for matrix in (self.matrix, self._of_motion):
            matrix.numbers.keep(rows)

    def _record(self, capacity: int) -> Record:
        """Buffers for the steps of one call of the loop, with what only sweeps need if they are stored."""
        nq, m, stored = self.system.nq, self.system.m, self.settings.store_steps
        corrected = (nq, m) if stored and self.scheme.projects else (0, 0)
        stages = self._layout.recorded if stored else 0
        widths = (nq, nq, nq, nq, m, *corrected, stages, len(self.system.memory_places))
        shapes = [*[(capacity,)] * 3, *((capacity, width) for width in widths), *[(capacity,)] * 3, (0,)]
        return Record._make(np.zeros(shape) for shape in shapes)

    def restart(self, t: float, q: Array, v: Array, until: float) -> None:
        """Begin at a consistent state: a and λ of the equations of motion, a first step of its own."""
        self.t, self._span, self._arrays, self._vain = t, until - t, None, 0
        try:
            a, lam = self.acceleration(t, q, v)
        except SingularSystem:
            raise self._explained(q, v) from None
        begin_motion(self._tolerance, self.system, t, q, until if self._filtered else None)
        self._begin_at(q, v, a, lam)
        self._memory.noise[:] = round_off_of(self.system.Phi_q(q, t, b=self.b), q)
        control, given, settings = self._control, self.store.given(), self.settings
        control.clear()
        control.t, control.defect = t, 1.0
        first, longest = (
            min(settings.first_step, settings.max_step),
            min(0.01 * self._span, settings.max_step),
        )
        if len(given):
            first = given[0]
        elif not first:
            first = first_step(self, self._tolerance, self._first_error, t, q, v, a, longest)
        control.h = control.x_h = first
        self._renew_pivots(of_motion=False)  # they have just been chosen
        self.store.begin(**self._node())

    def shorten(self, longest: float) -> None:
        """See `Stepper`."""
        self._control.h = min(self._control.h, longest)

    def end_at(self, switching: Switching) -> None:
        """See `Stepper`."""
        self.switching = switching

    @property
    def has_history(self) -> bool:
        """Whether steps depend on accelerations of the method's own, or on steps before."""
        return bool(self.scheme.extra) or len(self._state.past) > 0

    def jump(self) -> None:
        """Go on from the present state with other forces: new a and λ, and the step size as it is.

        Raises
        ------
        RunFailure
            If they do not exist.
        """
        q, v = self._state.q0.copy(), self._state.v_given.copy()
        try:
            a, lam = self.acceleration(self.t, q, v)
        except SingularSystem:
            raise self._explained(q, v) from None
        self._begin_at(q, v, a, lam)
        self._control.continued = self._control.projected = False
        self._control.last_h = self._control.x_h = 0.0  # coefficients are computed anew

    def _begin_at(self, q: Array, v: Array, a: Array, lam: Array) -> None:
        state, first = self._state, {"q": q, "v": v, "a": a, "lam": lam}
        for place in state:
            place[:] = 0.0
        for name, value in first.items():
            getattr(state, f"{name}0")[:] = value
        for name, by in self.scheme.extra.items():
            own = self._program.state + self._layout.tables.state[name]
            state.x[own : own + len(q)] = _value(by, first)
        state.v_given[:] = v
        state.past[1:] = np.inf

    def _node(self) -> dict[str, Any]:
        """The present state, as it is stored."""
        state = self._state
        return {"t": self.t, "q": state.q0, "v": state.v_given, "a": state.a0, "lam": state.lam0}

    def advance(self, stop: float, limit: int) -> Nodes:
        """Steps towards a time, see `Stepper`."""
        if self.independence.rows is not None:
            self._renew_equations()
        state, control, before = self._state, self._control, self._control.copy()
        memory = self.b[self.system.memory_places]
        first = [
            np.array(x, dtype=float)[None] for x in (self.t, state.q0, state.v0, state.a0, state.lam0, memory)
        ]
        limit = min(limit, self._chunk, limit if self.independence.rows is None else DEPENDENT_CHUNK)
        status, taken = self._advance(self.run(), float(stop), limit)
        self.t = float(control.t)
        self._count(before)
        self.tally.history.append(self.store.history(taken))
        self.switched = self._crossing if status == loop.SWITCHED else None
        self._look(status, taken)
        return Nodes._make(
            np.concatenate(x) for x in zip(first, self.store.collect(taken, memory), strict=True)
        )

    def run(self) -> Run:
        """All that the loop works on, with pivots."""
        if self._arrays is None:
            self._renew_pivots()
        assert self._arrays is not None
        return Run(
            self._program, self._entries, self._at_nodes, self._remembered, self.b, self.system.memory_places,
            float(self.settings.max_step), self._state, self._memory, self._arrays, self._control, self.store.record(),
            self._tolerance, self.switching, self._crossing, self.apart,
        )  # fmt: skip

    def _count(self, before: Control) -> None:
        """Add the counts of a call of the loop."""
        now = self._control
        matrices = int(now.matrices - before.matrices)
        self.tally.add(
            int(now.steps - before.steps),
            int(now.rejected - before.rejected),
            self.evaluations * int(now.residuals - before.residuals),
            matrices,
            self.factorizations * matrices,
        )

    def _forget_pivots(self) -> None:
        self._arrays, self.matrix.placed, self._of_motion.placed = None, None, None
        if self._pair:
            self._pair.placed = None

    def _look(self, status: int, taken: int) -> None:
        """Evaluate the result of a call of the loop."""
        self._vain = 0 if taken else self._vain + int(status == loop.REPIVOT)
        state = self._state
        if status == loop.REPIVOT:
            self._forget_pivots()
            if self._vain > 1:  # new pivots did not help: a shorter step may
                self._control.h *= 0.25
            if self._vain > PATIENCE:
                raise self._explained(state.q0, state.v0)
        if status == loop.TOO_SMALL and not taken:
            message = (
                f"steps become too small near t = {self.t:.6g} s: {self._why_small().removesuffix('.')}."
            )
            raise self._explained(state.q0, state.v0, RunFailure("step too small", message))

    def _explained(self, q: Array, v: Array, otherwise: RunFailure | None = None) -> RunFailure:
        """Why there are no further steps."""
        message = otherwise or singular(self.t, [])
        return failure_of(self.system, self.b, self.t, q, v, self.independence, self._span, message)

    @property
    def host(self) -> PlacedMatrix | None:
        """See `Stepper`."""
        return self._of_motion

    def _why_small(self) -> str:
        q, v = self._state.q0, self._state.v0
        far = float(abs(q[self.system.layout.positions]).max(initial=0.0))
        if far > FAR * extent(self.system, q) and self._control.x_h < finest(self.settings.tolerances, q, v):
            return (
                f"bodies are {far:.3g} m from the origin, where positions have fewer digits than the tolerances "
                "ask for. Place the model near the origin, give a larger atol, or use Radau()"
            )
        failure, cause = REASONS[int(self._control.failure)]
        return failure + cause if has_laws(self.system) else failure

    def _renew_equations(self) -> None:
        """Choose other independent equations if the present choice is poor."""
        state, saved = self._state, self.independence
        if saved.renew(self.t, state.q0):
            self._keep(saved.rows)
            state.lam0[:] = self.acceleration(self.t, state.q0, state.v0)[1]
            at = self._program.lam_slope
            state.x[at : at + self.system.m] = 0.0
            self._control.continued, self._arrays = False, None

    def _renew_pivots(self, of_motion: bool = True) -> None:
        """Pivot orders for the matrices of the next step, as far as it is known, and of the equations of motion."""
        given = self.store.given()
        self._evaluate(float(given[0] if len(given) else self._control.h))
        while not np.all(np.isfinite(self.matrix.numbers.values)) and self._can_shorten(given):
            self._control.h *= 0.25
            self._evaluate(float(self._control.h))
        length, shortened = self._control.h, 0
        while not self._factors(of_motion):
            shortened += 1
            if shortened > PATIENCE or not self._can_shorten(given):
                self._control.h = length
                raise self._explained(self._state.q0, self._state.v0)
            self._control.h *= 0.25
            self._evaluate(float(self._control.h))
        self._show_matrix()

    def _factors(self, of_motion: bool) -> bool:
        """Factor the matrices; false where one is singular, as by a force that is too steep for the step."""
        try:
            (self._pair or self.matrix).factor(PRECISE)
            if of_motion:
                self._factor_motion(self.t, self._state.q0)
        except SingularMatrix:
            return False
        return True

    def _evaluate(self, h: float) -> None:
        """The numbers of the matrices at the first guess of a step of length h."""
        state, control, program, numbers = self._state, self._control, self._program, self.matrix.numbers
        ratio = h / control.last_h if control.last_h > 0 else 1.0
        link(loop.guess)(program, h, ratio, bool(control.continued), state)
        control.x_h = control.factored_h = 0.0
        self.matrix.weights[:] = state.r[program.weights]
        if self._pair:
            self._pair.complex.weights[:] = state.r[program.pair_weights] @ (1.0, 1.0j)
        end = self.t + h
        link(evaluate)(program, self._entries, self.b, end, h, state.x, numbers.values, numbers.left_out)

    def _can_shorten(self, given: Array) -> bool:
        """Whether the next step may be shorter: it is not prescribed, and not next to nothing."""
        return not len(given) and self._control.h > loop.SHORTEST * max(abs(self.t), self._span)

    def _factor_motion(self, t: float, q: Array) -> PlacedMatrix:
        """The matrix of the equations of motion at a position, factored."""
        for name in ("M", "Phi_q"):
            self._of_motion.numbers.evaluate((name,), self.b, {"t": t, "q": q})
        self._of_motion.factor(PRECISE)
        return self._of_motion

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

    def _show_matrix(self) -> None:
        """The matrices as the loop takes them."""
        numbers = self.matrix.numbers
        placed = self.matrix.placed
        assert placed is not None
        pair = self._pair.show() if self._pair else none_paired(placed)
        self._arrays = Matrix._make([numbers.values, numbers.left_out, placed, pair])
        self._at_nodes = MotionSolver(self._motion_kernels, motion_arrays(self._of_motion), self._work)

    def resume(self, state: Mapping[str, Array]) -> None:
        """See `RunPart`."""
        super().resume(state)
        self._keep(self.independence.rows)

    def forget(self) -> None:
        """Forget what was stored for derivatives, except the present state."""
        self.store.begin(**self._node())

    def steps(self) -> StepsTaken | None:
        """The steps stored for derivatives, or None."""
        error, message = self.scheme.error, self.settings.tolerances.greatest(self._tolerance)
        order = error.of_method if isinstance(error, FilteredEstimate) else self._program.exponent - 1
        own = {"scheme": self.scheme, "start": self.begin, "b": self._numbers, "order": order}
        return self.store.steps(**own, **message)


def _value(affine: Affine, blocks: Mapping[str, Array]) -> Array:
    return np.asarray(sum(factor * blocks[name] for name, factor in affine.items()))


def finest(tolerances: Tolerances, q: Array, v: Array) -> float:
    """The step at which round-off in Φ, over h, is as large in v as what Newton's method may leave there."""
    noise = 2 * np.finfo(float).eps * abs(q).max(initial=0.0)
    relative = noise / (tolerances.atol_v + tolerances.rtol_v * abs(v))
    return float(np.sqrt(np.mean(relative**2))) / NEWTON_SHARE
