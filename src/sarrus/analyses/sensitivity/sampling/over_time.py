"""Derivatives of all reported states of a run at fixed times: ends of steps, and events."""

from __future__ import annotations

import numpy as np

from ....algebra import Array
from ....results import Pieces, StepsTaken
from ....system import System
from ..chain.chain import Nodes
from ..steps.sweep_loop import NodeArrays
from .consistent import ConsistentSampling
from .pieces import PieceSampling, Where, course_of
from .reported import Reported
from .sampling import Sampling, apart


def at_all_times(steps: StepsTaken | Pieces) -> Sampling:
    """The states at the ends of all steps, and on both sides of every event, at times that stay where they are.

    Only the end of a run moves with the event that ended it, as in a response at that time.
    """
    if not isinstance(steps, Pieces):
        return Sampling(steps)
    course = course_of(steps)
    part = np.full(len(course.times), np.nan)
    part[-1] = 1.0
    piece = np.repeat(np.arange(len(course.t)), [len(t) for t in course.t])
    return PieceSampling(steps, Where(course.times, piece, part))


def reported_along(system: System, steps: StepsTaken | Pieces, nodes: Nodes, b: Array) -> NodeArrays:
    """The changes of q, v, a and λ there (n, nq or m, k), with those of all nodes and of the numbers (len(b), k)."""
    if not isinstance(steps, Pieces) and not apart(steps):
        reported = Reported(system, steps)
        found = reported.along(nodes, b) if reported.redundant else nodes
        return NodeArrays(found.q, found.v, found.a, found.lam)
    consistent = ConsistentSampling(system, steps, at_all_times(steps))
    columns = [consistent.along(nodes, b[:, k : k + 1], k).found for k in range(b.shape[1])]
    return NodeArrays._make(np.concatenate(x, axis=2) for x in zip(*columns, strict=True))
