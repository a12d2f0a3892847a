"""Events: what happens when a function of the state crosses zero along a motion."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ....algebra import Array
from ....model import ModelError
from ....model.checks.arguments import WholeNumber, real
from ....results import EventRecord, EventStep
from ....results.motion.events import records_to_store
from ....system import System
from ..dense_output.sampler import Sampler
from ..stepping.nodes import Nodes
from ..stepping.stepper import RunFailure, RunPart
from .event_output import EventOutput, as_formula, takes_outputs

LOOKS = 4  # at so many places of a step a crossing is looked for
AHEAD = 1e-9  # of a run, after which its direction is seen
JUMPED = 1e5  # times as far from zero as it moves until then: new velocities have changed the function itself
# of what it moves until then: so near to zero when another event comes, it crosses at the same time
MEETS = 1e-2
NEAR = 1e-13  # of the time reached: where root finding ends
LAST, CROWDED = 20, 1e-6  # so many intervals between switches within this part of the whole time: they crowd
# or, where a force jumps, after so many switches, if the last intervals are so much shorter than all
FREE, FASTER = 200, 0.5
ACCUMULATE = (
    "as impacts that lose energy come to rest in finite time",
    "End the run with terminal=..., or model the contact by a force.",
)
Function = Callable[[float, Array, Array], float]


@dataclass(frozen=True)
class Impact:
    """Reset of an event: an impulse that reverses the rate of an output, with a coefficient of restitution.

    ṡ⁺ = -restitution ṡ⁻ of the output s, ṡ = s_q v + s_t, and M (v⁺ - v⁻) + Φ_qᵀΛ = s_qᵀ p, Φ_q v⁺ = -Φ_t with an
    impulse p. An output that depends on the time, `ball.z - 0.1*sin(9*t)`, is the distance from a prescribed motion.

    Attributes
    ----------
    along : the output, e.g. "ball.z" or "pin.angle"; by default the event's own
    restitution : 1 for an elastic impact, 0 for a plastic one
    """

    restitution: float = 1.0
    along: str | Callable[[Any], Any] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "along", as_formula(self.along, "along of an Impact"))
        if not 0 <= self.restitution <= 1:
            raise ValueError(
                f"restitution of an Impact must be between 0 and 1, but is {self.restitution!r}. "
                "Give 1 to keep the energy."
            )


@dataclass(frozen=True, eq=False)
class Event:
    """An event of a simulation: a zero crossing of a function of the state.

    Attributes
    ----------
    function : an output or formula of outputs, "ball.z - 0.1", "pin.angle"; a function of outputs,
        ``lambda o: o("ball.z") - 0.1``; or a Python function (t, q, v) -> float
    direction : 1 for increasing values, -1 for decreasing values, 0 for both
    terminal : whether the run ends there; a number means that crossing. An event with a reset at the end of the run
        ends it, too
    reset : `Impact`, or a function (t, q, v) -> v of new velocities, which are projected onto the constraints
    name : for `Trajectory.events`; by default the formula, or the function's name
    """

    function: str | Function
    direction: int = 0
    terminal: bool | int = False
    reset: Impact | Callable[[float, Array, Array], Array] | None = None
    name: str = ""

    def __post_init__(self) -> None:
        name: Any = self.name
        if not isinstance(name, str) or not name.isprintable():
            raise TypeError(
                f"the name of an event must be a text on one line, but is {self.name!r:.40}. Give one, or leave it out."
            )
        if callable(self.function) and takes_outputs(self.function):
            object.__setattr__(self, "name", self.title)
            object.__setattr__(self, "function", as_formula(self.function, f"the event {self.name}"))
        direction: object = self.direction
        if not np.isscalar(direction) or direction not in (-1, 0, 1):
            raise ValueError(
                f"direction of an event must be -1, 0 or 1, but is {self.direction!r}. Give 0 for both ways."
            )
        if isinstance(self.function, type) or not (isinstance(self.function, str) or callable(self.function)):
            raise TypeError(
                f"an event needs a formula or a function (t, q, v), but has {self.function!r}. "
                "Give one, such as 'ball.z - 0.1'."
            )
        if not isinstance(self.terminal, bool):
            WholeNumber(0)("terminal", self.terminal)
        if not (self.reset is None or isinstance(self.reset, Impact) or callable(self.reset)):
            raise TypeError(
                f"reset must be an Impact or a function (t, q, v), but is {self.reset!r:.40}. "
                "Give one of them, such as Impact(0.5)."
            )
        if isinstance(self.reset, Impact) and not (self.reset.along or isinstance(self.function, str)):
            raise ValueError(
                'reset: the Impact of a Python function needs a direction. Give one, as in Impact(0.5, along="ball.z").'
            )

    @property
    def title(self) -> str:
        """The name, or a default name."""
        own = self.function if isinstance(self.function, str) else getattr(self.function, "__name__", "event")
        return self.name or own


def restitutions_of(events: Sequence[Event]) -> dict[str, float]:
    """Return the restitutions of the impacts among events, by the names of derivatives."""
    found = {event.title: event.reset for event in events}
    return {f"{n}.restitution": float(x.restitution) for n, x in found.items() if isinstance(x, Impact)}


def with_restitutions(events: Sequence[Event], values: Mapping[str, float]) -> list[Event]:
    """The events with other restitutions, by name."""
    return [_struck(event, values.get(f"{event.title}.restitution")) for event in events]


def _struck(event: Event, restitution: float | None) -> Event:
    if restitution is None or not isinstance(event.reset, Impact):
        return event
    return replace(event, reset=replace(event.reset, restitution=restitution))


class Crowd(RunPart):
    """The times of one switch, to refuse those that follow each other ever faster."""

    VARIABLES = "_count", "_first", "_recent"

    def __init__(self) -> None:
        self._count, self._first, self._recent = 0, 0.0, np.zeros(0)

    def add(self, t: float) -> None:
        """Count a switch."""
        self._first = self._first if self._count else t
        self._count, self._recent = self._count + 1, np.append(self._recent, t)[-LAST - 1 :]

    def refuse(self, name: str, span: float | None, reason: str, remedy: str) -> None:
        """Refuse switches that crowd: events, of a run that takes so long, or those of a force that jumps.

        Raises
        ------
        RunFailure
        """
        if len(self._recent) <= LAST:
            return
        t, last = self._recent[-1], self._recent[-1] - self._recent[0]
        mean = (t - self._first) / (self._count - 1) if self._count > FREE else 0.0
        if last < (FASTER * LAST * mean if span is None else CROWDED * span):
            raise RunFailure("switches crowd", f"{name}: switches crowd at t = {t:.6g} s, {reason}. {remedy}")


class Watch(RunPart):
    """One event along one run."""

    VARIABLES = "count", "last", "at", "near", "crowd"

    def __init__(self, system: System, event: Event) -> None:
        self.event = event
        self.function: Function = (
            EventOutput(system, event.function) if isinstance(event.function, str) else _apart(event.function)
        )
        self.name = event.title
        along = event.reset.along if isinstance(event.reset, Impact) else None
        self.output: Function = EventOutput(system, str(along)) if along else self.function
        if isinstance(event.reset, Impact) and isinstance(self.output, EventOutput):
            self.output.refuse_no_gradient()
        self._counted = [x for x in dict.fromkeys((self.function, self.output)) if isinstance(x, EventOutput)]
        self.count, self.last, self.at, self.crowd = 0, 0.0, -np.inf, Crowd()

    def begin(self, t: float, q: Array, v: Array, event: bool, span: float) -> None:
        """A start, perhaps after an event: then a function at zero has crossed it just now, or is about to."""
        value, ahead = self._value(t, q, v), AHEAD * span
        change = float(self.function(t + ahead, q + ahead * v, v)) - value if event else 0.0
        own = t - self.at <= max(2 * MEETS * ahead, NEAR * abs(t))
        if event or not self.last:  # what is zero at a breakpoint crosses if its sign changes behind it
            self.last = value
        if own and abs(value) <= JUMPED * abs(change):
            self.last = change
        elif not own and abs(value) <= MEETS * abs(change):
            self.last = -change

    def _value(self, t: float, q: Array, v: Array) -> float:
        """The function's value; what an impact is along counts its revolutions, too.

        Raises
        ------
        RunFailure
            If it is not a number.
        """
        if self.output is not self.function:
            self.output(t, q, v)
        value = real(f"the value of the event {self.name}", self.function(t, q, v))
        if np.isnan(value):
            message = f"the event {self.name} has no value at t = {t:.6g} s: its function returned nan. Make it finite."
            raise RunFailure("event undefined", message)
        return value

    @property
    def near(self) -> Array:
        """The joints' coordinates from which revolutions are counted."""
        return np.array([x for output in self._counted for x in output.near])

    @near.setter
    def near(self, values: Array) -> None:
        for output in self._counted:
            output.near, values = values[: len(output.near)], values[len(output.near) :]

    def near_start(self, coordinates: Array, memory: Array) -> None:
        """Take the joints' coordinates at the start, with their revolutions, and what elements remember."""
        for output in self._counted:
            output.near_start(coordinates, memory)

    def crossings(self, nodes: Nodes, sampler: Sampler, until: float) -> Iterator[float]:
        """The times of all crossings within the nodes; the end of the run is one if the function is zero there."""
        since = nodes.t[0]
        for t, q, v in _looks(nodes, sampler.apart):
            value = self._value(t, q, v)
            before, now = np.sign(self.last), np.sign(value)  # values may be infinite
            crosses = before * now < 0 or (before and not now and t == until)
            if crosses and -before * self.event.direction >= 0:
                yield self._root(nodes, sampler, since, t)
            if value != 0:
                self.last, since = value, t

    def _root(self, nodes: Nodes, sampler: Sampler, before: float, after: float) -> float:
        def value(t: float) -> float:
            sample = sampler.states(nodes, np.array([t]))
            found = self.function(t, sample.q[0], sample.v[0])
            if t == before and not found * self.last > 0:  # round-off after an event there
                found = self.last
            return float(np.nan_to_num(found, nan=np.nan))

        from scipy.optimize import brentq  # 0.2 s to import: only runs with events pay

        if value(after) * self.last > 0:  # making the state consistent has moved the crossing behind it
            return after
        near = NEAR * max(after - before, abs(after))
        root = float(brentq(value, before, after, xtol=near, rtol=1e-15))
        return root if root - before > 2 * near else before

    @property
    def ends(self) -> bool:
        """Whether the run ends with the crossing just counted."""
        wanted = self.event.terminal
        return bool(wanted) and (wanted is True or self.count >= wanted)

    def after(self, t: float, q: Array, v: Array, sampler: Sampler) -> Array:
        """The velocities after it; the sampler has settled the state just before.

        Raises
        ------
        ValueError
            For a reset that does not return velocities, and an impact along an output that no impulse changes.
        """
        reset = self.event.reset
        if reset is None:
            return v
        if not isinstance(reset, Impact):
            return self._velocities(reset(t, q.copy(), v.copy()), len(v))
        assert isinstance(self.output, EventOutput)  # of a name: see `Event`
        s_q, s_t = self.output.gradient(t, q, v)
        if not s_q.any():
            raise ModelError(
                f"the impact of the event {self.name} is along an output that no impulse changes. Name one of a body "
                'that is free to move, as in Impact(0.5, along="ball.z").'
            )
        w = sampler.pushed(t, q, s_q)
        return np.asarray(v - (1 + reset.restitution) * (s_q @ v + s_t) / (s_q @ w) * w)

    def event_step(self, t: float, q: Array, v: Array, after: Array, ends: bool) -> EventStep:
        """The record for derivatives of an event, which changes velocities or ends the run."""
        reset, changes = self.event.reset, dict[str, Any]()
        if isinstance(reset, Impact) and not ends:
            changes = {"along": reset.along or self.event.function, "restitution": reset.restitution}
        elif not ends:
            changes = {"reset": reset}
        return EventStep(name=self.name, t=t, function=self.event.function, q=q, v=v, after=after, **changes)

    def _velocities(self, given: Any, size: int) -> Array:
        """Check the velocities that a user's function returned."""
        message = (
            f"the reset of the event {self.name} must return {size} finite velocities. Return a new array."
        )
        try:
            found = np.array(given, dtype=float)
        except (TypeError, ValueError) as error:
            raise ValueError(message) from error
        if found.shape != (size,) or not np.all(np.isfinite(found)):
            raise ValueError(message)
        return found


