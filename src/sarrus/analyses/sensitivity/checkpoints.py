"""The gradient of a long run in little memory: states are kept now and then, the steps between them are taken again.

A stepper goes on from a state that it gave with the same numbers, so that the steps taken again are those of the run,
bit by bit. Twice the steps, and memory for one stretch of them besides the checkpoints.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from ...algebra import Array
from ...results import Assembly, Gradient, Steps
from ...system import System
from ..assembly import assemble
from ..dynamics import HHT, GeneralizedAlpha
from ..dynamics.breakpoints import stops_of
from ..dynamics.stepper import Settings
from ..dynamics.tolerance import Given, Tolerances
from .chain import Chain, Gradients, Nodes, through
from .derivatives import Wanted, as_responses, own_parts
from .evaluation import Evaluation, Explicit
from .parameters import Parameters
from .responses import At, Final, Integral, Response
from .sweep import Sweep
from .sweep_loop import Given as Ends

LINEAR = (Final, At, Integral)  # responses whose weights do not depend on the motion


def sensitivity_by_checkpoints(
    system: System,
    responses: Wanted,
    wrt: Sequence[str] | None = None,
    *,
    until: float,
    start: Assembly | None = None,
    method: HHT | GeneralizedAlpha | None = None,
    rtol: Given = 1e-6,
    atol: Given = 1e-8,
    max_step: float = np.inf,
    every: int = 400,
) -> Gradient:
    """Simulate and differentiate with the memory of some states: see `simulate` and `sensitivity`, whose result it is.

    Parameters
    ----------
    system, until, start, method, rtol, atol, max_step : as for `simulate`
    responses, wrt : as for `sensitivity`; angles of joints with their turns are not among the outputs
    every : a state is kept after so many steps

    Raises
    ------
    ValueError
        For a model whose tables or functions have numbers, for angles of joints, and where the run does not reach its
        end.
    """
    begin = assemble(system) if start is None else start
    settings = Settings(Tolerances.of(system, rtol, atol), max_step, keep_steps=True)
    run = LongRun(system, begin, method or HHT(), settings, until, every)
    parameters = Parameters(system, wrt, start=begin)
    return LongGradient(run, as_responses(responses), parameters).gradient()


@dataclass(frozen=True)
class Checkpoint:
    """What a stepper needs to go on, how far it may go, and the step before."""

    state: dict[str, Array]
    stop: float
    before: float


class LongRun:
    """A run of which only checkpoints are kept; its stretches are simulated again as they are asked for.

    Attributes
    ----------
    t : (n + 1,) start, then the end of each step [s]
    ends : the nodes at which stretches begin, and the last one
    """

    def __init__(
        self, system: System, start: Assembly, method: Any, settings: Settings, until: float, every: int
    ) -> None:
        self.system, self._every = system, every
        self._stepper = method.stepper(system, start, settings)
        self._points: list[Checkpoint] = []
        stops = [*stops_of(system, np.zeros(0), until)[0], until]
        times, before = [np.zeros(1)], 0.0
        self._stepper.restart(0.0, start.q, start.v, until)
        while self._stepper.t < until:
            state = {name: np.array(x) for name, x in self._stepper.state().items()}
            stop = next(stop for stop in stops if stop > self._stepper.t)
            nodes = self._stepper.advance(stop, every)
            if len(nodes.t) > 1:
                self._points.append(Checkpoint(state, stop, before))
                times.append(nodes.t[1:])
                before = float(self._stepper.steps().h[-1])
            self._stepper.forget()
        self.t = np.concatenate(times)
        self.ends = np.cumsum([0, *(len(x) for x in times[1:])])

    def __len__(self) -> int:
        """Number of stretches."""
        return len(self._points)

    def stretch(self, n: int) -> tuple[Steps, float]:
        """The steps of a stretch, and the length of the one before them (0 at the start)."""
        point = self._points[n]
        self._stepper.resume(point.state)
        self._stepper.advance(point.stop, self._every)
        steps = self._stepper.steps()
        assert isinstance(steps, Steps)
        return steps, point.before


@dataclass(frozen=True, eq=False)
class Share(Response):
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
        if parameters.in_curves:
            raise ValueError("numbers of tables and functions need all steps: simulate(..., keep_steps=True)")
        self._run, self._responses, self._parameters = run, responses, parameters
        self._times = [response.times(run.t) for response in responses]

    def _samples(self, r: int) -> Array:
        times = self._times[r]
        return self._run.t if times is None else times

    def _slice(self, r: int, n: int) -> Array:
        """Which samples of a response lie in a stretch."""
        first, last = self._run.t[self._run.ends[n]], self._run.t[self._run.ends[n + 1]]
        t = self._samples(r)
        after = t > first if n else np.full(len(t), True)
        return np.flatnonzero(after & ((t <= last) | (n == len(self._run) - 1)))

    def _evaluation(self, n: int, steps: Steps, weights: Sequence[Array]) -> tuple[list[int], Evaluation]:
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
                shares.append(Share(response.of, response.name, None if times is None else times[own], by))
        return present, Evaluation(self._run.system, steps, shares, self._parameters, NO_TURNS)

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
        sweep: Sweep | None = None
        held: Nodes | None = None
        for n in reversed(range(len(run))):
            steps, before = run.stretch(n)
            present, evaluation = self._evaluation(n, steps, weights)
            nodes = self._given(steps, present, evaluation, total)
            values[present] += evaluation.values
            if held is not None:
                for kind in Ends._fields:
                    getattr(nodes, kind)[-1] += getattr(held, kind)[0]
            steps = _led(steps, before) if n else steps
            if sweep is None:
                sweep = Sweep(run.system, steps, k)
                bars = sweep.bars()
            sweep.over(steps)
            sweep.backward(bars, nodes.after_start(), 1 if n else 0, len(steps))
            held = nodes
        assert held is not None
        for r, response in enumerate(self._responses):
            if not isinstance(response, LINEAR):
                values[r] = response.value(self._signals[r], self._samples(r))
        chain = Chain(run.system, steps)
        by_q, by_v, by_b = chain.through_start(held, bars)
        b, q, v = through(chain.assembly, by_q, by_v)
        by = Gradients(by_b + b, q, v)
        matrix = parameters.gradient(replace(by, b=by.b + total.b), total.c + by.c).T
        told = Explicit(total.b, total.c, total.named)
        titles = tuple(response.title for response in self._responses)
        return Gradient(
            titles, tuple(parameters.names), values, parameters.values, matrix + own_parts(told, parameters)
        )

    def _given(self, steps: Steps, present: list[int], evaluation: Evaluation, total: Totals) -> Nodes:
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


class _NoTurns:
    """In place of the nodes of a whole run, at which turns are counted."""

    def __getattr__(self, name: str) -> Any:
        raise ValueError("angles of joints count turns along all steps: simulate(..., keep_steps=True)")


NO_TURNS: Any = _NoTurns()


def _led(steps: Steps, before: float) -> Steps:
    """Steps with one before them, of which nothing but its length is told."""
    doubled: dict[str, Any] = {
        name: _doubled(getattr(steps, name)) for name in ("t", "q", "v", "a", "x", "lam", "memory")
    }
    left_out = _doubled(steps.left_out) if len(steps.left_out) else steps.left_out
    h, removed = np.concatenate([[before], steps.h]), np.concatenate([[0.0], steps.removed])
    return replace(steps, left_out=left_out, h=h, removed=removed, **doubled)


def _doubled(rows: Array) -> Array:
    """The first row twice."""
    return np.concatenate([rows[:1], rows])
