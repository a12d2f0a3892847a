"""Described methods at work: the run of every `Description`, also of a user's."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from ...._jit.kernels.pointer import NONE
from ...._jit.linking.link import link
from ....algebra import Array
from ....linalg.sparse_solver import SingularMatrix
from ....results import Assembly, DescribedSteps, StepsTaken
from ....system import System
from ....system.cached import once_alike
from ...equations.block_matrix import PRECISE, Numbers, Placed, PlacedMatrix
from ...equations.length import kinematic_weights
from ..dense_output.sampler import motion_arrays, motion_entries, motion_work
from ..methods.check import check
from ..methods.description import Affine, Description, FilteredEstimate
from ..methods.equations import GROUPS as OF_MATRICES
from ..methods.leading_error import Leading, leading_errors
from ..methods.program import NODE, OF_EQUATIONS, Program, ProgramBuilder
from ..methods.tables import Tables
from ..stepping import alpha_loop
from ..stepping.entries import entry_of, joined
from ..stepping.motion_scale import Tolerance
from ..stepping.newton_matrix import motion_matrix
from ..stepping.stepper import Settings
from ..stepping.tolerance import Tolerances
from ..time_loop.prescribed import Prescribed
from . import described_loop as loop
from .alpha_stepper import AlphaStepper
from .implicit import GROUPS

SHARE = 0.1  # of rtol^(2/3)
SLOW = 0.03  # contraction above which the matrices of split stages are renewed for the next step
STALLED = 0.1  # of the tolerance: corrections that are smaller and no longer fall are round-off
FACTORS, FURTHER = (
    1e9,
    8.0,
)  # where steps are stored, see `Tolerance`: two matrices are worth many corrections
REPEATED = 1.0  # the same where equations repeat others, whose combination may be weak
FUNCTIONS: dict[str, Callable[..., Any]] = {
    "update": loop.update,
    "residual": loop.residual,
    "renew": loop.renew,
    "weights_of": loop.weights_of,
    "correct": loop.correct,
    "settled": loop.settled,
    "prepare": loop.prepare,
    "local_error": loop.local_error,
    "factor_to": loop.factor_to,
    "next_length": loop.next_length,
    "finish": loop.finish,
    "accept": loop.accept,
    "keep": loop.keep,
}  # of the time integration loop, for described methods


class Layout(NamedTuple):
    """What follows from a description for systems of one structure.

    program, tables : see `methods.program`, `methods.tables`
    of_matrix : tables of the matrix, which are those of one stage where stages are split
    size : of the work array
    nodes : where q, v, a and λ before (0) and after (1) a step are in it
    """

    program: Program
    tables: Tables
    of_matrix: Tables
    size: int
    nodes: Mapping[str, slice]


@once_alike
def layout_of(system: System, method: Description) -> Layout:
    """The layout of a method.

    Raises
    ------
    TypeError, ValueError
        If the description is not one of a method.
    """
    check(method)
    builder, later = ProgramBuilder(system, method), leading_errors(method).later
    tables = builder.tables
    numbers = Numbers(system, builder.of_matrix.names, builder.of_matrix.like)
    program = builder.program(numbers, *later)
    places = {f"{name}{k}": (builder.block(where, name), name) for k, where in enumerate(("state", "after"))
              for name in NODE}  # fmt: skip
    nodes = {key: slice(at, at + tables.size(method.state[name])) for key, (at, name) in places.items()}
    return Layout(program, tables, builder.of_matrix, builder.size, nodes)


@once_alike
def kernels_of(system: System, method: Description) -> loop.Entries:
    """The kernels of the operators that steps of a method need."""
    program = layout_of(system, method).program
    needed = {*program.calls[:, 0].tolist(), *(OF_EQUATIONS + program.operators[:, 0]).tolist()}
    of_equations = [GROUPS[name] for name in ("RESIDUAL", "MOMENTUM", "FORCE", "VELOCITY")]
    groups = enumerate((*of_equations, ("gamma",), *OF_MATRICES.values()))
    found = [entry_of(system, *names) if n in needed else NONE for n, names in groups]
    bounds = np.cumsum([0, *(len(group.addresses) for group in found)])
    return loop.Entries(*joined(found), bounds, entry_of(system, "remembered"), motion_entries(system))


@dataclass(frozen=True)
class Described(Prescribed):
    """A method that is given by its description."""

    description: Description

    def stepper(self, system: System, start: Assembly, settings: Settings) -> DescribedStepper:
        """The method at work, see `Stepper`."""
        return DescribedStepper(system, self.description, start, settings)


class DescribedStepper(AlphaStepper):
    """A described method at work on one system, see `AlphaStepper`.

    Parameters
    ----------
    system : System
    scheme : its description
    start, settings : of the run

    Raises
    ------
    TypeError, ValueError
        If the description is not one of a method.
    """

    kind = DescribedSteps

    @property
    def _counts_periods(self) -> bool:
        return isinstance(self.scheme.error, FilteredEstimate)

    scheme: Description

    def _tolerances(self) -> Tolerance:
        given, error = self.settings.tolerances, self.scheme.error
        return filtered_tolerance(given, error) if isinstance(error, FilteredEstimate) else given.for_loop()

    def _make(self) -> None:
        system, nq, m = self.system, self.system.nq, self.system.m
        self._layout = layout_of(system, self.scheme)
        self._passed, tables, of_matrix = self._layout.program, self._layout.tables, self._layout.of_matrix
        self.first_error, later = leading_errors(self.scheme)
        self._split = len(self._passed.T) > 0
        self.evaluations, self.factorizations = (3, 2) if self._split else (1, 1)
        self.apart = later.exponent <= Leading(3, 0.0).exponent
        numbers = Numbers(system, of_matrix.names, of_matrix.like)
        self.matrix = PlacedMatrix(numbers, of_matrix.n, of_matrix.parts)
        self._pair = PlacedMatrix(numbers, of_matrix.n, of_matrix.parts, complex) if self._split else None
        self._of_motion = motion_matrix(system)
        self._keep(self.independence.rows)
        self._advance = link(alpha_loop.advance, **FUNCTIONS)
        self._entries = kernels_of(system, self.scheme)
        x, past = np.zeros(self._layout.size), 0 if self.scheme.error else max(later.exponent - 2, 0)
        right = x[self._passed.right : self._passed.right + tables.n]
        own = [np.zeros(width) for width in (tables.n, m, nq + m)]
        one = of_matrix.n if self._split else 0
        parts = [np.zeros(one, dtype=kind) for kind in (float, float, complex, complex)]
        self._memory = loop.Memory._make(
            [right, *own, kinematic_weights(system), motion_work(system), *parts]
        )
        views = {name: x[own] for name, own in self._layout.nodes.items()}
        others = {"v_given": np.zeros(nq), "past": np.zeros(past), "past_a": np.zeros((past, nq))}
        self._state = loop.State(x=x, r=np.zeros(len(self._passed.tape)), **views, **others)
        self._control = alpha_loop.Control.zeros()

    def _keep(self, saved: Array | None) -> None:
        """Solve only the equations in these places."""
        for matrix in (self.matrix, self._of_motion):
            matrix.numbers.keep(saved)

    def _record(self, capacity: int) -> loop.Record:
        system, nq, m = self.system, self.system.nq, self.system.m
        stored, projects = self.settings.store_steps, self.scheme.projects
        corrected = (nq, m) if stored and projects else (0, 0)
        widths = (
            nq,
            nq,
            nq,
            m,
            *corrected,
            self._layout.tables.stage_size if stored else 0,
            len(system.memory_places),
        )
        shapes = [*[(capacity,)] * 3, *((capacity, width) for width in widths), *[(capacity,)] * 3, (0,)]
        return loop.Record._make(np.zeros(shape) for shape in shapes)

    def _begin_at(self, q: Array, v: Array, a: Array, lam: Array) -> None:
        state, first = self._state, {"q": q, "v": v, "a": a, "lam": lam}
        for place in state:
            place[:] = 0.0
        for name, value in first.items():
            getattr(state, f"{name}0")[:] = value
        at = self._passed.state
        for name, by in self.scheme.extra.items():
            own = at + self._layout.tables.state[name]
            state.x[own : own + len(q)] = _value(by, first)
        state.v_given[:] = v
        state.past[1:] = np.inf

    def _node(self) -> dict[str, Any]:
        state = self._state
        return {"t": self.t, "q": state.q0, "v": state.v_given, "a": state.a0, "lam": state.lam0}

    def _forget_pivots(self) -> None:
        super()._forget_pivots()
        self._of_motion.placed = None
        if self._pair:
            self._pair.placed = None

    @property
    def host(self) -> PlacedMatrix | None:
        """See `Stepper`."""
        return self._of_motion

    def _renew_equations(self) -> None:
        state, saved = self._state, self.independence
        if saved.renew(self.t, state.q0):
            self._keep(saved.rows)
            state.lam0[:] = self._motion().acceleration(self.t, state.q0, state.v0)[1]
            at = self._passed.lam_slope
            state.x[at : at + self.system.m] = 0.0
            self._control.continued, self._arrays = False, None

    def _renew_pivots(self) -> None:
        """Pivot orders for the matrices of the next step, as far as it is known, and of the equations of motion."""
        state, control, program, numbers = self._state, self._control, self._passed, self.matrix.numbers
        given = self.store.given()
        h = float(given[0] if len(given) else control.h)
        ratio = h / control.last_h if control.last_h > 0 else 1.0
        link(loop.guess)(program, h, ratio, bool(control.continued), state)
        control.x_h = control.beta = 0.0
        self.matrix.weights[:] = state.r[program.weights]
        if self._pair:
            self._pair.weights[:] = state.r[program.pair_weights] @ (1.0, 1.0j)
        end = self.t + h
        link(loop.evaluate)(program, self._entries, self.b, end, h, state.x, numbers.values, numbers.left_out)
        try:
            for matrix in (self.matrix, self._pair) if self._pair else (self.matrix,):
                matrix.factor(PRECISE)
            self._factor_motion(self.t, state.q0)
        except SingularMatrix:
            raise self._explained(state.q0, state.v0) from None
        self._show_matrix()

    def _factor_motion(self, t: float, q: Array) -> PlacedMatrix:
        for name in ("M", "Phi_q"):
            self._of_motion.numbers.evaluate((name,), self.b, {"t": t, "q": q})
        self._of_motion.factor(PRECISE)
        return self._of_motion

    def _show_matrix(self) -> None:
        numbers = self.matrix.numbers
        motion, placed = motion_arrays(self._of_motion), self.matrix.placed
        assert placed is not None
        pair = self._pair.placed if self._pair else _empty(placed)
        self._arrays = loop.Matrix._make([numbers.values, numbers.left_out, placed, pair, motion])

    def steps(self) -> StepsTaken | None:
        """What was stored for derivatives, or None."""
        found = super().steps()
        error = self.scheme.error
        order = error.of_method if isinstance(error, FilteredEstimate) else self._passed.exponent - 1
        return replace(found, order=order) if isinstance(found, DescribedSteps) else None

    def state(self) -> dict[str, Array]:
        """All that is needed to go on, see `Stepper`."""
        found = super().state() | {f"motion_{name}": x for name, x in self._of_motion.state().items()}
        return found | {f"pair_{name}": x for name, x in (self._pair.state() if self._pair else {}).items()}

    def resume(self, state: Mapping[str, Array]) -> None:
        """Go on from such a state."""
        found = {name[7:]: array for name, array in state.items() if name.startswith("motion_")}
        if found:
            self._of_motion.resume(**found)
        found = {name[5:]: array for name, array in state.items() if name.startswith("pair_")}
        if found and self._pair:
            self._pair.resume(**found)
        super().resume(state)
        self._keep(self.independence.rows)


def _empty(placed: Placed) -> Placed:
    """No complex matrix."""
    none: Array = np.zeros(0, dtype=complex)
    return Placed._make(array[:0] for array in placed)._replace(weights=none, factors=none, work=none)


def filtered_tolerance(given: Tolerances, error: FilteredEstimate) -> Tolerance:
    """The tolerances of an estimate of lower order than the method's.

    The estimate falls with h^(p + 1), the error with a higher power: steps are controlled as in Hairer and Wanner's
    RADAU5, with a share of rtol^(2/3) in the place of rtol.
    """
    power = (error.order + 1) / (error.of_method + 1)
    inner_q, inner_v = (SHARE * rtol**power for rtol in (given.rtol_q, given.rtol_v))
    inner = float(min(inner_q.min(), inner_v.min()))
    newton = float(max(1e-14 / inner, min(alpha_loop.NEWTON_SHARE, inner**0.5)))
    found = given.for_loop(inner_q / given.rtol_q, inner_v / given.rtol_v, speed=True)
    return found._replace(
        newton=newton,
        stalled=STALLED,
        stalled_repeated=REPEATED,
        slow=SLOW,
        noise=0.0,
        factors=FACTORS,
        further=FURTHER,
    )


def _value(affine: Affine, blocks: Mapping[str, Array]) -> Array:
    return np.asarray(sum(factor * blocks[name] for name, factor in affine.items()))
