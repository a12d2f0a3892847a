"""Integration methods and other parts of a run: their interfaces, and their states.

The variables that a part lists are its state, from which a run goes on with the same bits.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import reduce
from operator import attrgetter
from typing import Any, ClassVar, Protocol

import numpy as np

from ...._jit.kernels.scalars import Scalars
from ....algebra import Array
from ....results import Assembly, StepsTaken
from ....results.saving.saved import COUNTS
from ....system import System
from ...equations.block_matrix import PlacedMatrix
from ...redundancy.redundant_constraints import InconsistentConstraints, Independence
from .nodes import Nodes
from .tolerance import Tolerances

CHUNK = 400  # steps for one call of a method
HISTORY = 5  # columns of the history: t, h, error, Newton iterations, rejected before it


class RunFailure(ArithmeticError):
    """A method cannot go on; `status` and `message` give the reason."""

    def __init__(self, status: str, message: str) -> None:
        super().__init__(message)
        self.status, self.message = status, message


class RunPart:
    """A part of a run.

    Attributes
    ----------
    VARIABLES : names of the attributes on which what follows depends, with dots for those of an attribute: arrays,
        numbers, texts, lists of them, records, and other parts, or what has their two methods
    """

    VARIABLES: ClassVar[tuple[str, ...]] = ()

    def state(self) -> dict[str, Array]:
        """All variables, copied; those of a part within as "part.variable"."""
        return state_of(self, self.VARIABLES)

    def resume(self, state: Mapping[str, Array]) -> None:
        """Go on from such a state; arrays of the same shape stay where they are, as compiled code knows them."""
        take_over(self, self.VARIABLES, state)


class FactoredPart(RunPart):
    """A part with factored matrices, of which compiled code takes the arrays."""

    _arrays: Any = None

    def _show_matrix(self) -> None:
        """The matrices as compiled code takes them."""
        raise NotImplementedError

    @property
    def _is_factored(self) -> bool:
        """Whether compiled code has them."""
        return self._arrays is not None

    @_is_factored.setter
    def _is_factored(self, factored: bool) -> None:
        self._arrays = None
        if factored:
            self._show_matrix()


def state_of(part: object, variables: Iterable[str]) -> dict[str, Array]:
    """The variables of a part, see `RunPart`."""
    return arrays_of({name: attrgetter(name)(part) for name in variables})


def take_over(part: object, variables: Iterable[str], state: Mapping[str, Array]) -> None:
    """Let a part go on from such a state."""
    for name in variables:
        *path, last = name.split(".")
        owner = reduce(getattr, path, part)
        value = resumed(getattr(owner, last), below(name, state))
        if not hasattr(owner, "_asdict"):  # arrays of records are written in place
            setattr(owner, last, value)


def arrays_of(variables: Mapping[str, Any]) -> dict[str, Array]:
    """Variables by name as arrays; see `RunPart`."""
    found = dict[str, Array]()
    for name, value in variables.items():
        inner = _inner(value)
        if inner is None:
            found[name] = np.array(value.as_array() if isinstance(value, Scalars) else value)
        else:
            found |= {f"{name}.{key}": array for key, array in inner.items()}
    return found


def below(name: str, state: Mapping[str, Array]) -> dict[str, Array]:
    """The state of one variable; an array has the name ""."""
    found = {key[len(name) + 1 :]: array for key, array in state.items() if key.startswith(f"{name}.")}
    return found | ({"": state[name]} if name in state else {})


def _inner(value: Any) -> dict[str, Array] | None:
    """The arrays of what has variables itself, or is not there."""
    if value is None:
        return {}
    if hasattr(value, "resume"):
        return dict(value.state())
    if isinstance(value, list) and value and hasattr(value[0], "resume"):
        return arrays_of({str(n): one for n, one in enumerate(value)})
    return arrays_of(value._asdict()) if hasattr(value, "_asdict") else None


def resumed(value: Any, state: Mapping[str, Array]) -> Any:
    """The value of a variable in a state, which takes the place of the present one."""
    if value is None:
        return None
    if hasattr(value, "resume"):
        value.resume(state)
    elif isinstance(value, list) and value and hasattr(value[0], "resume"):
        for n, one in enumerate(value):
            one.resume(below(str(n), state))
    elif hasattr(value, "_asdict"):
        return value._make(resumed(one, below(name, state)) for name, one in value._asdict().items())
    elif isinstance(value, Scalars):
        value.assign(state[""])
    elif not isinstance(value, np.ndarray):
        return state[""].tolist() if isinstance(value, list) else type(value)(state[""])
    elif value.shape != state[""].shape or not value.flags.writeable:
        return state[""].copy()
    else:
        value[...] = state[""]
    return value


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
class Tally(RunPart):
    """Counters of a method, see `Trajectory`."""

    VARIABLES = COUNTS

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

    def resume(self, state: Mapping[str, Array]) -> None:
        """See `RunPart`; the history before is elsewhere."""
        super().resume(state)
        self.history = []

    def steps(self) -> Array:
        """The history as one array."""
        return np.concatenate([np.zeros((0, HISTORY)), *self.history])


class Stepper(Protocol):
    """A method at work on one system.

    Attributes
    ----------
    t : time reached
    switched : the switch just before which the last steps ended, if they did
    has_history : whether steps depend on accelerations of the method's own, or on steps before
    """

    t: float

    @property
    def switched(self) -> Any:
        """The switch."""

    @property
    def has_history(self) -> bool:
        """Whether there is one."""

    def end_at(self, switching: Any) -> None:
        """Let steps end at switches of forces, and `advance` return at some of them."""

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


class KeepingStepper(Stepper, Protocol):
    """A method that keeps its steps for derivatives."""

    def steps(self) -> StepsTaken:
        """The steps stored."""

    def forget(self) -> None:
        """Forget what was stored for derivatives, except the present state."""
