"""The time integration loop from start to end, for any method: steps up to the first switch, and a new start behind it.

A switch is where the equations go on from another state, or otherwise: an event, a corner of a force, a sample of
controllers, a time at which a law jumps. Each of them ends a segment of steps as a `Hit`.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ....algebra import Array
from ....model.announcement import announce
from ....results import Assembly, Trajectory
from ....results.motion.steps import EventStep
from ....results.saving.checked_file import NotSavedError
from ....system import System
from ...progress import TimeLimit
from ..dense_output.sample_loop import Samples
from ..events.events import Impact, Watches
from ..inputs.prescribed_motions import motion_jumps, refuse_infinite_motions
from ..stepping.nodes import Nodes, joined
from ..stepping.step_budget import StepWatch
from ..stepping.stepper import CHUNK, RunFailure, Stepper
from .nearness import initial_warnings
from .recording import Plan, Recording, RunState
from .switches import Hit, Switches

WATCHED = 40  # the same, where events are looked for
JUMP = 1e-6  # of the largest acceleration: smaller changes at a kink are none of the accelerations
GOES_ON = "finished", "reached the end"  # status and message of a run unless something else ends it


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
        self.recording = Recording(system, stepper, plan)
        self.sampler = self.recording.sampler
        self.watches = Watches(system, plan.events, plan.until - stepper.t, plan.until)
        self.switches = Switches(system, stepper, plan, self.sampler)
        self.step_watch = StepWatch(plan.budget, plan.until)
        made = self.recording
        made.run_state = RunState(
            stepper, made.sampler, made.outputs, made.winding, made.energies, self.switches, self.watches,
            self.step_watch, made,
        )  # fmt: skip
        self._failure: RunFailure | KeyboardInterrupt | None = None  # once the steps before it are taken

    @property
    def portion(self) -> int:
        """Return the number of steps of the next call of the loop."""
        most = self.plan.budget.max_steps
        left = CHUNK if most is None else max(most - int(self.stepper.tally.nsteps), 1)
        return min(WATCHED if self.watches else CHUNK, left)

    def go(self, start: Assembly, state: Mapping[str, Array] | None = None) -> Trajectory:
        """Integrate from the start, or from a saved state, to the end; return the result also after a failure."""
        refuse_infinite_motions(self.system, start.t, self.plan.until)
        try:
            self._start(start, state)
            self.recording.save(force=True)
            status, message = self._segments()
        except KeyboardInterrupt:
            status, message = "stopped", f"stopped by the user at t = {self.stepper.t:.6g} s"
        except TimeLimit as over:
            status, message = "time limit", f"{over} at t = {self.stepper.t:.6g} s"
        except RunFailure as error:
            status, message = error.status, error.message
        except NotSavedError as wrong:
            return self.recording.not_saved(str(wrong))
        return self.recording.result(status, message, self.watches.records)

    def _start(self, start: Assembly, state: Mapping[str, Array] | None) -> None:
        """Begin at the start, or go on from a saved state."""
        self.recording.begin(start)
        if state is not None:
            self.recording.go_on(state)
            return
        self.watches.near(self.recording.winding.values, start.memory)
        self._begin(Hit(start.t + self.plan.behind * self.stepper.apart, start.q.copy(), start.v.copy()))
        self._first_sample(start)
        self.step_watch.begin(start.t)
        announce(initial_warnings(self.system, start, self.stepper.independence))
        announce(motion_jumps(self.system, start.t, self.plan.until))

    def _begin(self, hit: Hit) -> None:
        """Let the method begin anew."""
        self.stepper.restart(hit.t, hit.q, hit.v, self.plan.until)
        self.stepper.shorten(hit.longest)
        if self.watches:
            self.watches.begin(hit.t, hit.q, hit.v, hit.is_event)

    def _segments(self) -> tuple[str, str]:
        """Steps up to the first switch, no further than the next stop, and a new start behind it, until the end."""
        status, message = GOES_ON
        while self.stepper.t < self.plan.until and status == "finished":
            stop, before = self._stop(), self.stepper.b.copy()
            nodes, hit = self._up_to_event(*self._advance(stop), before)
            self._take(nodes)
            if hit := hit or self._at_time(stop, nodes):
                status, message = self._turn(hit)
            if status == "finished":  # else the end is recorded with it, and until then it is found again
                self.recording.save()
                self.step_watch.look(self.stepper.t, self.stepper.tally.nsteps)
            if self.plan.progress:
                self.plan.progress(float(self.stepper.t))
        if self.recording.interruption:
            raise self.recording.interruption
        return status, message

    def _turn(self, hit: Hit) -> tuple[str, str]:
        """Record what ended a segment, and begin behind it, or end the run."""
        if self.plan.stored:
            assert hit.record, "the steps before would be lost"
            self._cut(hit.record)
        if hit.b is not None:
            self.stepper.b[:] = hit.b
        if hit.message:
            self.stepper.t = hit.t
            return "event", hit.message
        self._begin(hit)
        if hit.is_event:
            self.watches.refuse_crowd()
        return GOES_ON

    def _advance(self, stop: float) -> tuple[Nodes, Hit | None]:
        """Some steps, up to the first corner of a force at which one ends; calls are joined."""
        most = self.portion
        if before := self._failure or self.recording.interruption:
            raise before
        parts, hit, taken = list[Nodes](), None, 0
        while taken < most and hit is None and (self.stepper.t < stop or not parts):
            try:
                nodes, hit = self.switches.advance(stop, most - taken)
            except (RunFailure, KeyboardInterrupt) as failure:
                if not parts:
                    raise
                self._failure = failure
                break
            parts.append(nodes)
            taken += max(len(nodes.t) - 1, 1)  # a call may choose pivots only
        return joined(parts), hit

    def _stop(self) -> float:
        """The next time that is hit exactly."""
        ahead = self.plan.stops[self.plan.stops > self.stepper.t]
        return float(ahead[0]) if len(ahead) else self.plan.until

    def _up_to_event(self, nodes: Nodes, corner: Hit | None, before: Array) -> tuple[Nodes, Hit | None]:
        """The steps up to the first event that changes the motion or ends it, or the corner at which they have ended.

        All events up to it are recorded. Within the gap at a corner the state is that behind it: the gap is so short
        that velocities between its ends would be round-off. `before` : the numbers of the elements at their begin
        """
        watched = joined([nodes, corner.behind]) if corner and corner.behind else nodes
        for t, watch in self.watches.crossings(watched, self.sampler) if self.watches else ():
            states = self.sampler.states(
                watched.part(slice(-1, None)) if t > nodes.t[-1] else watched, np.array([t])
            )
            q, v = states.q[0], states.v[0]
            after, event = self.watches.record(watch, t, q, v, self.sampler), watch.event
            ends = watch.ends or (event.reset is not None and t >= self.plan.until)
            if not ends and event.reset is None:
                continue
            memory = watched.memory[max(int(np.searchsorted(watched.t, t)) - 1, 0)]
            before[self.system.memory_places] = memory
            record = watch.event_step(t, q.copy(), v.copy(), after.copy(), ends)
            message = f"ended by the event {watch.name} at t = {t:.9g} s" if ends else ""
            if not ends and self.plan.control and not isinstance(event.reset, Impact):
                self.plan.control.reset(v, after)
            state = self.sampler.state_at(t, q, v if ends else after, memory)
            hit = Hit(t, state.q[0], state.v[0], record, before, is_event=True, message=message)
            return _until(watched, states), hit
        return nodes, corner

    def _at_time(self, stop: float, nodes: Nodes) -> Hit | None:
        """A sample of controllers, or a kink of a law over time, if the method has to begin anew behind it."""
        if not self.stepper.t == stop < self.plan.until:
            return None
        control, begin = self.plan.control, stop + 2 * self.plan.aside
        if control and (due := control.due(stop)) and (now := self.recording.reached()):
            sample = control.sample(now, due)
            return Hit(begin, now.q, sample.after(), sample.event_step() if self.plan.stored else None)
        if stop not in self.plan.kinks:
            return None
        before = self.sampler.state_at(stop, nodes.q[-1], nodes.v[-1], nodes.memory[-1])
        q, v, jumps = before.q[0], before.v[0], self._jumps(before, begin)
        if self.stepper.passes_kinks and not jumps:
            return None
        name, function = "jump", f"t - {stop!r}"
        record = EventStep(
            name=name, t=stop, function=function, named=False, q=q.copy(), v=v.copy(), after=v.copy()
        )
        return Hit(begin, q, v, record if jumps else None)

    def _jumps(self, before: Samples, begin: float) -> bool:
        """Whether accelerations jump, from which the method would go on."""
        if not self.stepper.apart:
            return False
        after = self.sampler.state_at(begin, before.q[0].copy(), before.v[0].copy(), before.memory[0])
        return bool(abs(after.a - before.a).max() > JUMP * max(abs(after.a).max(), abs(before.a).max()))

    def _first_sample(self, start: Assembly) -> None:
        """The sample at the start where steps are stored, as an event there, before which derivatives need a step."""
        control, before = self.plan.control, self.stepper.b.copy()
        if not control or not self.plan.stored:
            return
        begin, tally = float(self.stepper.t), self.stepper.tally
        taken, chunks = tally.nsteps, len(tally.history)
        while self.stepper.t == begin:  # a call may choose pivots only
            self.stepper.advance(self._stop(), 1)
        sample = control.first_sample(start.q, start.v)
        tally.nsteps = taken
        del tally.history[chunks:]
        self._turn(Hit(begin, start.q, sample.after(), sample.event_step(), before))

    def _take(self, nodes: Nodes) -> None:
        """Record steps."""
        self.recording.take(nodes)

    def _cut(self, event_step: EventStep) -> None:
        """Keep the stored steps up to an event, and the event."""
        self.recording.cut(event_step)


def _until(nodes: Nodes, states: Samples) -> Nodes:
    """The nodes up to a state between them."""
    rows = int(np.searchsorted(nodes.t, states.t[0]))
    last = Nodes(states.t, states.q, states.v, states.a, states.lam, nodes.memory[max(rows - 1, 0)][None])
    return Nodes._make(np.concatenate(pair) for pair in zip(nodes.part(slice(rows)), last, strict=True))
