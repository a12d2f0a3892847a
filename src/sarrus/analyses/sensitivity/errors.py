"""Errors of derivatives of stored steps, and warnings of them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...algebra import Array
from ...model.announcement import announce, collecting
from ...results import Assembly, ErrorEstimate, Pieces, StepsTaken
from ...results.motion.steps import stretches
from ..equations.length import extent
from .accuracy.derivatives.change_errors import (
    WRONG_CHANGES,
    errors_of_stored_changes,
    relative_errors_of_changes,
    warnings_of_changes,
)
from .accuracy.derivatives.equivalent_change import EquivalentChange, moved_along, relative_changes
from .accuracy.derivatives.error_changes import by_changes_of_errors, errors_of_steps
from .accuracy.derivatives.growth import ENOUGH, OF_ORDER, WARNED, certain, doubtful, growth_of
from .accuracy.derivatives.random_changes import Directions, RandomChanges, comparable
from .accuracy.derivatives.relative_errors import OfSums, RunErrors
from .accuracy.derivatives.sampling_errors import relative_sampling_errors, warnings_of_samples
from .accuracy.derivatives.small_derivatives import Taken
from .accuracy.estimate import Effects, effects_of, estimated
from .accuracy.lost_vibrations import lost_vibrations
from .accuracy.state_errors import KINDS, RandomSums, sums, with_sums
from .chain.chain import FIELDS, Chain, Gradients, Nodes
from .events.chains import AnyChain, first_of, moved_chain
from .gradients import Derivatives, adjoint, by_parameters
from .parameters.parameters import Parameters
from .parameters.undefined import undefined
from .responses.evaluation import Evaluation


def sums_needed(chain: AnyChain, error: bool) -> bool:
    """Whether sums of states are swept with the responses: if errors are asked for, or probable."""
    pieces = stretches(chain.steps)
    return error or doubtful(len(chain.steps), len(pieces) - 1, pieces[0].rtol, pieces[0].precise)


def swept(
    chain: AnyChain, given: Nodes, count: int, adjoints: list[Array], parameters: Parameters, error: bool = False
) -> tuple[Nodes, Array]:  # fmt: skip
    """Gradients of the first responses by states, whose adjoints are swept and stored, for errors those of sums too.

    Return also the derivatives of the sums (s, p).
    """
    first = _first(given, count)
    by = chain.gradients(with_sums(first, chain) if sums_needed(chain, error) else first, adjoints)
    of_sums = Gradients(*(getattr(by, name)[:, count:] for name in "bqvc"))
    return first, by_parameters(of_sums, parameters)


def _first(given: Nodes, count: int) -> Nodes:
    return Nodes(*(getattr(given, name)[..., :count].copy() for name in FIELDS))


def estimates_and_warnings(
    chain: AnyChain, evaluation: Evaluation, given: Nodes, adjoints: Sequence[Array], error: bool,
    derivatives: Derivatives, order: int = 1,
) -> tuple[tuple[ErrorEstimate, ...], tuple[float, ...]]:  # fmt: skip
    """Warn where derivatives have few digits; errors of values and of derivatives, if asked for."""
    titles, found = [one.title for one in derivatives.responses], derivatives.of_responses
    checked = warn_of_states(chain, titles, given, adjoints, derivatives, order, error)
    stored = StoredChanges(chain, _first(given, len(titles)), adjoints)
    changes = _of_changes(stored, derivatives.parameters, found, order, error)
    announce(warnings_of_changes(titles, changes, order))
    if not error or checked is None:
        return (), ()
    effects, relative = checked
    vibrations = lost_vibrations(chain, _first(given, len(titles)))
    errors = estimated(derivatives.responses, evaluation, effects, vibrations)
    samples = _of_samples(chain, evaluation, derivatives) if order == 1 else 0.0 * relative
    announce(warnings_of_samples(titles, samples))
    return errors, tuple(map(float, np.linalg.norm([relative, changes, samples], axis=0)))


def _of_samples(chain: AnyChain, evaluation: Evaluation, derivatives: Derivatives) -> Array:
    """Relative errors of derivatives by samples (k,); in runs with events, `error_changes` contains them."""
    found, parameters = derivatives.of_responses, derivatives.parameters
    if not evaluation.has_panels or len(stretches(chain.steps)) > 1:
        return np.zeros(len(found))
    finer = adjoint(chain, evaluation.halved.gradients(), parameters, [])[0]
    span = chain.steps.start, float(chain.steps.t[-1])
    return relative_sampling_errors(parameters, found, evaluation.of_rule * (finer - found), *span)


def warn_of_states(
    chain: AnyChain, titles: Sequence[str], given: Nodes, adjoints: Sequence[Array], derivatives: Derivatives,
    order: int = 1, error: bool = False,
) -> tuple[Effects, Array] | None:  # fmt: skip
    """Warn where derivatives have few digits by errors of states; effects of these, and relative errors.

    They are estimated where sums of states were swept, too, or where adjoints grow enough; if no `error` is asked for,
    only as well as warnings need.
    """
    k = len(titles)
    of_responses = [one[..., :k] for one in adjoints]
    growth = growth_of(chain.steps, given, of_responses)
    if adjoints[0].shape[-1] == k:
        first = stretches(chain.steps)[0]
        if np.all(growth.digits(first.rtol, first.precise) >= ENOUGH):
            return None
        adjoints = list[Array]()
        by = chain.gradients(sums(chain), adjoints)
        derivatives = derivatives._replace(of_sums=by_parameters(by, derivatives.parameters))
    skipped = 0 if error else adjoints[0].shape[-1] - len(derivatives.of_sums)
    effects = effects_of(chain.system, chain.steps, [one[..., skipped:] for one in adjoints])
    taken = Taken((chain.steps.t[0], chain.steps.t[-1]))
    taken.take(chain.steps.t, _first(given, k))
    shares = taken.values(growth.sizes())

    sweeps = StoredSweeps(
        chain, derivatives, of_responses if derivatives.responses else adjoints, order, error
    )
    span, parameters = (chain.steps.start, float(chain.steps.t[-1])), derivatives.parameters
    found, of_sums, several = derivatives.of_responses, derivatives.of_sums, len(adjoints) > 1
    known = RunErrors(effects.by_bodies, growth, shares, parameters, found, of_sums, span, several)
    errors = known.relative(sweeps, order)
    announce(growth.warnings_of_errors(titles, errors, order))
    return effects, errors.values


class StoredSweeps(NamedTuple):
    """Sweeps over stored steps, see `Sweeps`, of responses with these adjoints; `asked` not for warnings alone."""

    chain: AnyChain
    derivatives: Derivatives
    adjoints: Sequence[Array]
    order: int
    asked: bool

    def by_all(self) -> OfSums:
        """Derivatives of the sums by all parameters of the model."""
        chain, start = self.chain, self.chain.steps.start
        restitutions = self.derivatives.parameters.restitutions
        every = Parameters(chain.system, None, start=start, restitutions=restitutions)
        by = by_parameters(chain.gradients(sums(chain)), every)
        by[:, undefined(chain.system, chain.steps, every)] = 0.0
        return OfSums(every, by, comparable(every, by, start, float(chain.steps.t[-1])))

    def changes(
        self, change: EquivalentChange, moving: Parameters, which: Array, weights: Array
    ) -> tuple[Array, float]:
        """Relative changes of derivatives of some responses with a change of parameters (k,), and of sums of states."""
        chain, (parameters, responses, found, of_sums) = self.chain, self.derivatives
        steps, small = moved_along(chain, moving, change.direction)
        there = moved_chain(chain, steps, parameters.restitutions)
        if responses:
            found, responses = found[which], [responses[r] for r in which]
            with collecting():  # its warnings are those of the run
                given, explicit = Evaluation(chain.system, steps, responses, parameters).gradients()
            whole = with_sums(given, chain) if self.order == 2 else given
            moved, moved_sums = adjoint(there, (whole, explicit), parameters, [])
        else:
            moved, moved_sums = found, by_parameters(there.gradients(sums(chain)), parameters)
        changes = relative_changes(found, moved, weights) / small
        if responses and self.order == 1:
            return changes, 0.0
        within = float(np.median(relative_changes(of_sums, moved_sums, weights))) / small
        return changes if responses else np.array([within]), within

    def by_changes_of_errors(self) -> Array | None:
        """Relative errors of derivatives (k,), or if there are no responses, of the states, by sums of them (1,)."""
        chain, (parameters, responses, found, of_sums) = self.chain, self.derivatives
        system, adjoints = chain.system, self.adjoints
        if not responses:
            found, adjoints = of_sums, [one[..., -len(of_sums) :] for one in adjoints]

        def errors(steps: StepsTaken | Pieces, bars: Sequence[Array] | None = None) -> Array:
            evaluation = Evaluation(system, steps, responses, parameters)
            if bars is None:
                bars, given = list[Array](), evaluation.gradients()[0] if responses else sums(chain)
                moved_chain(chain, steps, parameters.restitutions).gradients(given, bars)
            rules = np.array([evaluation.rule_error(n) for n in range(len(responses))] or 0.0)
            return np.asarray(errors_of_steps(system, steps, bars) + rules)

        def moved(direction: Array) -> tuple[Array, float]:
            steps, small = moved_along(chain, parameters, direction)
            return errors(steps), small

        def enough(relative: Array, changes: int) -> bool:
            return not self.asked and certain(OF_ORDER[self.order] * relative, changes, WARNED[self.order])

        own = None if stretches(chain.steps)[0].precise else lambda: errors(chain.steps, adjoints)
        start, until = chain.steps.start, float(chain.steps.t[-1])
        random = RandomChanges.of(parameters, found, start, until)
        relative = by_changes_of_errors(random, found, own, moved, enough)
        return relative if responses or relative is None else np.median(relative, keepdims=True)


@dataclass(frozen=True, eq=False)
class StoredChanges:
    """Changes of a run with stored steps, see `ChangedRun`: gradients of responses by its states, perhaps adjoints."""

    chain: AnyChain
    by_states: Nodes
    known: Sequence[Array] = ()

    @property
    def first(self) -> Chain:
        return first_of(self.chain)

    @property
    def span(self) -> tuple[Assembly, float]:
        return self.chain.steps.start, float(self.t[-1])

    @property
    def t(self) -> Array:
        return self.chain.steps.t

    @property
    def h(self) -> Array:
        return np.concatenate([np.diff(own.t) for own in stretches(self.chain.steps)])

    @cached_property
    def adjoints(self) -> Sequence[Array]:
        """Of the responses."""
        k = self.by_states.q.shape[-1]
        return [own[..., :k] for own in self.known or self.chain.adjoints(self.by_states)]

    def weighed(self, directions: Directions) -> Array:
        return self.chain.weighed(self.by_states, *directions)

    def given(self) -> Sequence[tuple[Array, Nodes]]:
        return [(self.t, self.by_states)]

    def prescribed(self) -> Array:
        return growth_of(self.chain.steps, self.by_states, self.adjoints).prescribed()

    def errors_of_changes(self, random: RandomChanges, longest: float) -> Iterable[Array]:
        return errors_of_stored_changes(self.chain, random, self.adjoints, longest)


def _of_changes(
    changes: StoredChanges, parameters: Parameters, found: Array, order: int, error: bool
) -> Array:
    """Relative errors of derivatives of an order (k,) by steps that do not suit what parameters change.

    If no `error` is asked for, they are estimated only as well as warnings need.
    """

    def enough(relative: Array, count: int) -> bool:
        return not error and certain(OF_ORDER[order] * relative, count, WRONG_CHANGES)

    return OF_ORDER[order] * relative_errors_of_changes(changes, parameters, found, enough)


def warn_of_changed_states(chain: AnyChain, name: str, parameters: Parameters, found: Nodes) -> None:
    """Warn where derivatives of all states have few digits, by random sums of the states, each over its changes."""
    start, span = chain.steps.start, (chain.steps.t[0], chain.steps.t[-1])
    changes = {kind: np.ptp(getattr(found, kind), axis=0) for kind in KINDS}
    weights = comparable(parameters, np.concatenate([*changes.values()]), start, float(span[1]))
    ranges = {kind: (own * weights).max(axis=1) for kind, own in changes.items()}
    some = RandomSums.of(span, ranges, extent(chain.system, start.q)).by_states(chain.steps)
    errors = _of_changes(StoredChanges(chain, some), parameters, some.inner(found), order=1, error=False)
    announce(warnings_of_changes([f"the states of {name}"], np.median(errors, keepdims=True)))
