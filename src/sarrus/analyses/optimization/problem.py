"""A simulation as a function of its design variables: responses, exact gradients, products with vectors."""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, TypeAlias, TypeVar

import numpy as np

from ...algebra import Array
from ...defaults import ATOL
from ...model import SarrusError
from ...model.announcement import announce, collecting
from ...results import Assembly, ErrorEstimate, Gradient, Pieces, StepsTaken, Trajectory
from ...system import System
from ..dynamics import HHT, Event, GeneralizedAlpha, Radau, simulate
from ..dynamics.events.events import restitutions_of, with_restitutions
from ..dynamics.stepping.stepper import RunFailure
from ..position.assembly_derivatives import NoDerivative
from ..position.initial_state import Start
from ..progress import TimeLimit, duration, refuse_time_limit
from ..sensitivity.accuracy.estimate import estimated
from ..sensitivity.chain.chain import FIELDS, Nodes, by_joints
from ..sensitivity.checkpoints import LongTask
from ..sensitivity.derivatives import (
    UndefinedResponse,
    differentiated,
    own_parts,
    refuse_undefined,
)
from ..sensitivity.events.chains import AnyChain, chain_of
from ..sensitivity.hessian import Curvature
from ..sensitivity.parameters.design_start import DesignStart
from ..sensitivity.parameters.parameters import Design, Parameters
from ..sensitivity.parameters.undefined import refuse
from ..sensitivity.responses.evaluation import Evaluation
from ..sensitivity.sampling.sampling import NotThere
from .combined import Outer, Part

Kind = TypeVar("Kind")
CACHED = 3  # designs whose simulations are remembered
LEAST_LIMIT, LONGER = 10.0, 20.0  # [s], [-] a simulation may take so many times as long as the first one


Analysis: TypeAlias = Callable[[System], Any]


class Infeasible(SarrusError):
    """A design that cannot be simulated."""


