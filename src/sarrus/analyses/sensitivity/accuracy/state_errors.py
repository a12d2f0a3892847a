"""Errors of the states of a run, and by them of derivatives, by random sums of states.

The error of a sum of states with random signs is one more response of the same adjoint sweep, and its mean square is
the sum of the squares of all errors (Cao and Petzold 2004). Derivatives of a run are those of a motion that is off by
so much: their relative errors are of the size of the largest error over the size of the motion, however much the
adjoint grows.

The mean square of three sums has about the chi-squared distribution with three degrees of freedom: its root is below a
third of the truth with a probability of some 4 %, and above twice the truth of some 1 %. The signs are always the same.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ....results import Pieces, StepsTaken
from ...equations.length import extent
from ..chain.chain import FIELDS, Nodes
from ..events.chains import AnyChain

KINDS = ("q", "v")
TINY = float(np.finfo(float).tiny)
RATES = {"q": "v", "v": "a"}
SUMS = 3  # random sums: they give the size within a factor of 2, mostly, and fill a vector of four with a response
MOMENTS = 48  # of a run whose states are summed, and its end
FIXED = 1e-9  # of the motion of a body: coordinates that vary by less do not move, and have no error by steps
ROUND_OFF = 1e-12  # of the mechanism: motions that are no more, as those of a system at rest
LEAST = 1e-3  # of the largest motion of a kind, which that of each body is taken to be at least
OF_DERIVATIVES = 0.8  # relative error of derivatives over the root mean square of the sums, of known motions


def with_sums(given: Nodes, chain: AnyChain) -> Nodes:
    """Gradients of responses by states, and behind them those of random sums."""
    return beside(given, sums(chain))


def beside(given: Nodes, sums: Nodes) -> Nodes:
    """Gradients by states side by side; those of sums are zero at nodes before theirs."""
    found = []
    for name in FIELDS:
        own, more = getattr(given, name), getattr(sums, name)
        before = np.zeros((len(own) - len(more), *more.shape[1:]))
        found.append(np.concatenate([own, np.concatenate([before, more])], axis=-1))
    return Nodes(*found)


class SumErrors(NamedTuple):
    """Errors of random sums (SUMS,) by those of the states of some bodies: by steps, and by round-off.

    `part` is that of these bodies among all, over whose number sums are means.
    """

    by_steps: Array
    by_round_off: Array
    part: float = 1.0

    @classmethod
    def of(cls, by_bodies: Array, which: Array) -> SumErrors:
        """By some bodies, from `Effects.by_bodies`, whose last columns are those of the sums."""
        by_steps, squares = by_bodies[:, which, -SUMS:].sum(axis=1)
        return cls(by_steps, np.sqrt(squares), max(float(np.mean(which)), TINY))

    def of_derivatives(self) -> tuple[float, float]:
        """The relative error of derivatives, and round-off in it."""
        by_round_off, by_steps = (float(np.sqrt(np.mean(x**2) / self.part)) for x in self[1::-1])
        return OF_DERIVATIVES * float(np.hypot(by_steps, by_round_off)), OF_DERIVATIVES * by_round_off


def sums(chain: AnyChain) -> Nodes:
    """Gradients of the sums by states: at some moments all coordinates and velocities over how much they vary."""
    steps = chain.steps
    ranges, t = {name: np.ptp(nodes_of(steps, name), axis=0) for name in KINDS}, steps.t
    return RandomSums.of((t[0], t[-1]), ranges, extent(chain.system, steps.start.q)).by_states(steps)


def nodes_of(steps: StepsTaken | Pieces, name: str) -> Array:
    """A field of all nodes."""
    return steps.nodes(name) if isinstance(steps, Pieces) else getattr(steps, name)


class RandomSums(NamedTuple):
    """Sums of states with random signs: their moments, and the weights of states in them (MOMENTS, nq, SUMS)."""

    moments: Array
    weights: dict[str, Array]

    @classmethod
    def of(cls, span: tuple[float, float], ranges: Mapping[str, Array], length: float) -> RandomSums:
        """Those of a run between two times, by how much q and v vary in it, and by the length of the system."""
        signs = np.random.default_rng(1).choice([-1.0, 1.0], (2, MOMENTS, len(ranges["q"]), SUMS))
        rate = (1.0 + ranges["q"].max() / length) / (span[1] - span[0])
        pairs = zip(KINDS, signs, (ROUND_OFF, ROUND_OFF * rate), strict=True)
        weights = {name: own / _sizes(ranges[name], length, still)[:, None] for name, own, still in pairs}
        return cls(np.linspace(*span, MOMENTS + 1)[1:], weights)

    def by_states(self, steps: StepsTaken | Pieces) -> Nodes:
        """Gradients by the states of a run, or of a part of it, and by the times at which stretches begin.

        Nodes move in time with the corner or the event at which their stretch begins: moments do not.
        """
        found, t = Nodes.zeros(steps, SUMS), steps.t
        own = (self.moments > t[0]) & (self.moments <= t[-1])
        rows = np.searchsorted(t, self.moments[own])
        stretch = np.searchsorted(steps.first, rows, side="right") - 1 if isinstance(steps, Pieces) else 0
        for name, weights in self.weights.items():
            np.add.at(getattr(found, name), rows, weights[own])
            moved = np.einsum("nj,njk->nk", nodes_of(steps, RATES[name])[rows], weights[own])
            np.subtract.at(found.shift, np.broadcast_to(stretch, len(moved)), moved)
        return found


def _sizes(ranges: Array, length: float, still: float) -> Array:
    """How much each coordinate, or velocity, varies, but not too little, times the root of the number of bodies (nq,).

    Displacements and rotations are compared by a length: one of them may vary by round-off only. Coordinates that are
    fixed count as infinite: adjoints by what leaves the constraints are large, and mean nothing. So do those that are
    `still`, over the length: they vary by round-off.
    """
    vary = ranges.reshape(-1, 7)
    moved, turned = vary[:, :3].max(axis=1, keepdims=True), vary[:, 3:].max(axis=1, keepdims=True)
    least = LEAST * max(moved.max(), length * turned.max())
    moved, turned = np.maximum(moved, least), np.maximum(turned, least / length)
    sizes = np.hstack([np.repeat(moved, 3, axis=1), np.repeat(turned, 4, axis=1)]).ravel()
    fixed = np.maximum(FIXED * sizes, still * np.tile(np.repeat((length, 1.0), (3, 4)), len(vary)))
    return np.asarray(np.where(ranges > fixed, sizes, np.inf) * np.sqrt(len(vary)))
