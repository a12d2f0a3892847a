"""The analyses of a study: one analysis of the system of each case."""

from __future__ import annotations

import time
from abc import abstractmethod
from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import KW_ONLY, asdict, dataclass, field, fields, is_dataclass, replace
from functools import cache, cached_property
from inspect import formatannotation, signature
from pathlib import Path
from typing import Any, ClassVar, NamedTuple, TypeAlias

import numpy as np

from ..analyses import assemble, equilibrium, inverse_dynamics, kinematics, linearize, modes, simulate
from ..analyses.dynamics.former_options import with_former_options
from ..analyses.dynamics.integrators.described import DescribedMethod
from ..analyses.dynamics.integrators.differentiable import Method, method_with_options
from ..analyses.dynamics.methods import Description
from ..analyses.dynamics.recipe import refuse_end
from ..analyses.dynamics.run_options import Stored, refuse_store
from ..analyses.dynamics.stepping.step_control import CONTROL, StepControl, with_control
from ..analyses.integration_methods import METHODS, method_named
from ..analyses.position.initial_state import Start as InitialState
from ..analyses.sensitivity.parameters.design_start import DesignStart
from ..analyses.sensitivity.sampling.segments import NoSample, refuse_outside
from ..model import SarrusError
from ..model.announcement import collecting
from ..model.checks.arguments import CHECKS, TEXTS, Number, WholeNumber
from ..model.checks.calls import CallCheck
from ..model.show import show, suggest
from ..outputs import UnknownOutput, find_output
from ..outputs.motion import motion_outputs
from ..outputs.output import Level
from ..outputs.outputs import Outputs
from ..results import Assembly, Trajectory, load_run
from ..results.result import Result
from ..system import System
from .parameters import Array, number, whole
from .responses import Response
from .source import Start


class CaseTimeout(SarrusError):
    """A case that took longer than a study allows."""


class CaseResult(NamedTuple):
    """Result of one analysis, the times of its histories, and access to histories by name."""

    result: Result | Mapping[str, float]
    t: Array
    lookup: Callable[[str], float | Array]


NAMES = ("coordinates", "inputs", "outputs")  # of a linearization
FIELD_CHECKS: dict[str, Callable[[str, Any], None]] = {
    **CHECKS,
    **dict.fromkeys(NAMES, CHECKS["variables"]),
    "steps": WholeNumber(1),
    "time": Number(),
}


