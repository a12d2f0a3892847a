"""Relative errors of derivatives: by those of the states, and in unstable motions by an equivalent change."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np

from ....algebra import Array
from ..parameters.parameters import Parameters
from .equivalent_change import LEAST, REST, UNSTABLE, EquivalentChange
from .growth import OF_ORDER, Growth, RelativeErrors
from .random_changes import without_curves
from .state_errors import SumErrors


class OfSums(NamedTuple):
    """Derivatives of random sums of states (s, p) by parameters, whose changes by the weights (p,) are comparable."""

    parameters: Parameters
    matrix: Array
    weights: Array


class Route(Protocol):
    """Derivatives of some responses, and sweeps over a run, by which their errors are estimated.

    Attributes
    ----------
    of_sums : by the same parameters
    factors : of `small_derivatives` (k,)
    """

    @property
    def of_sums(self) -> OfSums: ...
    @property
    def factors(self) -> Array: ...

    def by_all(self) -> OfSums:
        """By all parameters of the model."""
        ...

    def changes(self, change: EquivalentChange, moving: Parameters) -> tuple[Array, float]:
        """Relative changes of derivatives of responses with a change of the parameters (k,), and within the run."""
        ...


def relative_errors(
    by_bodies: Array, growth: Growth, route_of: Callable[[Array], Route], order: int = 1
) -> RelativeErrors:
    """Of derivatives of all responses of an order: each by errors of the bodies that it depends on.

    Parameters
    ----------
    by_bodies : of sums, see `Effects`
    route_of : gives the route of responses with these numbers
    """
    grown = growth.values()
    found = RelativeErrors(*np.ones((3, len(grown))))
    for bodies, responses in growth.groups():
        errors, largest = SumErrors.of(by_bodies, bodies), float(grown[responses].max())
        for whole, own in zip(found, _of_group(errors, largest, route_of(responses), order), strict=True):
            whole[responses] = own
    return found


def _of_group(errors: SumErrors, grown: float, route: Route, order: int) -> RelativeErrors:
    """Of responses that depend on the same bodies, whose adjoints have grown by so much."""
    factors = route.factors if order == 1 else np.ones_like(route.factors)
    by_states = np.outer(errors.of_derivatives(), factors) * OF_ORDER[order]
    if grown <= UNSTABLE:
        return RelativeErrors(by_states[0], by_states[1], factors)
    change, moving = _equivalent(errors, grown, route)
    if change is None or change.rest >= REST:
        return RelativeErrors(by_states[0], by_states[1], factors)
    by_change = change.of_derivatives(*route.changes(change, moving), order)
    others = max(change.rest, UNSTABLE / grown, LEAST) * by_states
    values, by_round_off = np.hypot(by_change, others)
    return RelativeErrors(values, by_round_off, np.where(by_change[0] > others[0], 1.0, factors))


def _equivalent(errors: SumErrors, grown: float, route: Route) -> tuple[EquivalentChange | None, Parameters]:
    """A change of parameters that moves the run as its errors do: of those given, or else of all of the model."""
    of_sums = route.of_sums
    change = _change(errors, of_sums)
    if (change is None or change.rest >= REST) and grown >= UNSTABLE / REST:
        of_sums = route.by_all()
        change = _change(errors, of_sums)
    return change, of_sums.parameters


def _change(errors: SumErrors, of_sums: OfSums) -> EquivalentChange | None:
    weights = without_curves(of_sums.parameters, of_sums.weights)
    return EquivalentChange.of(errors, of_sums.matrix, weights)
