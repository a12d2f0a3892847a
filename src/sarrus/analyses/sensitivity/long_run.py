"""A long run of which some states are kept: its stretches are simulated again as they are asked for.

A stepper goes on from a state that it gave with the same numbers, so that the steps taken again are those of the run,
bit by bit.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import accumulate, zip_longest
from typing import Any

import numpy as np

from ...algebra import Array
from ...results import Assembly, StepsTaken
from ...system import System
from ..dynamics.breakpoints import stops_of
from ..dynamics.stepper import Settings

# Steps of a stretch at first
FIRST = 400


@dataclass(frozen=True)
class Checkpoint:
    """What a stepper needs to go on.

    Attributes
    ----------
    state : of the stepper
    count : steps to the next checkpoint
    before : length of the step before; 0 at the start
    """

    state: dict[str, Array]
    count: int
    before: float

    @property
    def nbytes(self) -> int:
        """Memory that it takes."""
        return sum(x.nbytes for x in self.state.values())

    def with_next(self, other: Checkpoint | None) -> Checkpoint:
        """One in place of two neighbours."""
        return Checkpoint(self.state, self.count + (other.count if other else 0), self.before)


class LongRun:
    """A run of which only checkpoints are kept.

    Half of the memory is for checkpoints: where they need more, every second one is dropped, and stretches become twice
    as long. The other half is for the steps of one stretch.

    Parameters
    ----------
    system, start, method, settings, until : of the simulation; steps are kept
    room : [bytes]
    per_step : what each step of a stretch takes [bytes]

    Attributes
    ----------
    t : (n + 1,) start, then the end of each step [s]

    Raises
    ------
    ValueError
        Where the memory is too small.
    """

    def __init__(
        self,
        system: System,
        start: Assembly,
        method: Any,
        settings: Settings,
        until: float,
        room: float,
        per_step: float,
    ) -> None:
        self.system, self._until, self._half, self._per_step = system, until, room / 2, per_step
        self._stepper = method.stepper(system, start, settings)
        self._stops = [*stops_of(system, np.zeros(0), until)[0], until]
        self._points: list[Checkpoint] = []
        self._stepper.restart(0.0, start.q, start.v, until)
        self.t = self._run()

    def __len__(self) -> int:
        """Number of stretches."""
        return len(self._points)

    @property
    def ends(self) -> list[int]:
        """The nodes at which stretches begin, and the last one."""
        return list(accumulate((point.count for point in self._points), initial=0))

    def stretch(self, n: int) -> tuple[StepsTaken, float]:
        """The steps of a stretch, and the length of the one before them (0 at the start)."""
        point = self._points[n]
        self._stepper.resume(point.state)
        taken = 0
        while taken < point.count:
            taken += len(self._advance()) - 1
        steps = self._stepper.steps()
        assert isinstance(steps, StepsTaken)
        return steps, point.before

    def _run(self) -> Array:
        times, before = [np.zeros(1)], 0.0
        while self._stepper.t < self._until:
            state = {name: np.array(x) for name, x in self._stepper.state().items()}
            t = self._advance()
            if len(t) > 1:
                self._points.append(Checkpoint(state, len(t) - 1, before))
                times.append(t[1:])
                before = float(self._stepper.steps().h[-1])
                self._make_room()
            self._stepper.forget()
        return np.concatenate(times)

    def _advance(self) -> Array:
        """The next steps, in the same portions whenever they are taken."""
        stop = next(stop for stop in self._stops if stop > self._stepper.t)
        return np.asarray(self._stepper.advance(stop, FIRST).t)

    def _make_room(self) -> None:
        steps = self._per_step * max(point.count for point in self._points)
        if steps > self._half:
            raise self._too_little(2 * steps)
        while sum(point.nbytes for point in self._points) > self._half:
            if 2 * steps > self._half or len(self._points) == 1:
                raise self._too_little(2 * sum(point.nbytes for point in self._points) + 2 * steps)
            pairs = zip_longest(self._points[::2], self._points[1::2])
            self._points, steps = [one.with_next(other) for one, other in pairs], 2 * steps

    def _too_little(self, wanted: float) -> ValueError:
        return ValueError(
            f"memory={2 * self._half:.3g} bytes are too few at t = {self._stepper.t:.6g} s of {self._until:.6g} s; "
            f"give more than memory={wanted:.2g}"
        )
