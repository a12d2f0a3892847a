"""Interface of integration methods for `simulate`: take steps from a state, and restart from another one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from ....algebra import Array
from ....results import Assembly, StepsTaken
from ....system import System
from ...equations.block_matrix import PlacedMatrix
from ...redundancy.redundant_constraints import InconsistentConstraints, Independence
from .nodes import Nodes
from .tolerance import Tolerances

HISTORY = 5  # columns of the history: t, h, error, Newton iterations, rejected before it


class RunFailure(ArithmeticError):
    """A method cannot go on; `status` and `message` give the reason."""

    def __init__(self, status: str, message: str) -> None:
        super().__init__(message)
        self.status, self.message = status, message


def independence_at(system: System, start: Assembly) -> Independence:
    """Return the independent equations.

    Raises
    ------
    RunFailure
        If the start is inconsistent, or equations contradict each other.
    """
    found = Independence(system, start.q, start.t)
    try:
        found.check(start)
    except InconsistentConstraints as contradiction:
        raise RunFailure("inconsistent", str(contradiction)) from None
    return found


def remember_start(system: System, start: Assembly, b: Array) -> None:
    """Write into the parameters `b` what elements remember at the start of a run."""
    if len(start.memory):
        b[system.memory_places] = start.memory
    system.remember(start.q, b, start.t)


@dataclass(frozen=True)
class Settings:
    """The settings of a method.

    Attributes
    ----------
    tolerances : of the local error
    max_step, first_step : the longest step, and the first one (0: chosen) [s]
    store_steps : whether steps are stored for derivatives
    given : lengths of steps where they are prescribed
    b : other numbers of the elements than the system's
    times : rising times at which states are wanted: methods of high order, whose steps are long, have nodes there [s]
    dense : whether states at other times are wanted too
    """

    tolerances: Tolerances
    max_step: float = np.inf
    first_step: float = 0.0
    store_steps: bool = False
    given: Array | None = None
    b: Array | None = None
    times: Array = field(default_factory=lambda: np.zeros(0))
    dense: bool = False


@dataclass
class Tally:
    """Counters of a method, see `Trajectory`."""

    nfev: int = 0
    njev: int = 0
    nlu: int = 0
    nsteps: int = 0
    nrejected: int = 0
    history: list[Array] = field(default_factory=list)

    def add(self, steps: int, rejected: int, residuals: int, matrices: int, factors: int) -> None:
        """Count what one call has done."""
        self.nsteps, self.nrejected = self.nsteps + steps, self.nrejected + rejected
        self.nfev, self.njev, self.nlu = self.nfev + residuals, self.njev + matrices, self.nlu + factors

    def counts(self) -> Array:
        """All numbers but the history."""
        return np.array([self.nfev, self.njev, self.nlu, self.nsteps, self.nrejected])

    @classmethod
    def of(cls, counts: Array) -> Tally:
        """Create the counters from stored ones."""
        nfev, njev, nlu, nsteps, nrejected = (int(x) for x in counts)
        return cls(nfev, njev, nlu, nsteps, nrejected)

    def steps(self) -> Array:
        """The history as one array."""
        return np.concatenate([np.zeros((0, HISTORY)), *self.history])


class Stepper(Protocol):
    """A method at work on one system.

    Attributes
    ----------
    t : time reached
    """

    t: float

    @property
    def b(self) -> Array:
        """The numbers of the elements, with what they remember at t."""

    @property
    def independence(self) -> Independence:
        """Return the independent equations."""

    @property
    def tally(self) -> Tally:
        """Return the counters."""

    @property
    def apart(self) -> bool:
        """Whether q and v are interpolated apart between its steps, see `nodes.between`."""

    @property
    def passes_kinks(self) -> bool:
        """Whether its steps go on behind a kink of a law over time, without a new start, unless accelerations jump."""

    @property
    def host(self) -> PlacedMatrix | None:
        """A matrix whose pattern contains that of the equations of motion, if there is one."""

    def restart(self, t: float, q: Array, v: Array, until: float) -> None:
        """Begin at a consistent state; the past is forgotten. The run goes on until a time, if nothing comes between.

        Raises
        ------
        RunFailure
            If accelerations do not exist there.
        """

    def shorten(self, longest: float) -> None:
        """Let the next step be so long at most [s]."""

    def advance(self, stop: float, limit: int) -> Nodes:
        """Take at most `limit` steps, the last of which ends at a time exactly.

        Returns
        -------
        Nodes
            where it began, then the steps; nothing but the first if none could be taken

        Raises
        ------
        RunFailure
            If it could take no step and cannot go on.
        """

    def steps(self) -> StepsTaken | None:
        """The steps stored for derivatives, or None."""

    def state(self) -> dict[str, Array]:
        """All that is needed to go on later with the same numbers.

        Raises
        ------
        ValueError
            If the method cannot do so.
        """

    def resume(self, state: Mapping[str, Array]) -> None:
        """Go on from such a state, in place of `restart`."""


class IntegrationMethod(Protocol):
    """Interface of a method with its options."""

    def stepper(self, system: System, start: Assembly, settings: Settings) -> Stepper:
        """The method at work."""


class KeepingStepper(Stepper, Protocol):
    """A method that keeps its steps for derivatives."""

    def steps(self) -> StepsTaken:
        """The steps stored."""

    def forget(self) -> None:
        """Forget what was stored for derivatives, except the present state."""