class Problem:
    """Responses of a simulation or another analysis as a function of design variables, with derivatives.

    Parameters
    ----------
    system : with the design at the start
    responses : one or several, see `sensitivity`, or `Combined` ones
    wrt : names of the design variables, see `sensitivity`
    until : end time of the simulation [s]
    analysis : instead of a simulation, `Kinematics`, `Statics`, `Vibration`, or a function of the system that returns
        the result of `kinematics`, `inverse_dynamics`, `equilibrium` or `modes`
    start : as for `simulate`. An `Assembly`, rates of joints (``{"rates": {"pin": 5.0}}``) and coordinates are
        assembled again for every design, an `Equilibrium` (``{"equilibrium": True}``) is found again, both with their
        derivatives in the gradients. A function of the system is called for every design. The state of a run
        (``run.final``) is fixed: variables that change constraints are refused. By default the model's own state,
        assembled for every design
    design : values of named design variables at the start
    formula : the function that computes parameters of the model from them; differentiated exactly
    method : `Radau` (the default), whose values have the least noise, `HHT`, or `GeneralizedAlpha`
    rtol, atol, max_step : tolerances and longest step of the simulation
    events : of the simulation; restitutions of impacts, ``stop.restitution``, may be design variables. A design whose
        run lacks an event or a time of a response counts as one that cannot be simulated
    memory : for stored states and steps [bytes], see `sensitivity_by_checkpoints`; by default all steps are stored.
        Only values and gradients are available then
    time_limit : seconds after which a simulation is stopped; by default twenty times the duration of the first one, at
        least 10 s

    Attributes
    ----------
    names, units : of the design variables
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
        method: HHT | GeneralizedAlpha | Radau | None = None,
        rtol: float | None = None,
        atol: float | None = ATOL,
        max_step: float = np.inf,
        events: Event | Sequence[Event] = (),
        memory: float | None = None,
        time_limit: float | None = None,
    ) -> None:
        refuse_time_limit(time_limit)
        if (until is None) == (analysis is None):
            raise TypeError(
                "Problem: give until=, the end of a simulation, or analysis=, such as sr.Statics() or sr.Vibration()."
            )
        self.system, self.given, self.outer = system, responses, Outer(responses)
        self.design, self.formula = design, formula
        until = 0.0 if until is None else float(until)
        self.settings: dict[str, Any] = {
            "method": method,
            "until": until,
            "rtol": rtol,
            "atol": atol,
            "max_step": max_step,
            "events": [events] if isinstance(events, Event) else list(events),
        }
        self.time_limit, self.memory = time_limit, memory
        self.restitutions = restitutions_of(self.settings["events"])
        self._parameters = Parameters(
            system, wrt, design=design, formula=formula, restitutions=self.restitutions
        )
        self.names, self.units = tuple(self._parameters.names), self._parameters.units
        self.x0: Array = self._parameters.values.copy()
        self.titles = self.outer.titles
        self._points: OrderedDict[bytes, Point] = OrderedDict()
        self.start_warnings: tuple[str, ...] = ()
        if analysis is None:
            self._begin(start, until)
        elif start is not None or memory is not None or self.settings["events"] or method is not None:
            raise TypeError(
                "Problem: start, events, method and memory are those of a simulation. Leave them out."
            )
        else:
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
        return {**named, **self.settings, "memory": self.memory, "start": self.start}

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
        if self.analysis is None:
            kind = Point
        else:
            from .solved_point import SolvedPoint as kind
        if np.array_equal(x, self.x0):
            return kind(self, self.system, x)
        try:
            return kind(self, System(self._parameters.model_at([float(value) for value in x])), x)
        except SarrusError as error:
            raise Infeasible(str(error)) from error

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
                raise Infeasible(
                    f"the simulation had come to t = {t:.4g} s when its {self.time_limit:.3g} s were over"
                )

        return watch

    def took(self, seconds: float) -> None:
        """Set the time limit from the duration of the first simulation."""
        if self.time_limit is None:
            self.time_limit = max(LEAST_LIMIT, LONGER * seconds)


def timed(analysis: Analysis, times: Sequence[float]) -> Analysis:
    """An analysis over time, with the times at which responses are taken among its own."""
    with_times: Any = getattr(analysis, "with_times", lambda _: analysis)
    found: Analysis = with_times(times)
    return found


class Point:
    """One design, simulated on demand."""

    def __init__(self, problem: Problem, system: System, x: Array) -> None:
        self.problem, self.system, self.x = problem, system, x
        self._run: Trajectory | None = None
        self._evaluation: Any = None
        self._gradient: Gradient | None = None
        self._failure = ""
        self._curvatures: dict[int, Curvature] = {}

    @property
    def run(self) -> Trajectory:
        """Its simulation.

        Raises
        ------
        Infeasible
            If it cannot be assembled, or the run does not reach its end.
        """
        if self._run is None:
            self._run = self._feasible(self._simulated)
        return self._run

    def _feasible(self, make: Callable[[], Kind]) -> Kind:
        """Return the result of a simulation; a failure is stored."""
        if self._failure:
            raise Infeasible(self._failure)
        try:
            return make()
        except Infeasible as error:
            self._failure = str(error)
            raise

    def _simulated(self) -> Trajectory:
        problem, began = self.problem, time.perf_counter()
        times = {"t_eval": [problem.settings["until"]], "store_steps": problem.memory is None}
        run = simulate(
            self.system, self.start, **problem.settings | {"events": self.events} | times,
            progress=problem.limit(began),
        )  # fmt: skip
        if run.status == "stopped" and "by the user" in run.message:
            raise KeyboardInterrupt
        if not run.success:
            raise Infeasible(run.message)
        problem.took(time.perf_counter() - began)
        return run

    def motion(self) -> Trajectory:
        """The same simulation at the default output times, which do not influence its steps."""
        settings = {"t_eval": None, **self.problem.settings, "events": self.events}
        with collecting():
            run = simulate(
                self.system, self.start, **settings, store_steps=self.problem.memory is None, progress=False
            )
        return run if run.success else self.run

    @cached_property
    def start(self) -> Assembly:
        """The state from which it starts.

        Raises
        ------
        Infeasible
        """
        if self.system is self.problem.system:
            found = self.problem.start.first
            announce(self.problem.start_warnings)
        else:
            found = self._start_of_design()
        if not found.success:
            raise Infeasible(found.message)
        return found

    @property
    def nearest(self) -> bool:
        """Whether the start is known to be the nearest one to its estimate."""
        return self.start.nearest

    def _start_of_design(self) -> Assembly:
        """Return the start of another design; poses of bodies that assembly moves are estimates."""
        with collecting():
            try:
                return self.problem.start.at(self.system)
            except SarrusError as error:
                raise Infeasible(str(error)) from None

    @property
    def events(self) -> list[Event]:
        """The events, with the restitutions of this design.

        Raises
        ------
        Infeasible
            If one is not between 0 and 1, where only bounds keep an optimizer.
        """
        try:
            return with_restitutions(self.problem.settings["events"], self._restitutions)
        except ValueError as error:
            raise Infeasible(str(error)) from None

    @cached_property
    def _restitutions(self) -> dict[str, float]:
        return self.problem.restitutions_at(self.x)

    @property
    def design(self) -> dict[str, float]:
        """The design variables with their values."""
        return dict(zip(self.problem.names, map(float, self.x), strict=True))

    def _named(self) -> dict[str, Any]:
        design, own = self.problem.design, self.design
        values = None if design is None else {name: own.get(name, value) for name, value in design.items()}
        return {"wrt": self.problem.names, "design": values, "formula": self.problem.formula}

    @cached_property
    def _variables(self) -> Parameters:
        start = self.start if self.problem.analysis is None else None
        return Parameters(self.system, **self._named(), start=start, restitutions=self._restitutions)

    @property
    def _steps(self) -> StepsTaken | Pieces:
        """The steps of the simulation.

        Raises
        ------
        ValueError
        """
        if self.problem.memory is not None:
            raise ValueError("with memory= there are values and gradients only. Leave it out for the rest.")
        steps = self.run.steps
        assert steps is not None
        return steps

    def _parameters(self) -> Parameters:
        """The variables, each of which must have derivatives."""
        refuse(self.system, self._steps, self._variables)
        return self._variables

    def evaluation(self) -> Any:
        """The responses with their outputs over time: values, signals."""
        if self._evaluation is None:
            self._evaluation = self._feasible(self._evaluated)
        return self._evaluation

    def _evaluated(self) -> Evaluation:
        parts = self.problem.outer.parts
        try:
            found = Evaluation(self.system, self._steps, parts, self._variables)
        except NotThere as error:
            raise Infeasible(str(error)) from None
        self._defined([part.title for part in parts], found.values)
        return found

    @property
    def values(self) -> Array:
        """Return the responses (r,)."""
        known = self.evaluation() if self.problem.memory is None else self.of_parts()
        return self._defined(self.problem.titles, self.problem.outer.values(known.values))

    def _defined(self, titles: Sequence[str], values: Array) -> Array:
        """The values, all of which must be numbers."""
        try:
            refuse_undefined(titles, values)
        except UndefinedResponse as error:
            self._failure = str(error)
            raise Infeasible(self._failure) from error
        return values

    @property
    def slopes(self) -> Array:
        """The gradients of the responses (r, p).

        Raises
        ------
        NoDerivative
            For a variable whose change alone contradicts equations that others imply, or has no derivative otherwise.
        """
        found = self.gradient
        if found.undefined and self.problem.memory is None:
            self._parameters()
        return self._known(found.matrix)

    def _known(self, derivatives: Array) -> Array:
        """Derivatives by the variables (…, p), all of which are there."""
        missing = np.flatnonzero(np.isnan(derivatives).reshape(-1, len(self.problem.names)).any(axis=0))
        if len(missing):
            name = self.problem.names[missing[0]]
            raise NoDerivative(
                f"{self.system.name}: responses have no derivative by {name} at this design. Move it."
            )
        return derivatives

    @property
    def gradient(self) -> Gradient:
        """Responses and their gradients, by one sweep backwards."""
        found, outer = self.of_parts(), self.problem.outer
        values, slopes = outer.linear(found.values)
        self._defined(outer.titles, values)
        units = outer.units(self.system)
        return replace(
            found, responses=outer.titles, values=values, matrix=slopes @ found.matrix, response_units=units
        )

    def of_parts(self) -> Gradient:
        """The gradients of all responses of which those asked for are made."""
        if self._gradient is None:
            self._gradient = self._feasible(self._differentiated)
        return self._gradient

    def _differentiated(self) -> Gradient:
        problem, began = self.problem, time.perf_counter()
        parts, own = problem.outer.parts, self._variables
        if problem.memory is None:
            return differentiated(self.system, self._steps, parts, own, evaluation=self.evaluation())
        how = problem.settings | {"events": self.events, "memory": problem.memory}
        try:
            found = LongTask(self.start, **how, progress=problem.limit(began)).gradient(
                self.system, parts, own
            )
        except (RunFailure, NotThere, UndefinedResponse) as error:
            raise Infeasible(str(error)) from None
        problem.took(time.perf_counter() - began)
        return found

    def errors(self) -> list[ErrorEstimate]:
        """The estimated errors of the responses, by one sweep backwards; none where the steps are not stored."""
        if self.problem.memory is not None:
            return []
        outer, evaluation, adjoints = self.problem.outer, self.evaluation(), list[Array]()
        self._chain().gradients(evaluation.gradients()[0], adjoints)
        given = self.system, self._steps, outer.parts, evaluation, adjoints
        return outer.errors(estimated(*given))

    def along(self, changes: Array) -> Array:
        """Changes of the responses (r, k) for changes of the variables (p, k), by one sweep forwards."""
        parameters, evaluation = self._parameters(), self.evaluation()
        b, q, v, c = parameters.along(changes)
        nodes, explicit = evaluation.gradients()
        named = own_parts(explicit, parameters)
        total = self._chain().weighed(nodes, b, q, v, c) + explicit.b.T @ b + explicit.c.T @ c
        return np.asarray(self.problem.outer.linear(evaluation.values)[1] @ (total + named @ changes))

    def gradient_of_sum(self, weights: Array) -> Array:
        """The gradient (p,) of the responses' sum with weights (r,): one column, however many responses there are."""
        parameters, evaluation = self._parameters(), self.evaluation()
        nodes, explicit = evaluation.gradients()
        column = (weights @ self.problem.outer.linear(evaluation.values)[1])[:, None]
        by = self._chain().gradients(Nodes(*(getattr(nodes, name) @ column for name in FIELDS)))
        found = parameters.gradient(
            replace(by, b=by.b + explicit.b @ column), by_joints(explicit.c @ column, by.c)
        )
        return self._known((found.T + column.T @ own_parts(explicit, parameters))[0])

    def curved(self, direction: Array, response: int = 0) -> Array:
        """The Hessian of a response times a direction (p,)."""
        outer, values = self.problem.outer, self.evaluation().values
        place = outer.place(response)
        slopes = outer.linear(values)[1][response, place]
        parts = range(place.start, place.stop)
        bends = [
            slope * self._curvature(n).times(direction)
            for slope, n in zip(slopes, parts, strict=True)
            if slope
        ]
        found = np.sum(bends, axis=0) if bends else np.zeros(len(direction))
        if outer.is_combined(response):
            matrix = self.of_parts().matrix[place]
            found = found + outer.slopes_along(response, values, matrix @ direction) @ matrix
        return np.asarray(found)

    def _curvature(self, place: int) -> Curvature:
        """The Hessian of one part, in products."""
        if place not in self._curvatures:
            steps, parameters = self._steps, self._parameters()
            evaluation = Evaluation(self.system, steps, [self.problem.outer.parts[place]], parameters)
            self._curvatures[place] = Curvature(self._chain(), evaluation, parameters)
        return self._curvatures[place]

    def signals(self) -> tuple[list[Array], list[Array]]:
        """The output of every response at its times (nt,), and its derivatives (nt, p), by one sweep forwards."""
        parameters, evaluation = self._parameters(), self.evaluation()
        every = np.eye(len(parameters.names))
        b, q, v, c = parameters.along(every)
        named = dict(zip(parameters.names, every, strict=True))
        return list(evaluation.signals), evaluation.signals_along(
            self._chain().along(b, q, v, c), b, c, named
        )

    def _chain(self) -> AnyChain:
        return chain_of(self.system, self._steps, self._variables.restitutions)
