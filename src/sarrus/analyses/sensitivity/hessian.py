"""Products of the Hessian of a response with a direction: the adjoint of a run differentiated along it.

The states' change along the direction is swept forwards; the adjoint backwards; then its change backwards, with the
contracted second derivatives of every operation (`Lagrangian`) as sources.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ...algebra import Array
from .chain import FIELDS, Chain, Nodes, by_joints
from .curved_steps import CurvedSteps, remembered
from .evaluation import Evaluation
from .lagrangian import Change, change_at
from .parameters import Parameters


class Moved(NamedTuple):
    """The change of a run along a direction: of the numbers and of the states; and what was solved for on the way."""

    b: Array
    c: Array
    nodes: Nodes
    assembly: tuple[Array, Array, Array, Array]
    solved: Any


class Adjoined(NamedTuple):
    """The adjoint of a run: what was solved for in every operation of the steps, in the assembly; the gradient."""

    solved: Any
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
        evaluation.refuse_redundant(response)
        self._way = CurvedSteps(chain)

    @cached_property
    def _first(self) -> Adjoined:
        """The adjoint, and what does not go through the states."""
        every, explicit = self._evaluation.gradients()
        r = self._response
        nodes = Nodes(*(getattr(every, name)[..., r : r + 1] for name in FIELDS))
        explicit_b, explicit_c = explicit.b[:, r], explicit.c[:, r]
        adjoint, b = self._backward(nodes, None, None)
        assembly = adjoint.assembly
        whole = np.concatenate([b + explicit_b, assembly.q, assembly.v, by_joints(explicit_c, assembly.c)])
        return adjoint._replace(whole=whole)

    def _backward(
        self, nodes: Nodes, turned: Any | None, changes: dict[str, Change] | None
    ) -> tuple[Adjoined, Array]:
        """Back through steps and assembly; with the changes of their equations, where an adjoint changes."""
        contiguous = Nodes(*(np.ascontiguousarray(getattr(nodes, name)) for name in FIELDS))
        q_bar, v_bar, b_bar, solved = self._way.back(contiguous, turned)
        change = None
        if changes:
            rate, place = changes["rate"], changes["place"]
            axes, own = changes["axes"], self._chain.assembly.rates.selection
            change = (
                rate.q + place.q + axes.q, place.lam, rate.v + axes.v, np.concatenate([rate.lam, own @ axes.lam])
            )  # fmt: skip
            b_bar = b_bar - (rate.b + place.b)[:, None]
        assembly = self._chain.assembly.adjoint(q_bar[:, 0], v_bar[:, 0], change)
        if changes:
            assembly = assembly._replace(c=assembly.c - changes["axes"].b)
        return Adjoined(solved, assembly, np.zeros(0)), b_bar[:, 0] + assembly.b

    def _along(self, direction: Array) -> Moved:
        """The run's change."""
        b, q, v, c = self._parameters.along(direction[:, None])
        assembly, nodes = self._chain.assembly.whole_along(b, dq=q, dv=v, dc=c), Nodes.zeros(self._steps, 1)
        solved = self._way.along(b, assembly[0], assembly[2], nodes)
        return Moved(b, c, nodes, assembly, solved)

    def times(self, direction: Array) -> Array:
        """The Hessian times a direction of the parameters (p,)."""
        moved, first = self._along(np.asarray(direction, dtype=float)), self._first
        own = {name: np.array([x]) for name, x in zip(self._parameters.names, direction, strict=True)}
        nodes, explicit = self._evaluation.gradient_along(self._response, moved.nodes, moved.b, moved.c, own)
        changes, by_b = self._way.turned(moved.b[:, 0], moved.nodes, moved.solved, first.solved)
        second, b = self._backward(nodes, changes, self._changes(moved, first))
        assembly = second.assembly
        by_c = by_joints(explicit.c[:, 0], assembly.c)
        turned = np.concatenate([b - by_b + explicit.b[:, 0], assembly.q, assembly.v, by_c])
        found = self._parameters.gradient_along(first.whole, turned, direction)
        own_part = [explicit.named[0].get(name, 0.0) for name in self._parameters.names]
        return np.asarray(found + np.array(own_part))

    def _changes(self, moved: Moved, first: Adjoined) -> dict[str, Change]:
        """The changes of the equations of the assembly."""
        system, steps, found, adjoint = self._system, self._steps, self._steps.start, first.assembly
        b, b_dot, t = remembered(steps, 0), moved.b[:, 0], float(steps.t[0])
        q_dot, lam_dot, v_dot, mu_dot = (x[:, 0] for x in moved.assembly)
        rate = change_at(
            system, "rate", t, b, b_dot, found.mu, -adjoint.y2[: system.m], mu_dot[: system.m],
            q=found.q, v=found.v, xi=adjoint.x2, q_dot=q_dot, v_dot=v_dot,
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
        return {"rate": rate, "place": place, "axes": self._axes_change(moved, first)}

    def _axes_change(self, moved: Moved, first: Adjoined) -> Change:
        """The changes of the rows of given rates of joints."""
        joints: Any = self._system.joint_coordinates  # they have the structure of a system's constraints
        own, found, adjoint = self._chain.assembly.rates.selection, self._steps.start, first.assembly
        if not own.any():
            none = np.zeros(self._system.nq)
            return Change(none, none, none, np.zeros(joints.m), np.zeros(len(joints.b)))
        q_dot, _, v_dot, mu_dot = (x[:, 0] for x in moved.assembly)
        m = self._system.m
        return change_at(
            joints, "rate", 0.0, joints.b, moved.c[: len(joints.b), 0], found.nu @ own, -adjoint.y2[m:] @ own,
            mu_dot[m:] @ own, q=found.q, v=found.v, xi=adjoint.x2, q_dot=q_dot, v_dot=v_dot,
        )  # fmt: skip
