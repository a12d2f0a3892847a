"""Gradients of a long run in little memory: states are stored now and then, the steps between them are taken again.

Twice the steps of the run, and memory for one interval of them besides the checkpoints; see `LongRun`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any, TypeAlias

import numpy as np

from ...algebra import Array
from ...defaults import ATOL
from ...linalg.threads import one_thread_if_small
from ...model.announcement import reports_warnings
from ...outputs.recording import Angles
from ...results import Gradient, Segments, StepsTaken
from ...system import System
from ..dynamics import Event
from ..dynamics.events.events import restitutions_of
from ..dynamics.integrators.differentiable import Differentiable
from ..dynamics.recipe import Recipe, refuse_end
from ..dynamics.stepping.tolerance import Absolute, Given
from ..equilibria.settled_derivatives import derivatives_of
from ..position.initial_state import Start, start_of
from ..progress import Progress
from .accuracy.estimate import effects_of, estimates
from .chain.chain import FIELDS, Nodes
from .combined import Composite
from .events.first_order import EventDerivatives
from .gradients import Wanted, by_parameters, gradient_of, within
from .long_run import Interval, LongRun, recipe_with_steps
from .parameters.parameters import Design, Parameters
from .parameters.singular_start import undefined
from .responses.evaluation import DirectTerms, Evaluation, about_extreme, placed
from .responses.panels import ABOUT, Steps
from .responses.responses import (
    At,
    AtEvent,
    ExtremeValue,
    Final,
    Integral,
    Response,
    distinct_titles,
    of_whole_run,
)
from .responses.undefined import refuse_undefined
from .run_chain import BackSweep, segment_chains
from .sampling.sampling import Sampling, angles_of
from .sampling.segments import Instants

LINEAR = (Final, At, AtEvent)  # responses whose derivatives need no other samples


@dataclass(frozen=True, eq=False)
class PartOf(Response):
    """The part of a whole response that some samples have, with given weights, and derivatives by their times.

    Attributes
    ----------
    by, by_t : weights, and derivatives by times
    vanish : not zero for weights that are zero only at this output
    """

    by: Array = field(default_factory=lambda: np.zeros(0))
    by_t: Array = field(default_factory=lambda: np.zeros(0))
    vanish: Array = field(default_factory=lambda: np.zeros(0))
    whole: Response | None = None

    @property
    def pointwise(self) -> bool:
        return self.whole is None or self.whole.pointwise

    def value(self, g: Array, t: Array) -> float:
        return float(self.by @ g)

    def weights(self, g: Array, t: Array) -> Array:
        return self.by

    def vanishing_weights(self, g: Array, t: Array, weights: Array) -> Array:
        return np.asarray(self.vanish != 0.0)

    def by_times(self, g: Array, t: Array) -> Array:
        return self.by_t


Weights: TypeAlias = tuple[Array, Array, Array]  # by, by_t and vanish of all samples of a response


def _weights(response: Response, g: Array, t: Array) -> Weights:
    weights = np.asarray(response.weights(g, t))
    return (
        weights,
        np.asarray(response.by_times(g, t)),
        response.vanishing_weights(g, t, weights).astype(float),
    )


class Samples:
    """Sample times of a response of a long run.

    Parameters
    ----------
    run : LongRun
    where : all times
    """

    def __init__(self, run: LongRun, where: Instants) -> None:
        self._run, self.where = run, where

    @cached_property
    def _rows(self) -> list[Array]:
        """Return the times in each section."""
        t, segment, _ = self.where
        interval = np.full(len(t), -1)
        for p, step in map(self._run.begin, range(len(self._run))):
            first = max(step - self._run.late, 0)
            since = self._run.course.t[p][first] if first else -np.inf
            interval += (segment > p) | ((segment == p) & (t >= since))
        order = np.argsort(interval, kind="stable")
        return np.split(order, np.searchsorted(interval[order], np.arange(1, len(self._run))))

    def rows(self, n: int) -> Array:
        """Return the times in a section."""
        return self._rows[n]

    def sampling(self, n: int, interval: Interval) -> Sampling:
        t, segment, part = (x[self.rows(n)] for x in self.where)
        return Sampling(interval.sampled, Instants(t, segment - interval.first, part))


class LongGradient:
    """The gradient of responses of a long run; integrals with twice as many, reported samples if `halved`."""

    def __init__(
        self,
        run: LongRun,
        responses: Sequence[Response],
        parameters: Parameters,
        halved: bool = False,
    ) -> None:
        whole = [of_whole_run(run.system, response) for response in responses]
        pairs = [placed(run.course, response, halved) for response in whole]
        self._responses = [response for response, _ in pairs]
        self._run, self._parameters = run, parameters
        self._samples = [Samples(run, where) for _, where in pairs]
        self._initial: dict[int, Array] = {}
        self._locate([r for r, one in enumerate(self._responses) if isinstance(one, ExtremeValue)])

    def _locate(self, extremes: list[int]) -> None:
        """Sample extremes about their places, which one more pass over the run finds."""
        course, precise = self._run.course, self._run.precise
        signals = self._signals_of(extremes)
        for r in extremes:
            own: Any = self._responses[r]
            self._responses[r], panels = about_extreme(course, own, signals[r], precise)
            self._samples[r] = Samples(self._run, panels.where(Steps.of(course), ABOUT))

    def _evaluation(
        self, n: int, interval: Interval, angles: Angles, weights: Mapping[int, Weights]
    ) -> tuple[list[int], Evaluation]:
        """The responses that have samples in an interval, with their weights there."""
        present = [r for r in weights if len(self._samples[r].rows(n))]
        shares = list[Response]()
        for r in present:
            response, samples = self._responses[r], self._samples[r]
            by, by_t, vanish = (x[samples.rows(n)] for x in weights[r])
            shares.append(
                PartOf(
                    response.of, response.title, by=by, by_t=by_t, vanish=vanish, whole=response,
                    reported=response.reported,
                )
            )  # fmt: skip
        samplings = [self._samples[r].sampling(n, interval) for r in present]
        return present, Evaluation(
            self._run.system, interval.sampled, shares, self._parameters, angles, samplings
        )

    def _angles(self, n: int, interval: Interval) -> Angles:
        if not n:
            return angles_of(self._run.system, interval.sampled)
        states = Sampling(interval.sampled).states
        return Angles(self._run.system, states, partial(self._first_angles, n))

    def _first_angles(self, n: int) -> Array:
        """The joints' coordinates where an interval begins, with all revolutions; this may need one more pass."""
        if n not in self._initial:
            for before in range(len(self._run) - 1):
                self._count_on(before, self._angles(before, self._run.interval(before)))
        return self._initial[n]

    def _count_on(self, n: int, angles: Angles) -> None:
        """Note the joints' coordinates where the next interval begins."""
        self._initial[n + 1] = angles.values[-1 - self._leading(n + 1)].copy()

    def _leading(self, n: int) -> int:
        """Return the number of leading nodes of a section."""
        lead = self._run.lead(n) if self._run.late and n < len(self._run) else None
        return len(lead) if lead else 0

    @cached_property
    def _signals(self) -> list[Array]:
        """The outputs of responses at their samples, or zero if their weights do not depend on them."""
        known = LINEAR if self._run.course.event_steps else (*LINEAR, Integral)
        return self._signals_of([r for r, one in enumerate(self._responses) if not isinstance(one, known)])

    def _signals_of(self, which: Sequence[int]) -> list[Array]:
        """The outputs of some responses at their samples, of others zero, from the intervals in which these are."""
        found = [np.zeros(len(samples.where.t)) for samples in self._samples]
        for n in range(len(self._run)):
            if not any(len(self._samples[r].rows(n)) for r in which):
                continue
            interval = self._run.interval(n)
            angles = self._angles(n, interval)
            weights = {r: (found[r], found[r], found[r]) for r in which}
            present, evaluation = self._evaluation(n, interval, angles, weights)
            if "values" in vars(angles):  # they were asked for
                self._count_on(n, angles)
            for r, signal in zip(present, evaluation.signals, strict=True):
                found[r][self._samples[r].rows(n)] = signal
        return found

    def _rule_errors(self, values: Array) -> Array:
        """The sampling errors of all responses (k,) with their values; see `Evaluation.rule_error`."""
        errors = np.zeros(len(values))
        which = [
            r for r, one in enumerate(self._responses) if not (one.pointwise or isinstance(one, ExtremeValue))
        ]
        if which:
            finer = LongGradient(
                self._run, [self._responses[r] for r in which], self._parameters, halved=True
            )
            each = zip(
                which, finer._responses, finer._signals_of(range(len(which))), finer._samples, strict=True
            )
            for r, one, g, samples in each:
                errors[r] = values[r] - one.value(g, samples.where.t)
        return errors

    def gradient(self, titled: Sequence[Response], report: Callable[[float], None], error: bool) -> Gradient:
        """Values and derivatives of all responses, by a sweep backward over the run, and errors of the values.

        Parameters
        ----------
        titled : the responses as the user gave them
        report : called with the time to which the sweep has come back
        """
        run, parameters, k = self._run, self._parameters, len(self._responses)
        whole = list(zip(self._responses, self._signals, self._samples, strict=True))
        weights = {r: _weights(one, g, samples.where.t) for r, (one, g, samples) in enumerate(whole)}
        total, adjoints = Totals.zeros(run.system, parameters, k), list[Array]()
        back = BackSweep(run.system, k, parameters.c_size, adjoints if error else None)
        for n in reversed(range(len(run))):
            interval = run.interval(n)
            self._over(n, interval, weights, total, back)
            if error:
                total.effects[:] += effects_of(run.system, interval.steps, adjoints[::-1]).sums
                adjoints.clear()
            report(run.plan.until * n / len(run))
        for r, (response, g, samples) in enumerate(whole):
            if not isinstance(response, (*LINEAR, Integral)):
                total.values[r] = response.value(g, samples.where.t)
        titles = distinct_titles(response.title for response in self._responses)
        refuse_undefined(titles, total.values)
        assembly = derivatives_of(run.system, run.start)
        matrix = by_parameters(
            back.gradients(assembly), parameters, DirectTerms(total.b, total.c, total.named)
        )
        rules = self._rule_errors(total.values) if error else np.zeros(k)
        errors = estimates(titles, total.values, total.effects, rules) if error else ()
        return gradient_of(
            titled, parameters, run.start, assembly, total.values, matrix, total.missing, errors
        )

    def _over(
        self, n: int, interval: Interval, weights: Mapping[int, Weights], total: Totals, back: BackSweep
    ) -> None:
        """Sweep backward over one interval, and add its contributions."""
        run, angles = self._run, self._angles(n, interval)
        present, evaluation = self._evaluation(n, interval, angles, weights)
        total.values[present] += evaluation.values
        total.missing[:] |= undefined(run.system, interval.steps, self._parameters)
        nodes = self._given(interval.sampled, present, evaluation, total)
        del evaluation  # before the buffers of the sweep are allocated
        chains = segment_chains(run.system, interval.steps, interval.first)
        events = len(interval.steps.event_steps) if isinstance(interval.steps, Segments) else 0

        def through(p: int, bars: Array) -> Array:
            assert isinstance(interval.steps, Segments)
            event_step, names = interval.steps.event_steps[p], self._parameters.of_run
            own = EventDerivatives(run.system, chains[p].steps, event_step, names, angles)
            return np.asarray(own.matrix.T @ bars)

        back.over(chains, nodes, events, through, lead=interval.lead)

    def _given(
        self, steps: StepsTaken | Segments, present: list[int], evaluation: Evaluation, total: Totals
    ) -> Nodes:
        """The gradients by the states of an interval, a column for each response; what is explicit is added up."""
        if not present:
            return Nodes.zeros(steps, len(self._responses))
        nodes, explicit = evaluation.gradients()
        if len(present) < len(self._responses):
            found, nodes = nodes, Nodes.zeros(steps, len(self._responses))
            for kind in FIELDS:
                getattr(nodes, kind)[..., present] = getattr(found, kind)
        total.b[:, present] += explicit.b
        total.c[:, present] += explicit.c
        for r, own in zip(present, explicit.named, strict=True):
            for name, value in own.items():
                total.named[r][name] = total.named[r].get(name, 0.0) + value
        return nodes


