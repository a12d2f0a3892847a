"""Gradients of a long run in little memory: states are stored now and then, the steps between them are taken again.

Twice the steps of the run, and memory for one interval of them besides the checkpoints; see `LongRun`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from ...algebra import Array
from ...outputs.recording import Angles
from ...results import Gradient
from ..dynamics.recipe import Recipe
from ..equilibria.settled_derivatives import derivatives_of
from .chain.chain import FIELDS, Nodes
from .gradients import by_parameters, gradient_of
from .long_run import Interval, LongRun
from .parameters.contradictions import undefined
from .parameters.parameters import Parameters
from .responses.evaluation import DirectTerms, Evaluation, Where, placed
from .responses.panels import Panels
from .responses.responses import ExtremeValue, Response, distinct_titles, of_whole_run
from .responses.undefined import refuse_undefined
from .run_chain import BackSweep, RunChain
from .sampling.sampling import Sampling, angles_of
from .sampling.segments import Instants


class Sums(NamedTuple):
    """Sums over all intervals.

    Attributes
    ----------
    b, c, named : what responses depend on by themselves, see `DirectTerms`
    values : of the responses
    missing : true for parameters without a derivative
    """

    b: Array
    c: Array
    named: list[dict[str, float]]
    values: Array
    missing: Array

    @classmethod
    def zeros(cls, parameters: Parameters, k: int) -> Sums:
        """Nothing yet of k responses."""
        sizes = (len(parameters.system.b), k), (parameters.c_size, k)
        b, c, values = (np.zeros(size) for size in (*sizes, k))
        missing = np.zeros(len(parameters.names), dtype=bool)
        return cls(b, c, [{} for _ in range(k)], values, missing)


class LongGradient:
    """The gradient of responses of a long run, from the parts that they have in its intervals.

    Responses are sums over time, or extremes, whose intervals one more pass over the run finds.

    Raises
    ------
    ValueError
        For other responses.
    """

    def __init__(self, run: LongRun, responses: Sequence[Response], parameters: Parameters) -> None:
        self._run, self._parameters = run, parameters
        self._responses = [of_whole_run(run.system, response) for response in responses]
        self._where = [placed(run.course, response) for response in self._responses]
        self._initial: dict[int, Array] = {}
        for one in self._responses:
            if not (one.additive or isinstance(one, ExtremeValue)):
                raise ValueError(
                    f"{one.title}: memory= needs responses that are sums over time, see `Response.additive`. Use "
                    "simulate(..., store='steps')."
                )
        self._interval_of = self._located()

    def _located(self) -> dict[int, int]:
        """The intervals of extremes, by number of the response."""
        extremes = {r: one for r, one in enumerate(self._responses) if isinstance(one, ExtremeValue)}
        every = list(extremes.values())
        outermost = np.tile([-np.inf * one.sign for one in every], (len(self._run), 1))
        for n in range(len(self._run) if every else 0):
            interval = self._run.interval(n)
            angles, own = self._angles(n, interval), Panels.some(interval.own)
            if len(own.step):
                outermost[n] = self._evaluation(interval, every, [own] * len(every), angles).outermost
            if "values" in vars(angles):  # they were asked for
                self._count_on(n, angles)
        return {r: one.outermost(g) for (r, one), g in zip(extremes.items(), outermost.T, strict=True)}

    def _evaluation(
        self, interval: Interval, responses: Sequence[Response], where: Sequence[Where], angles: Angles
    ) -> Evaluation:
        return Evaluation(self._run.system, interval.sampled, responses, self._parameters, angles, where)

    def _parts(self, n: int, interval: Interval) -> list[tuple[int, Response, Where]]:
        """The responses with samples in an interval: their numbers, their parts, and where these are sampled."""
        found, panels = list[tuple[int, Response, Where]](), Panels.some(interval.own)
        for r, (response, where) in enumerate(zip(self._responses, self._where, strict=True)):
            if isinstance(where, Instants):
                rows = self._run.holds(n, where)
                t, segment, part = (x[rows] for x in where)
                if len(t):
                    found.append((r, response.part(rows), Instants(t, segment - interval.first, part)))
            elif len(panels.step) and self._interval_of.get(r, n) == n:
                found.append((r, response, panels))
        return found

    def _angles(self, n: int, interval: Interval) -> Angles:
        if not n:
            return angles_of(self._run.system, interval.sampled)
        return Angles(self._run.system, Sampling(interval.sampled), partial(self._first_angles, n))

    def _first_angles(self, n: int) -> Array:
        """The joints' coordinates where an interval begins, with all revolutions; this may need one more pass."""
        if n not in self._initial:
            for before in range(len(self._run) - 1):
                self._count_on(before, self._angles(before, self._run.interval(before)))
        return self._initial[n]

    def _count_on(self, n: int, angles: Angles) -> None:
        """Note the joints' coordinates where the next interval begins, with the steps that lead it."""
        lead = self._run.lead(n + 1) if n + 1 < len(self._run) else None
        self._initial[n + 1] = angles.values[-1 - (len(lead) if lead else 0)].copy()

    def gradient(self, titled: Sequence[Response], report: Callable[[float], None]) -> Gradient:
        """Values and derivatives of all responses, by a sweep backward over the run.

        Parameters
        ----------
        titled : the responses as the user gave them
        report : called with the time to which the sweep has come back
        """
        run, parameters, k = self._run, self._parameters, len(self._responses)
        total, back = Sums.zeros(parameters, k), BackSweep(run.system, k, parameters.c_size)
        for n in reversed(range(len(run))):
            interval = run.interval(n)
            angles = self._angles(n, interval)
            total.missing[:] |= undefined(run.system, interval.steps, parameters)
            nodes = self._gradients(n, interval, angles, total)
            chain = RunChain(run.system, interval.steps, parameters.of_run, interval.first, angles)
            chain.over(back, nodes, interval.lead)
            report(run.plan.until * n / len(run))
        titles = distinct_titles(response.title for response in self._responses)
        refuse_undefined(titles, total.values)
        explicit = DirectTerms(total.b, total.c, total.named)
        matrix = by_parameters(back.gradients(derivatives_of(run.system, run.start)), parameters, explicit)
        return gradient_of(titled, parameters, total.values, matrix, total.missing)

    def _gradients(self, n: int, interval: Interval, angles: Angles, total: Sums) -> Nodes:
        """The gradients by the states of an interval, a column for each response; all others are added up."""
        nodes, found = Nodes.zeros(interval.sampled, len(self._responses)), self._parts(n, interval)
        if not found:
            return nodes
        numbers, parts, where = map(list, zip(*found, strict=True))
        evaluation = self._evaluation(interval, parts, where, angles)
        total.values[numbers] += evaluation.values
        by_nodes, explicit = evaluation.gradients()
        for kind in FIELDS:
            getattr(nodes, kind)[..., numbers] = getattr(by_nodes, kind)
        total.b[:, numbers] += explicit.b
        total.c[:, numbers] += explicit.c
        for r, own in zip(numbers, explicit.named, strict=True):
            for name, value in own.items():
                total.named[r][name] = total.named[r].get(name, 0.0) + value
        return nodes


def repeated_gradient(
    recipe: Recipe,
    responses: Sequence[Response],
    parameters: Parameters,
    memory: float,
    *,
    progress: Callable[[float], None],
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
    return sweep.gradient(responses, lambda t: progress(2 * until - t))
