"""The time integration loop from start to end, for any method: breakpoints, events, outputs, failures."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from ....algebra import Array
from ....model.announcement import announce, collected, is_strict
from ....results import Assembly, EventRecord, NoSolution, Solution, State, Trajectory, load_run
from ....results.motion.steps import EventStep, Segments, StepsTaken, segments_from_store, segments_to_store
from ....results.motion.steps import until as steps_until
from ....results.saving.checked_file import NOT_SAVED, NoSavedDataError, NotSavedError
from ....results.saving.saved import COUNTS, UNFINISHED, Store
from ....system import System
from ...equations.block_matrix import PlacedMatrix
from ...equations.table_ranges import announce_left_tables
from ...progress import TimeLimit
from ..dense_output.sample_loop import Samples
from ..dense_output.sampler import Sampler
from ..dense_output.winding import Winding, WindingAlong
from ..events.events import Event, Impact, Watch, Watches, restitutions_of
from ..events.force_corners import Corner
from ..stepping.nodes import Nodes, joined
from ..stepping.step_budget import SHORT, StepBudget, StepWatch, changing_fastest
from ..stepping.stepper import RunFailure, Stepper
from .energy_check import EnergyCheck
from .initial_warnings import initial_warnings, motion_jumps
from .outcome import OutputStates, nothing
from .switches import Cut, Switches

PAUSE, PATIENT = 1.0, 20.0  # s between two checkpoints at least; as a multiple of what one takes
CHUNK = 400  # steps for one call of a method
WATCHED = 40  # the same, where events are looked for
JUMP = 1e-6  # of the largest acceleration: smaller changes at a kink are none of the accelerations
STORED = {one.__name__: one for one in (StepsTaken, EventStep, Corner)}
CROWD, CROWDED = 20, 1e-6  # so many events within this part of the whole time: they accumulate


@dataclass(frozen=True)
class Plan:
    """Options of a run.

    Attributes
    ----------
    times : rising times of the states wanted [s]
    until : end [s]
    stops : rising times that are hit exactly [s]
    kinks : those of them behind which laws go on otherwise
    events : what is looked for
    dense : whether the motion is wanted at any time
    progress : called with the time reached after every chunk of steps
    store : where states are written as they are computed, instead of to memory
    budget : how many steps the run may take
    corners : whether steps end at all corners of forces, not only at those that a step passes over; None: no switches
    free : whether steps can be taken again, so that they end where a law varies; else there is a warning
    aside : how far kinks are before jumps; the method starts anew as far behind them
    behind : how long after the start a method begins that goes on from the accelerations there [s]
    stored : whether steps are stored for derivatives
    control : of sampled controllers
    """

    times: Array
    until: float
    stops: Array
    kinks: Array
    events: Sequence[Event] = ()
    dense: bool = False
    progress: Callable[[float], None] | None = None
    store: Store | None = None
    budget: StepBudget = field(default_factory=StepBudget)
    corners: bool | None = None
    free: bool = True
    aside: float = 0.0
    behind: float = 0.0
    stored: bool = False
    control: Controllers | None = None


class ControllerSample(Protocol):
    """A sample of controllers, see `sampled.control.Sample`."""

    def after(self) -> Array:
        """The velocities after it."""

    def event_step(self) -> EventStep:
        """The record of it."""


class Controllers(Protocol):
    """Sampled controllers of one run, see `sampled.control.Control`."""

    def due(self, t: float) -> Sequence[Any]:
        """Take the samples at a time, each once."""

    def sample(self, state: State, due: Sequence[Any]) -> ControllerSample:
        """Call the controllers of a sample."""

    def first_sample(self, q: Array, v: Array) -> ControllerSample:
        """Call them at the start, for derivatives."""

    def reset(self, before: Array, after: Array) -> None:
        """Take the values that an event has changed, from the velocities before and after it."""


class TimeLoop:
    """One run of a method.

    Parameters
    ----------
    system : System
    stepper : the method at work
    plan : what is wanted
    """

    def __init__(self, system: System, stepper: Stepper, plan: Plan) -> None:
        self.system, self.stepper, self.plan = system, stepper, plan
        self.sampler = sampler_of(system, stepper)
        self.outputs = OutputStates(system, sampler_of(system, stepper, self.sampler.matrix))
        # whose choices the run does not depend on, as it does not depend on when it is saved
        self._sampler_of_marks = sampler_of(system, stepper) if plan.store else self.sampler
        self._at_once = plan.store is not None or is_strict()  # outputs are computed in the run
        self.watches = Watches(system, plan.events)
        events = ((n, event, name) for n, event in enumerate(plan.events) for name in ("function", "reset"))
        self._functions = {f"{name} of event {n}": getattr(event, name) for n, event, name in events}
        self.switches = Switches(system, stepper, plan.free, plan.corners, plan.stored)
        self._failure: RunFailure | KeyboardInterrupt | TimeLimit | None = None
        self._interruption: KeyboardInterrupt | TimeLimit | None = None  # while outputs were computed
        self.energies = EnergyCheck(system, self.sampler, partial(sampler_of, system, stepper))
        self.winding = Winding(system)
        self._last: Nodes | None = None
        self._recent: Nodes | None = None
        self.step_watch = StepWatch(plan.budget, plan.until)
        self._written, self._started = 0, 0.0
        self._dense: list[Nodes] = []
        self._segments: list[Any] = []
        self._event_steps: list[EventStep] = []
        self._marked, self._pause, self._safe = time.perf_counter(), PAUSE, 0.0

    @property
    def portion(self) -> int:
        """Return the number of steps of the next call of the loop."""
        most = self.plan.budget.max_steps
        left = CHUNK if most is None else max(most - int(self.stepper.tally.nsteps), 1)
        return min(WATCHED if self.watches else CHUNK, left)

    def go(self, start: Assembly, state: Mapping[str, Array] | None = None) -> Trajectory:
        """Integrate from the start, or from a saved state, to the end; return the result also after a failure."""
        status, message, self._started = "finished", "reached the end", start.t
        self.watches.span = self.energies.span = self.plan.until - start.t
        self.watches.until = self.plan.until
        try:
            if state is None:
                self.winding.begin(start.q, start.revolutions)
                self.watches.near(self.winding.values, start.memory)
                self._begin(start.t + self.plan.behind * self.stepper.apart, start.q, start.v)
                self._first_sample(start)
                self.step_watch.begin(start.t)
                announce(initial_warnings(self.system, start, self.stepper.independence))
                announce(motion_jumps(self.system, start.t, self.plan.until))
            else:
                self._resume(state)
            self._save(force=True)
            while self.stepper.t < self.plan.until and status == "finished":
                status, message = self._segment()
                if status == "finished":  # else the end is recorded with it, and until then it is found again
                    self._save()
                    self.step_watch.look(self.stepper.t, self.stepper.tally.nsteps)
                if self.plan.progress:
                    self.plan.progress(float(self.stepper.t))
            if self._interruption:
                raise self._interruption
        except KeyboardInterrupt:
            status, message = "stopped", f"stopped by the user at t = {self.stepper.t:.6g} s"
        except TimeLimit as over:
            status, message = "time limit", f"{over} at t = {self.stepper.t:.6g} s"
        except RunFailure as error:
            status, message = error.status, error.message
        except NotSavedError as wrong:
            return self._not_saved(str(wrong))
        return self._result(status, message)

    def _begin(self, t: float, q: Array, v: Array, event: bool = False, longest: float = np.inf) -> None:
        self.stepper.restart(t, q, v, self.plan.until)
        self.stepper.shorten(longest)
        if self.watches:
            self.watches.begin(t, q, v, event)

    def _resume(self, state: Mapping[str, Array]) -> None:
        announce(json.loads(str(state["told"])).get("warnings", ()))
        self._resume_steps(state)
        self._take_pieces(state)
        self.sampler.resume(state)
        self.watches.resume(state)
        self.outputs.resume(state)
        self.energies.resume(state)
        self.winding.resume(state)
        self.step_watch.resume(state)
        self._written = int(state["written"])
        if "final_t" in state:
            self._last = Nodes(*(state[f"final_{name}"][None] for name in Nodes._fields))
        self._safe = float(self.stepper.t)
        self._take_dense(state)

    def _state_of_steps(self) -> dict[str, Array]:
        """Return the data on which the next steps depend."""
        return self.stepper.state() | self.switches.state()

    def _resume_steps(self, state: Mapping[str, Array]) -> None:
        self.stepper.resume(state)
        self.switches.resume(state)

    def _take_pieces(self, state: Mapping[str, Array]) -> None:
        steps = self.stepper.steps()
        self._segments, self._event_steps = segments_from_store(state, steps, STORED, self._functions)

    def _take_dense(self, state: Mapping[str, Array]) -> None:
        if self.plan.dense and "dense_t" in state:
            self._dense = [Nodes._make(state[f"dense_{name}"] for name in Nodes._fields)]

    def over(self, state: Mapping[str, Array], folder: Path) -> Trajectory:
        """A saved run that has come to its end, with the whole motion and the steps where they were stored."""
        self.sampler.resume(state)
        self.winding.resume(state)
        self._take_dense(state)
        if "kept_t" in state:
            self.stepper.resume(state)
            self._take_pieces(state)
        return self._opened(folder)

    def _opened(self, folder: Path) -> Trajectory:
        """The contents of the folder, and the stored steps."""
        own: dict[str, Any] = {
            "sol": self._solution(),
            "steps": self._steps(),
            "steps_folder": "",
            "call": None,
        }
        return replace(load_run(folder, self.system), restitutions=restitutions_of(self.plan.events), **own)

    def _solution(self) -> Solution | NoSolution:
        """The whole motion, where it was stored."""
        if not self._dense:
            return NoSolution()
        nodes = joined(self._dense)
        return Solution(nodes, self.sampler, WindingAlong(self.system, nodes, self.winding.first))

    def _end(self, sampler: Sampler) -> Samples:
        """The state reached, as an output; none before the first step."""
        if (last := self._last) is None:
            return sampler.capacity(np.zeros(0))
        found = sampler.state(float(last.t[0]), last.q[0], last.v[0], last.memory[0])
        found.revolutions[0] = self.system.joint_coordinates.revolutions(self.winding.values, found.q[0])
        return found

    def _is_output(self, end: Samples) -> bool:
        """Whether there is no state behind the last output."""
        written = self.plan.times[: self._written]
        return not len(end.t) or bool(np.any(written >= end.t[0]))

    def _final(self, end: Samples) -> State | None:
        """The state reached, from which another run can go on."""
        if not len(end.t):
            return None
        b, (t, q, v, a, lam) = self.stepper.b.copy(), (x[0] for x in end[:5])
        b[self.system.memory_places] = end.memory[0]
        self.system.remember(q, b, float(t))
        return State(float(t), q, v, a, lam, b[self.system.memory_places], end.revolutions[0])

    def _save(self, message: Mapping[str, Any] | None = None, force: bool = False) -> None:
        """Hand over what was computed; mark it as safe now and then, at the start, and at the end with the record."""
        store = self.plan.store
        if store is None:
            return
        for samples in self.outputs.released() or [self.sampler.capacity(np.zeros(0))]:
            store.write(samples, self.stepper.tally.steps())
            self.stepper.tally.history.clear()
        if self.outputs.waiting:  # the run was stopped while they were computed
            return
        now = time.perf_counter()
        if force or message is not None or now - self._marked > self._pause:
            state = {**self._state_of_steps(), **self.sampler.choices(), **self.watches.state()}
            state |= self.outputs.state() | self.winding.state() | self.step_watch.state()
            state |= self.energies.state() | self._dense_state()
            state |= segments_to_store(self._segments, self._event_steps, STORED, self._functions)
            state |= {
                "written": np.array(self._written),
                "told": np.array(json.dumps(message or self._record_of_state())),
            }
            end = self._end(self._sampler_of_marks if message is None else self.sampler)
            if (final := self._final(end)) is not None:
                state |= final.to_store()
            if message is None and not self._is_output(end):
                state |= {
                    "final_violation": end.violation[0],
                    "final_energy": self.sampler.energies(end)[0, :2],
                }
            (store.mark if message is None else store.finish)(state)
            self._marked, self._safe = time.perf_counter(), float(self.stepper.t)
            self._pause = max(PAUSE, PATIENT * (self._marked - now))

    def _dense_state(self) -> dict[str, Array]:
        if not self._dense:
            return {}
        self._dense = [joined(self._dense)]
        return {f"dense_{name}": array for name, array in self._dense[0]._asdict().items()}

    def _record_of_state(self) -> dict[str, Any]:
        counts = dict(zip(COUNTS, self.stepper.tally.counts().tolist(), strict=True))
        message = f"cut short; it is safe up to t = {self.stepper.t:.6g} s"
        text = {"status": "cut short", "message": message, "t": self.stepper.t}
        text |= {"singular": self.outputs.nearness.times, "warnings": collected()}
        return text | counts

    def _segment(self) -> tuple[str, str]:
        """Some steps, no further than the next stop, and the events among them."""
        stop, before = self._stop(), self.stepper.b.copy()
        nodes, cut = self._advance(stop)
        behind = [self._behind(cut)] if cut else []
        watched = joined([nodes, *behind]) if behind else nodes
        for t, watch in self.watches.crossings(watched, self.sampler) if self.watches else ():
            ended = self._happen(watched, t, watch, before, behind[0] if behind and t > nodes.t[-1] else None)
            if ended is not None:
                return ended
        self._take(nodes)
        if cut:
            self._turn_corner(cut, *behind)
        elif self.stepper.t == stop < self.plan.until:
            self._go_on(stop, nodes)
        return "finished", "reached the end"

    def _go_on(self, stop: float, nodes: Nodes) -> None:
        """Start anew behind a sample of controllers, or a kink of a law."""
        control, begin = self.plan.control, stop + 2 * self.plan.aside
        if control and (due := control.due(stop)) and (now := self._final(self._end(self.sampler))):
            sample, steps = control.sample(now, due), self.stepper.steps()
            if steps is not None:
                self._cut(steps, sample.event_step())
            self._begin(begin, now.q, sample.after())
        elif stop in self.plan.kinks:
            state = self.sampler.state(stop, nodes.q[-1], nodes.v[-1], nodes.memory[-1])
            if not self.stepper.passes_kinks or self._cut_at_jump(state, begin):
                self._begin(begin, state.q[0], state.v[0])

    def _cut_at_jump(self, before: Samples, begin: float) -> bool:
        """End the steps where accelerations jump, if the method goes on from those of its last step."""
        q, v = before.q[0].copy(), before.v[0].copy()
        if not self.stepper.apart:
            return False
        after = self.sampler.state(begin, q, v, before.memory[0])
        if not abs(after.a - before.a).max() > JUMP * max(abs(after.a).max(), abs(before.a).max()):
            return False
        if (steps := self.stepper.steps()) is not None:
            t, own = float(self.stepper.t), dict[str, Any].fromkeys(("along", "restitution", "reset"))
            step = EventStep(name="jump", t=t, function=f"t - {t!r}", **own, named=False, q=q, v=v, after=v)
            self._cut(steps, step)
        return True

    def _first_sample(self, start: Assembly) -> None:
        """The sample at the start where steps are stored, as an event there, before which derivatives need a step."""
        control, before = self.plan.control, self.stepper.b.copy()
        if not control or self.stepper.steps() is None:
            return
        begin, tally = float(self.stepper.t), self.stepper.tally
        taken, chunks = tally.nsteps, len(tally.history)
        while self.stepper.t == begin:  # a call may choose pivots only
            self.stepper.advance(self._stop(), 1)
        sample = control.first_sample(start.q, start.v)
        steps = self.stepper.steps()
        assert steps is not None
        self._cut(steps, sample.event_step())
        self.stepper.b[:], tally.nsteps = before, taken
        del tally.history[chunks:]
        self._begin(begin, start.q, sample.after())

    def _advance(self, stop: float) -> tuple[Nodes, Cut | None]:
        """Some steps, over no short part of a law, and up to the first corner of a force; calls are joined."""
        most = self.portion
        if before := self._failure or self.switches.failure:
            raise before
        parts, cut, taken = list[Nodes](), None, 0
        while taken < most and cut is None and (self.stepper.t < stop or not parts):
            try:
                nodes, cut = self.switches.advance(stop, most - taken)
            except (RunFailure, KeyboardInterrupt) as failure:
                if not parts:
                    raise
                self._failure = failure  # once the steps before it are taken
                break
            parts.append(nodes)
            taken += max(len(nodes.t) - 1, 1)  # a call may choose pivots only
        return joined(parts), cut

    def _stop(self) -> float:
        """The next time that is hit exactly."""
        ahead = self.plan.stops[self.plan.stops > self.stepper.t]
        return float(ahead[0]) if len(ahead) else self.plan.until

    def _happen(
        self, nodes: Nodes, t: float, watch: Watch, before: Array, behind: Nodes | None
    ) -> tuple[str, str] | None:
        """Execute one event; return a status and a message if it ends the run.

        At a corner of a force, the state is that behind it: the gap there is so short that velocities between its ends
        would be round-off.
        """
        watch.count, watch.at = watch.count + 1, t
        states = self.sampler.states(behind or nodes, np.array([t]))
        q, v = states.q[0], states.v[0]
        after = watch.after(t, q, v, self.sampler)
        self.watches.records.append(EventRecord(watch.name, t, q, v, after))
        ends = watch.ends or (watch.event.reset is not None and t >= self.plan.until)
        if not ends and watch.event.reset is None:
            return None
        self._take(_until(nodes, states))
        self._turn(watch, ends, t, q, v, after)
        self.stepper.b[:] = before
        rows = max(int(np.searchsorted(nodes.t, t)) - 1, 0)
        self.stepper.b[self.system.memory_places] = nodes.memory[rows]
        if ends:
            self.stepper.t = t
            return "event", f"ended by the event {watch.name} at t = {t:.9g} s"
        state = self.sampler.state(t, q, after, nodes.memory[rows])
        if self.plan.control and not isinstance(watch.event.reset, Impact):
            self.plan.control.reset(v, after)
        self._begin(t, state.q[0], state.v[0], event=True)
        return self._crowd() or ("finished", "reached the end")

    def _turn(self, watch: Watch, ends: bool, t: float, q: Array, v: Array, after: Array) -> None:
        """Store the record of an event, if steps are stored."""
        steps, event = self.stepper.steps(), watch.event
        if steps is None:
            return
        message: dict[str, Any] = {"along": None, "restitution": None, "reset": None}
        if isinstance(event.reset, Impact) and not ends:
            message |= {"along": event.reset.along or event.function, "restitution": event.reset.restitution}
        elif not ends:
            message |= {"reset": event.reset}
        message |= {"q": q.copy(), "v": v.copy(), "after": after.copy()}
        self._cut(steps, EventStep(name=watch.name, t=t, function=event.function, **message))

    def _turn_corner(self, cut: Cut, behind: Nodes) -> None:
        """Begin anew behind a corner of a force."""
        t, memory, steps = float(cut.nodes.t[-1]), cut.nodes.memory[-1], self.stepper.steps()
        if steps is not None:
            before = self.sampler.state(t, cut.nodes.q[-1], cut.nodes.v[-1], memory)
            state = {"q": before.q[0].copy(), "v": before.v[0].copy(), "after": before.v[0].copy()}
            name = f"corner of {cut.corner.owner}"
            own: dict[str, Any] = dict.fromkeys(("along", "restitution", "reset")) | {"named": False}
            self._cut(steps, EventStep(name=name, t=t, function=cut.corner, **own, **state))
        late = cut.corner.length and behind.t[0] < self._stop()  # other corners are nearer by far
        self._begin(float(behind.t[0]) if late else t, behind.q[0], behind.v[0], longest=cut.longest)

    def _behind(self, cut: Cut) -> Nodes:
        """The state behind a corner."""
        memory = cut.nodes.memory[-1]
        return cut.beyond(lambda t, q, v: self.sampler.state(t, q.copy(), v.copy(), memory).a[0])

    def _cut(self, steps: StepsTaken, event_step: EventStep) -> None:
        """Keep the steps up to an event, and the event."""
        self._segments.append(steps_until(steps, event_step.t))
        self._event_steps.append(event_step)

    def _steps(self) -> Any:
        """All stored steps."""
        steps = self.stepper.steps()
        if steps is None or not self._event_steps:
            return steps
        ended = len(self._event_steps) == len(self._segments) and self.stepper.t == self._event_steps[-1].t
        segments = self._segments if ended else [*self._segments, steps]
        return Segments(
            segments=tuple(segments), event_steps=tuple(self._event_steps), until=float(self.stepper.t)
        )

    def _crowd(self) -> tuple[str, str] | None:
        """Whether events follow each other ever faster."""
        last = self.watches.records[-CROWD:]
        if len(last) < CROWD or last[-1].t - last[0].t > CROWDED * self.watches.span:
            return None
        return "events accumulate", (
            f"{CROWD} events, the last {last[-1].name}, within {last[-1].t - last[0].t:.2g} s near "
            f"t = {last[-1].t:.6g} s: impacts that lose energy come to rest in finite time; end the run with "
            "terminal=..., or model the contact by a force"
        )

    def _take(self, nodes: Nodes) -> None:
        """Give out the states wanted within the nodes."""
        last = int(np.searchsorted(self.plan.times, nodes.t[-1], side="right"))
        if self._last is None:  # pivots do not depend on when states are computed
            for sampler in (self.sampler, self.outputs.sampler):
                sampler.begin(float(nodes.t[0]), nodes.q[0])
        revolutions = self.winding.take(nodes.t, nodes.q, nodes.v)
        self.outputs.take(nodes, self.plan.times[self._written : last], revolutions)
        self._written = last
        announce_left_tables(self.system, self.stepper.b, nodes.t, nodes.q, nodes.v, nodes.memory)
        self.energies.take(nodes)
        self._last = nodes.part(slice(-1, None))
        if len(nodes.t) > 1:
            self._recent = nodes.part(slice(-2, None))
        if self.plan.dense:
            first = (
                () if self._dense else (self._started,)
            )  # the start itself, also where steps begin behind it
            self._dense.append(nodes._replace(t=np.append(first, nodes.t[len(first) :])))
        if self._at_once or self.outputs.too_large:
            try:
                self.outputs.compute(self.plan.progress)
            except (KeyboardInterrupt, TimeLimit) as interruption:
                self._failure = self._interruption = interruption  # once the steps are taken

    def _result(self, status: str, message: str) -> Trajectory:
        end = self._end(self.sampler)
        if not self._is_output(end) and status not in ("finished", *(UNFINISHED if self.plan.store else ())):
            assert self._last is not None
            _, q, v, _, _, memory = (x[0] for x in self._last)
            node = self.sampler.node(float(end.t[0]), q, v, memory)
            self.outputs.take(node, end.t, self.winding.take(*node[:3]))
            if self._at_once:
                self.outputs.compute()
        if status in SHORT and self._recent is not None:
            advice = f" {self.plan.budget.advice()}" if status == "too many steps" else ""
            cause = changing_fastest(self.system, self._recent)
            message = f"{message.removesuffix('.')}.{advice}{cause}"
        self.outputs.end(status, message)
        if self.plan.store:
            message, warnings = self.outputs.remarks()
            announce(warnings)
            return self._saved(self.plan.store, status, message)
        tally = self.stepper.tally
        return self.outputs.trajectory(
            nfev=tally.nfev,
            njev=tally.njev,
            nlu=tally.nlu,
            nsteps=tally.nsteps,
            nrejected=tally.nrejected,
            history=tally.steps(),
            events=tuple(self.watches.records),
            restitutions=restitutions_of(self.plan.events),
            sol=self._solution(),
            final=self._final(end),
            steps=self._steps(),
        )

    def _saved(self, store: Store, status: str, message: str) -> Trajectory:
        """The result of a run that is on disk."""
        text = {**self._record_of_state(), "status": status, "message": message}
        try:
            if status == "time limit":
                self._save(force=True)
            if status not in UNFINISHED:
                self._save(text)
            elif not store.replace_record(
                json.dumps(text)
            ):  # the last checkpoint stays: the run can be resumed
                return nothing(self.system, status, message)
        except NotSavedError as wrong:
            return self._not_saved(str(wrong))
        return self._opened(store.path)

    def _not_saved(self, why: str) -> Trajectory:
        """Return the saved part of a run whose folder could not be written."""
        assert self.plan.store is not None
        try:
            found = self._opened(self.plan.store.path)
        except NoSavedDataError:
            return nothing(self.system, NOT_SAVED, why)
        message = f"{why} The run is safe up to t = {self._safe:.6g} s: continue it with sarrus.resume."
        return replace(found, success=False, status=NOT_SAVED, message=message)


def sampler_of(system: System, stepper: Stepper, host: PlacedMatrix | None = None) -> Sampler:
    """A sampler of the states between a method's steps; `host` instead of the method's matrix."""
    return Sampler(system, stepper.independence, stepper.b, host or stepper.host, stepper.apart)


def _until(nodes: Nodes, states: Samples) -> Nodes:
    """The nodes up to a state between them."""
    rows = int(np.searchsorted(nodes.t, states.t[0]))
    last = Nodes(states.t, states.q, states.v, states.a, states.lam, nodes.memory[max(rows - 1, 0)][None])
    return Nodes._make(np.concatenate(pair) for pair in zip(nodes.part(slice(rows)), last, strict=True))
