"""One design of an analysis that equations determine: an equilibrium, its modes, or a driven motion."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from ...algebra import Array
from ...model import SarrusError
from ...results import ErrorEstimate, Gradient, Trajectory
from ..position.assembly_derivatives import NoDerivative
from ..sensitivity.implicit.responses import ResponsesOfResult
from ..sensitivity.implicit.results import is_solved, responses_of_result
from .point import Infeasible, Point


class SolvedPoint(Point):
    """One design, analysed on demand; see `Point`."""

    def _simulated(self) -> Any:
        problem, began = self.problem, time.perf_counter()
        assert problem.analysis is not None
        problem.refuse_late()
        try:
            found = problem.analysis(self.system)
        except (ArithmeticError, SarrusError) as error:
            raise Infeasible(str(error)) from error
        if str(getattr(found, "status", "")) == "stopped":
            raise KeyboardInterrupt
        if not is_solved(found):
            raise TypeError(
                "analysis: it must return the result of kinematics, inverse_dynamics, equilibrium, modes or linearize, "
                f"got {type(found).__name__}. For simulations give until=."
            )
        if not found.success:
            raise Infeasible(found.message)
        problem.took(time.perf_counter() - began)
        return found

    def motion(self) -> Any:
        """The driven motion; None for an equilibrium and modes."""
        found: Any = self.run
        return found if isinstance(found, Trajectory) else None

    @property
    def nearest(self) -> bool:
        """Whether derivatives are known; these analyses refuse designs without any."""
        return True

    def _evaluated(self) -> Any:
        parts = self.problem.outer.parts
        try:
            found: ResponsesOfResult = responses_of_result(self.run, parts, lambda _: self._variables)
        except SarrusError as error:  # a mode that only other designs have
            raise Infeasible(str(error)) from error
        self._defined([part.title for part in parts], found.values)
        return found

    def _differentiated(self) -> Gradient:
        found: Gradient = self.evaluation().gradient()
        return found

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
        return evaluation.signals, [self._known(one) for one in evaluation.signals_along()]

    def curved(self, direction: Array, response: int = 0) -> Array:
        """Second derivatives, which are not known.

        Raises
        ------
        NoDerivative
        """
        raise NoDerivative(
            f"{self.system.name}: second derivatives of this analysis are not known. Leave out second_order=True."
        )
