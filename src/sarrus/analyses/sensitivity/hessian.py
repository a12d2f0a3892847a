"""Products of the Hessian of a response with a direction: the adjoint of a run differentiated along it.

The states' change along the direction is swept forwards; the adjoint backwards; then its change backwards, with the
contracted second derivatives of every operation (`Lagrangian`) as sources.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ...algebra import Array
from .chain import FIELDS, Chain, Nodes
from .evaluation import Evaluation
from .lagrangian import Change, Lagrangian
from .parameters import Parameters
from .sweep import Sweep
from .sweep_loop import Kept, Sources


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
    def _lagrangians(self) -> dict[str, Lagrangian]:
        return {kind: Lagrangian(self._system, kind) for kind in ("place", "step", "rate", "motion")}

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
        sources, by_b = (
            Sources._make(np.zeros((len(steps), width)) for width in widths),
            np.zeros(len(steps.b)),
        )
        for n in range(len(steps)):
            by_b += self._of_step(n, moved, first, sources)
            if steps.removed[n] != 0.0:
                by_b += self._of_rescale(n, moved, first, sources)
        return sources, by_b

    def _of_step(self, n: int, moved: Moved, first: Adjoined, sources: Sources) -> Array:
        steps, nq, scheme = self._steps, self._system.nq, self._steps.scheme
        kappa = (1 - scheme.alpha_f) / (1 - scheme.alpha_m)
        h = float(steps.h[n])
        beta, gamma = scheme.beta * h * h * kappa, scheme.gamma * h * kappa
        solved, dots = first.kept.step[n, :, 0], moved.nodes
        change = self._lagrangians["step"](
            float(steps.t[n + 1]), self._numbers(n), moved.b[:, 0], steps.lam[n + 1], solved[nq:] / beta,
            dots.lam[n + 1, :, 0], q=steps.q[n + 1], v=steps.v[n + 1], a=steps.a[n + 1],
            q_dot=dots.q[n + 1, :, 0], v_dot=dots.v[n + 1, :, 0], a_dot=dots.a[n + 1, :, 0], xi=solved[:nq],
        )  # fmt: skip
        sources.step[n, :nq] = change.a + gamma * change.v + beta * change.q
        sources.step[n, nq:] = self._solved_rows(n, change.lam)
        sources.step_q[n], sources.step_v[n] = change.q, change.v
        return change.b

    def _of_rescale(self, n: int, moved: Moved, first: Adjoined, sources: Sources) -> Array:
        steps, nq, dots = self._steps, self._system.nq, moved.nodes
        solved, s, s_dot = first.kept.rescale[n, :, 0], first.kept.s[n], moved.kept.rescale[n, :, 0]
        change = self._lagrangians["rate"](
            float(steps.t[n]), self._numbers(n), moved.b[:, 0], s[nq:], solved[nq:], s_dot[nq:],
            q=steps.q[n], a=s[:nq], eta=steps.v[n] - s[:nq],
            q_dot=dots.q[n, :, 0], a_dot=s_dot[:nq], eta_dot=dots.v[n, :, 0] - s_dot[:nq], xi=solved[:nq],
        )  # fmt: skip
        sources.rescale[n, :nq] = change.a - change.eta
        sources.rescale[n, nq:] = self._solved_rows(n, change.lam)
        sources.rescale_q[n], sources.rescale_v[n] = change.q, change.eta
        return change.b

    def _changes(self, moved: Moved, first: Adjoined) -> dict[str, Change]:
        """The changes of the equations of the start and of the assembly."""
        system, steps, found, adjoint = self._system, self._steps, self._steps.start, first.assembly
        b, b_dot, t = self._numbers(0), moved.b[:, 0], float(steps.t[0])
        q_dot, lam_dot, v_dot, mu_dot = (x[:, 0] for x in moved.assembly)
        y, z = (x[:, 0] for x in first.start)
        dots = {"q_dot": q_dot, "v_dot": v_dot, "a_dot": moved.nodes.a[0, :, 0]}
        motion = self._lagrangians["motion"](
            t, b, b_dot, steps.lam[0], z, moved.nodes.lam[0, :, 0],
            q=steps.q[0], v=steps.v[0], a=steps.a[0], xi=y, **dots,
        )  # fmt: skip
        rate = self._lagrangians["rate"](
            t, b, b_dot, found.mu, -adjoint.y2, mu_dot, q=found.q, eta=found.v, q_dot=q_dot, eta_dot=v_dot,
            xi=adjoint.x2,
        )  # fmt: skip
        place = self._lagrangians["place"](
            t, b, b_dot, found.lam, adjoint.y1, lam_dot, q=found.q, q_dot=q_dot, xi=adjoint.x1
        )
        assert len(motion.lam) == system.m
        return {"motion": motion, "rate": rate, "place": place}

    def _numbers(self, n: int) -> Array:
        b = self._steps.b.copy()
        b[self._steps.places] = self._steps.memory[n]
        return b

    def _solved_rows(self, n: int, rows: Array) -> Array:
        out = self._steps.left_out
        return np.where(out[n + 1], 0.0, rows) if len(out) else rows
