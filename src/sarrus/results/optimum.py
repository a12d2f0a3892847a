"""The result of an optimization."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..algebra import Array
from ..deferred import renderer
from ..model import Model
from .motion.trajectory import Trajectory
from .result import Result
from .saving.exported_file import write_table


class Fitted(NamedTuple):
    """Measurements of an output, and its values in the fitted simulation.

    Attributes
    ----------
    output : its name
    unit : of the output; empty if not known
    t : times [s] (n,)
    data, sigma : measured values (n,) and their standard deviation
    values : of the simulation at these times (n,)
    """

    output: str
    unit: str
    t: Array
    data: Array
    sigma: float
    values: Array


@dataclass(frozen=True, eq=False)
class StartReport:
    """Outcome of one of several starts.

    Attributes
    ----------
    number : from 1, which is the system's own design
    x0 : the design from which the search began (p,)
    value : final value of the objective, NaN if the design cannot be simulated
    success : whether the search converged
    message : the outcome
    """

    number: int
    x0: Array = field(repr=False)
    value: float
    success: bool
    message: str


@dataclass(frozen=True, eq=False)
class Optimum(Result):
    """Result of `optimize` and `fit`: the best design.

    Attributes
    ----------
    names : of the design variables
    x, x0 : their values, and those at the start (p,)
    value, value0 : of the objective
    error : estimated error of the value from the errors of the simulation, see `Trajectory.error`; NaN if the steps
        are not stored
    success : whether all constraints hold, and `optimality` is at most 0.01
    status : "converged", "not converged", "stopped" or "time limit"
    optimality : the predicted relative distance from the optimum, 0 at an optimum: the largest change of a variable,
        relative to its value or size, or the square root of the decrease of the objective, relative to its changes in
        the search, if that is larger. It is the same for the objectives f and a·f + b
    message : the outcome
    history : (n, 3) for each simulation the objective, the norm of its gradient by scaled variables without components
        against bounds (NaN without a gradient), and the violation of the constraints
    trace : (n, p) values of the variables in each simulation
    constraints : values of the constrained responses by name
    covariance : (p, p) of fitted parameters; empty for other problems
    poor : text about combinations of parameters that the data hardly determine
    spare : number of measured values minus number of fitted parameters
    quantile : number of standard deviations of the 95 % confidence interval
    feasible : whether all constraints hold
    failures : messages of the designs that could not be simulated
    starts : the optima from several starts, the best one first
    start_reports : outcome of every start in order, including those that cannot be simulated
    seconds : duration of the search
    model : the model of the best design
    run : the simulation of the best design
    measurements : those of a fit, with the values of the best design
    unit, units : of the objective and of the variables; empty if not known
    table_units : units in which tables show the variables, such as mm; empty for `units`
    """

    names: tuple[str, ...]
    x: Array
    x0: Array = field(repr=False)
    value: float
    value0: float
    success: bool
    message: str
    history: Array = field(repr=False)
    trace: Array = field(repr=False)
    constraints: Mapping[str, float] = field(default_factory=dict)
    covariance: Array = field(default_factory=lambda: np.zeros((0, 0)), repr=False)
    poor: tuple[str, ...] = ()
    spare: int = 0
    quantile: float = 0.0
    failures: tuple[str, ...] = field(default=(), repr=False)
    starts: tuple[Optimum, ...] = field(default=(), repr=False)
    start_reports: tuple[StartReport, ...] = field(default=(), repr=False)
    status: str = "converged"
    optimality: float = 0.0
    feasible: bool = True
    seconds: float = field(default=0.0, repr=False)
    error: float = float("nan")
    model: Model | None = field(default=None, repr=False)
    run: Trajectory | None = field(default=None, repr=False)
    measurements: tuple[Fitted, ...] = field(default=(), repr=False)
    unit: str = field(default="", repr=False)
    units: tuple[str, ...] = field(default=(), repr=False)
    table_units: tuple[str, ...] = field(default=(), repr=False)

    def __getitem__(self, name: str) -> float:
        """The value of a design variable.

        Raises
        ------
        KeyError
            If there is none of this name.
        """
        if name not in self.names:
            raise KeyError(f"There is no design variable {name!r}. Choose from {', '.join(self.names)}.")
        return float(self.x[self.names.index(name)])

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.names)

    @property
    def deviations(self) -> Array:
        """The standard deviations of fitted parameters (p,)."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def correlations(self) -> Array:
        """The correlations of fitted parameters (p, p)."""
        return np.asarray(self.covariance / np.outer(self.deviations, self.deviations))

    def interval(self, name: str) -> tuple[float, float]:
        """Return the 95 % confidence interval of a fitted parameter."""
        value, wide = self[name], self.quantile * float(self.deviations[self.names.index(name)])
        return value - wide, value + wide

    def to_csv(self, path: str | Path) -> None:
        """Write every simulation with its objective, size of gradient, gap in constraints, and variables."""
        rows = np.hstack([self.history, self.trace]).tolist()
        write_table(path, ["objective", "gradient", "gap", *self.names], rows)

    def table(self) -> str:
        """Return a table of the design variables before and after as text."""
        return str(renderer().optimum_table(self))

    def summary(self) -> str:
        """The result in words."""
        return self.table()

    def plot(self, ax: Any = None) -> Any:
        """Draw the convergence; see `sarrus.views.plot_convergence`."""
        return renderer().plot_convergence(self, ax)

    def plot_fit(self, ax: Any = None) -> Any:
        """Draw the fitted simulation over its measurements; see `sarrus.views.plot_fit`."""
        return renderer().plot_fit(self, ax)