@dataclass(frozen=True)
class Run(metaclass=CallCheck):
    """Interface of an analysis of a system."""

    def __post_init__(self) -> None:
        for option in fields(self):
            value = getattr(self, option.name)
            if option.name in TEXTS and isinstance(value, str):
                value = TEXTS[option.name](option.name, value)
                object.__setattr__(self, option.name, value)
            if option.name in FIELD_CHECKS and value is not option.default:
                FIELD_CHECKS[option.name](option.name, value)

    kind: ClassVar[str]

    @abstractmethod
    def result(self, system: System, start: Start, times: tuple[float, ...], until: float) -> Any:
        """The result; `until` is the clock time at which it is given up."""

    def __call__(self, system: System) -> Any:
        """The result of a system from its own guess, as `Problem` and `optimize` take it."""
        return self.result(system, Start(system.q0, system.v0), (), np.inf)

    def found(self, system: System, start: Start, times: tuple[float, ...], limit: float) -> CaseResult:
        """The result, with its histories.

        Raises
        ------
        SarrusError
            With its message, if the analysis failed.
        """
        result = self.result(system, start, times, time.monotonic() + limit)
        if getattr(result, "status", "") == "stopped":  # by Ctrl-C, which is meant for the study
            raise KeyboardInterrupt
        if not result.success:
            raise SarrusError(result.message)
        return CaseResult(result, times_of(result), lookup_of(system, result))

    def check(self, system: System, responses: Iterable[Response], parameters: Container[str]) -> None:
        """Refuse a response that no case can have, before any case is run.

        Raises
        ------
        SarrusError
            For names that are no outputs and no numbers, and times after the end.
        """
        for response in responses:
            for name in response.names():
                if name not in parameters:
                    self._refuse_unknown(system, response, name)
            try:
                refuse_outside(response.times(), self.begin, getattr(self, "until", np.inf))
            except NoSample as wrong:
                raise SarrusError(f"response {response.name!r}: {wrong}") from None

    def _refuse_unknown(self, system: System, response: Response, name: str) -> None:
        """Refuse a name that no case has; whether it has a value there is another matter."""
        try:
            only = find_output(system, name).only
            if only and only != self.kind:
                remedy = next(one.__name__ for one in KINDS.values() if one.kind == only)
                raise UnknownOutput(f"{name} is an output of {only} alone. Use {remedy}() as the analysis.")
        except UnknownOutput as unknown:
            raise SarrusError(f"response {response.name!r}: {unknown}") from None

    @property
    def begin(self) -> float:
        """The time at which it begins [s]."""
        return 0.0

    def started(self, system: System) -> Run:
        """The same with a start that was checked for the nominal system, and can be sent to other processes."""
        return self

    def start_warnings(self, system: System) -> tuple[str, ...]:
        """Return the changes of the system's initial state by the start of the analysis."""
        return ()

    def short(self) -> Run | None:
        """The same in little time, for compiling all that it needs; None if that cannot be known."""
        return self

    def described(self) -> dict[str, Any]:
        """The form in a study file."""
        options = {option.name: getattr(self, option.name) for option in fields(self)}
        given = {name: _plain(x) for name, x in options.items() if x is not None and x != np.inf and x != ()}
        return {"type": self.kind, **given}


@with_former_options
@dataclass(frozen=True)
class Simulation(Run):
    """Analysis of a study: a simulation from the assembled initial state, or from another `start`.

    Parameters
    ----------
    until : end time [s]
    start : as for `simulate`, by default the model's own state. An `Assembly`, rates of joints
        (``{"rates": {"pin": 5.0}}``) and coordinates are assembled again for every case, an `Equilibrium`
        (``{"equilibrium": True}``) is found again, a function of the system is called; the state of a run
        (``run.final``, ``{"run": "drop.sarrus"}``) is fixed, and cases whose constraints it contradicts fail
    steps : number of intervals of the histories for responses; times of ``at(x, t)`` are added
    method, store : as in `simulate`; "steps" if a response is an ``error(...)``
    """

    kind = "simulate"
    until: float
    _: KW_ONLY
    steps: int = 1000
    method: Method | None = None
    start: InitialState | DesignStart | None = None
    store: Stored | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.store is not None:
            refuse_store(self.store)

    @property
    def begin(self) -> float:
        """The time of its start [s]."""
        return self.start.t if isinstance(self.start, DesignStart) else 0.0

    def started(self, system: System) -> Simulation:
        """Return the simulation with its start for the nominal system."""
        if self.start is None:
            return self
        start = DesignStart.of(system, self.start)
        refuse_end(self.until, start.t)
        return replace(self, start=start)

    def assembled(self, system: System, start: Start) -> Assembly:
        """Return the start of a case; the nominal state is the estimate."""
        with collecting():
            if isinstance(self.start, DesignStart):
                return self.start.at(system)
            return assemble(system, start.q, start.v, rates=system.model.rates)

    def result(self, system: System, start: Start, times: tuple[float, ...], until: float) -> Any:
        """The trajectory."""
        grid = np.unique(np.concatenate([np.linspace(self.begin, self.until, self.steps + 1), times]))
        begin = self.assembled(system, start)
        options: dict[str, Any] = {"t_eval": grid, "store": self.store or "samples", "method": self.method}
        return simulate(system, begin, until=self.until, progress=_watch(until), **options)

    def start_warnings(self, system: System) -> tuple[str, ...]:
        """The warnings of the assembly; the cases report its failures."""
        if self.start is not None:
            return ()
        with collecting() as found, suppress(SarrusError):
            assemble(system)
        return found.messages

    def short(self) -> Run | None:
        """Return a simulation of the first thousandth of the time."""
        return replace(self, until=self.begin + (self.until - self.begin) / 1000, steps=1)


