"""A simulation as a function of its design variables: responses, exact gradients, products with vectors."""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from inspect import signature
from typing import Any, TypeAlias, TypedDict

import numpy as np

from ...algebra import Array
from ...model import Model, SarrusError
from ...model.announcement import collecting
from ...model.checks.arguments import checked
from ...model.expansion.blueprint import blueprint
from ...model.show import quote, suggest
from ...results import ErrorEstimate, Gradient, Trajectory
from ...system import System
from ..dynamics.events.events import restitutions_of
from ..dynamics.former_options import FORMER, accepts_former_options
from ..dynamics.integrators.differentiable import Differentiable
from ..dynamics.run_options import Events, events_of, listed_events
from ..dynamics.sampled.control import controlled, without_held
from ..dynamics.sampled.controllers import Controller, controllers_of
from ..position.assembly_derivatives import NoDerivative
from ..position.initial_state import Start
from ..progress import TimeLimit, duration, refuse_time_limit
from ..sensitivity.combined import Composite, Part
from ..sensitivity.gradients import is_solved
from ..sensitivity.implicit.responses import ResponsesOfResult
from ..sensitivity.implicit.results import responses_of_result
from ..sensitivity.parameters.design_start import DesignStart
from ..sensitivity.parameters.parameters import Design, Parameters
from .point import DesignError, Point

CACHED = 3  # designs whose simulations are remembered
LEAST_LIMIT, LONGER = 10.0, 20.0  # [s], [-] a simulation may take so many times as long as the first one


Analysis: TypeAlias = Callable[[System], Any]


class RunSettings(TypedDict):
    """The options of the simulations of all designs."""

    method: Differentiable | None
    until: float


SETTINGS = ("method", "events", "controllers", "memory", "time_limit")  # of a problem that searches take, too


def refuse_unknown(function: Callable[..., Any], settings: Mapping[str, Any]) -> None:
    """Refuse settings that a search does not have.

    Raises
    ------
    TypeError
    """
    own = [name for name in signature(function).parameters if name != "settings"]
    known = {*own, *SETTINGS, *(name for names in FORMER.values() for name in names)}
    for name in settings:
        if name not in known:
            message = f"{function.__name__} has no argument {quote(name)}"
            raise TypeError(f"{message}. {suggest(name, [*own, *SETTINGS])}")