@dataclass(frozen=True)
class Totals:
    """Sums over all intervals.

    Attributes
    ----------
    b, c, named : what responses depend on by themselves, see `DirectTerms`
    values : of the responses
    missing : true for parameters without a derivative
    effects : of defects and round-off on the values, see `Effects.sums`
    """

    b: Array
    c: Array
    named: list[dict[str, float]]
    values: Array
    missing: Array
    effects: Array

    @classmethod
    def zeros(cls, system: System, parameters: Parameters, k: int) -> Totals:
        """Nothing yet of k responses."""
        return cls(
            np.zeros((len(system.b), k)),
            np.zeros((parameters.c_size, k)),
            [{} for _ in range(k)],
            np.zeros(k),
            np.zeros(len(parameters.names), dtype=bool),
            np.zeros((3, k)),
        )


def repeated_gradient(
    recipe: Recipe,
    responses: Sequence[Response],
    parameters: Parameters,
    memory: float,
    *,
    progress: Callable[[float], None],
    error: bool = False,
) -> Gradient:
    """Values and derivatives of responses of a run that is computed twice, with limited memory [bytes].

    `progress` is called with the simulated time, forwards and backwards; it goes to twice the end.

    Raises
    ------
    ValueError
        Where the memory is too small.
    RunFailure
        Where the end is not reached.
    """
    until = recipe.plan.until
    run = LongRun(recipe, memory, len(responses), progress)
    sweep = LongGradient(run, responses, parameters)
    return sweep.gradient(responses, lambda t: progress(2 * until - t), error)