@dataclass(frozen=True)
class Kinematics(Run):
    """Analysis of a study: the motion that the drivers prescribe, in `steps` intervals until a time [s].

    `times` are more times of its histories, the last of which is the end where no other is given.
    """

    kind = "kinematics"
    until: float = 0.0
    steps: int = 1000
    times: Sequence[float] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "times", tuple(map(float, self.times)))
        if not self.until:
            if not self.times:
                raise SarrusError("Kinematics: until is missing. Give the end time in s, or times.")
            object.__setattr__(self, "until", max(self.times))
        super().__post_init__()

    def with_times(self, times: Sequence[float]) -> Kinematics:
        """Return the same with more times."""
        return replace(self, times=(*self.times, *times))

    def result(self, system: System, start: Start, times: tuple[float, ...], until: float) -> Any:
        """The trajectory."""
        grid = np.unique(np.concatenate([np.linspace(0.0, self.until, self.steps + 1), times, self.times]))
        return kinematics(system, grid, start.q, progress=_watch(until))

    def short(self) -> Run | None:
        """One interval."""
        return replace(self, until=self.until / self.steps, steps=1)


@dataclass(frozen=True)
class Statics(Run):
    """Analysis of a study: an equilibrium, drivers at a `time` [s]; with ``stable=False``, the nearest one."""

    kind = "statics"
    time: float = 0.0
    stable: bool = True

    def result(self, system: System, start: Start, times: tuple[float, ...], until: float) -> Any:
        """The equilibrium."""
        return equilibrium(system, start.q, t=self.time, stable=self.stable)


@dataclass(frozen=True)
class Vibration(Run):
    """`modes` about the `equilibrium`: outputs are ``mode1.frequency`` [Hz], ``mode1.damping_ratio`` ..."""

    kind = "modes"
    time: float = 0.0
    stable: bool = True

    def result(self, system: System, start: Start, times: tuple[float, ...], until: float) -> Any:
        """Return the modes, or the failed equilibrium."""
        rest = equilibrium(system, start.q, t=self.time, stable=self.stable)
        return modes(system, rest, t=self.time) if rest.success else rest


@dataclass(frozen=True)
class Linearization(Run):
    """`linearize` about the `equilibrium`: outputs are ``A[pin.angle.rate, pin.angle]``, ``phase[pin.angle, u, 2]`` ...

    `coordinates`, `inputs` and `outputs` are names as for `linearize`.
    """

    kind = "linearization"
    coordinates: Sequence[str] | None = None
    inputs: Sequence[str] | None = None
    outputs: Sequence[str] | None = None
    time: float = 0.0
    stable: bool = True

    def result(self, system: System, start: Start, times: tuple[float, ...], until: float) -> Any:
        """Return the linearization, or the failed equilibrium."""
        rest = equilibrium(system, start.q, t=self.time, stable=self.stable)
        names = {name: getattr(self, name) for name in NAMES}
        return linearize(system, rest, **names) if rest.success else rest


@dataclass(frozen=True)
class InverseDynamics(Run):
    """`inverse_dynamics`: forces that a `motion` requires, which is a run, or a saved one by its folder."""

    kind = "inverse_dynamics"
    motion: Trajectory | str | Path

    def result(self, system: System, start: Start, times: tuple[float, ...], until: float) -> Any:
        """The motion with its forces."""
        return inverse_dynamics(system, self._run)

    @cached_property
    def _run(self) -> Trajectory:
        return self.motion if isinstance(self.motion, Trajectory) else load_run(self.motion)

    @property
    def begin(self) -> float:
        """The time at which the motion begins [s]."""
        return float(self._run.t[0])

    @property
    def until(self) -> float:
        """The time at which it ends [s]."""
        return float(self._run.t[-1])

    def described(self) -> dict[str, Any]:
        """The form in a study file; of a run in memory, its name."""
        motion = self.motion.name if isinstance(self.motion, Trajectory) else str(self.motion)
        return {"type": self.kind, "motion": motion}


