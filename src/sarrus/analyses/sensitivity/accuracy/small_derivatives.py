"""Size of the derivatives of a response beside those of its output within the run.

An error of the states changes a derivative by a part of what such derivatives are within the run. Those of a response
may be much smaller: of an angle at the end, where the motion reverses just then, or of a velocity that has decayed.
Their relative error is larger by so much, at most: random sums of states give the size of derivatives within the run,
but of all states, and some may depend on the parameters far more than others. The estimate is therefore multiplied by
the root of the ratio.
"""

from __future__ import annotations

import numpy as np

from ....algebra import Array
from ....results import Pieces, StepsTaken
from ..chain.chain import Nodes
from .growth import NONE, STATES
from .state_errors import MOMENTS, nodes_of

MOST = 100.0  # times smaller than those within the run


def small_derivatives(
    steps: StepsTaken | Pieces, given: Nodes, weights: Array, found: Array, of_sums: Array
) -> Array:
    """Factors of the relative errors of responses whose derivatives are smaller than those within the run (k,).

    Parameters
    ----------
    given : gradients of responses by the states
    weights : changes of the parameters that are compared (p,)
    found, of_sums : derivatives of responses (k, p) and of random sums by the parameters
    """
    within = np.linalg.norm(of_sums * weights) / np.sqrt(len(of_sums) * MOMENTS)
    sizes = np.linalg.norm(found * weights, axis=1)
    ratio = np.divide(_taken(steps, given) * within, sizes, out=np.ones_like(sizes), where=sizes > 0)
    return np.asarray(np.sqrt(np.clip(ratio, 1.0, MOST)))


def untouched(found: Array, of_sums: Array, relative_errors: Array) -> Array:
    """Whether derivatives are exactly zero and have no error (k,), as parameters move the run, but not the response.

    Parameters that do not act at all may do so in the exact motion, as a stop that is not met; and states that have no
    correct digit do not show what acts on what.
    """
    return np.asarray(~found.any(axis=1) & of_sums.any() & (relative_errors < NONE))


def _taken(steps: StepsTaken | Pieces, given: Nodes) -> Array:
    """What each response takes from states that vary independently at the moments of the sums (k,)."""
    t = steps.t
    moment = np.minimum((MOMENTS * (t - t[0]) / (t[-1] - t[0])).astype(int), MOMENTS - 1)
    total = np.zeros(given.q.shape[-1])
    for name in STATES:
        by = getattr(given, name)
        own = np.zeros((MOMENTS, *by.shape[1:]))
        np.add.at(own, moment, by)
        total += ((own * np.ptp(nodes_of(steps, name), axis=0)[:, None]) ** 2).sum(axis=(0, 1))
    return np.asarray(np.sqrt(total))
