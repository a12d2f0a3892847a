"""What a run is to do, and its record: outputs, the whole motion, steps for derivatives, and checkpoints."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ....algebra import Array
from ....model.announcement import announce, collected, is_strict
from ....model.read_only import read_only
from ....results import Assembly, EventRecord, NoSolution, Solution, State, Trajectory, load_run
from ....results.motion.events import event_records
from ....results.motion.steps import EventStep, Segments, StepsTaken, segments_from_store, segments_to_store
from ....results.motion.steps import until as steps_until
from ....results.saving.checked_file import NOT_SAVED, NoSavedDataError, NotSavedError
from ....results.saving.saved import COUNTS, STORED_STEPS, UNFINISHED, Store
from ....system import System
from ...equations.table_ranges import announce_left_ranges
from ...progress import TimeLimit
from ..dense_output.sample_loop import Samples
from ..dense_output.sampler import Sampler
from ..dense_output.winding import Winding, WindingAlong
from ..events.events import Event, Watches, restitutions_of
from ..events.switching_functions import Corner
from ..sampled.control import Control
from ..stepping.nodes import Nodes, joined
from ..stepping.step_budget import SHORT, StepBudget, changing_fastest
from ..stepping.stepper import RunPart, Stepper, arrays_of, below, resumed
from .energy_check import EnergyCheck
from .outcome import OutputStates, nothing

PAUSE, PATIENT = 1.0, 20.0  # s between two checkpoints at least; as a multiple of what one takes
STORED = {one.__name__: one for one in (StepsTaken, EventStep, Corner)}


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
    free : whether steps end at switches of forces
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
    free: bool = False
    aside: float = 0.0
    behind: float = 0.0
    stored: bool = False
    control: Control | None = None


class RunState(NamedTuple):
    """The state of a run at its last accepted step: all on which what follows depends, to the last bit.

    Each part lists its variables, see `RunPart`. A checkpoint contains ``_asdict()`` of this state.

    Attributes
    ----------
    method : t, q, v, a and λ, memory of the elements, control of the steps, tolerances, factors, and stored steps
    sampler, outputs : choices of pivots for states between steps, for outputs, and configurations near singular ones
    winding : revolutions
    energies : what they changed beyond bounds
    switches, events : times, counts and signs
    step_watch : numbers of steps
    record : the motion and the segments so far, where they are stored, and the number of outputs
    """

    method: Stepper
    sampler: RunPart
    outputs: RunPart
    winding: RunPart
    energies: RunPart
    switches: RunPart
    events: Watches
    step_watch: RunPart
    record: RunPart


class Recording(RunPart):
    """The record of one run.

    Parameters
    ----------
    system : System
    stepper : the method at work
    plan : what is wanted

    Attributes
    ----------
    sampler : of the states at which a run is looked at
    run_state : of the run, for checkpoints
    interruption : of the computation of outputs, to be raised once the steps are taken
    """

    VARIABLES = "_written", "_motion", "_before"
    run_state: RunState

    def __init__(self, system: System, stepper: Stepper, plan: Plan) -> None:
        self.system, self.stepper, self.plan = system, stepper, plan
        self.sampler = sampler_of(system, stepper)
        self.outputs = OutputStates(system, sampler_of(system, stepper))
        # whose choices the run does not depend on, as it does not depend on when it is saved
        self._sampler_of_marks = sampler_of(system, stepper) if plan.store else self.sampler
        self._at_once = plan.store is not None or is_strict()  # outputs are computed in the run
        events = ((n, event, name) for n, event in enumerate(plan.events) for name in ("function", "reset"))
        self._functions = {f"{name} of event {n}": getattr(event, name) for n, event, name in events}
        self.energies = EnergyCheck(system, self.sampler, partial(sampler_of, system, stepper))
        self.winding = Winding(system)
        self.interruption: KeyboardInterrupt | TimeLimit | None = None
        self._last: Nodes | None = None
        self._recent: Nodes | None = None
        self._written, self._started = 0, 0.0
        self._dense: list[Nodes] = []
        self._segments: list[StepsTaken] = []
        self.event_steps: list[EventStep] = []
        self._marked, self._pause, self._safe = time.perf_counter(), PAUSE, 0.0

    def begin(self, start: Assembly) -> None:
        """Take the start of the run."""
        self._started, self.energies.span = start.t, self.plan.until - start.t
        self.winding.begin(start.q, start.revolutions)

    def take(self, nodes: Nodes) -> None:
        """Give out the states wanted within the nodes."""
        last = int(np.searchsorted(self.plan.times, nodes.t[-1], side="right"))
        if self._last is None:  # pivots do not depend on when states are computed
            for sampler in (self.sampler, self.outputs.sampler):
                sampler.begin(float(nodes.t[0]), nodes.q[0], nodes.memory[0])
        revolutions = self.winding.take(nodes.t, nodes.q, nodes.v)
        self.outputs.take(nodes, self.plan.times[self._written : last], revolutions)
        self._written = last
        announce_left_ranges(self.system, self.stepper.b, nodes.t, nodes.q, nodes.v, nodes.memory)
        self.energies.take(nodes)
        self._last = nodes.part(slice(-1, None))
        if len(nodes.t) > 1:
            self._recent = nodes.part(slice(-2, None))
        if self.plan.dense:  # the start itself, also where steps begin behind it
            first = () if self._dense else (self._started,)
            self._dense.append(nodes._replace(t=np.append(first, nodes.t[len(first) :])))
        if self._at_once or self.outputs.too_large:
            try:
                self.outputs.compute(self.plan.progress)
            except (KeyboardInterrupt, TimeLimit) as interruption:
                self.interruption = interruption

    def cut(self, event_step: EventStep) -> None:
        """Keep the stored steps up to an event, and the event."""
        steps = self.stepper.steps()
        assert steps is not None
        self._segments.append(steps_until(steps, event_step.t))
        self.event_steps.append(event_step)

    def steps(self) -> StepsTaken | Segments | None:
        """All stored steps, which cannot be written."""
        steps: StepsTaken | Segments | None = self.stepper.steps()
        if isinstance(steps, StepsTaken) and self.event_steps:
            ended = len(self.event_steps) == len(self._segments) and self.stepper.t == self.event_steps[-1].t
            segments = tuple(self._segments if ended else [*self._segments, steps])
            steps = Segments(
                segments=segments, event_steps=tuple(self.event_steps), until=float(self.stepper.t)
            )
        stored: StepsTaken | Segments | None = read_only(steps)
        return stored

    def reached(self) -> State | None:
        """The state reached, from which another run can go on."""
        return self._reached()()

    def _reached(self) -> Callable[[], State | None]:
        """What computes that state, without a reference to this record; at once if others use the sampler later."""
        sampler, b, last, turns = self.sampler, self.stepper.b.copy(), self._last, self.winding.values.copy()

        def state() -> State | None:
            return _final(sampler.system, b, _end(sampler, last, turns))

        if not self.plan.dense:
            return state
        found = state()
        return lambda: found

    def _is_output(self) -> bool:
        """Whether there is no state behind the last output."""
        written = self.plan.times[: self._written]
        return self._last is None or bool(np.any(written >= self._last.t[0]))

    def _solution(self) -> Solution | NoSolution:
        """The whole motion, where it was stored."""
        if not self._dense:
            return NoSolution()
        nodes = joined(self._dense)
        return Solution(nodes, self.sampler, WindingAlong(self.system, nodes, self.winding.first))

    @property
    def _motion(self) -> Nodes:
        """The whole motion so far, where it is stored."""
        self._dense = [joined(self._dense)] if self._dense else []
        return self._dense[0] if self._dense else Nodes._make([np.zeros(0)] * len(Nodes._fields))

    @_motion.setter
    def _motion(self, nodes: Nodes) -> None:
        self._dense = [nodes] if len(nodes.t) else []

    @property
    def _before(self) -> Array:
        """The segments before the present one, and the events that ended them, as bytes."""
        return segments_to_store(self._segments, self.event_steps, STORED, self._functions)

    @_before.setter
    def _before(self, stored: Array) -> None:
        steps = self.stepper.steps()
        self._segments, self.event_steps = segments_from_store(stored, steps, STORED, self._functions)

    def go_on(self, state: Mapping[str, Array]) -> None:
        """Go on from a checkpoint."""
        announce(json.loads(str(state["told"])).get("warnings", ()))
        resumed(self.run_state, state)
        self.run_state.events.records = event_records(state)
        self._safe = float(self.stepper.t)
        if "final_t" in state:
            self._last = Nodes(*(state[f"final_{name}"][None] for name in Nodes._fields))

    def over(self, state: Mapping[str, Array], folder: Path) -> Trajectory:
        """A saved run that has come to its end, with the whole motion and the steps where they were stored."""
        for name in ("method", "sampler", "winding", "record"):
            if name != "method" or STORED_STEPS in state:
                getattr(self.run_state, name).resume(below(name, state))
        return self._opened(folder)

    def _opened(self, folder: Path) -> Trajectory:
        """The contents of the folder, and the stored steps."""
        own: dict[str, Any] = {
            "sol": self._solution(),
            "steps": self.steps(),
            "steps_folder": "",
            "call": None,
        }
        return replace(load_run(folder, self.system), restitutions=restitutions_of(self.plan.events), **own)

    def save(self, message: Mapping[str, Any] | None = None, force: bool = False) -> None:
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
            state = arrays_of(self.run_state._asdict()) | self.run_state.events.stored_records()
            state |= {"told": np.array(json.dumps(message or self._message_of_state()))}
            sampler = self._sampler_of_marks if message is None else self.sampler
            end = _end(sampler, self._last, self.winding.values)
            if (final := _final(sampler.system, self.stepper.b, end)) is not None:
                state |= final.to_store()
            if message is None and not self._is_output():
                state["final_violation"] = end.violation[0]
                state["final_energy"] = self.sampler.energies(end)[0, :2]
            (store.mark if message is None else store.finish)(state)
            self._marked, self._safe = time.perf_counter(), float(self.stepper.t)
            self._pause = max(PAUSE, PATIENT * (self._marked - now))

    @property
    def _counts(self) -> dict[str, int]:
        return {name: getattr(self.stepper.tally, name) for name in COUNTS}

    def _message_of_state(self) -> dict[str, Any]:
        message = f"cut short; it is safe up to t = {self.stepper.t:.6g} s"
        text = {"status": "cut short", "message": message, "t": self.stepper.t}
        return text | {"singular": self.outputs.nearness.times, "warnings": collected()} | self._counts

    def result(self, status: str, message: str, records: Sequence[EventRecord]) -> Trajectory:
        """The result of the run, with its events."""
        if not self._is_output() and status not in ("finished", *(UNFINISHED if self.plan.store else ())):
            assert self._last is not None
            t, q, v, _, _, memory = (x[0] for x in self._last)
            node = self.sampler.node(float(t), q, v, memory)
            self.outputs.take(node, node.t, self.winding.take(*node[:3]))
            if self._at_once:
                self.outputs.compute()
        if status in SHORT and self._recent is not None:
            advice = f" {self.plan.budget.advice()}" if status == "too many steps" else ""
            message = f"{message.removesuffix('.')}.{advice}{changing_fastest(self.system, self._recent)}"
        self.outputs.end(status, message, self._reached())
        if self.plan.store:
            message, warnings = self.outputs.remarks()
            announce(warnings)
            return self._saved(self.plan.store, status, message)
        return self.outputs.trajectory(
            **self._counts, history=self.stepper.tally.steps(), events=tuple(records), sol=self._solution(),
            restitutions=restitutions_of(self.plan.events), steps=self.steps(),
        )  # fmt: skip

    def _saved(self, store: Store, status: str, message: str) -> Trajectory:
        """The result of a run that is on disk."""
        text = {**self._message_of_state(), "status": status, "message": message}
        try:
            if status == "time limit":
                self.save(force=True)
            if status not in UNFINISHED:
                self.save(text)
            elif not store.replace_record(
                json.dumps(text)
            ):  # the last checkpoint stays: the run can be resumed
                return nothing(self.system, status, message)
        except NotSavedError as wrong:
            return self.not_saved(str(wrong))
        return self._opened(store.path)

    def not_saved(self, why: str) -> Trajectory:
        """Return the saved part of a run whose folder could not be written."""
        assert self.plan.store is not None
        try:
            found = self._opened(self.plan.store.path)
        except NoSavedDataError:
            return nothing(self.system, NOT_SAVED, why)
        message = f"{why} The run is safe up to t = {self._safe:.6g} s: continue it with sarrus.resume."
        return replace(found, success=False, status=NOT_SAVED, message=message)


def _end(sampler: Sampler, last: Nodes | None, turns: Array) -> Samples:
    """The state reached, as an output; none before the first step."""
    if last is None:
        return sampler.capacity(np.zeros(0))
    found = sampler.state_at(float(last.t[0]), last.q[0], last.v[0], last.memory[0])
    found.revolutions[0] = sampler.system.counted_coordinates.revolutions(turns, found.q[0])
    return found


def _final(system: System, b: Array, end: Samples) -> State | None:
    """A state from which another run can go on."""
    if not len(end.t):
        return None
    b, (t, q, v, a, lam) = b.copy(), (x[0] for x in end[:5])
    b[system.memory_places] = end.memory[0]
    system.remember(q, b, float(t))
    return State(float(t), q, v, a, lam, b[system.memory_places], end.revolutions[0])


def sampler_of(system: System, stepper: Stepper) -> Sampler:
    """A sampler of the states between a method's steps."""
    return Sampler(system, stepper.independence, stepper.b, stepper.host, stepper.apart)
