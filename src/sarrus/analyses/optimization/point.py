"""One design of a problem: its simulation, responses and derivatives, on demand."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from ...algebra import Array
from ...model import SarrusError
from ...model.announcement import announce, collecting
from ...results import Assembly, ErrorEstimate, Gradient, Segments, StepsTaken, Trajectory
from ...system import System
from ..dynamics import Event, simulate
from ..dynamics.events.events import with_restitutions
from ..dynamics.run_options import events_of
from ..dynamics.stepping.stepper import RunFailure
from ..position.assembly_derivatives import NoDerivative
from ..sensitivity.chain.chain import FIELDS, Nodes, by_joints
from ..sensitivity.checkpoints import repeated_gradient
from ..sensitivity.error_estimates import effects_of, estimated
from ..sensitivity.gradients import differentiated, own_parts
from ..sensitivity.hessian import Curvature
from ..sensitivity.long_run import recipe_with_steps
from ..sensitivity.parameters.contradictions import refuse
from ..sensitivity.parameters.parameters import Parameters
from ..sensitivity.responses.evaluation import Evaluation
from ..sensitivity.responses.undefined import UndefinedResponse, refuse_undefined
from ..sensitivity.run_chain import RunChain
from ..sensitivity.sampling.segments import NoSample

if TYPE_CHECKING:
    from .problem import Problem

Kind = TypeVar("Kind")


class DesignError(SarrusError):
    """A design that cannot be simulated."""


class Point:
    """One design, simulated on demand."""

    def __init__(self, problem: Problem, system: System, x: Array) -> None:
        self.problem, self.system, self.x = problem, system, x
        self._run: Trajectory | None = None
        self._evaluation: Any = None
        self._gradient: Gradient | None = None
        self._failure = ""
        self._signals: tuple[list[Array], list[Array]] | None = None
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
            raise DesignError(self._failure)
        try:
            return make()
        except DesignError as error:
            self._failure = str(error)
            raise
        except UndefinedResponse as error:
            self._failure = str(error)
            raise DesignError(self._failure) from error

    def _simulated(self) -> Trajectory:
        problem, began = self.problem, time.perf_counter()
        run = self._simulate([problem.settings["until"]], problem.limit(began))
        if run.status == "stopped" and "by the user" in run.message:
            raise KeyboardInterrupt
        if not run.success:
            raise DesignError(run.message)
        problem.took(time.perf_counter() - began)
        return run

    def motion(self) -> Trajectory:
        """The same simulation at the default output times, which do not influence its steps."""
        with collecting():
            run = self._simulate(None, False)
        return run if run.success else self.run

    def _simulate(self, times: list[float] | None, progress: Callable[[float], None] | bool) -> Trajectory:
        problem = self.problem
        return simulate(
            self.system, self.start, **problem.settings, events=self.events, controllers=problem.controllers,
            t_eval=times, store="steps" if problem.memory is None else "samples", progress=progress,
        )  # fmt: skip

    @cached_property
    def start(self) -> Assembly:
        """The state from which it starts.

        Raises
        ------
        Infeasible
        """
        if self.system is self.problem.system:
            start = self.problem.start.first
            announce(self.problem.start_warnings)
        else:
            start = self._start_of_design()
        if not start.success:
            raise DesignError(start.message)
        return start

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
                raise DesignError(str(error)) from None

    @property
    def events(self) -> list[Event | float]:
        """The events, with the restitutions of this design, and breakpoints.

        Raises
        ------
        Infeasible
            If one is not between 0 and 1, where only bounds keep an optimizer.
        """
        try:
            events, breakpoints = events_of(self.problem.events)
            return [*with_restitutions(events, self._restitutions), *breakpoints]
        except ValueError as error:
            raise DesignError(str(error)) from None

    @cached_property
    def _restitutions(self) -> dict[str, float]:
        return self.problem.restitutions_at(self.x)

    @property
    def design(self) -> dict[str, float]:
        """The design variables with their values."""
        return dict(zip(self.problem.names, map(float, self.x), strict=True))

    def _named(self) -> dict[str, Any]:
        design = self.problem.design
        if design is not None:
            design = {name: self.design.get(name, value) for name, value in design.items()}
        return {"wrt": self.problem.names, "design": design, "formula": self.problem.formula}

    @cached_property
    def _variables(self) -> Parameters:
        start = self.start if self.problem.analysis is None else None
        return Parameters(self.system, **self._named(), start=start, restitutions=self._restitutions)

    @property
    def _steps(self) -> StepsTaken | Segments:
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
            evaluation = Evaluation(self.system, self._steps, parts, self._variables)
        except NoSample as error:
            raise DesignError(str(error)) from None
        self._defined([part.title for part in parts], evaluation.values)
        return evaluation

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
            raise DesignError(self._failure) from error
        return values

    @property
    def slopes(self) -> Array:
        """The gradients of the responses (r, p).

        Raises
        ------
        NoDerivative
            For a variable whose change alone contradicts equations that others imply, or has no derivative otherwise.
        """
        gradient = self.gradient
        if gradient.undefined and self.problem.memory is None:
            self._parameters()
        return self._known(gradient.matrix)

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
        gradient = self.problem.outer.gradient(self.of_parts(), self.system)
        self._defined(gradient.responses, gradient.values)
        return gradient

    def of_parts(self) -> Gradient:
        """The gradients of all responses of which those asked for are made."""
        if self._gradient is None:
            self._gradient = self._feasible(self._differentiated)
        return self._gradient

    def _differentiated(self) -> Gradient:
        problem, began = self.problem, time.perf_counter()
        parts, variables = problem.outer.parts, self._variables
        if problem.memory is None:
            return differentiated(self.system, self._steps, parts, variables, evaluation=self.evaluation())
        watch, until = problem.limit(began), problem.settings["until"]

        def progress(t: float) -> None:  # the limit is that of the simulation
            if t <= until:
                watch(t)

        try:
            recipe = recipe_with_steps(self.system, self.start, **problem.settings, events=self.events)
            gradient = repeated_gradient(recipe, parts, variables, problem.memory, progress=progress)
        except (RunFailure, NoSample) as error:
            raise DesignError(str(error)) from None
        problem.took(time.perf_counter() - began)
        return gradient

    def errors(self) -> list[ErrorEstimate]:
        """The estimated errors of the responses, by one sweep backwards; none where the steps are not stored."""
        if self.problem.memory is not None:
            return []
        outer, evaluation = self.problem.outer, self.evaluation()
        effects = effects_of(self.system, self._steps, self._chain().adjoints(evaluation.gradients()[0]))
        return outer.errors(estimated(outer.parts, evaluation, effects))

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
        gradient = parameters.gradient(
            replace(by, b=by.b + explicit.b @ column), by_joints(explicit.c @ column, by.c)
        )
        return self._known((gradient.T + column.T @ own_parts(explicit, parameters))[0])

    def curved(self, direction: Array, response: int = 0) -> Array:
        """The Hessian of a response times a direction (p,)."""
        outer, values = self.problem.outer, self.evaluation().values

        def times(place: int, by: Array) -> Array:
            return self._curvature(place).times(by)

        return outer.curved(response, values, lambda: self.of_parts().matrix, times, direction)

    def _curvature(self, place: int) -> Curvature:
        """The Hessian of one part, in products."""
        if place not in self._curvatures:
            steps, parameters = self._steps, self._parameters()
            response = self.problem.outer.parts[place]
            evaluation = Evaluation(self.system, steps, [response], parameters)
            self._curvatures[place] = Curvature(self._chain(), evaluation, parameters)
        return self._curvatures[place]

    def signals(self) -> tuple[list[Array], list[Array]]:
        """The output of every response at its times (nt,), and its derivatives (nt, p), by one sweep forwards."""
        if self._signals is None:
            self._signals = self._with_derivatives()
        return self._signals

    def _with_derivatives(self) -> tuple[list[Array], list[Array]]:
        parameters, evaluation = self._parameters(), self.evaluation()
        every = np.eye(len(parameters.names))
        b, q, v, c = parameters.along(every)
        named = dict(zip(parameters.names, every, strict=True))
        return list(evaluation.signals), evaluation.signals_along(
            self._chain().along(b, q, v, c), b, c, named
        )

    def _chain(self) -> RunChain:
        return RunChain(self.system, self._steps, self._variables.restitutions)
