"""The gradient of a long run in little memory: states are stored now and then, the steps between them are taken again.

Twice the steps of the run, and memory for one stretch of them besides the checkpoints; see `LongRun`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import TypeAlias

import numpy as np

from ...algebra import Array
from ...defaults import ATOL
from ...linalg.threads import one_thread_if_small
from ...model.announcement import announce, reports_warnings
from ...outputs.recording import Angles
from ...results import Assembly, Gradient, Pieces, StepsTaken
from ...system import System
from ..dynamics import Event
from ..dynamics.events.events import restitutions_of
from ..dynamics.simulation import Differentiable, differentiable, refuse_end, rtol_of
from ..dynamics.stepping.stepper import RunFailure, Settings
from ..dynamics.stepping.tolerance import Absolute, Given, Tolerances
from ..equations.length import extent
from ..equilibria.settled_derivatives import derivatives_of
from ..position.initial_state import Start, start_of
from ..progress import Progress, TimeLimit, monitor
from .accuracy.estimate import Effects, effects_of
from .accuracy.growth import FEW, Growth
from .accuracy.state_errors import SUMS, RandomSums, of_derivatives
from .chain.chain import FIELDS, Gradients, Nodes, by_joints, through
from .chain.stretches import Stretches
from .corners import corners
from .derivatives import Wanted, as_responses, own_parts
from .events.first_order import EventDerivatives
from .events.piece_chain import Backward
from .long_run import LongRun, Stretch
from .parameters.parameters import Design, Parameters
from .parameters.singular_start import singular_start
from .parameters.undefined import undefined
from .responses.evaluation import Evaluation, Explicit, where_of
from .responses.responses import At, AtEvent, Final, Integral, Response, distinct_titles, of_whole_run
from .responses.undefined import refuse_undefined
from .responses.within_steps import fine
from .sampling.pieces import PieceSampling, Where, angles_of, sampling_of
from .sampling.sampling import Sampling

# What a step takes at the most, as multiples of the state's size: itself, twice; gradients for each response
STEP, GRADIENT = 20, 10
LINEAR = (
    Final,
    At,
    AtEvent,
)  # responses whose derivatives need no other samples


@reports_warnings
@one_thread_if_small
def sensitivity_by_checkpoints(
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
    strict: bool = False,
) -> Gradient:
    """Simulate and compute a gradient with limited memory, by checkpoints; see `simulate` and `sensitivity`.

    Parameters
    ----------
    system, until, start, method, rtol, atol, max_step, events : as for `simulate`
    responses, wrt, design, formula : as for `sensitivity`
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
    watched = [events] if isinstance(events, Event) else list(events)
    if not begin.success:
        raise ValueError(f"derivatives need a start that is assembled, but {system.name}: {begin.message}")
    parameters = Parameters(
        system, wrt, design=design, formula=formula, start=begin, restitutions=restitutions_of(watched)
    )
    try:
        with monitor(progress, 2 * until, done="differentiated", time_limit=time_limit) as report:
            back = partial(_backwards, report, 2 * until)
            task = LongTask(begin, until, method, rtol, atol, max_step, watched, memory, report, back)
            return task.gradient(system, as_responses(responses), parameters)
    except (RunFailure, TimeLimit) as error:
        message = error.message if isinstance(error, RunFailure) else error
        raise ValueError(
            f"derivatives need a run that reached its end, but {system.name}: {message}"
        ) from None


def _backwards(report: Progress, whole: float, t: float) -> None:
    """Progress of the sweep, which has come back to a time."""
    report(whole - t)


@dataclass(frozen=True, eq=False)
class LongTask:
    """Options of the simulation of a long run, with the memory; see `sensitivity_by_checkpoints`.

    Attributes
    ----------
    progress, back : called with the time reached forwards, and then backwards
    """

    start: Assembly
    until: float
    method: Differentiable | None
    rtol: Given | None
    atol: Absolute
    max_step: float
    events: Sequence[Event]
    memory: float
    progress: Callable[[float], None] | None = None
    back: Callable[[float], None] | None = None

    def gradient(self, system: System, responses: Sequence[Response], parameters: Parameters) -> Gradient:
        """Values and derivatives of responses.

        Raises
        ------
        RunFailure
            Where the end is not reached.
        """
        per_step = 8 * (system.nq + system.m) * (STEP + GRADIENT * len(responses))
        method = differentiable(self.method)
        tolerances = Tolerances.of(system, rtol_of(method, self.rtol), self.atol)
        settings = Settings(tolerances, self.max_step, store_steps=True)
        message = (self.start, method, settings, self.until, self.memory, per_step)
        run = LongRun(system, *message, self.events, self.progress)
        wanted = [fine(response) for response in responses] if run.precise else responses
        return LongGradient(run, wanted, parameters).gradient(self.back)


