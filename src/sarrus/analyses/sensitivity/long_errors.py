"""Errors of derivatives of a long run, by further sweeps over its stretches, and warnings of them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np

from ...algebra import Array
from ...model.announcement import announce, collecting
from ...results import Assembly, ErrorEstimate, Gradient, StepsTaken
from ...results.motion.steps import first_of, stretches
from ...system import System
from ..equations.length import extent
from ..equilibria.settled_derivatives import derivatives_of
from .accuracy.derivatives.change_errors import (
    WRONG_CHANGES,
    errors_of_changes,
    relative_errors_of_changes,
    warnings_of_changes,
)
from .accuracy.derivatives.equivalent_change import EquivalentChange, relative_changes
from .accuracy.derivatives.error_changes import by_changes_of_errors, errors_of_steps
from .accuracy.derivatives.growth import ENOUGH, WARNED, Growth, RelativeErrors, certain, doubtful
from .accuracy.derivatives.random_changes import Directions, RandomChanges, comparable
from .accuracy.derivatives.relative_errors import OfSums, RunErrors
from .accuracy.derivatives.sampling_errors import relative_sampling_errors, warnings_of_samples
from .accuracy.derivatives.small_derivatives import Taken
from .accuracy.estimate import effects_of, estimates
from .accuracy.lost_vibrations import LOOKED_AT, lost_modes, sizes, some
from .accuracy.state_errors import RandomSums
from .chain.chain import FIELDS, STATES, Chain, Nodes
from .gradients import by_parameters
from .long_gradient import LongGradient, Swept, Watch
from .long_rule_errors import errors_of_derivatives, rule_errors
from .long_run import LongRun, Stretch
from .moved_run import LongChanges, MovedRun, Report
from .parameters.parameters import Parameters
from .parameters.singular_start import singular_start
from .parameters.undefined import undefined
from .responses.responses import Response
from .responses.undefined import refuse_undefined


def gradient_with_warnings(
    run: LongRun, responses: Sequence[Response], parameters: Parameters, report: Report | None, error: bool
) -> Gradient:
    """Values and derivatives of all responses, and their errors if they are asked for."""
    errors = LongErrors(run, responses, parameters, report, error)
    if errors.finer:
        errors = LongErrors(run, errors.finer, parameters, report, error)
    found, titles = errors.found, errors.titles
    refuse_undefined(titles, found.values)
    relative = errors.warn()
    announce(singular_start(parameters, run.start, derivatives_of(run.system, run.start), found.missing))
    matrix = found.matrix.copy()
    matrix[:, found.missing] = np.nan
    return Gradient(
        titles, tuple(parameters.names), found.values, parameters.values, matrix, units=parameters.units,
        response_units=tuple(one.unit(run.system) for one in responses),
        errors=errors.of_values() if error else (), relative_errors=relative,
    )  # fmt: skip


class LongErrors:
    """Derivatives of responses of a long run, and sweeps for their errors; see `Sweeps`.

    Attributes
    ----------
    found : values and derivatives
    titles : of the responses
    finer : the responses, if some of them need more samples than the ends of steps
    """

    def __init__(
        self, run: LongRun, responses: Sequence[Response], parameters: Parameters, report: Report | None,
        asked: bool = False,
    ) -> None:  # fmt: skip
        self._asked = asked
        self._run, self._responses, self._parameters, self._report = run, responses, parameters, report
        t = run.course.t
        self._h, self._span = np.concatenate([np.diff(own) for own in t]), (run.start.t, float(t[-1][-1]))
        self._growth, self._taken, self._effects = Growth(), Taken(self._span), list[Array]()
        self._some = list[StepsTaken]()
        self._of_values = np.zeros((3, len(responses)))
        self._sums = RandomSums.of(self._span, run.ranges, extent(run.system, run.start.q))
        self._together = asked or doubtful(len(self._h), len(t) - 1, run.rtol, run.precise)
        self._own = LongGradient(run, responses, parameters, self._sums if self._together else None)
        self.titles, self.found = self._own.titles, self._own.swept(report, self)
        self.finer = self._finer()
        announce(() if self.finer else self._own.warnings())

    def _finer(self) -> list[Response]:
        """All responses, with more samples in each step of coarse ones; none if they have them already."""
        wanted = self._own.finer(self._responses)
        return wanted if any(x is not y for x, y in zip(wanted, self._responses, strict=True)) else []

    def take(self, n: int, stretch: Stretch, given: Nodes, adjoints: Sequence[Array]) -> None:
        """See `Watch`."""
        k, t = len(self._responses), stretch.steps.t
        own = Nodes(*(getattr(given, name)[..., :k] for name in FIELDS))
        self._growth.take(stretch.steps, own, [one[..., :k] for one in adjoints])
        self._taken.take(t, Nodes(*(getattr(own, name)[-len(t) :] for name in FIELDS)))
        first = stretches(stretch.steps)[0]
        if n == 0:
            self._first = first_of(first, 1)
        if first.t[0] < self._run.course.t[0][-1]:
            self._some[:0] = some(first, 1 + LOOKED_AT // len(self._run))
        if self._together:
            skipped = 0 if self._asked else k
            effects = effects_of(self._run.system, stretch.steps, [one[..., skipped:] for one in adjoints])
            self._effects.append(effects.by_bodies)
            if self._asked:
                self._of_values += effects.sums[:, :k]

    def warn(self) -> tuple[float, ...]:
        """Warn where derivatives have few digits; their relative errors, if they are asked for."""
        growth, run, by_states = self._growth, self._run, np.zeros(len(self.titles))
        if self._together or not np.all(growth.digits(run.rtol, run.precise) >= ENOUGH):
            errors = self._errors()
            by_states = errors.values
            announce(growth.warnings_of_errors(self.titles, errors))
        changes = relative_errors_of_changes(self, self._parameters, self.found.matrix, self._enough_changes)
        announce(warnings_of_changes(self.titles, changes))
        if not self._asked:
            return ()
        samples = self._errors_of_samples()
        announce(warnings_of_samples(self.titles, samples))
        return tuple(map(float, np.linalg.norm([by_states, changes, samples], axis=0)))

    def _errors_of_samples(self) -> Array:
        """By samples of responses (k,); in runs with events, changes of errors contain them."""
        run, parameters, found = self._run, self._parameters, self.found.matrix
        if run.course.event_steps:
            return np.zeros(len(found))
        errors = errors_of_derivatives(run, self._responses, parameters, found)
        return relative_sampling_errors(parameters, found, errors, run.start, self._span[1])

    def of_values(self) -> tuple[ErrorEstimate, ...]:
        """The errors of the responses."""
        values = self.found.values
        rules = rule_errors(self._run, self._responses, self._parameters, values)
        return estimates(self.titles, values, self._of_values, rules, self._lost_vibrations())

    def _lost_vibrations(self) -> Array:
        """The size of errors of the responses (k,) by those that begin at the start, with one more sweep if any do."""
        chain = Chain(self._run.system, self._first)
        modes, found = lost_modes(chain, self._run.course.t[0], self._some), np.zeros(len(self.titles))
        if modes is not None:
            for t, own in self.given():
                found = found + sizes(modes, chain.system, t, own)
        return found

    def by_all(self) -> OfSums:
        """Derivatives of the sums by all parameters of the model."""
        restitutions = self._parameters.restitutions
        every = Parameters(self._run.system, None, start=self._run.start, restitutions=restitutions)
        matrix = by_parameters(self._with_sums.of_sums, every)
        matrix[:, self._missing(every)] = 0.0
        return OfSums(every, matrix, comparable(every, matrix, self._run.start, self._span[1]))

    def _moved_run(self, direction: Array, moving: Parameters) -> tuple[MovedRun, float]:
        """The run, moved by a small multiple of a change; this multiple."""
        changes = self._changes_along(moving.along(direction[:, None]))
        return MovedRun(changes), changes.small

    def changes(
        self, change: EquivalentChange, moving: Parameters, which: Array, weights: Array
    ) -> tuple[Array, float]:
        """Relative changes of derivatives of some responses with a change (k,); none of those within the run."""
        there, small = self._moved_run(change.direction, moving)
        responses = list(np.array(self._responses, dtype=object)[which])
        with collecting():  # its warnings are those of the run
            moved = LongGradient(there, responses, self._parameters).swept(self._within_time).matrix
        return relative_changes(self.found.matrix[which], moved, weights) / small, 0.0

    def by_changes_of_errors(self) -> Array | None:
        """Relative errors of derivatives (k,), from two or more sweeps for each change of the parameters."""
        run, parameters, responses = self._run, self._parameters, self._responses

        def errors(there: LongRun | MovedRun) -> Array:
            watch = ErrorsOfSteps(run.system)
            found = LongGradient(there, responses, parameters).swept(self._within_time, watch)
            return np.asarray(watch.total + rule_errors(there, responses, parameters, found.values))

        def moved(direction: Array) -> tuple[Array, float]:
            there, small = self._moved_run(direction, parameters)
            return errors(there), small

        def enough(relative: Array, changes: int) -> bool:
            return not self._asked and certain(relative, changes, WARNED[1])

        own = None if run.precise else partial(errors, run)
        random = RandomChanges.of(parameters, self.found.matrix, *self.span)
        return by_changes_of_errors(random, self.found.matrix, own, moved, enough)

    def _errors(self) -> RelativeErrors:
        """By errors of states, which take one more sweep if sums of states were not swept with the responses."""
        matrix, of_sums = self.found.matrix, by_parameters(self._with_sums.of_sums, self._parameters)
        of_sums[:, self.found.missing] = 0.0
        taken, several = self._taken.values(self._growth.sizes()), len(self._run.course.t) > 1
        by_bodies, span = np.sum(self._effects, axis=0), (self._run.start, self._span[1])
        known = RunErrors(by_bodies, self._growth, taken, self._parameters, matrix, of_sums, span, several)
        return known.relative(self)

    @cached_property
    def _with_sums(self) -> Swept:
        """What a sweep with the sums has found."""
        if self._together:
            return self.found
        alone = LongGradient(self._run, (), self._parameters, self._sums)
        with collecting():
            return alone.swept(self._within_time, EffectsOfSums(self._run.system, self._effects))

    def _missing(self, parameters: Parameters) -> Array:
        """Other parameters without a derivative."""
        found = np.zeros(len(parameters.names), dtype=bool)
        for n in range(len(self._run)):
            found |= undefined(self._run.system, self._run.stretch(n).steps, parameters)
            self._within_time(0.0)
        return found

    def _enough_changes(self, relative: Array, count: int) -> bool:
        return not self._asked and certain(relative, count, WRONG_CHANGES)

    @cached_property
    def first(self) -> Chain:
        """See `ChangedRun`, as all up to `errors_of_changes`."""
        return Chain(self._run.system, self._first)

    @property
    def span(self) -> tuple[Assembly, float]:
        return self._run.start, self._span[1]

    @property
    def t(self) -> Array:
        return np.concatenate(self._run.course.t)

    @property
    def h(self) -> Array:
        return self._h

    def weighed(self, directions: Directions) -> Array:
        weighed = WeighedChanges(self._changes_along(directions))
        self._sweep_again(weighed)
        return weighed.total

    def given(self) -> Sequence[tuple[Array, Nodes]]:
        found = GivenNodes([])
        self._sweep_again(found)
        return found.parts

    def prescribed(self) -> Array:
        return self._growth.prescribed()

    def errors_of_changes(self, random: RandomChanges, longest: float) -> Iterable[Array]:
        errors = ErrorsOfChanges(random, self._changes_along(random.directions), longest)
        self._sweep_again(errors)
        return errors.total

    def _changes_along(self, directions: Directions) -> LongChanges:
        return LongChanges(self._run, directions, self._own.event_matrices, self._within_time)

    def _sweep_again(self, watch: Watch) -> None:
        with collecting():
            LongGradient(self._run, self._responses, self._parameters).swept(self._within_time, watch)

    def _within_time(self, _: float) -> None:
        """Heed the limit of time, and show no progress."""
        if self._report is not None:
            self._report(0.0)


class EffectsOfSums(NamedTuple):
    """Effects of errors of states on sums of them, which are swept alone; see `Watch`."""

    system: System
    found: list[Array]

    def take(self, n: int, stretch: Stretch, given: Nodes, adjoints: Sequence[Array]) -> None:
        """Of a stretch."""
        self.found.append(effects_of(self.system, stretch.steps, adjoints).by_bodies)


class GivenNodes(NamedTuple):
    """Times of nodes of stretches, and gradients of responses by their states; see `Watch`."""

    parts: list[tuple[Array, Nodes]]

    def take(self, n: int, stretch: Stretch, given: Nodes, adjoints: Sequence[Array]) -> None:
        """Of a stretch: of nodes that have any."""
        t, states = stretch.steps.t, [getattr(given, name)[-len(stretch.steps.t) :] for name in STATES]
        rows = np.any([own.any(axis=(1, 2)) for own in states], axis=0)
        q, v, a, lam = (own[rows] for own in states)
        self.parts.append((t[rows], Nodes(q, v, a, lam, given.shift)))


class WeighedChanges:
    """Changes of responses with changes of the parameters, during a sweep; see `Watch`.

    Attributes
    ----------
    total : (k, n)
    """

    def __init__(self, changes: LongChanges) -> None:
        self._changes = changes
        self.total: Array = np.zeros((1, 1))

    def take(self, n: int, stretch: Stretch, given: Nodes, adjoints: Sequence[Array]) -> None:
        """Of a stretch: of its nodes, and of the times at which the stretches between its events begin."""
        own = self._changes.of(n, stretch)
        for name in STATES:
            changes = np.concatenate([getattr(nodes, name) for nodes in own.nodes])
            by = getattr(given, name)[-len(changes) :]
            self.total = self.total + np.tensordot(by, changes, axes=([0, 1], [0, 1]))
        self.total = self.total + given.shift[: len(own.shifts)].T @ np.array(own.shifts)


class ErrorsOfSteps:
    """Errors of responses by all steps, during a sweep; see `Watch`.

    Attributes
    ----------
    total : (k,)
    """

    def __init__(self, system: System) -> None:
        self._system = system
        self.total: Array = np.zeros(1)

    def take(self, n: int, stretch: Stretch, given: Nodes, adjoints: Sequence[Array]) -> None:
        """Of a stretch."""
        self.total = self.total + errors_of_steps(self._system, stretch.steps, adjoints)


class ErrorsOfChanges:
    """Errors of random changes of the parameters, during a sweep; see `Watch`.

    Attributes
    ----------
    total : (changes, k)
    """

    def __init__(self, random: RandomChanges, changes: LongChanges, longest: float) -> None:
        self._random, self._changes, self._longest = random, changes, longest
        self.total: Array = np.zeros(1)

    def take(self, n: int, stretch: Stretch, given: Nodes, adjoints: Sequence[Array]) -> None:
        """Of a stretch."""
        system, small, own = self._changes.run.system, self._changes.small, self._changes.of(n, stretch).nodes
        for one in zip(stretches(stretch.steps), adjoints, own, strict=True):
            own_errors = partial(errors_of_changes, system, *one, self._random, small, self._longest)
            self.total = self.total + np.array([*map(own_errors, range(len(self._random.each)))])
