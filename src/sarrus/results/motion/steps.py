"""The computed steps of a run, from which its derivatives are computed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np

from ...algebra import Array
from ..assembly import Assembly
from ..saving.data_bytes import Kinds, dumps, loads
from .events import EventRecord


@dataclass(frozen=True, eq=False, kw_only=True)
class StepsTaken:
    """All accepted steps of a method, as they were taken.

    Attributes
    ----------
    scheme : the description of the method, which alone defines it
    start : the assembly from which it started
    b : (len(system.b),) the numbers of the elements
    t : (n + 1,) start, then the end of each step [s]
    h : (n,) lengths [s]
    q, v, a : (n + 1, nq) states
    lam : (n + 1, m)
    left_out : (n + 1, m) true for equations that others imply; (0, m) where there is none at any time
    memory : (n, number of remembered numbers) what elements remembered during each step, in `places` of b
    stages : (n, entries) all quantities of the stages of each step; (n, 0) where they are those of the states
    removed : (n,) which part of the defect of the velocity constraints was removed before each step
    correction, impulse : (n, nq), (n, m) change of the velocities that removes all of it, and its multipliers, zero
        where nothing was removed; (n, 0) if the method removes nothing
    order : of the method
    rtol, atol : tolerances of the steps
    """

    scheme: object
    start: Assembly = field(repr=False)
    b: Array = field(repr=False)
    t: Array = field(repr=False)
    h: Array = field(repr=False)
    q: Array = field(repr=False)
    v: Array = field(repr=False)
    a: Array = field(repr=False)
    lam: Array = field(repr=False)
    left_out: Array = field(repr=False)
    places: Array = field(repr=False)
    memory: Array = field(repr=False)
    stages: Array = field(repr=False)
    removed: Array = field(repr=False)
    correction: Array = field(repr=False)
    impulse: Array = field(repr=False)
    order: int
    rtol: float
    atol: float

    def __len__(self) -> int:
        """Number of steps."""
        return len(self.h)

    @property
    def precise(self) -> bool:
        """Whether states at the ends of steps are nodes of one polynomial in q, v and a: of an order above two."""
        return self.order > 2

    @property
    def nbytes(self) -> int:
        """Memory that the states and stages take [bytes]."""
        stored = (self.q, self.v, self.a, self.lam, self.stages, self.correction, self.impulse)
        return sum(x.nbytes for x in stored)


@dataclass(frozen=True, eq=False, kw_only=True)
class EventStep(EventRecord):
    """A switch at which a run went on from other velocities or began new steps, or ended, for its derivatives.

    Its state is just before, on the constraints; velocities after it that `reset` gives are not yet on them.

    Attributes
    ----------
    function : what crossed zero: a formula, a Python function (t, q, v), or a corner of a force
    along, restitution : of its `Impact`; None where the run ended
    reset : its function (t, q, v) that gives new velocities, a sample of controllers, or None
    named : whether responses can refer to it by its name; jumps, corners and samples only begin new steps
    """

    function: object
    along: str | None = None
    restitution: float | None = None
    reset: object = None
    named: bool = True


@dataclass(frozen=True, eq=False, kw_only=True)
class Segments:
    """The steps of a run with events, from one to the next.

    Attributes
    ----------
    segments : the steps of each segment; the last step of a segment goes on beyond the event that ends it
    event_steps : the events; one more than there are starts anew where an event ended the run
    until : end of the run [s]
    """

    segments: tuple[StepsTaken, ...]
    event_steps: tuple[EventStep, ...]
    until: float

    def __len__(self) -> int:
        """Number of steps."""
        return sum(len(segment) for segment in self.segments)

    @property
    def nbytes(self) -> int:
        """Memory that the states take [bytes]."""
        return sum(segment.nbytes for segment in self.segments)

    @property
    def start(self) -> Assembly:
        """The assembly from which it started."""
        return self.segments[0].start

    @property
    def b(self) -> Array:
        """The numbers of the elements."""
        return self.segments[0].b

    @property
    def t(self) -> Array:
        """Start, ends of the steps, and the events, each at the end of one segment and the start of the next [s]."""
        ends = zip(self.segments, self.ends, strict=True)
        return np.concatenate([x for segment, end in ends for x in (segment.t[:-1], [end])])

    @property
    def first(self) -> Array:
        """The place of each segment's first node among all nodes."""
        return np.cumsum([0, *(len(segment) + 1 for segment in self.segments[:-1])])

    @property
    def ends(self) -> Array:
        """The time at which each segment ends [s]."""
        times = [event_step.t for event_step in self.event_steps]
        return np.array([*times, self.until][: len(self.segments)])

    def nodes(self, name: str) -> Array:
        """A field of all nodes, segment after segment."""
        return np.concatenate([getattr(segment, name) for segment in self.segments])


