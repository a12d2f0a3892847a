"""A long run of which some states are stored: its intervals are simulated again on request.

A stepper goes on from a state that it gave with the same numbers, so that the steps taken again are those of the run,
bit by bit. Events are not looked for again: where they were, and what the motion went on with, is stored.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ...algebra import Array
from ...defaults import ATOL
from ...results import Assembly, EventStep, Segments, StepsTaken, Trajectory
from ...results.motion.steps import first_of, last_of, led
from ...system import System
from ..dynamics.integrators.differentiable import differentiable
from ..dynamics.recipe import Recipe, events_of
from ..dynamics.simulation import arguments_of
from ..dynamics.stepping.nodes import Nodes
from ..dynamics.stepping.stepper import KeepingStepper, RunFailure
from ..dynamics.time_loop.time_loop import CROWD, TimeLoop
from ..position.initial_state import start_of
from .sampling.sampling import HIGH, LINEAR, LOW, late
from .sampling.segments import Course

# Steps of an interval at first
FIRST = 1600
# What a step takes at the most, as multiples of the state's size: itself, twice; gradients for each response
STEP, GRADIENT = 20, 10
# Of `simulate`, on which steps depend, with their defaults
OPTIONS: dict[str, Any] = {
    "method": None, "rtol": None, "atol": ATOL, "max_step": np.inf, "first_step": None, "events": (),
    "breakpoints": (), "corners": None,
}  # fmt: skip
OBJECTS = 2000  # bytes of an event, besides its numbers


def recipe_with_steps(system: System, start: Assembly, until: float, **options: Any) -> Recipe:
    """A run whose steps are stored, by some options of `simulate`."""
    given = {**OPTIONS, **options}
    given |= {"method": differentiable(given["method"]), "events": events_of(given["events"])}
    stored = {"t_eval": [until], "dense_output": False, "store_steps": True, "max_steps": None}
    return Recipe.of(system, start, {**given, **stored, "until": until})


def repeated_recipe(run: Trajectory) -> Recipe:
    """A run that stored no steps, as it is repeated.

    Raises
    ------
    ValueError
        If it is not known how it was computed.
    """
    system, arguments = run.system, arguments_of(run)
    if system is None or arguments is None or arguments.get("controllers"):
        raise ValueError(
            f"{run.name}: memory= repeats a run of simulate, without controllers, in the process that computed it or "
            "from its folder. Use simulate(..., store_steps=True)."
        )
    options = {name: arguments[name] for name in OPTIONS}
    return recipe_with_steps(system, start_of(system, arguments["start"]), arguments["until"], **options)


class Place(NamedTuple):
    """Position of a checkpoint: number of events, and of steps since the last event."""

    segment: int
    step: int


@dataclass(frozen=True)
class Checkpoint:
    """Data from which a stepper continues.

    Attributes
    ----------
    state : of the stepper
    place : in the run
    count : steps of the run before it
    lead : the last steps before it; None at the start and after an event
    """

    state: dict[str, Array]
    place: Place
    count: int
    lead: StepsTaken | None

    @cached_property
    def nbytes(self) -> int:
        """Memory that it takes."""
        return sum(x.nbytes for x in self.state.values()) + (self.lead.nbytes if self.lead else 0)


class Restart(NamedTuple):
    """A state from which the motion goes on, what elements remember there, and how long the first step is at most."""

    t: float
    q: Array
    v: Array
    memory: Array
    longest: float


@dataclass(frozen=True, eq=False)
class Interval:
    """The steps of a run between two checkpoints.

    Attributes
    ----------
    steps : `Segments` in a run with events, also where there is none between the checkpoints
    lead : the last steps before, see `Checkpoint`
    sampled : its steps, led by those between which states that depend on its nodes are interpolated, too
    first : number of events before
    """

    steps: StepsTaken | Segments
    lead: StepsTaken | None
    sampled: StepsTaken | Segments
    first: int


class LongRun(TimeLoop):
    """A run of which only checkpoints and the events are stored.

    Half of the memory is for checkpoints and events: where they need more, every second checkpoint is dropped, and
    intervals become twice as long. The other half is for the steps of one interval.

    Parameters
    ----------
    recipe : of the run, whose steps are stored
    memory : [bytes]
    responses : how many are differentiated
    progress : called with the time reached

    Attributes
    ----------
    start : of the simulation
    precise, rtol : see `StepsTaken`
    course : the nodes, and the events that change velocities or end the run
    late : the last steps before a checkpoint within which states depend on nodes behind it

    Raises
    ------
    ValueError
        Where the memory is too small.
    RunFailure
        Where the end is not reached.
    """

    stepper: KeepingStepper

    def __init__(
        self,
        recipe: Recipe,
        memory: float,
        responses: int,
        progress: Callable[[float], None] | None = None,
    ) -> None:
        system, start = recipe.system, recipe.start
        stepper = recipe.method.stepper(system, start, recipe.settings)
        super().__init__(system, stepper, replace(recipe.plan, progress=progress))
        self._half = memory / 2
        self._per_step = 8 * (system.nq + system.m) * (STEP + GRADIENT * responses)
        self._first = self._every = max(1, min(FIRST, int(self._half / self._per_step)))
        self.start, self.precise = start, not self.stepper.apart
        self.rtol = float(recipe.settings.tolerances.rtol_q.max())
        self._lead: StepsTaken | None = None
        self._points: list[Checkpoint] = []
        self._begins: list[Restart] = []
        self._times: list[list[Array]] = []
        self._place, self._count = Place(-1, 0), 0
        self.go(start)
        self._free_memory()
        times = self._times if self._place.step else self._times[:-1]  # an event may be at the very end
        self.course = Course([np.concatenate(t) for t in times], self._event_steps)
        self.late = late(HIGH if self.precise else LOW if self._event_steps else LINEAR)

    def __len__(self) -> int:
        """Number of intervals."""
        return len(self._points)

    def go(self, start: Assembly, state: Mapping[str, Array] | None = None) -> Trajectory:
        """See `TimeLoop`; what does not reach the end is no run.

        Raises
        ------
        RunFailure
        """
        run = super().go(start, state)
        if run.status == "stopped":
            raise KeyboardInterrupt
        if not run.success:
            raise RunFailure(run.status, run.message)
        return run

    @property
    def portion(self) -> int:
        """See `TimeLoop`; checkpoints lie between two portions."""
        return min(super().portion, self._first)

    def begin(self, n: int) -> Place:
        """Return where a section begins, or where the last one ends; at an event, the place after it."""
        if n == len(self):
            return Place(len(self.course.t), 0)
        place, course = self._points[n].place, self.course
        over = place.segment < len(course.event_steps) and place.step == len(course.t[place.segment]) - 1
        return Place(place.segment + 1, 0) if over else place

    def interval(self, n: int) -> Interval:
        """The steps between two checkpoints, taken again."""
        point, (first, step), (last, end) = self._points[n], self.begin(n), self.begin(n + 1)
        self._resume_steps(point.state)
        segments = []
        for p in range(first, last + (end > 0)):
            if p > point.place.segment:
                self._begin_again(self._begins[p])
            to = end if p == last else len(self.course.t[p]) - 1
            segments.append(self._again(to - (step if p == first else 0)))
        return self.joined(segments, self.course.event_steps[first:last], self.lead(n), first)

    def joined(
        self,
        segments: Sequence[StepsTaken],
        event_steps: Sequence[EventStep],
        lead: StepsTaken | None,
        first: int,
    ) -> Interval:
        """An interval of its steps between events, of the events, and of the steps before it."""
        known = lead if self.late else None
        if not self.course.event_steps:
            return Interval(segments[0], lead, led(known, segments[0]), first)
        until = float(segments[-1].t[-1])
        steps = Segments(segments=tuple(segments), event_steps=tuple(event_steps), until=until)
        return Interval(steps, lead, replace(steps, segments=(led(known, segments[0]), *segments[1:])), first)

    def lead(self, n: int) -> StepsTaken | None:
        """The last steps before an interval; None where it begins the run or follows an event."""
        return self._points[n].lead if self.begin(n).step else None

    def _begin_again(self, begin: Restart) -> None:
        """Start as the motion continued after an event."""
        self.stepper.b[self.system.memory_places] = begin.memory
        self.stepper.restart(begin.t, begin.q, begin.v, self.plan.until)
        self.stepper.shorten(begin.longest)

    def _again(self, count: int) -> StepsTaken:
        """The next steps, taken in the same portions as the first time, and up to the same corners.

        Raises
        ------
        RunFailure
            Where there are fewer steps than the first time.
        """
        taken = 0
        while taken < count:
            ends = _ends(self._advance(self._stop())[0])
            if not len(ends) and self.stepper.t >= self.plan.until:
                raise RunFailure(
                    "not repeated",
                    f"{self.system.name}: the steps between checkpoints were not the same a second time. Store all "
                    "steps with store_steps=True, and use sensitivity.",
                )
            taken += len(ends)
        return first_of(self.stepper.steps(), count)

    def _begin(self, t: float, q: Array, v: Array, event: bool = False, longest: float = np.inf) -> None:
        memory = self.stepper.b[self.system.memory_places]
        self._begins.append(Restart(t, q.copy(), v.copy(), memory.copy(), longest))
        self._times.append([np.array([t])])
        self._place, self._lead = Place(self._place.segment + 1, 0), None
        super()._begin(t, q, v, event, longest)

    def _segment(self) -> tuple[str, str]:
        if not self._points or self._count - self._points[-1].count + self.portion > self._every:
            self._mark()
        return super()._segment()

    def _take(self, nodes: Nodes) -> None:
        super()._take(nodes)
        self._note(_ends(nodes))

    def _note(self, t: Array) -> None:
        """The ends of further steps."""
        self._times[-1].append(t)
        self._place = self._place._replace(step=self._place.step + len(t))
        self._count += len(t)

    def _cut(self, steps: StepsTaken, event_step: EventStep) -> None:
        if not self._place.step:  # an event at once: there is one step at least
            self._note(np.array([event_step.t]))
        self._event_steps.append(event_step)

    def _mark(self) -> None:
        """A checkpoint; the stored steps before it are forgotten."""
        stepper, steps = self.stepper, self.stepper.steps()
        if len(steps):
            self._lead = last_of(led(self._lead, steps), (HIGH if self.precise else LOW) - 2)
        stepper.forget()
        stepper.tally.history.clear()
        del self.watches.records[:-CROWD]
        state = {name: np.array(x) for name, x in self._state_of_steps().items()}
        self._points.append(Checkpoint(state, self._place, self._count, self._lead))
        self._free_memory()

    def _free_memory(self) -> None:
        counts = [*(point.count for point in self._points), self._count]
        steps = self._per_step * int(max(np.diff(counts)))
        if steps > self._half:
            raise self._too_little(2 * steps)
        while self._stored > self._half:
            if 2 * steps > self._half or len(self) == 1:
                raise self._too_little(2 * self._stored + 2 * steps)
            self._points, self._every, steps = self._points[::2], 2 * self._every, 2 * steps

    @property
    def _stored(self) -> int:
        """Memory of checkpoints and events [bytes]."""
        numbers = 5 * self.system.nq + len(self.system.memory_places)
        return sum(point.nbytes for point in self._points) + len(self._event_steps) * (8 * numbers + OBJECTS)

    def _too_little(self, wanted: float) -> ValueError:
        return ValueError(
            f"memory={2 * self._half:.3g} bytes are too few at t = {self.stepper.t:.6g} s of {self.plan.until:.6g} s; "
            f"give more than memory={wanted:.2g}"
        )


def _ends(nodes: Nodes) -> Array:
    """The ends of the steps between nodes: one with other velocities after new pivots is there twice. [s]"""
    return nodes.t[1:][np.diff(nodes.t) > 0]