COARSE = (
    "its output changes faster than the steps, and more samples are not taken within them unless the states of the run "
    "are stored. Use simulate(..., store_steps=True) and sensitivity(), or a smaller max_step"
)


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
    response : the whole

    Attributes
    ----------
    where : all times
    """

    def __init__(self, run: LongRun, response: Response) -> None:
        self._run, self.where = run, where_of(run.course, response)
        self._at_nodes = not run.late and response.times(run.course.times) is None

    @cached_property
    def _rows(self) -> list[Array]:
        """Return the times in each section."""
        t, piece, _ = self.where
        stretch = np.full(len(t), -1)
        for p, step in map(self._run.begin, range(len(self._run))):
            first = max(step - self._run.late, 0)
            since = self._run.course.t[p][first] if first else -np.inf
            stretch += (piece > p) | ((piece == p) & (t >= since))
        order = np.argsort(stretch, kind="stable")
        return np.split(order, np.searchsorted(stretch[order], np.arange(1, len(self._run))))

    def rows(self, n: int) -> Array:
        """Return the times in a section."""
        return self._rows[n]

    def sampling(self, n: int, stretch: Stretch) -> Sampling:
        """The states there."""
        t, piece, part = (x[self.rows(n)] for x in self.where)
        if isinstance(stretch.sampled, Pieces):
            return PieceSampling(stretch.sampled, Where(t, piece - stretch.first, part))
        return Sampling(stretch.sampled, None if self._at_nodes else t)

    def padded(self, n: int, values: Array) -> Array:
        """The values at the samples of a stretch, and nothing where the next one begins."""
        own = values[self.rows(n)]
        more = len(self._run) - 1 > n and self._at_nodes
        return np.append(own, 0.0) if more else own


class LongGradient:
    """The gradient of responses of a long run."""

    def __init__(self, run: LongRun, responses: Sequence[Response], parameters: Parameters) -> None:
        self._responses = [of_whole_run(run.system, response) for response in responses]
        self._run, self._parameters = run, parameters
        self._samples = [Samples(run, response) for response in self._responses]
        self._initial: dict[int, Array] = {}
        self._growth, self._adjoints = Growth(), list[Array]()
        self._coarseness = np.zeros((len(responses), 2))

    def _evaluation(
        self, n: int, stretch: Stretch, angles: Angles, weights: Sequence[Weights]
    ) -> tuple[list[int], Evaluation]:
        """The responses that have samples in a stretch, with their weights there."""
        present = [r for r, samples in enumerate(self._samples) if len(samples.rows(n))]
        shares = list[Response]()
        for r in present:
            response, samples = self._responses[r], self._samples[r]
            by, by_t, vanish = (samples.padded(n, x) for x in weights[r])
            shares.append(
                PartOf(response.of, response.title, by=by, by_t=by_t, vanish=vanish, whole=response)
            )
        samplings = [self._samples[r].sampling(n, stretch) for r in present]
        return present, Evaluation(
            self._run.system, stretch.sampled, shares, self._parameters, angles, samplings
        )

    def _angles(self, n: int, stretch: Stretch) -> Angles:
        if not n:
            return angles_of(self._run.system, stretch.sampled)
        states = sampling_of(stretch.sampled).states
        return Angles(self._run.system, states, partial(self._first_angles, n))

    def _first_angles(self, n: int) -> Array:
        """The joints' coordinates where a stretch begins, with all revolutions; this may need one more pass."""
        if n not in self._initial:
            for before in range(len(self._run) - 1):
                self._count_on(before, self._angles(before, self._run.stretch(before)))
        return self._initial[n]

    def _count_on(self, n: int, angles: Angles) -> None:
        """Note the joints' coordinates where the next stretch begins."""
        self._initial[n + 1] = angles.values[-1 - self._leading(n + 1)].copy()

    def _leading(self, n: int) -> int:
        """Return the number of leading nodes of a section."""
        lead = self._run.lead(n) if self._run.late and n < len(self._run) else None
        return len(lead) if lead else 0

    @cached_property
    def _signals(self) -> list[Array]:
        """The outputs of responses at their samples, from one more pass over the run; zero where nobody asks."""
        found = [np.zeros(len(samples.where.t)) for samples in self._samples]
        known = LINEAR if self._run.course.event_steps else (*LINEAR, Integral)
        if all(isinstance(response, known) for response in self._responses):
            return found
        for n in range(len(self._run)):
            stretch = self._run.stretch(n)
            angles = self._angles(n, stretch)
            present, evaluation = self._evaluation(n, stretch, angles, [(x, x, x) for x in found])
            if "values" in vars(angles):  # they were asked for
                self._count_on(n, angles)
            for r, signal in zip(present, evaluation.signals, strict=True):
                own = self._samples[r].rows(n)
                found[r][own] = signal[: len(own)]
        return found

    def gradient(self, report: Callable[[float], None] | None = None) -> Gradient:
        """Values and derivatives of all responses."""
        run, parameters, k = self._run, self._parameters, len(self._responses)
        whole = list(zip(self._responses, self._signals, self._samples, strict=True))
        weights = [_weights(one, g, samples.where.t) for one, g, samples in whole]
        total = Totals.zeros(run.system, parameters, k)
        back = Backward(run.system, Stretches(run.system, k, self._adjoints), k, parameters.c_size)
        for n in reversed(range(len(run))):
            self._over(n, weights, total, back)
            if report is not None:
                report(run.plan.until * n / len(run))
        values, missing = total.values, total.missing
        for r, (response, g, samples) in enumerate(whole):
            if not isinstance(response, (*LINEAR, Integral)):
                values[r] = response.value(g, samples.where.t)
        titles = distinct_titles(response.title for response in self._responses)
        refuse_undefined(titles, values)
        if not np.all(self._growth.digits(run.rtol, run.precise) >= FEW):
            announce(self._growth.warnings_of_errors(titles, self._errors_of_states(report)))
        pairs = zip(titles, self._coarseness, strict=True)
        announce([f"{title}: {COARSE}" for title, (error, allowed) in pairs if error > allowed])
        assembly = derivatives_of(run.system, run.start)
        announce(singular_start(parameters, run.start, assembly, missing))
        b, q, v, c = through(assembly, back.q, back.v)
        by = Gradients(back.b + b, q, v, by_joints(back.c, c))
        matrix = parameters.gradient(replace(by, b=by.b + total.b), total.c + by.c).T
        matrix = matrix + own_parts(Explicit(total.b, total.c, total.named), parameters)
        matrix[:, missing] = np.nan
        return Gradient(
            titles, tuple(parameters.names), values, parameters.values, matrix, units=parameters.units,
            response_units=tuple(one.unit(run.system) for one in self._responses),
        )  # fmt: skip

    def _errors_of_states(self, report: Callable[[float], None] | None) -> tuple[float, float]:
        """The relative error of derivatives, see `of_derivatives`, by one more sweep, with sums of states."""
        run, adjoints, effects = self._run, list[Array](), list[Effects]()
        sums = RandomSums.of(
            (run.start.t, float(run.course.t[-1][-1])), self._growth.sizes(), extent(run.system, run.start.q)
        )
        back = Backward(run.system, Stretches(run.system, SUMS, adjoints), SUMS, self._parameters.c_size)
        for n in reversed(range(len(run))):
            stretch = run.stretch(n)
            given, event_step = (
                sums.by_states(stretch.steps),
                partial(self._event_step, stretch, self._angles(n, stretch)),
            )
            back.over(stretch.steps, given, event_step, lead=stretch.lead, first=stretch.first)
            effects.append(effects_of(run.system, stretch.steps, adjoints[::-1]))
            adjoints.clear()
            if report is not None:
                report(0.0)  # time limit
        shares = np.concatenate([one.shares.sum(axis=0, keepdims=True) for one in effects])
        return of_derivatives(Effects(shares, np.linalg.norm([one.noise for one in effects], axis=0)))

    def _over(self, n: int, weights: Sequence[Weights], total: Totals, back: Backward) -> None:
        """Sweep backward over one section, and add its contributions."""
        stretch = self._run.stretch(n)
        announce(corners(self._run.system, stretch.steps))
        angles = self._angles(n, stretch)
        present, evaluation = self._evaluation(n, stretch, angles, weights)
        for k, r in enumerate(present):
            if isinstance(self._responses[r], Integral):
                self._coarseness[r] += evaluation.coarseness(k)
            if not self._responses[r].pointwise and evaluation.is_interpolated_badly(k):
                self._coarseness[r, 0] = np.inf
        total.values[present] += evaluation.values
        total.missing[:] |= undefined(self._run.system, stretch.steps, self._parameters)
        nodes = self._given(stretch.sampled, present, evaluation, total)
        del evaluation  # before the buffers of the sweep are allocated
        event_step = partial(self._event_step, stretch, angles)
        back.over(stretch.steps, nodes, event_step, lead=stretch.lead, first=stretch.first)
        self._growth.take(stretch.steps, nodes, self._adjoints)
        self._adjoints.clear()

    def _event_step(self, stretch: Stretch, angles: Angles, p: int) -> Array:
        """The matrix of an event in a stretch."""
        assert isinstance(stretch.steps, Pieces)
        pieces, names = stretch.steps, list(self._parameters.restitutions)
        return EventDerivatives(
            self._run.system, pieces.pieces[p], pieces.event_steps[p], names, angles
        ).matrix

    def _given(
        self, steps: StepsTaken | Pieces, present: list[int], evaluation: Evaluation, total: Totals
    ) -> Nodes:
        """The gradients by the states of a stretch, a column for each response; what is explicit is added up."""
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
    """Sums over all sections.

    Attributes
    ----------
    b, c, named : what responses depend on by themselves, see `Explicit`
    values : of the responses
    missing : true for parameters without a derivative
    """

    b: Array
    c: Array
    named: list[dict[str, float]]
    values: Array
    missing: Array

    @classmethod
    def zeros(cls, system: System, parameters: Parameters, k: int) -> Totals:
        """Nothing yet of k responses."""
        return cls(
            np.zeros((len(system.b), k)),
            np.zeros((parameters.c_size, k)),
            [{} for _ in range(k)],
            np.zeros(k),
            np.zeros(len(parameters.names), dtype=bool),
        )
