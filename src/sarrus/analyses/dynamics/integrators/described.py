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
from ...equations.block_matrix import PRECISE, Numbers, PlacedMatrix
from ...equations.length import kinematic_weights
from ..dense_output.sampler import motion_arrays, motion_entries, motion_work
from ..methods.check import check
from ..methods.description import Affine, Description
from ..methods.equations import GROUPS as OF_MATRICES
from ..methods.leading_error import Leading, leading_errors
from ..methods.program import NODE, OF_EQUATIONS, Program, ProgramBuilder
from ..methods.tables import Tables, constrained
from ..stepping import alpha_loop
from ..stepping.entries import entry_of, joined
from ..stepping.newton_matrix import motion_matrix
from ..stepping.stepper import Settings
from ..time_loop.prescribed import Prescribed
from . import described_loop as loop
from .alpha_stepper import AlphaStepper
from .implicit import GROUPS

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
    "finish": loop.finish,
    "accept": loop.accept,
    "keep": loop.keep,
}  # of the time integration loop, for described methods


class Layout(NamedTuple):
    """What follows from a description for systems of one structure.

    program, tables : see `methods.program`, `methods.tables`
    size : of the work array
    nodes : where q, v, a and λ before (0) and after (1) a step are in it
    """

    program: Program
    tables: Tables
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
    numbers = Numbers(system, tables.names, tables.like)
    program = builder.program(numbers, constrained(system, tables.structure), *later)
    places = {f"{name}{k}": (builder.block(where, name), name) for k, where in enumerate(("state", "after"))
              for name in NODE}  # fmt: skip
    nodes = {key: slice(at, at + tables.size(method.state[name])) for key, (at, name) in places.items()}
    return Layout(program, tables, builder.size, nodes)


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
    scheme: Description

    def _make(self) -> None:
        system, nq, m = self.system, self.system.nq, self.system.m
        self._layout = layout_of(system, self.scheme)
        self._passed, tables = self._layout.program, self._layout.tables
        self.first_error, later = leading_errors(self.scheme)
        self.apart = later.exponent <= Leading(3, 0.0).exponent
        self.matrix = PlacedMatrix(Numbers(system, tables.names, tables.like), tables.n, tables.parts)
        self._of_motion = motion_matrix(system)
        self._keep(self.independence.rows)
        self._advance = link(alpha_loop.advance, **FUNCTIONS)
        self._entries = kernels_of(system, self.scheme)
        x, past = np.zeros(self._layout.size), max(later.exponent - 2, 0)
        right = x[self._passed.right : self._passed.right + tables.n]
        own = [np.zeros(width) for width in (tables.n, m, nq + m)]
        self._memory = loop.Memory._make([right, *own, kinematic_weights(system), motion_work(system)])
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
            self._arrays = None

    def _renew_pivots(self) -> None:
        """Pivot orders for the matrices of the next step, as far as it is known, and of the equations of motion."""
        state, control, program, numbers = self._state, self._control, self._passed, self.matrix.numbers
        h = float(control.h)
        link(loop.guess)(program, h, h / control.last_h if control.last_h > 0 else 1.0, state)
        control.x_h = control.beta = 0.0
        self.matrix.weights[:] = state.r[program.weights]
        end = self.t + h
        link(loop.evaluate)(program, self._entries, self.b, end, h, state.x, numbers.values, numbers.left_out)
        try:
            self.matrix.factor(PRECISE)
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
        motion = motion_arrays(self._of_motion)
        self._arrays = loop.Matrix._make([numbers.values, numbers.left_out, self.matrix.placed, motion])

    def steps(self) -> StepsTaken | None:
        """What was stored for derivatives, or None."""
        found = super().steps()
        return replace(found, order=self._passed.exponent - 1) if isinstance(found, DescribedSteps) else None

    def state(self) -> dict[str, Array]:
        """All that is needed to go on, see `Stepper`."""
        return super().state() | {f"motion_{name}": x for name, x in self._of_motion.state().items()}

    def resume(self, state: Mapping[str, Array]) -> None:
        """Go on from such a state."""
        found = {name[7:]: array for name, array in state.items() if name.startswith("motion_")}
        if found:
            self._of_motion.resume(**found)
        super().resume(state)
        self._keep(self.independence.rows)


def _value(affine: Affine, blocks: Mapping[str, Array]) -> Array:
    return np.asarray(sum(factor * blocks[name] for name, factor in affine.items()))