@reports_warnings
@one_thread_if_small
def simulated_gradient(
    system: System,
    responses: Wanted,
    wrt: Sequence[str] | None = None,
    *,
    until: float,
    start: Start | None = None,
    method: Differentiable | None = None,
    rtol: Given | None = None,
    atol: Absolute = ATOL,
    max_step: float = np.inf,
    events: Event | Sequence[Event] = (),
    memory: float = 100e6,
    design: Mapping[str, float] | None = None,
    formula: Design | None = None,
    progress: bool | Progress | None = None,
    time_limit: float | None = None,
    error: bool = False,
    strict: bool = False,
) -> Gradient:
    """Simulate and compute a gradient with limited memory; `sensitivity` of a run with `memory` does the same.

    Parameters
    ----------
    system, until, start, method, rtol, atol, max_step, events : as for `simulate`
    responses, wrt, design, formula, error : as for `sensitivity`
    memory : for stored states, events, and the steps between two stored states [bytes]
    progress : True for a bar on standard error, or a function of the simulated time, forwards and backwards: it goes to
        twice `until`
    time_limit : seconds of the clock after which the analysis is given up
    strict : raise the first warning as a `StrictError`

    Raises
    ------
    ValueError
        For an end time that is none, where the memory is too small, and where the run does not reach its end or not
        within the time limit.
    """
    begin = start_of(system, start, "sensitivity_by_checkpoints")
    refuse_end(until, begin.t)
    if not begin.success:
        raise ValueError(f"derivatives need a start that is assembled, but {system.name}: {begin.message}")
    recipe = recipe_with_steps(
        system, begin, until, method=method, rtol=rtol, atol=atol, max_step=max_step, events=events
    )
    restitutions, outer = restitutions_of(recipe.plan.events), Composite(responses)
    parameters = Parameters(
        system, wrt, design=design, formula=formula, start=begin, restitutions=restitutions
    )
    with within(system.name, progress, 2 * until, "differentiated", " s", time_limit) as report:
        found = repeated_gradient(recipe, outer.parts, parameters, memory, progress=report, error=error)
    return outer.gradient(found, system)