def until(steps: StepsTaken, t: float) -> StepsTaken:
    """The steps up to the one within which, or at whose end, a time lies; one at least, for a time at the start."""
    return first_of(steps, min(max(int(np.searchsorted(steps.t, t)), 1), len(steps)))


def first_of(steps: StepsTaken, count: int) -> StepsTaken:
    """The first ones of some steps."""
    return part_of(steps, 0, count)


def last_of(steps: StepsTaken, count: int) -> StepsTaken:
    """The last ones of some steps, or all of them."""
    return part_of(steps, max(len(steps) - count, 0), count)


def part_of(steps: StepsTaken, first: int, count: int) -> StepsTaken:
    """Some steps from the given one on, which do not hold the memory of the others."""
    ends = ((name, first + count + at_nodes) for name, at_nodes in _lengths(steps))
    return replace(steps, **{name: getattr(steps, name)[first:end].copy() for name, end in ends})


def led(lead: StepsTaken | None, steps: StepsTaken) -> StepsTaken:
    """Steps with those just before them, if there are any."""
    if lead is None:
        return steps
    one, other = _with_left_out(lead, steps), _with_left_out(steps, lead)
    both = ((name, getattr(one, name)[: len(one)], getattr(other, name)) for name, _ in _lengths(other))
    message: dict[str, Any] = {name: np.concatenate([before, own]) for name, before, own in both}
    return replace(other, **message)


def _with_left_out(steps: StepsTaken, other: StepsTaken) -> StepsTaken:
    """Steps with their left-out equations, if others have them."""
    if len(steps.left_out) or not len(other.left_out):
        return steps
    message: dict[str, Any] = {"left_out": np.zeros(steps.lam.shape, dtype=bool)}
    return replace(steps, **message)


def _lengths(steps: StepsTaken) -> Sequence[tuple[str, int]]:
    """The arrays that have an entry for each step (0), and for each node (1)."""
    arrays = [f.name for f in fields(steps) if isinstance(getattr(steps, f.name), np.ndarray)]
    shared = [name for name in arrays if name not in ("b", "places") and len(getattr(steps, name))]
    return [(name, int(len(getattr(steps, name)) == len(steps) + 1)) for name in shared]


def segments_of(steps: StepsTaken | Segments) -> Sequence[StepsTaken]:
    """The steps between events, or all in one."""
    return steps.segments if isinstance(steps, Segments) else (steps,)


def segments_to_store(
    segments: Sequence[StepsTaken],
    event_steps: Sequence[EventStep],
    known: Kinds,
    functions: Mapping[str, Any],
) -> Array:
    """Segments before the present one and the events that end them, without the method and the start of the run.

    `functions` : those of the user's events, which are stored by these names
    """
    none: dict[str, Any] = {"scheme": None, "start": None}
    own = [replace(segment, **none) for segment in segments], event_steps
    return np.frombuffer(dumps(own, known, functions) if event_steps else b"", dtype=np.uint8)


def segments_from_store(
    stored: Array, steps: StepsTaken | None, known: Kinds, functions: Mapping[str, Any]
) -> tuple[list[StepsTaken], list[EventStep]]:
    """The same, with the method and the start of the segment that follows."""
    if steps is None or not len(stored):
        return [], []
    segments, event_steps = loads("checkpoint", stored.tobytes(), known, functions.__getitem__)
    return [replace(segment, scheme=steps.scheme, start=steps.start) for segment in segments], [*event_steps]
