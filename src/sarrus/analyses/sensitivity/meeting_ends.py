"""Lengths whose ends meet and could pass beside each other: derivatives to what moves them aside do not exist.

The force of a length |d| reverses where its ends meet. If d can turn aside, the component f d/|d| there has a slope
f/|d| without an integral over the passage.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.linalg import null_space

from ..._jit.formulas.replay import needed
from ...algebra import Array
from ...results import Pieces
from ...results.motion.steps import EventStep
from ...system import System
from ...system.curves.curve_derivatives import CurveDerivatives
from ..dynamics.events.force_corners import Corner
from ..dynamics.inputs.force_arguments import force_functions

DIRECTIONS = 4  # of all possible velocities, at random: enough to see whether d has more than one
ALONG = 1e-8  # of the square of the largest change of d: others are round-off


def free_aside(system: System, steps: Pieces) -> Iterator[str]:
    """Yield a message for each length whose ends met and could have passed beside each other."""
    passed: dict[tuple[str, int], tuple[EventStep, Corner]] = {}
    for event in steps.event_steps:
        corner = event.function
        if isinstance(corner, Corner) and corner.length:
            passed.setdefault((corner.owner, corner.element), (event, corner))
    for event, corner in passed.values():
        if _is_free(system, steps.b, event, corner):
            yield (
                f"{corner.owner}: its ends meet at t = {event.t:.6g} s, and could pass beside each other, so that "
                "derivatives to parameters that move them aside do not exist. Guide one end along a line, or leave "
                "these parameters out."
            )


def _is_free(system: System, b: Array, event: EventStep, corner: Corner) -> bool:
    """Whether d can change in more than one direction: the rank of the squares of its changes, s̈/2 where d is zero."""
    free = null_space(system.Phi_q(event.q, event.t, b=b).toarray())
    if free.shape[1] < 2:
        return False
    chosen = free @ np.random.default_rng(0).standard_normal((free.shape[1], DIRECTIONS))
    i, j = np.triu_indices(DIRECTIONS)
    v = (chosen[:, i] + chosen[:, j]).T
    p = system.populations[corner.population]
    graph, bend = force_functions(p.variant).graph, [force_functions(p.variant).lengths[corner.sign].bend]
    operands = {"q": np.tile(event.q, (len(v), 1)), "v": v, "t": np.full(len(v), event.t)}
    values = CurveDerivatives(system).on_elements(p, graph, bend, needed(graph, bend), b, {}, operands)
    sums = np.zeros((DIRECTIONS, DIRECTIONS))
    sums[i, j] = sums[j, i] = values[0, corner.element]
    own = np.diag(sums) / 4
    changes = np.linalg.eigvalsh((sums - own[:, None] - own) / 2)
    return bool(changes[-2] > ALONG * changes[-1])
