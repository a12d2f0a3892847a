"""Steps of a run, moved by a small multiple of their changes with the parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from .....algebra import Array
from .....results import Assembly, EventStep, StepsTaken
from .....system import System
from .....system.curves.curve_derivatives import CurveDerivatives
from ....equations.length import extent
from ...chain.chain import STATES, Nodes
from ...sampling.settled import PIVOTS, settled
from ...steps.sweep import ORDERS

SMALL = 1e-6  # change of positions, over the size of the mechanism
PART = 1e-3  # and of the motion: in one of 1e-6 rad, stiffness times displacement would change by the square of both
STILL = 1e-9  # of the size of the mechanism: a motion that is round-off


class Extremes(NamedTuple):
    """How much q varies within a part of a run, and largest absolute values of v and of changes of q and v (nq,)."""

    q: Array
    v: Array
    q_dot: Array
    v_dot: Array


def extremes(steps: StepsTaken, changes: Nodes) -> Extremes:
    """Those of some steps, and of changes of their nodes (n, nq, k)."""
    sizes = np.ptp(steps.q, axis=0), abs(steps.v).max(axis=0)
    return Extremes(*sizes, abs(changes.q).max(axis=(0, 2)), abs(changes.v).max(axis=(0, 2)))


def _sizes(system: System, parts: Sequence[Extremes], length: float) -> tuple[float, float]:
    """The motion and the largest change, of positions over a length or of Euler parameters; states over their size."""
    q, v, q_dot, v_dot = (np.max(each, axis=0) for each in zip(*parts, strict=True))
    moving, scales = system.moving, np.repeat((1 / length, 1.0), (3, 4))
    motion, moved = (float((own[:moving].reshape(-1, 7).max(axis=0) * scales).max()) for own in (q, q_dot))
    sizes = v[moving:]
    shares = np.divide(v_dot[moving:], sizes, out=np.zeros_like(sizes), where=sizes > 0)
    return motion, float(max(moved, shares.max(initial=0.0)))


def small_multiple(system: System, changes: Sequence[Extremes], start: Assembly) -> float:
    """The multiple of changes of a run that is as small as differences need, from the extremes of its parts."""
    motion, change = _sizes(system, changes, extent(system, start.q))
    return (min(SMALL, PART * motion) if motion > STILL else SMALL) / (change or 1.0)


def moved_piece(
    system: System, steps: StepsTaken, small: float, changes: Nodes, db: Array, shift: float = 0.0,
    stages: Array | None = None, column: int = 0,
) -> StepsTaken:  # fmt: skip
    """Some steps, moved by a small multiple of their changes, with other numbers, and in time.

    Orders of pivots that serve the steps serve those moved, too.

    Parameters
    ----------
    changes, db, stages : of their nodes, of the numbers, and of their stages (n, entries, k), which may be left out
    shift : of their times [s]
    column : of the changes
    """
    fields = {name: getattr(steps, name) + small * getattr(changes, name)[..., column] for name in STATES}
    if stages is not None and steps.stages.shape[1]:
        fields["stages"] = steps.stages + small * stages[..., column]
    b = CurveDerivatives(system).moved(steps.b, small * db[:, column])
    moved = replace(steps, b=b, t=steps.t + shift, **fields)
    ORDERS[moved] = ORDERS.setdefault(steps, {})
    if steps in PIVOTS:
        PIVOTS[moved] = PIVOTS[steps]
    return moved


def moved_event(
    system: System,
    event: EventStep,
    shift: float,
    stretch: tuple[StepsTaken, StepsTaken],
    after: Array | float,
) -> EventStep:
    """An event that moves in time, at the end of a stretch before and after its move, and by the change behind it."""
    times = event.t, event.t + shift
    here, there = (settled(system, own, np.array([t])) for own, t in zip(stretch, times, strict=True))
    q, v = event.q + there.q[0] - here.q[0], event.v + there.v[0] - here.v[0]
    return replace(event, t=times[1], q=q, v=v, after=event.after + after)