def _apart(function: Function) -> Function:
    """A function of one's own, which may overwrite the state that it is given."""
    return lambda t, q, v: function(t, q.copy(), v.copy())


def _looks(nodes: Nodes, apart: bool) -> Iterator[tuple[float, Array, Array]]:
    """Places of the steps at which signs are compared."""
    for k in range(len(nodes.t) - 1):
        t0, t1 = nodes.t[k], nodes.t[k + 1]
        for n in range(1, LOOKS):
            t = float(t0 + n / LOOKS * (t1 - t0))
            yield t, *nodes.part(slice(k, k + 2)).near(t, apart)
        yield float(t1), nodes.q[k + 1], nodes.v[k + 1]


class Watches(RunPart):
    """All events of one run.

    Attributes
    ----------
    span, until : how long it takes, and its end [s]
    """

    VARIABLES = ("_all",)

    def __init__(self, system: System, events: Sequence[Event], span: float, until: float) -> None:
        self._all = [Watch(system, event) for event in events]
        self.span, self.until = span, until
        self.records: list[EventRecord] = []

    def __bool__(self) -> bool:
        return bool(self._all)

    def near(self, coordinates: Array, memory: Array) -> None:
        """The joints' coordinates at the start, with their revolutions, and what elements remember."""
        for watch in self._all:
            watch.near_start(coordinates, memory)

    def begin(self, t: float, q: Array, v: Array, event: bool) -> None:
        """A start at a state, perhaps after an event."""
        for watch in self._all:
            watch.begin(t, q, v, event, self.span)

    def record(self, watch: Watch, t: float, q: Array, v: Array, sampler: Sampler) -> Array:
        """Count and record an event; returns the velocities after it."""
        watch.count, watch.at = watch.count + 1, t
        watch.crowd.add(t)
        after = watch.after(t, q, v, sampler)
        self.records.append(EventRecord(watch.name, t, q, v, after))
        return after

    def refuse_crowd(self) -> None:
        """Refuse events that follow each other ever faster.

        Raises
        ------
        RunFailure
        """
        for watch in self._all:
            watch.crowd.refuse(watch.name, self.span, *ACCUMULATE)

    def stored_records(self) -> dict[str, Array]:
        """The events so far, as results of a saved run."""
        return records_to_store(self.records, [watch.name for watch in self._all])

    def crossings(self, nodes: Nodes, sampler: Sampler) -> list[tuple[float, Watch]]:
        """All crossings within the nodes, in the order of time; of those at one time, resets come last.

        New velocities may take a function back before it has crossed.
        """
        found = sorted(
            (t, n) for n, watch in enumerate(self._all) for t in watch.crossings(nodes, sampler, self.until)
        )
        first, order = -np.inf, list[tuple[float, bool, int, float]]()
        for t, n in found:
            first = first if t - first <= NEAR * max(self.span, abs(t)) else t
            order.append((first, self._all[n].event.reset is not None, n, t))
        return [(t, self._all[n]) for _, _, n, t in sorted(order)]
