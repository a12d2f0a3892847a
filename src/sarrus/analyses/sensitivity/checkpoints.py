"""The gradient of a long run in little memory: states are kept now and then, the steps between them are taken again.

Twice the steps of the run, and memory for one stretch of them besides the checkpoints; see `LongRun`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np

from ...algebra import Array
from ...results import Assembly, Gradient, StepsTaken
from ...system import System
from ..assembly import assemble
from ..assembly_derivatives import AssemblyDerivatives
from ..dynamics import HHT, GeneralizedAlpha, Radau
from ..dynamics.simulation import refuse_end
from ..dynamics.stepper import Settings, Trouble
from ..dynamics.tolerance import Given, Tolerances
from .chain import Gradients, Nodes, through
from .derivatives import Wanted, as_responses, own_parts
from .evaluation import Evaluation, Explicit
from .fine import fine
from .long_run import LongRun
from .parameters import Parameters
from .pieces import sampling_of
from .recording import Angles
from .responses import At, Final, Integral, Response
from .stretches import Stretches, stretches_of
from .sweep_loop import Given as Ends
from .undefined import undefined

# What a step takes at the most, as multiples of the state's size: itself, twice; gradients for each response
STEP, GRADIENT = 20, 6
LINEAR = (Final, At, Integral)  # responses whose weights do not depend on the motion


def sensitivity_by_checkpoints(
    system: System,
    responses: Wanted,
    wrt: Sequence[str] | None = None,
    *,
    until: float,
    start: Assembly | None = None,
    method: HHT | GeneralizedAlpha | Radau | None = None,
    rtol: Given = 1e-6,
    atol: Given = 1e-8,
    max_step: float = np.inf,
    memory: float = 100e6,
) -> Gradient:
    """Simulate and differentiate with the memory of some states: see `simulate` and `sensitivity`, whose result it is.

    Parameters
    ----------
    system, until, start, method, rtol, atol, max_step : as for `simulate`
    responses, wrt : as for `sensitivity`
    memory : for kept states and the steps between two of them [bytes]

    Raises
    ------
    ValueError
        For an end time that is none, where the memory is too small, and where the run does not reach its end.

    Notes
    -----
    Multipliers between nodes of Radau are interpolated within a stretch; at its ends they differ a little from those
    of a run that keeps all steps.
    """
    refuse_end(until)
    wanted, begin = as_responses(responses), assemble(system) if start is None else start
    settings = Settings(Tolerances.of(system, rtol, atol), max_step, keep_steps=True)
    per_step = 8 * (system.nq + system.m) * (STEP + GRADIENT * len(wanted))
    if not begin.success:
        raise ValueError(f"derivatives need a start that is assembled, but {system.name}: {begin.message}")
    try:
        run = LongRun(system, begin, method or HHT(), settings, until, memory, per_step)
    except Trouble as trouble:
        told = f"derivatives need a run that reached its end, but {system.name}: {trouble.sentence}"
        raise ValueError(told) from None
    if isinstance(method, Radau):
        wanted = [fine(response) for response in wanted]
    return LongGradient(run, wanted, Parameters(system, wrt, start=begin)).gradient()


@dataclass(frozen=True, eq=False)
class PartOf(Response):
    """The part of a response that some samples have, with given weights."""

    at: Array | None = None
    by: Array = field(default_factory=lambda: np.zeros(0))

    def times(self, t: Array) -> Array | None:
        return self.at

    def value(self, g: Array, t: Array) -> float:
        return float(self.by @ g)

    def weights(self, g: Array, t: Array) -> Array:
        return self.by


class LongGradient:
    """The gradient of responses of a long run."""

    def __init__(self, run: LongRun, responses: Sequence[Response], parameters: Parameters) -> None:
        self._run, self._responses, self._parameters = run, responses, parameters
        self._times, self._ends = [response.times(run.t) for response in responses], run.ends

    def _samples(self, r: int) -> Array:
        times = self._times[r]
        return self._run.t if times is None else times

    def _slice(self, r: int, n: int) -> Array:
        """Which samples of a response lie in a stretch."""
        first, last = self._run.t[self._ends[n]], self._run.t[self._ends[n + 1]]
        t = self._samples(r)
        after = t > first if n else np.full(len(t), True)
        return np.flatnonzero(after & ((t <= last) | (n == len(self._run) - 1)))

    def _evaluation(
        self, n: int, steps: StepsTaken, weights: Sequence[Array]
    ) -> tuple[list[int], Evaluation]:
        """The responses that have samples in a stretch, with their weights there."""
        present, shares = [], list[Response]()
        for r, response in enumerate(self._responses):
            own, times = self._slice(r, n), self._times[r]
            if len(own):
                by = (
                    weights[r][own]
                    if times is not None or n == 0
                    else np.concatenate([[0.0], weights[r][own]])
                )
                present.append(r)
                shares.append(PartOf(response.of, response.name, None if times is None else times[own], by))
        return present, Evaluation(self._run.system, steps, shares, self._parameters, self._angles(n, steps))

    def _angles(self, n: int, steps: StepsTaken) -> Angles:
        return Angles(self._run.system, sampling_of(steps).states, lambda: self._first_angles[n])

    @cached_property
    def _first_angles(self) -> list[Array]:
        """The joints' coordinates where stretches begin, with all turns, from one more pass over the run."""
        found: list[Array] = []
        last: Callable[[], Array] | None = None
        for n in range(len(self._run)):
            values = Angles(self._run.system, sampling_of(self._run.stretch(n)[0]).states, last).values
            found.append(values[0])
            last = partial(np.array, values[-1])
        return found

    @cached_property
    def _signals(self) -> list[Array]:
        """The outputs of responses at their samples, from one more pass over the run; zero where nobody asks."""
        found = [np.zeros(len(self._samples(r))) for r in range(len(self._responses))]
        if all(isinstance(response, LINEAR) for response in self._responses):
            return found
        for n in range(len(self._run)):
            steps, _ = self._run.stretch(n)
            present, evaluation = self._evaluation(n, steps, found)
            for r, signal in zip(present, evaluation.signals, strict=True):
                own = self._slice(r, n)
                found[r][own] = signal[-len(own) :]
        return found

    def gradient(self) -> Gradient:
        """Values and derivatives of all responses."""
        run, parameters, k = self._run, self._parameters, len(self._responses)
        weights = [
            np.asarray(response.weights(self._signals[r], self._samples(r)))
            for r, response in enumerate(self._responses)
        ]
        values, total = np.zeros(k), Totals.zeros(run.system, parameters, k)
        missing = np.zeros(len(parameters.names), dtype=bool)
        back: Stretches | None = None
        for n in reversed(range(len(run))):
            steps, before = run.stretch(n)
            present, evaluation = self._evaluation(n, steps, weights)
            nodes = self._given(steps, present, evaluation, total)
            values[present] += evaluation.values
            missing |= undefined(run.system, steps, parameters)
            back = back or stretches_of(run.system, steps, k)
            back.over(steps, before, nodes)
        assert back is not None
        for r, response in enumerate(self._responses):
            if not isinstance(response, LINEAR):
                values[r] = response.value(self._signals[r], self._samples(r))
        by_q, by_v, by_b = back.by_start()
        b, q, v = through(AssemblyDerivatives(run.system, steps.start), by_q, by_v)
        by = Gradients(by_b + b, q, v)
        matrix = parameters.gradient(replace(by, b=by.b + total.b), total.c + by.c).T
        matrix = matrix + own_parts(Explicit(total.b, total.c, total.named), parameters)
        matrix[:, missing] = np.nan
        titles = tuple(response.title for response in self._responses)
        return Gradient(titles, tuple(parameters.names), values, parameters.values, matrix)

    def _given(self, steps: StepsTaken, present: list[int], evaluation: Evaluation, total: Totals) -> Nodes:
        """The gradients by the states of a stretch, a column for each response; what is explicit is added up."""
        nodes = Nodes.zeros(steps, len(self._responses))
        if not present:
            return nodes
        found, explicit = evaluation.gradients()
        for kind in Ends._fields:
            getattr(nodes, kind)[:, :, present] = getattr(found, kind)
        total.b[:, present] += explicit.b
        total.c[:, present] += explicit.c
        for r, own in zip(present, explicit.named, strict=True):
            for name, value in own.items():
                total.named[r][name] = total.named[r].get(name, 0.0) + value
        return nodes


@dataclass(frozen=True)
class Totals:
    """What responses depend on by themselves, added up over all stretches."""

    b: Array
    c: Array
    named: list[dict[str, float]]

    @classmethod
    def zeros(cls, system: System, parameters: Parameters, k: int) -> Totals:
        """Nothing yet of k responses."""
        return cls(
            np.zeros((len(system.b), k)),
            np.zeros((parameters.c_size, k)),
            [{} for _ in range(k)],
        )
