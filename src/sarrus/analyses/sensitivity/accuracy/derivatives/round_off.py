"""Round-off in second derivatives of the times of events and corners of forces.

They need v̈ in the last step before an event, from q, v and a at its ends. The round-off of these is divided by up to
the third power of the step size, and smaller tolerances make these steps shorter. Products with the Hessian are
computed again with round-off at random in these states.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from .....algebra import Array
from .....results import Pieces, StepsTaken

ROUND_OFF = 0.5 * float(np.finfo(float).eps)  # of the largest entry
SAMPLES = 3
NODES = slice(-2, None)  # of each piece
Times = Callable[[Array], Array]


def with_round_off(steps: Pieces) -> Iterator[Pieces]:
    """Yield the steps with round-off in the states between which events are, each time with another one."""
    rng, count = np.random.default_rng(0), len(steps.event_steps)
    for _ in range(SAMPLES):
        pieces = (*(_moved(one, rng) for one in steps.pieces[:count]), *steps.pieces[count:])
        yield replace(steps, pieces=pieces)


def _moved(steps: StepsTaken, rng: np.random.Generator) -> StepsTaken:
    changed: dict[str, Any] = {}
    for name in ("q", "v", "a"):
        own = np.array(getattr(steps, name))
        last = own[NODES]
        last += ROUND_OFF * abs(last).max(initial=0.0) * rng.standard_normal(last.shape)
        changed[name] = own
    return replace(steps, **changed)


def relative_round_off(size: int, times: Times, others: Iterable[Times]) -> float:
    """Return how much a product with a Hessian along a direction changes at most, over its size."""
    direction = np.random.default_rng(1).choice([-1.0, 1.0], size)
    own = times(direction)
    largest = abs(own).max(initial=0.0)
    changes = [abs(other(direction) - own).max(initial=0.0) for other in others] if largest else [0.0]
    return float(max(changes) / (largest or 1.0))