Own: TypeAlias = Callable[[System], Any]


@dataclass(frozen=True)
class OwnRun(Run):
    """A function of the system that returns a result, or a mapping of numbers by name."""

    kind = "own"
    function: Own = field(default=lambda system: None)

    def result(self, system: System, start: Start, times: tuple[float, ...], until: float) -> Any:
        """Return the result of the function."""
        return self.function(system)

    def found(self, system: System, start: Start, times: tuple[float, ...], limit: float) -> CaseResult:
        """The result; histories if it is a trajectory or the like."""
        result = self.function(system)
        if isinstance(result, Mapping):
            return CaseResult(result, np.zeros(1), lambda name: _entry(result, name))
        if not getattr(result, "success", True):
            raise SarrusError(str(getattr(result, "message", "the function reports no success")))
        if not hasattr(result, "q"):
            numbers = getattr(result, "values", {})  # as those of a manoeuvre
            known = numbers if isinstance(numbers, Mapping) else {}
            return CaseResult(result, np.zeros(1), lambda name: _entry(known, name))
        return CaseResult(result, times_of(result), lookup_of(system, result))

    def check(self, system: System, responses: Iterable[Response], parameters: Container[str]) -> None:
        """What the function returns is not known before it is called."""

    def short(self) -> Run | None:
        return None

    def described(self) -> dict[str, Any]:
        """Return the location of the function."""
        function: Any = self.function
        return {"type": "own", "function": f"{function.__module__}.{getattr(function, '__qualname__', '')}"}


EVERY = (Simulation, Kinematics, Statics, Vibration, Linearization, InverseDynamics)
KINDS: dict[str, type[Run]] = {one.kind: one for one in EVERY}


ANNOTATIONS = {  # of options that are no numbers
    "str": (str, "a text"),
    "Stored | None": (str, "a text"),
    "bool": (bool, "true or false"),
    "bool | None": (bool, "true or false"),
}


def run_of(analysis: Any, folder: Path | None = None) -> Run:
    """A run of what a user writes: ``{"type": "simulate", "until": 5, "method": {"type": "hht", "alpha": -0.1}}``, a
    kind's name, a `Run`, or a function of the system; a saved run that it starts from is relative to the folder.

    Raises
    ------
    SarrusError
        For anything else.
    """
    if isinstance(analysis, Run):
        return analysis
    if isinstance(analysis, type) and issubclass(analysis, Run):
        raise SarrusError(
            f"the analysis {analysis.__name__} is a class. Give its options: {analysis.__name__}(...)."
        )
    if callable(analysis):
        return OwnRun(analysis)
    options = dict(analysis) if isinstance(analysis, Mapping) else {"type": analysis}
    kind = str(options.pop("type", "simulate"))
    begin = options.get("start")
    if folder is not None and isinstance(begin, Mapping) and "run" in begin:
        options["start"] = {**begin, "run": str(folder / str(begin["run"]))}
    if folder is not None and "motion" in options:
        options["motion"] = str(folder / str(options["motion"]))
    if kind not in KINDS:
        raise SarrusError(f"there is no analysis {kind!r}. {suggest(str(kind), KINDS)}")
    named = {str(name): x for name, x in options.items()}
    control = {name: named.pop(name) for name in CONTROL if name in named} if kind == Simulation.kind else {}
    if control:
        method = method_with_options(_method(named.get("method", "radau")))
        named["method"] = with_control(method, **_read(StepControl, "the analysis simulate", control))
    run: Run = _built(KINDS[kind], f"the analysis {kind}", named)
    return run


