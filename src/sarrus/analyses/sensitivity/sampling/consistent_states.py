"""Derivatives of consistent states: on the constraints, with the accelerations and multipliers of the motion.

A state (q0, v) of a method, or between its nodes, becomes consistent by three operations of a description: q is put
onto the constraints, v made compatible with them, and a and λ follow from the equations of motion. The states do not
depend on each other.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ....system import System
from ...dynamics.methods.description import (
    CONSTRAINTS,
    COORDINATES,
    accelerations,
    compatible_velocity,
    placement,
)
from ...equations.minimum_norm import multipliers_of
from ..steps.curves import Curves
from ..steps.record import Operations
from ..steps.sweep import ORDERS, PerOperation, Sweep, stages_of, unknowns_of
from ..steps.sweep_loop import NodeArrays

STATE = {**dict.fromkeys(("q0", "q", "v", "a"), COORDINATES), "lam": CONSTRAINTS}
MULTIPLIERS = (0, "lam")  # σ and ρ as quantities of a stage


@dataclass(frozen=True, eq=False)
class ConsistentStates:
    """Consistent states (nt, …), and what they were made of.

    Attributes
    ----------
    b, places, memory : parameters, and what elements store
    dq, dv : q - q0, and what v was changed by
    sigma, rho : the multipliers of both projections
    between : where q was put onto the constraints; elsewhere it is a node's
    defined : where the equations of motion have a solution; elsewhere states stay as they are
    left_out : 1 for equations that others imply
    """

    b: Array
    t: Array
    q: Array
    v: Array
    a: Array
    lam: Array
    q0: Array
    dq: Array
    dv: Array
    sigma: Array
    rho: Array
    between: Array
    defined: Array
    left_out: Array
    places: Array
    memory: Array

    def __len__(self) -> int:
        """Return the number of states."""
        return len(self.t)

    def operations(self, system: System) -> Operations:
        """The operations that make the states consistent."""
        found, defined = Operations(system, self, []), self.defined
        rolls = system.m_holonomic < system.m
        own = [
            (placement(STATE, rolls), defined & self.between,
             {(0, "q"): self.q0, (0, "v"): self.dq, (0, "a"): self.dq, (0, "lam"): self.sigma, (1, "q"): self.q}),
            (compatible_velocity(STATE), defined,
             {(0, "q"): self.q0, (0, "a"): self.dv, (0, "lam"): self.rho, (1, "q"): self.q, (1, "v"): self.v}),
            (accelerations(STATE), defined,
             {(0, name): getattr(self, name) for name in ("q", "v", "a", "lam")}),
        ]  # fmt: skip
        for operation, rows, values in own:
            at = np.flatnonzero(rows)
            chosen = values if len(at) == len(self) else {key: x[at] for key, x in values.items()}
            found.operations.append(found.at_states(operation, at, at, self.t[at], chosen))
        return found

    def of_independent(self, system: System) -> ConsistentStates:
        """With the multipliers of independent equations that have the constraint forces of those reported."""
        lam, b = self.lam.copy(), self.b.copy()
        for row in np.flatnonzero(self.left_out.any(axis=1)).tolist():
            b[self.places] = self.memory[row]
            chosen = np.flatnonzero(self.left_out[row] == 0.0)
            lam[row] = multipliers_of(system, chosen, lam[row], self.q[row], float(self.t[row]), b)
        return replace(self, lam=lam)

    def with_multipliers(self, system: System) -> ConsistentStates:
        """With σ and ρ, which are those changes of the multipliers by which q - q0 and v's change are undone."""
        if not self.defined.any():
            return self
        none = replace(self, dq=np.zeros_like(self.dq), dv=np.zeros_like(self.dv))
        sweep = ConsistentSweep(system, none, moving=False)
        initial = {"q0": -self.dq[:, :, None], "v": -self.dv[:, :, None]}
        stages = sweep.along(initial, np.zeros((len(self.b), 1)))[1]
        found = [self.sigma.copy(), self.rho.copy()]
        for x, one, own in zip(found, sweep.record.operations, stages.parts, strict=False):
            first = one.tables.stages[MULTIPLIERS]
            x[one.steps] = own[:, first : first + system.m, 0]
        whole = replace(self, sigma=found[0], rho=found[1])
        ORDERS[whole] = ORDERS[none]  # the equations are the same
        return whole


