"""A long run of which some states are stored: its intervals are simulated again on request.

A stepper goes on from a state that it gave with the same numbers, so that the steps taken again are those of the run,
bit by bit. Events are not looked for again: where they were, and what the motion went on with, is stored.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...algebra import Array
from ...results import Assembly, EventStep, Segments, StepsTaken, Trajectory
from ...results.motion.steps import first_of, last_of, led
from ...system import System
from ..dynamics.integrators.differentiable import Differentiable, differentiable
from ..dynamics.recipe import Recipe
from ..dynamics.run_options import Events
from ..dynamics.simulation import arguments_of
from ..dynamics.stepping.nodes import Nodes
from ..dynamics.stepping.stepper import KeepingStepper, RunFailure, arrays_of, below
from ..dynamics.time_loop.switches import Hit
from ..dynamics.time_loop.time_loop import TimeLoop
from ..position.initial_state import start_of
from .sampling.sampling import HIGH, LOW
from .sampling.segments import Course, Instants

# Steps of an interval at first
FIRST = 1600
# What a step takes at the most, as multiples of the state's size: itself, twice; gradients for each response
STEP, GRADIENT = 20, 10
OBJECTS = 2000  # bytes of an event, besides its numbers
# The last steps before a checkpoint with nodes behind it about them, or an extreme between both; those that must be
# known with these. Of methods of order two, of Radau
LATE = {False: LOW - 2, True: HIGH - 2 - (HIGH - 2) // 2}
LEAD = {False: LOW - 1, True: HIGH - 1}


def recipe_with_steps(
    system: System, start: Assembly, until: float, method: Differentiable | None = None, events: Events = ()
) -> Recipe:
    """A run whose steps are stored, but not its motion at any time, by options of `simulate`."""
    given = {"until": until, "t_eval": [until], "method": differentiable(method), "events": events}
    recipe = Recipe.of(system, start, {**given, "store": "steps", "limits": None})
    return replace(recipe, plan=replace(recipe.plan, dense=False))


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
            "from its folder. Use simulate(..., store='steps')."
        )
    begin, options = start_of(system, arguments["start"]), (arguments["method"], arguments["events"])
    return recipe_with_steps(system, begin, arguments["until"], *options)


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


@dataclass(frozen=True, eq=False)
class Interval:
    """The steps of a run between two checkpoints.

    Attributes
    ----------
    steps : `Segments` in a run with events, also where there is none between the checkpoints
    lead : the last steps before, see `Checkpoint`
    sampled : its steps, led by those between which states that depend on its nodes are interpolated, too
    own : the steps of these in which this interval has samples
    first : number of events before
    """

    steps: StepsTaken | Segments
    lead: StepsTaken | None
    sampled: StepsTaken | Segments
    own: slice
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
        self._begins: list[tuple[Hit, Array]] = []
        self._times: list[list[Array]] = []
        self._place, self._count = Place(-1, 0), 0
        self.go(start)
        self._free_memory()
        times = self._times if self._place.step else self._times[:-1]  # an event may be at the very end
        self.course = Course([np.concatenate(t) for t in times], self.recording.event_steps)
        self._counts = np.cumsum([0, *(len(t) - 1 for t in self.course.t)])

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
        self.stepper.resume(below("method", point.state))
        self.switches.resume(below("switches", point.state))
        segments = []
        for p in range(first, last + (end > 0)):
            if p > point.place.segment:
                self._begin_again(*self._begins[p])
            to = end if p == last else len(self.course.t[p]) - 1
            segments.append(self._again(to - (step if p == first else 0)))
        lead = self.lead(n)
        before = self._number(Place(first, step)) - (len(lead) if lead else 0)  # steps of the run
        own = slice(*(self._number(self._since(k)) - before for k in (n, n + 1)))
        whole = led(lead, segments[0])
        if not self.course.event_steps:
            return Interval(segments[0], lead, whole, own, first)
        until, event_steps = float(segments[-1].t[-1]), tuple(self.course.event_steps[first:last])
        steps = Segments(segments=tuple(segments), event_steps=event_steps, until=until)
        return Interval(steps, lead, replace(steps, segments=(whole, *segments[1:])), own, first)

    def _number(self, place: Place) -> int:
        """The number of steps before a place."""
        return int(self._counts[place.segment]) + place.step

    def _since(self, n: int) -> Place:
        """The first step with samples in an interval: about those of the last steps before it are nodes of it, too."""
        place = self.begin(n)
        return place._replace(step=max(place.step - LATE[self.precise], 0))

    def holds(self, n: int, times: Instants) -> Array:
        """Which times an interval has (nt,)."""
        behind = []
        for segment, step in (self._since(n), self._since(n + 1)):
            since = self.course.t[segment][step] if step else -np.inf
            behind.append((times.segment > segment) | ((times.segment == segment) & (times.t >= since)))
        return np.asarray(behind[0] & ~behind[1])

    def lead(self, n: int) -> StepsTaken | None:
        """The last steps before an interval; None where it begins the run or follows an event."""
        return self._points[n].lead if self.begin(n).step else None

    def _begin_again(self, hit: Hit, memory: Array) -> None:
        """Start as the motion continued after an event, with what elements remembered there."""
        self.stepper.b[self.system.memory_places] = memory
        self.stepper.restart(hit.t, hit.q, hit.v, self.plan.until)
        self.stepper.shorten(hit.longest)

    def _again(self, count: int) -> StepsTaken:
        """The next steps, taken in the same portions as the first time, and up to the same corners.

        Raises
        ------
        RunFailure
            Where there are fewer steps than the first time.
        """
        taken = 0
        while taken < count:
            ends = _ends(super()._advance(self._stop())[0])
            if not len(ends) and self.stepper.t >= self.plan.until:
                raise RunFailure(
                    "not repeated",
                    f"{self.system.name}: the steps between checkpoints were not the same a second time. Store all "
                    "steps with store='steps', and use sensitivity.",
                )
            taken += len(ends)
        return first_of(self.stepper.steps(), count)

    def _begin(self, hit: Hit) -> None:
        memory = self.stepper.b[self.system.memory_places]
        begin = Hit(hit.t, hit.q.copy(), hit.v.copy(), longest=hit.longest)
        self._begins.append((begin, memory.copy()))
        self._times.append([np.array([hit.t])])
        self._place, self._lead = Place(self._place.segment + 1, 0), None
        super()._begin(hit)

    def _advance(self, stop: float) -> tuple[Nodes, Hit | None]:
        if not self._points or self._count - self._points[-1].count + self.portion > self._every:
            self._mark()
        return super()._advance(stop)

    def _take(self, nodes: Nodes) -> None:
        super()._take(nodes)
        self._note(_ends(nodes))

    def _note(self, t: Array) -> None:
        """The ends of further steps."""
        self._times[-1].append(t)
        self._place = self._place._replace(step=self._place.step + len(t))
        self._count += len(t)

    def _cut(self, event_step: EventStep) -> None:
        if not self._place.step:  # an event at once: there is one step at least
            self._note(np.array([event_step.t]))
        self.recording.event_steps.append(event_step)

    def _mark(self) -> None:
        """A checkpoint; the stored steps before it are forgotten."""
        stepper, steps = self.stepper, self.stepper.steps()
        if len(steps):
            self._lead = last_of(led(self._lead, steps), LEAD[self.precise])
        stepper.forget()
        stepper.tally.history.clear()
        self.watches.records.clear()
        state = arrays_of({"method": stepper, "switches": self.switches})
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
        return sum(point.nbytes for point in self._points) + len(self.recording.event_steps) * (
            8 * numbers + OBJECTS
        )

    def _too_little(self, wanted: float) -> ValueError:
        return ValueError(
            f"memory={2 * self._half:.3g} bytes are too few at t = {self.stepper.t:.6g} s of {self.plan.until:.6g} s; "
            f"give more than memory={wanted:.2g}"
        )


def _ends(nodes: Nodes) -> Array:
    """The ends of the steps between nodes: one with other velocities after new pivots is there twice. [s]"""
    return nodes.t[1:][np.diff(nodes.t) > 0]