def _built(kind: Any, subject: str, options: dict[str, Any]) -> Any:
    """A dataclass, or what a function returns, with its numbers converted."""
    known, options = signature(kind).parameters, _read(kind, subject, options)
    if "until" in known and "until" not in options:
        raise SarrusError(f"{subject} needs an end time. Give until in s.")
    if "motion" in known and "motion" not in options:
        raise SarrusError(f"{subject} needs a motion. Give the folder of a saved run.")
    return kind(**options)


def _read(kind: Any, subject: str, options: dict[str, Any]) -> dict[str, Any]:
    """The options of a dataclass or function, with their numbers converted."""
    known = signature(kind).parameters
    for name, value in options.items():
        if name not in known:
            raise SarrusError(f"{subject} has no key {name!r}. {suggest(name, known)}")
        if name == "method":
            options[name] = _method(value)
        elif name in ("start", "motion", *NAMES):
            options[name] = value
        elif name in ("steps",):
            options[name] = whole(value, name)
        elif (expected := formatannotation(known[name].annotation).strip("'")) in ANNOTATIONS:
            annotation, article = ANNOTATIONS[expected]
            if not isinstance(value, annotation):
                raise SarrusError(f"{subject}: {name} must be {article}, but is {show(value)}. Change it.")
        else:
            options[name] = number(value)
    return options


def _method(method: Any) -> Any:
    if isinstance(method, StepControl):
        return method
    options = dict(method) if isinstance(method, Mapping) else {"type": method}
    kind = str(options.pop("type", "radau")).lower()
    if kind not in METHODS:
        raise SarrusError(f"there is no method {kind!r}. {suggest(kind, METHODS)}")
    return _built(method_named(kind), f"the method {kind}", options)


def _plain(value: Any) -> Any:
    if isinstance(value, DesignStart):
        return value.described()
    if isinstance(value, Description):
        return value.record
    if isinstance(value, DescribedMethod):
        return {**value.description.record, **_control(value)}
    if is_dataclass(value) and not isinstance(value, type):
        return {"type": type(value).__name__.lower(), **_own(value), **_control(value)}
    return value


def _own(value: Any) -> dict[str, Any]:
    """The fields of a dataclass, without those of the control of steps."""
    return {name: x for name, x in asdict(value).items() if name not in CONTROL}


def _control(value: Any) -> dict[str, Any]:
    """The options of the control of steps that are not the default ones."""
    found = {
        one.name: (getattr(value, one.name), one.default) for one in fields(value) if one.name in CONTROL
    }
    return {name: x for name, (x, default) in found.items() if x != default}


def _watch(until: float) -> Callable[[float], None]:
    """Receives the progress of a run, and ends it after its time limit."""

    def watch(reached: float) -> None:
        if time.monotonic() > until:
            raise CaseTimeout(
                f"took longer than it may, it had reached t = {reached:.6g} s. Raise time_limit."
            )

    return watch


def times_of(result: Any) -> Array:
    """The times of a motion, or the one of an equilibrium."""
    return np.atleast_1d(np.asarray(getattr(result, "t", 0.0), dtype=float))


def lookup_of(system: System, result: Any) -> Callable[[str], Any]:
    """Histories by name: outputs of a motion, what modes have, and parameters of the model.

    Accelerations and multipliers are computed only for outputs that depend on them.
    """

    @cache
    def outputs(level: Level) -> Outputs:
        return motion_outputs(system, result, level=level)

    def lookup(name: str) -> Any:
        output = find_output(system, name)
        found = output.record(outputs(output.level))
        return np.asarray(getattr(found, "value", found), dtype=float)

    return lookup


def _entry(numbers: Mapping[str, Any], name: str) -> float:
    if name not in numbers:
        raise SarrusError(
            f"the function returned no {name!r}. {suggest(name, numbers) if numbers else 'Return a mapping.'}"
        )
    return float(numbers[name])