class ConsistentGradients(NamedTuple):
    """Gradients by q0 and v (nt, nq, 1), by the parameters (len(b), 1) and the times (nt,); the adjoint variables."""

    q: Array
    v: Array
    b: Array
    t: Array
    solved: PerOperation


class ConsistentSweep:
    """The derivatives of some consistent states, one column.

    Parameters
    ----------
    system : System
    states : with the multipliers of their projections
    moving : whether their times move by themselves, and the system depends on the time
    """

    def __init__(self, system: System, states: ConsistentStates, moving: bool) -> None:
        self._system, self._states, self._moving = system, states, moving
        self.record = states.operations(system)

    @cached_property
    def _curves(self) -> Curves:
        return Curves(self.record, self._moving)

    def nodes(self) -> NodeArrays:
        """Zeros for changes of states, or gradients by them."""
        nq, m = self._system.nq, self._system.m
        return NodeArrays._make(np.zeros((len(self._states), width, 1)) for width in (nq, nq, nq, m))

    def along(
        self, initial: Mapping[str, Array], b: Array, dt: Array | None = None
    ) -> tuple[NodeArrays, PerOperation]:
        """The changes of the consistent states, and those of the stages' quantities.

        For changes of what the states are made of, by block, of the parameters (len(b), 1) and of the times (nt,).
        """
        found, stages, states = self.nodes(), stages_of(self.record, 1), self._states
        for name in ("q", "v"):
            if name in initial:
                getattr(found, name)[~states.defined] = initial[name][~states.defined]
        if states.defined.any():
            sweep = Sweep(self.record, 1, np.ascontiguousarray(b))
            first = np.zeros((len(states), sweep.state_size, 1))
            for name, x in initial.items():
                first[:, sweep.rows[name] : sweep.rows[name] + self._system.nq] = x
            sweep.forward(sweep.state(), found, stages, self._sources(b, dt), initial=first)
        return found, stages

    def _sources(self, b: Array, dt: Array | None) -> PerOperation | None:
        """What changes of curves' parameters, and of the times, do."""
        own = np.append(b, np.zeros((1, 1)), axis=0) if self._moving else b
        if self._moving and dt is not None:
            return self._curves.sources(own, dt)
        return self._curves.sources(own) if self._curves.moved_by(own) else None

    def back(self, given: NodeArrays, sources: PerOperation | None = None) -> ConsistentGradients:
        """Gradients by what the states are made of; `sources` as those of `Sweep.backward`."""
        states, system, size = self._states, self._system, len(self._states.b)
        found = ConsistentGradients(given.q.copy(), given.v.copy(), np.zeros((size, 1)), np.zeros(len(states)),
                     unknowns_of(self.record, 1))  # fmt: skip
        if not states.defined.any():
            return found
        sweep = Sweep(self.record, 1)
        initial = np.zeros((len(states), sweep.state_size, 1))
        by_b = sweep.backward(sweep.state(), given, 0, found.solved, sources, initial)
        q0, q, v = (initial[:, sweep.rows[name] : sweep.rows[name] + system.nq] for name in ("q0", "q", "v"))
        found.q[states.defined], found.v[states.defined] = (q0 + q)[states.defined], v[states.defined]
        found.b[: len(by_b)] = by_b
        if self._curves:
            found.b[:] += self._curves.gradient(found.solved)[:size]
        if self._moving:
            found.t[:] = self._curves.by_times(found.solved)
        return found
