"""Relative errors of derivatives: by those of the states, and in unstable motions by an equivalent change."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from ....algebra import Array
from ..parameters.parameters import Parameters
from .change_errors import without_curves
from .equivalent_change import LEAST, REST, UNSTABLE, EquivalentChange
from .estimate import Effects
from .growth import OF_ORDER, RelativeErrors
from .state_errors import of_derivatives


class OfSums(NamedTuple):
    """Derivatives of random sums of states (s, p) by parameters, whose changes by the weights (p,) are comparable."""

    parameters: Parameters
    matrix: Array
    weights: Array


class Route(Protocol):
    """Sweeps over a run, by which errors of derivatives in unstable motions are estimated."""

    def by_all(self) -> OfSums:
        """By all parameters of the model."""
        ...

    def changes(self, change: EquivalentChange, moving: Parameters) -> tuple[Array, float]:
        """Relative changes of derivatives of responses with a change of the parameters (k,), and within the run."""
        ...


def relative_errors(
    effects: Effects, of_sums: OfSums, factors: Array, grown: float, route: Route, order: int = 1
) -> RelativeErrors:
    """Of derivatives of an order, if adjoints have grown by so much."""
    by_states = np.outer(of_derivatives(effects), factors) * OF_ORDER[order]
    if grown <= UNSTABLE:
        return RelativeErrors(by_states[0], by_states[1], factors)
    change, moving = _equivalent(effects, of_sums, grown, route)
    if change is None or change.rest >= REST:
        return RelativeErrors(by_states[0], by_states[1], factors)
    by_change = change.of_derivatives(*route.changes(change, moving), order)
    others = max(change.rest, UNSTABLE / grown, LEAST) * by_states
    values, by_round_off = np.hypot(by_change, others)
    return RelativeErrors(values, by_round_off, np.where(by_change[0] > others[0], 1.0, factors))


def _equivalent(
    effects: Effects, of_sums: OfSums, grown: float, route: Route
) -> tuple[EquivalentChange | None, Parameters]:
    """A change of parameters that moves the run as its errors do: of those given, or else of all of the model."""
    change = _change(effects, of_sums)
    if (change is None or change.rest >= REST) and grown >= UNSTABLE / REST:
        of_sums = route.by_all()
        change = _change(effects, of_sums)
    return change, of_sums.parameters


def _change(effects: Effects, of_sums: OfSums) -> EquivalentChange | None:
    weights = without_curves(of_sums.parameters, of_sums.weights)
    return EquivalentChange.of(effects, of_sums.matrix, weights)
