"""The best design: SciPy's solvers with exact gradients of simulations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...algebra import Array
from ...results import Optimum
from ...system import System
from ..sensitivity.derivatives import as_responses
from ..sensitivity.responses import Output, Response
from .search import Bounds, Progress, Search
from .study import Infeasible, Point, Study


@dataclass(frozen=True, eq=False)
class Within:
    """A constraint: a response between two limits.

    Parameters
    ----------
    response : a response, or an output whose final value is meant
    lower, upper : None for no limit
    """

    response: Response | Output
    lower: float | None = None
    upper: float | None = None


def optimize(
    system: System,
    objective: Response | Output,
    wrt: Sequence[str] | None = None,
    *,
    until: float,
    bounds: Bounds | None = None,
    constraints: Sequence[Within] = (),
    design: Mapping[str, float] | None = None,
    formula: Any = None,
    solver: str | None = None,
    iterations: int = 100,
    tolerance: float = 1e-8,
    progress: Progress | None = None,
    **settings: Any,
) -> Optimum:
    """Change numbers of a model so that a response of its motion becomes least.

    Every design is assembled, simulated, and differentiated by one sweep backwards.

    Parameters
    ----------
    system : with the design at the start
    objective : what is made least, see `sensitivity`
    wrt : names of the design variables, see `sensitivity`
    until : end time of the simulation [s]
    bounds : limits by name, ``{"spring.k": (1, 100), "spring.c": (0, None)}``
    constraints : responses that must stay within limits
    design, formula : named design variables, and the function that gives numbers of the model from them
    solver : of `scipy.optimize.minimize`: "L-BFGS-B" by default, "SLSQP" with constraints, or "trust-constr"
    iterations, tolerance : when the solver ends
    progress : called with the number of the simulation and the objective
    settings : ``method``, ``rtol`` and ``atol`` of the simulation

    Returns
    -------
    Optimum
        With ``success`` false and a sentence where the solver did not converge; the best design is kept.

    Raises
    ------
    ValueError
        For bounds of unknown variables.
    SarrusError
        If the first design cannot be simulated.
    """
    from scipy.optimize import minimize

    wanted = [objective, *(one.response for one in constraints)]
    study = Study(system, as_responses(wanted), wrt, until, design, formula, **settings)
    search = Search(study, bounds, progress)
    first = search.point.gradient
    size = abs(first.values[0]) or 1.0
    chosen = solver or ("SLSQP" if constraints else "L-BFGS-B")
    limits = {"maxiter": iterations}
    found = _Least()

    def value_and_slope(z: Array) -> tuple[float, Array]:
        try:
            point = search.at(z)
            gradient = point.gradient
        except Infeasible:
            return np.inf, np.zeros(len(z))
        value, slope = float(gradient.values[0]), gradient.matrix[0]
        search.note(point, value, slope)
        found.look(value, point, constraints)
        return value / size, slope * search.scale / size

    answer = minimize(
        value_and_slope, search.x0 / search.scale, jac=True, method=chosen, bounds=search.scaled_limits,
        constraints=[c for n, one in enumerate(constraints) for c in _scipy(search, n + 1, one)],
        tol=tolerance, options=limits,
    )  # fmt: skip
    return _optimum(search, found, first.values[0], bool(answer.success), str(answer.message), constraints)


class _Least:
    """The best design seen."""

    def __init__(self) -> None:
        self.value = np.inf
        self.point: Point | None = None
        self._gap = np.inf

    def look(self, value: float, point: Point, constraints: Sequence[Within]) -> None:
        """Keep a design that is better: first in its constraints, then in its objective."""
        gap = max(
            (_gap(v, one) for v, one in zip(point.gradient.values[1:], constraints, strict=True)), default=0.0
        )
        if gap < self._gap - 1e-9 or (gap <= self._gap + 1e-9 and value < self.value):
            self._gap, self.value, self.point = gap, value, point


def _gap(value: float, one: Within) -> float:
    """How far a constraint is from being satisfied."""
    low = -np.inf if one.lower is None else one.lower
    high = np.inf if one.upper is None else one.upper
    return float(max(low - value, value - high, 0.0))


def _scipy(search: Search, row: int, one: Within) -> list[dict[str, Any]]:
    """A constraint as inequalities ≥ 0, divided by the size of their limits."""
    found = []
    for sign, limit in ((1.0, one.lower), (-1.0, one.upper)):
        if limit is not None:
            weight = sign / (abs(limit) or 1.0)
            found.append(_inequality(search, row, weight, limit))
    return found


def _inequality(search: Search, row: int, weight: float, limit: float) -> dict[str, Any]:
    def value(z: Array) -> float:
        return weight * (float(search.at(z).gradient.values[row]) - limit)

    def slope(z: Array) -> Array:
        return np.asarray(weight * search.at(z).gradient.matrix[row] * search.scale)

    return {"type": "ineq", "fun": value, "jac": slope}


def _optimum(
    search: Search, found: _Least, value0: float, success: bool, message: str, constraints: Sequence[Within]
) -> Optimum:
    point = found.point if found.point is not None else search.first
    values = point.gradient.values
    told = Optimum(
        tuple(search.names), point.parameters.values, search.x0, float(values[0]), float(value0), success,
        f"{message.rstrip('.').lower()} after {len(search.history)} simulations",
        np.array(search.history).reshape(-1, 2), np.array(search.trace).reshape(-1, len(search.names)),
    )  # fmt: skip
    named = (
        dict(zip(point.gradient.responses[1:], map(float, values[1:]), strict=True)) if constraints else {}
    )
    return replace(told, constraints=named, model=point.system.model, run=point.run)