class Problem:
    """Responses of a simulation or another analysis as a function of design variables, with derivatives.

    Parameters
    ----------
    system : with the design at the start
    responses : one or several, see `sensitivity`, or `Combined` ones
    wrt : names of the design variables, see `sensitivity`
    until : end time of the simulation [s]
    analysis : instead of a simulation, `Kinematics`, `Statics`, `Vibration`, `Linearization`, `InverseDynamics`, or a
        function of the system that returns the result of `kinematics`, `inverse_dynamics`, `equilibrium`, `modes` or
        `linearize`
    start : as for `simulate`. An `Assembly`, rates of joints (``{"rates": {"pin": 5.0}}``) and coordinates are
        assembled again for every design, an `Equilibrium` (``{"equilibrium": True}``) is found again, both with their
        derivatives in the gradients. A function of the system is called for every design. The state of a run
        (``run.final``) is fixed: variables that change constraints are refused. By default the model's own state,
        assembled for every design
    design : values of named design variables at the start
    formula : the function that computes parameters of the model from them; differentiated exactly
    method : `Radau` (the default), whose values have the least noise, `HHT`, or `GeneralizedAlpha`, with the tolerances
        and lengths of its steps
    events : of the simulation, and breakpoints, see `simulate`; restitutions of impacts, ``stop.restitution``, may be
        design variables. A design whose run lacks an event or a time of a response counts as one that cannot be
        simulated
    controllers : one sampled controller of the simulation, or several, see `simulate`; their gains are inputs, and the
        first sample is that of the start at which a design is assembled
    memory : for stored states and steps [bytes], see `sensitivity`; by default all steps are stored.
        Only values and gradients are available then
    time_limit : seconds after which a simulation is stopped; by default twenty times the duration of the first one, at
        least 10 s

    Attributes
    ----------
    names, units, table_units : of the design variables
    x0 : their values at the start (p,)
    titles : of the responses

    Raises
    ------
    SarrusError
        For names that the model does not have, and responses at times after the end.

    Examples
    --------
    >>> problem = sr.Problem(system, sr.Final("slider.x"), ["spring.k"], until=1.0)  # doctest: +SKIP
    >>> value, gradient = problem.value_and_grad(problem.x0)  # doctest: +SKIP
    """

    analysis: Analysis | None = None

    @accepts_former_options
    @checked
    def __init__(
        self,
        system: System,
        responses: Part | Sequence[Part],
        wrt: Sequence[str] | None = None,
        *,
        until: float | None = None,
        analysis: Analysis | None = None,
        start: Start | DesignStart | None = None,
        design: Mapping[str, float] | None = None,
        formula: Design | None = None,
        method: Differentiable | None = None,
        events: Events = (),
        controllers: Controller | Sequence[Controller] = (),
        memory: float | None = None,
        time_limit: float | None = None,
    ) -> None:
        refuse_time_limit(time_limit)
        if (until is None) == (analysis is None):
            raise TypeError(
                "Problem: give until=, the end of a simulation, or analysis=, such as sr.Statics() or sr.Vibration()."
            )
        self.given, self.outer = responses, Composite(responses)
        self.design, self.formula = design, formula
        until = 0.0 if until is None else float(until)
        self.plain, controllers = system.model, controllers_of(controllers)
        if controllers:
            refuse_with_controllers(start, memory)
            begin = None if isinstance(start, DesignStart) else start
            system = controlled(system, begin, controllers, until, differentiated=True).system
        self.system = system
        self.settings = RunSettings(method=method, until=until)
        self.events = listed_events(events)
        self.controllers = controllers
        self.time_limit, self.memory = time_limit, memory
        self.restitutions = restitutions_of(events_of(events)[0])
        self._parameters = Parameters(
            system, wrt, design=design, formula=formula, restitutions=self.restitutions
        )
        self.names, self.units = tuple(self._parameters.names), self._parameters.units
        self.table_units = self._parameters.table_units
        self.x0: Array = self._parameters.values.copy()
        self.titles = self.outer.titles
        self._points: OrderedDict[bytes, Point] = OrderedDict()
        self.start_warnings: tuple[str, ...] = ()
        if analysis is None:
            self._begin(start, until)
        elif start is not None or memory is not None or self.events or controllers or method is not None:
            raise TypeError(
                "Problem: start, events, controllers, method and memory are those of a simulation. Leave them out."
            )
        else:
            self.outer.check(system, -np.inf, np.inf)
            self.analysis = timed(analysis, self.outer.times())
        self._deadline, self._seconds = np.inf, 0.0
        self.ending: tuple[float | None, float] = (None, 0.0)

    def _begin(self, start: Start | DesignStart | None, until: float) -> None:
        """Assemble the start of the simulations."""
        with collecting() as reported:
            self.start = DesignStart.of(self.system, start)
        self.outer.check(self.system, self.start.t, until)
        self.start_warnings = reported.messages  # of the assembly of the system itself
        self.start.refuse_moved(self.system, self._parameters)

    @property
    def options(self) -> dict[str, Any]:
        """The options with which the problem is made again, in another process."""
        named = {"design": self.design, "formula": self.formula}
        if self.analysis is not None:
            return {**named, "analysis": self.analysis, "time_limit": self.time_limit}
        beside = {"events": self.events, "controllers": self.controllers, "memory": self.memory}
        return {**named, **self.settings, **beside, "start": self.start}

    def end_after(self, seconds: float | None, since: float | None = None) -> None:
        """Limit the time of all simulations together.

        Parameters
        ----------
        seconds : without a limit none
        since : when they began, by the clock that processes share (``time.time()``); by default now
        """
        refuse_time_limit(seconds, "total_time_limit")
        if seconds is not None:
            begin = time.time() if since is None else since
            self.ending = seconds, begin
            self._deadline, self._seconds = time.perf_counter() + seconds - (time.time() - begin), seconds

    def model_of(self, system: System) -> Model:
        """The model of a design, with the inputs that controllers set."""
        return without_held(system.model, self.plain) if self.controllers else system.model

    @property
    def is_late(self) -> bool:
        """Whether the time limit has passed."""
        return time.perf_counter() > self._deadline

    def refuse_late(self) -> None:
        """Raise TimeLimit if the time limit has passed."""
        if self.is_late:
            raise TimeLimit(f"the time limit of {duration(self._seconds)} has passed")

    def restitutions_at(self, x: Array) -> dict[str, float]:
        """Return the restitutions of impacts of a design."""
        return self._parameters.restitutions_at([float(value) for value in x])

    def at(self, x: Array) -> Point:
        """Return the design with given values (p,); the last ones are cached.

        Raises
        ------
        Infeasible
            If there is no such model.
        ValueError
            For another number of values.
        """
        values = np.asarray(x, dtype=float)
        if values.shape != self.x0.shape:
            raise ValueError(self.expected())
        key = values.tobytes()
        if key not in self._points:
            self._points[key] = self._made(values.copy())
            while len(self._points) > CACHED:
                self._points.popitem(last=False)
        self._points.move_to_end(key)
        return self._points[key]

    def expected(self) -> str:
        """Return the message for a wrong number of values."""
        return f"{len(self.names)} values are expected, for {', '.join(self.names[:5])}"

    def _made(self, x: Array) -> Point:
        kind = Point if self.analysis is None else SolvedPoint
        if np.array_equal(x, self.x0):
            return kind(self, self.system, x)
        try:
            return kind(self, System(self._parameters.model_at([float(value) for value in x])), x)
        except SarrusError as error:
            raise DesignError(str(error)) from error

    def accepts(self, x: Array) -> bool:
        """Whether the model can be built of a design."""
        try:
            with np.errstate(all="ignore"):
                blueprint(self._parameters.model_at([float(value) for value in x]))
        except (SarrusError, ArithmeticError, ValueError):  # also of the user's formula
            return False
        return True

    def values(self, x: Array) -> Array:
        """Return the responses (r,)."""
        return self.at(x).values

    def gradient(self, x: Array) -> Gradient:
        """Return the responses and their gradients, by one adjoint sweep."""
        return self.at(x).gradient

    def value_and_grad(self, x: Array) -> tuple[float, Array]:
        """Return the first response and its gradient (p,), as ``scipy.optimize.minimize(..., jac=True)`` needs."""
        found = self.gradient(x)
        return float(found.values[0]), found.matrix[0]

    def jvp(self, x: Array, change: Array) -> Array:
        """Return the change of the responses (r,) for a change of the variables (p,), by one tangent sweep."""
        return self.at(x).along(np.asarray(change, dtype=float).reshape(-1, 1))[:, 0]

    def vjp(self, x: Array, weights: Array) -> Array:
        """Return the gradient (p,) of the weighted sum of the responses, by one adjoint sweep."""
        return self.at(x).gradient_of_sum(np.asarray(weights, dtype=float))

    def hvp(self, x: Array, direction: Array, response: int = 0) -> Array:
        """Return the Hessian of a response times a direction (p,), in two sweeps for each part of a `Combined` one."""
        return self.at(x).curved(np.asarray(direction, dtype=float), response)

    def hvp_of_sum(self, x: Array, direction: Array, weights: Array) -> Array:
        """Return the Hessian of the weighted sum of the responses times a direction (p,)."""
        rows = [k for k, weight in enumerate(weights) if weight]
        return sum((weights[k] * self.hvp(x, direction, k) for k in rows), np.zeros(len(self.names)))

    def limit(self, began: float) -> Callable[[float], None]:
        """Return the time limit of a simulation."""

        def watch(t: float) -> None:
            self.refuse_late()
            taken = time.perf_counter() - began
            if self.time_limit is not None and taken > self.time_limit:
                raise DesignError(
                    f"the simulation had come to t = {t:.4g} s when its {self.time_limit:.3g} s were over"
                )

        return watch

    def took(self, seconds: float) -> None:
        """Set the time limit from the duration of the first simulation."""
        if self.time_limit is None:
            self.time_limit = max(LEAST_LIMIT, LONGER * seconds)


