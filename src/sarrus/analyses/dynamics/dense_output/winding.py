"""Revolutions of joints' angles and of rotations of bodies along a run, counted from step to step.

Outputs may be any number of revolutions apart: what lies between them is known to the time integration alone.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from ...._jit.kernels.pointer import NONE
from ...._jit.linking.link import link
from ....algebra import Array
from ....system import System
from ....system.operators.joints import GROUPS
from ..stepping.entries import entry_of
from ..stepping.nodes import Nodes
from ..stepping.stepper import RunPart
from . import winding_loop as loop


class Winding(RunPart):
    """The joints' coordinates, and the rotations of bodies about global axes, at the last state taken.

    Parameters
    ----------
    system : System

    Attributes
    ----------
    values : (nc,) angles with their revolutions, and displacements [rad], [m]
    first : revolutions at the start; empty where each angle is nearest to its initial value
    residual, velocity, work : of `winding_loop.count`
    """

    VARIABLES = "values", "first"

    def __init__(self, system: System) -> None:
        self._of = of = system.counted_coordinates
        self.values, self.first = np.zeros(of.m), np.zeros(0)
        operators: Any = of  # they have the structure of a system's constraints
        self.residual, self.velocity = (entry_of(operators, *names) if of.m else NONE for names in GROUPS)
        self.work = loop.Work(*(np.zeros(n) for n in (of.m, of.m, of.nq, of.m, of.m, of.of_joints)))

    def begin(self, q: Array, revolutions: Array) -> None:
        """A start; without revolutions each angle is nearest to its initial value."""
        self.values, self.first = self._of.with_revolutions(self._of.Phi(q), revolutions), revolutions

    def take(self, t: Array, q: Array, v: Array) -> Array:
        """Go on along states; returns the revolutions (n, nc) there."""
        full_revolutions = np.zeros((len(t), self._of.m))
        if self._of.m:
            link(loop.count)(
                self.residual, self.velocity, self._of.b, self._of.angles, t, q, v, self.values, full_revolutions,
                self.work,
            )  # fmt: skip
        return full_revolutions


def revolutions_between(system: System, nodes: Nodes, known: Array, t: Array, q: Array, v: Array) -> Array:
    """Revolutions (nt, nc) at states between nodes, rising times, where those at the nodes (n, nc) are known."""
    if not (len(t) and known.size):
        return np.zeros((len(t), known.shape[1]))
    first = max(int(np.searchsorted(nodes.t, t[0])) - 1, 0)
    last = int(np.searchsorted(nodes.t, t[-1], side="right"))
    passed = nodes.part(slice(first, max(last, first + 1)))
    times = np.concatenate([passed.t, t])
    order = np.argsort(times, kind="stable")
    both_q, both_v = (np.concatenate(x)[order] for x in ((passed.q, q), (passed.v, v)))
    winding, counted = Winding(system), np.zeros((len(times), known.shape[1]))
    winding.begin(passed.q[0], known[first])
    counted[order] = winding.take(times[order], both_q, both_v)
    return counted[len(passed.t) :]


class WindingAlong:
    """The revolutions at any time of a motion whose nodes are stored.

    Parameters
    ----------
    system : System
    nodes : of the whole motion
    first : revolutions at its start
    """

    def __init__(self, system: System, nodes: Nodes, first: Array) -> None:
        self._system, self._nodes, self._first = system, nodes, first

    @cached_property
    def _at_nodes(self) -> Array:
        winding = Winding(self._system)
        winding.begin(self._nodes.q[0], self._first)
        return winding.take(self._nodes.t, self._nodes.q, self._nodes.v)

    def __call__(self, t: Array, q: Array, v: Array) -> Array:
        """At states (nt, nc), rising times."""
        return revolutions_between(self._system, self._nodes, self._at_nodes, t, q, v)
