"""Relative errors of derivatives: by those of the states, and in unstable motions by an equivalent change."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from .....algebra import Array
from .....results import Assembly
from ...parameters.parameters import Parameters
from ..state_errors import SumErrors
from .equivalent_change import LEAST, REST, UNSTABLE, EquivalentChange
from .growth import OF_ORDER, Growth, RelativeErrors
from .random_changes import comparable, without_curves
from .small_derivatives import small_derivatives, untouched


class OfSums(NamedTuple):
    """Derivatives of random sums of states (s, p) by parameters, whose changes by the weights (p,) are comparable."""

    parameters: Parameters
    matrix: Array
    weights: Array


class Sweeps(Protocol):
    """Further sweeps over a run, whose steps are stored or computed again."""

    def by_all(self) -> OfSums:
        """Derivatives of the sums by all parameters of the model."""
        ...

    def changes(
        self, change: EquivalentChange, moving: Parameters, which: Array, weights: Array
    ) -> tuple[Array, float]:
        """Relative changes of derivatives of some responses with a change of parameters (k,), and within the run."""
        ...

    def by_changes_of_errors(self) -> Array | None:
        """Relative errors of derivatives of all responses (k,), see `error_changes`."""
        ...


class Route(NamedTuple):
    """Numbers of some responses, derivatives of sums by the same parameters, factors of `small_derivatives` (k,)."""

    sweeps: Sweeps
    which: Array
    of_sums: OfSums
    factors: Array


class RunErrors(NamedTuple):
    """What relative errors of derivatives are estimated from.

    Attributes
    ----------
    by_bodies : effects of errors of states on sums, see `Effects`
    growth : of the adjoints of responses
    taken : by responses from states, see `Taken`
    found, of_sums : derivatives of responses (k, p), k is 0 for all states, and of sums by the parameters
    span : start of the run, and its end [s]
    contacts : whether it has corners or events
    """

    by_bodies: Array
    growth: Growth
    taken: Array
    parameters: Parameters
    found: Array
    of_sums: Array
    span: tuple[Assembly, float]
    contacts: bool

    def relative(self, sweeps: Sweeps, order: int = 1) -> RelativeErrors:
        """Of derivatives of all responses of an order: each by errors of the bodies that it depends on."""
        grown = self.growth.values()
        errors = RelativeErrors(*np.ones((3, len(grown))))
        for bodies, responses in self.growth.groups():
            own, largest = SumErrors.of(self.by_bodies, bodies), float(grown[responses].max())
            group = _of_group(own, largest, self._route(sweeps, responses), order)
            for whole, some in zip(errors, group, strict=True):
                whole[responses] = some
        if self.contacts and (stable := grown <= UNSTABLE).any():
            errors = errors.with_changes(sweeps.by_changes_of_errors(), stable, order)
        if len(self.found) and order == 1:
            errors = errors.without(untouched(self.found, self.of_sums, errors.values))
        return errors

    def _route(self, sweeps: Sweeps, which: Array) -> Route:
        """Of derivatives of some responses, or of those of sums of states alone."""
        found = self.found[which] if len(self.found) else self.of_sums
        weights, factors = comparable(self.parameters, found, *self.span), np.ones(1)
        if len(self.found):
            factors = small_derivatives(self.taken[which], weights, found, self.of_sums)
        return Route(sweeps, which, OfSums(self.parameters, self.of_sums, weights), factors)


def _of_group(errors: SumErrors, grown: float, route: Route, order: int) -> RelativeErrors:
    """Of responses that depend on the same bodies, whose adjoints have grown by so much."""
    factors = route.factors if order == 1 else np.ones_like(route.factors)
    by_states = np.outer(errors.of_derivatives(), factors) * OF_ORDER[order]
    if grown <= UNSTABLE:
        return RelativeErrors(by_states[0], by_states[1], factors)
    change, moving = _equivalent(errors, grown, route)
    if change is None or change.rest >= REST:
        return RelativeErrors(by_states[0], by_states[1], factors)
    by_change = change.of_derivatives(
        *route.sweeps.changes(change, moving, route.which, route.of_sums.weights), order
    )
    others = max(change.rest, UNSTABLE / grown, LEAST) * by_states
    values, by_round_off = np.hypot(by_change, others)
    return RelativeErrors(values, by_round_off, np.where(by_change[0] > others[0], 1.0, factors))


def _equivalent(errors: SumErrors, grown: float, route: Route) -> tuple[EquivalentChange | None, Parameters]:
    """A change of parameters that moves the run as its errors do: of those given, or else of all of the model."""
    of_sums = route.of_sums
    change = _change(errors, of_sums)
    if (change is None or change.rest >= REST) and grown >= UNSTABLE / REST:
        of_sums = route.sweeps.by_all()
        change = _change(errors, of_sums)
    return change, of_sums.parameters


def _change(errors: SumErrors, of_sums: OfSums) -> EquivalentChange | None:
    weights = without_curves(of_sums.parameters, of_sums.weights)
    return EquivalentChange.of(errors, of_sums.matrix, weights)