def refuse_with_controllers(start: Any, memory: float | None) -> None:
    """Refuse what is not supported together with controllers.

    Raises
    ------
    ValueError
    """
    if memory is not None:
        raise ValueError("Problem: memory is not supported with controllers. Leave out memory=.")
    if not (start is None or isinstance(start, Mapping | DesignStart)):
        raise ValueError(
            "Problem: with controllers, start must be None or a mapping. Give rates of joints by {'rates': {...}}."
        )


def timed(analysis: Analysis, times: Sequence[float]) -> Analysis:
    """An analysis over time, with the times at which responses are taken among its own."""
    with_times: Callable[[Sequence[float]], Analysis] = getattr(analysis, "with_times", lambda _: analysis)
    return with_times(times)


class SolvedPoint(Point):
    """One design, analysed on demand; see `Point`."""

    def _simulated(self) -> Any:
        problem, began = self.problem, time.perf_counter()
        assert problem.analysis is not None
        problem.refuse_late()
        try:
            result = problem.analysis(self.system)
        except (ArithmeticError, SarrusError) as error:
            raise DesignError(str(error)) from error
        if str(getattr(result, "status", "")) == "stopped":
            raise KeyboardInterrupt
        if not is_solved(result):
            raise TypeError(
                "analysis: it must return the result of kinematics, inverse_dynamics, equilibrium, modes or linearize, "
                f"got {type(result).__name__}. For simulations give until=."
            )
        if not result.success:
            raise DesignError(result.message)
        problem.took(time.perf_counter() - began)
        return result

    def motion(self) -> Any:
        """The driven motion; None for an equilibrium and modes."""
        result: Any = self.run
        return result if isinstance(result, Trajectory) else None

    @property
    def nearest(self) -> bool:
        """Whether derivatives are known; these analyses refuse designs without any."""
        return True

    def _evaluated(self) -> Any:
        parts = self.problem.outer.parts
        try:
            evaluation: ResponsesOfResult = responses_of_result(self.run, parts, lambda _: self._variables)
        except SarrusError as error:  # a mode that only other designs have
            raise DesignError(str(error)) from error
        self._defined([part.title for part in parts], evaluation.values)
        return evaluation

    def _differentiated(self) -> Gradient:
        gradient: Gradient = self.evaluation().gradient()
        return gradient

    @property
    def slopes(self) -> Array:
        """The gradients of the responses (r, p)."""
        return self._known(self.gradient.matrix)

    def errors(self) -> list[ErrorEstimate]:
        """None: these analyses are exact to round-off."""
        return []

    def along(self, changes: Array) -> Array:
        """Changes of the responses (r, k) for changes of the variables (p, k)."""
        return np.asarray(self.slopes @ changes)

    def gradient_of_sum(self, weights: Array) -> Array:
        """The gradient (p,) of the responses' sum with weights (r,)."""
        return np.asarray(weights @ self.slopes)

    def _with_derivatives(self) -> tuple[list[Array], list[Array]]:
        evaluation = self.evaluation()
        return evaluation.signals, [self._known(slopes) for slopes in evaluation.changes()]

    def curved(self, direction: Array, response: int = 0) -> Array:
        """Second derivatives, which are not known.

        Raises
        ------
        NoDerivative
        """
        raise NoDerivative(
            f"{self.system.name}: second derivatives of this analysis are not known. Leave out second_order=True."
        )
