"""Products of the Hessian of a response with a direction: the adjoint of a run differentiated along it.

The states' change along the direction is swept forwards; the adjoint backwards; then its change backwards, with the
contracted second derivatives of every operation (`Lagrangian`) as sources.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..._jit.vector import LANES
from ...algebra import Array
from .chain import FIELDS, Chain, Nodes
from .evaluation import Evaluation
from .lagrangian import Change, change_at, compiled, lagrangian, room
from .parameters import Parameters
from .sweep import Sweep
from .sweep_loop import Given, Kept, Sources


class Moved(NamedTuple):
    """The change of a run along a direction: of the numbers and of the states; and what was solved for on the way."""

    b: Array
    c: Array
    nodes: Nodes
    assembly: tuple[Array, Array, Array, Array]
    kept: Kept


class Adjoined(NamedTuple):
    """The adjoint of a run: what was solved for in every operation."""

    kept: Kept
    start: tuple[Array, Array]
    assembly: Any
    whole: Array


class Curvature:
    """The Hessian of one response of a run, in products.

    Parameters
    ----------
    chain, evaluation, parameters : the run, its responses, and what is differentiated by
    response : which of the responses
    """

    def __init__(
        self, chain: Chain, evaluation: Evaluation, parameters: Parameters, response: int = 0
    ) -> None:
        self._chain, self._evaluation, self._parameters = chain, evaluation, parameters
        self._response, self._system, self._steps = response, chain.system, chain.steps
        if len(chain.steps.start.asked.rates):
            raise ValueError(
                "second derivatives through given rates of an assembly are not there; give velocities"
            )

    @cached_property
    def _sweep(self) -> Sweep:
        return Sweep(self._system, self._steps, 1)

    @cached_property
    def _first(self) -> Adjoined:
        """The adjoint, and what does not go through the states."""
        every, explicit = self._evaluation.gradients()
        r = self._response
        nodes = Nodes(*(getattr(every, name)[..., r : r + 1] for name in FIELDS))
        explicit_b, explicit_c = explicit.b[:, r], explicit.c[:, r]
        adjoint, b = self._backward(nodes, None, None)
        assembly = adjoint.assembly
        whole = np.concatenate([b + explicit_b, assembly.q, assembly.v, explicit_c])
        return adjoint._replace(whole=whole)

    def _backward(
        self, nodes: Nodes, sources: Sources | None, changes: dict[str, Change] | None
    ) -> tuple[Adjoined, Array]:
        """Back through steps, start and assembly; with the changes of their equations, where an adjoint changes."""
        chain, sweep = self._chain, self._sweep
        contiguous = Nodes(*(np.ascontiguousarray(getattr(nodes, name)) for name in FIELDS))
        bars, kept = sweep.bars(), sweep.kept()
        sweep.backward(bars, contiguous.after_start(), 0, len(self._steps), kept, sources)
        a_bar, lam_bar = bars.a + bars.x + nodes.a[0], nodes.lam[0].copy()
        q_bar, v_bar, b_bar = bars.q + nodes.q[0], bars.v + nodes.v[0], bars.b
        if changes:
            motion = changes["motion"]
            a_bar, lam_bar = a_bar - motion.a[:, None], lam_bar - motion.lam[:, None]
            q_bar, v_bar, b_bar = (
                q_bar - motion.q[:, None],
                v_bar - motion.v[:, None],
                b_bar - motion.b[:, None],
            )
        start = chain.start.adjoint(a_bar, lam_bar)
        by_q, by_v, by_b = chain.start.transposed(a_bar, lam_bar)
        q_bar, v_bar, b_bar = q_bar + by_q, v_bar + by_v, b_bar + by_b
        change = None
        if changes:
            rate, place = changes["rate"], changes["place"]
            change = (rate.q + place.q, place.lam, rate.eta, rate.lam)
            b_bar = b_bar - (rate.b + place.b)[:, None]
        assembly = chain.assembly.adjoint(q_bar[:, 0], v_bar[:, 0], change)
        return Adjoined(kept, start, assembly, np.zeros(0)), b_bar[:, 0] + assembly.b

    def _along(self, direction: Array) -> Moved:
        """The run's change."""
        chain, steps = self._chain, self._steps
        b, q, v, c = self._parameters.along(direction[:, None])
        sweep, nodes = Sweep(self._system, steps, 1, b), Nodes.zeros(steps, 1)
        assembly = chain.assembly.whole_along(b, dq=q, dv=v)
        bars, kept = sweep.bars(b), sweep.kept()
        bars.q[:], bars.v[:] = assembly[0], assembly[2]
        bars.a[:], bars.lam[:] = chain.start.along(bars.q, bars.v, b)
        bars.x[:] = bars.a
        nodes.q[0], nodes.v[0], nodes.a[0], nodes.lam[0] = bars.q, bars.v, bars.a, bars.lam
        sweep.forward(bars, nodes.after_start(), 0, len(steps), kept)
        return Moved(b, c, nodes, assembly, kept)

    def times(self, direction: Array) -> Array:
        """The Hessian times a direction of the parameters (p,)."""
        moved, first = self._along(np.asarray(direction, dtype=float)), self._first
        own = {name: np.array([x]) for name, x in zip(self._parameters.names, direction, strict=True)}
        nodes, explicit = self._evaluation.gradient_along(self._response, moved.nodes, moved.b, moved.c, own)
        sources, by_b = self._sources(moved, first)
        second, b = self._backward(nodes, sources, self._changes(moved, first))
        assembly = second.assembly
        turned = np.concatenate([b - by_b + explicit.b[:, 0], assembly.q, assembly.v, explicit.c[:, 0]])
        found = self._parameters.gradient_along(first.whole, turned, direction)
        own_part = [explicit.named[0].get(name, 0.0) for name in self._parameters.names]
        return np.asarray(found + np.array(own_part))

    def _sources(self, moved: Moved, first: Adjoined) -> tuple[Sources, Array]:
        """The changes of the equations of all steps, and what they add to the gradient by the numbers."""
        steps, nq, m = self._steps, self._system.nq, self._system.m
        widths = (nq + m, nq, nq) * 2
        sources = Sources._make(np.zeros((len(steps), width)) for width in widths)
        dots = Given._make(np.ascontiguousarray(getattr(moved.nodes, k)[:, :, 0]) for k in Given._fields)
        solved = (np.ascontiguousarray(x[:, :, 0]) for x in first.kept[:2])
        adjoint = Kept._make([*solved, first.kept.s])
        changed = np.ascontiguousarray(moved.kept.rescale[:, :, 0])
        work, b, b_dot = room(self._system), steps.b.copy(), np.ascontiguousarray(moved.b[:, 0])
        head, record = (b, b_dot), self._sweep.record
        entries = [lagrangian(self._system, kind) for kind in ("step", "rate")]
        compiled()["of_steps"](steps.scheme, entries[0], *head, record, dots, adjoint, work, sources)
        compiled()["of_rescales"](entries[1], *head, record, dots, adjoint, changed, work, sources)
        return sources, work.by_b.reshape(-1, LANES).sum(axis=1)

    def _changes(self, moved: Moved, first: Adjoined) -> dict[str, Change]:
        """The changes of the equations of the start and of the assembly."""
        system, steps, found, adjoint = self._system, self._steps, self._steps.start, first.assembly
        b, b_dot, t = self._numbers(0), moved.b[:, 0], float(steps.t[0])
        q_dot, lam_dot, v_dot, mu_dot = (x[:, 0] for x in moved.assembly)
        y, z = (x[:, 0] for x in first.start)
        dots = {"q_dot": q_dot, "v_dot": v_dot, "a_dot": moved.nodes.a[0, :, 0]}
        motion = change_at(
            system, "motion", t, b, b_dot, steps.lam[0], z, moved.nodes.lam[0, :, 0],
            q=steps.q[0], v=steps.v[0], a=steps.a[0], xi=y, **dots,
        )  # fmt: skip
        rate = change_at(
            system, "rate", t, b, b_dot, found.mu, -adjoint.y2, mu_dot, q=found.q, eta=found.v, xi=adjoint.x2,
            q_dot=q_dot, eta_dot=v_dot,
        )  # fmt: skip
        place = change_at(
            system,
            "place",
            t,
            b,
            b_dot,
            found.lam,
            adjoint.y1,
            lam_dot,
            q=found.q,
            q_dot=q_dot,
            xi=adjoint.x1,
        )
        assert len(motion.lam) == system.m
        return {"motion": motion, "rate": rate, "place": place}

    def _numbers(self, n: int) -> Array:
        b = self._steps.b.copy()
        b[self._steps.places] = self._steps.memory[n]
        return b
