"""Integrals of outputs along a run, by Gauss' rule within its steps on consistent states."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ....algebra import Array
from ....outputs.motion import motion_outputs, over
from ....outputs.output import UnknownOutput, find_output
from ....results import StepsTaken
from ....results.motion.solution import Solution
from ....system import System
from ...redundancy.redundant_constraints import Independence
from ..stepping.nodes import Nodes, joined
from .sampler import Sampler

POINTS, WEIGHTS = (
    (x + shift) / 2 for x, shift in zip(np.polynomial.legendre.leggauss(5), (1, 0), strict=True)
)
ROUND_OFF = 1e-9  # of the length of a run, between a stored time and the end of a step


def accumulated(system: System, run: Any, names: Sequence[str]) -> Array:
    """The integrals of outputs since the start, at the times of a run (names, nt).

    Raises
    ------
    UnknownOutput
        If the motion between the stored times is not known.
    """
    if not len(run.t):  # an analysis that failed at its start
        return np.zeros((len(names), 0))
    motion = _motion(system, run, names[0])
    ends = np.unique(
        np.concatenate([motion.times[(motion.times > run.t[0]) & (motion.times < run.t[-1])], run.t])
    )
    lengths = np.diff(ends)
    if not len(lengths):
        return np.zeros((len(names), len(run.t)))
    states = motion((ends[:-1, None] + lengths[:, None] * POINTS).ravel())
    outputs = motion_outputs(system, states)
    found = np.zeros((len(names), len(ends)))
    for row, name in zip(found, names, strict=True):
        values = over(find_output(system, name).record(outputs), np.asarray(states.t)).reshape(
            len(lengths), -1
        )
        row[1:] = np.cumsum(lengths * (values @ WEIGHTS))
    return np.asarray(found[:, np.searchsorted(ends, run.t)])


def _motion(system: System, run: Any, name: str) -> Solution:
    """The motion of a run at all times: stored, or through its samples where these follow each other like steps."""
    if getattr(run, "sol", None):
        known: Solution = run.sol
        return known
    if not hasattr(run, "history"):
        raise UnknownOutput(f"{system.name}: {name} is integrated along a run. Name another output.")
    if run.steps is None and _sparse(run):
        raise UnknownOutput(
            f"{system.name}: the integral of {name} needs the motion between the stored times. "
            "Simulate with store='dense' or store='steps'."
        )
    segments = getattr(run.steps, "segments", [run.steps] if run.steps else [])
    if segments:
        nodes = joined([_nodes(segment) for segment in segments])
    else:
        nodes = Nodes(
            *map(np.array, (run.t, run.q, run.v, run.a, run.lam, run.memory))
        )  # those of a run cannot be written
    apart = bool(segments) and not segments[0].precise
    sampler = Sampler(system, Independence(system, nodes.q[0], float(nodes.t[0])), system.b, apart=apart)
    return Solution(nodes, sampler, lambda t, *_: np.zeros((len(t), system.counted_coordinates.m)))


def _nodes(steps: StepsTaken) -> Nodes:
    """The ends of steps, with what elements remembered from there on."""
    memory = np.vstack([steps.memory, steps.memory[-1:]])
    return Nodes(steps.t, steps.q, steps.v, steps.a, steps.lam, memory)


def _sparse(run: Any) -> bool:
    """Whether more than one step ended between two stored times."""
    ends = run.history[:, 0]
    near = ROUND_OFF * float(np.ptp(run.t)) if len(run.t) else 0.0
    inner = ends[abs(ends[:, None] - run.t).min(axis=1, initial=np.inf) > near]
    counts = np.bincount(np.searchsorted(run.t, inner), minlength=1)
    return bool(counts.max(initial=0) > 1)
