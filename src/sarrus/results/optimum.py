"""The result of an optimization."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..algebra import Array
from ..deferred import renderer
from ..model import Model
from .motion.trajectory import Trajectory
from .result import Result
from .saving.exported_file import exports


@dataclass(frozen=True, eq=False)
class StartReport:
    """What became of one start of several.

    Attributes
    ----------
    number : from 1, which is the system's own design
    x0 : the design from which the search began (p,)
    value : of the objective in the end, nan where the design cannot be simulated
    success : whether the search converged
    message : how it ended
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
    error : the estimated error of its value, by the errors of the simulation, see `Trajectory.error`; nan where the
        steps are not stored
    success : whether all constraints hold, and `optimality` is at most 0.01
    status : "converged", "not converged", "stopped" or "time limit"
    optimality : the predicted relative distance from the optimum: the larger of the change of a variable, over its
        value or size, and of the square root of the fall of the objective, over its changes in the search; 0 at an
        optimum. The same for an objective f as for a·f + b
    message : one message: the outcome
    history : (n, 3) of each simulation the objective; the size of its gradient by scaled variables, as far as it does
        not press against bounds, NaN where none was asked for; how far constraints are from being satisfied
    trace : (n, p) the values of the variables there
    constraints : values of the constrained responses by name
    covariance : (p, p) of fitted parameters; empty for other problems
    poor : combinations of parameters that the data hardly determine, in words
    spare : measured numbers beyond the fitted parameters
    quantile : standard deviations on both sides of a fitted parameter that hold 95 %
    feasible : whether all constraints hold
    failures : messages of the designs that could not be simulated
    starts : the optima from several starts, the best one first
    start_reports : what became of every start, in their order, also of those that cannot be simulated
    seconds : that it took
    model : the model of the best design
    run : its simulation
    unit, units : of the objective and of the variables; empty where they are not known
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
    unit: str = field(default="", repr=False)
    units: tuple[str, ...] = field(default=(), repr=False)

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

    @exports
    def to_csv(self, path: str | Path) -> None:
        """Write every simulation with its objective, size of gradient, gap in constraints, and variables."""
        head = ",".join(["objective", "gradient", "gap", *self.names])
        np.savetxt(
            path, np.hstack([self.history, self.trace]), delimiter=",", header=head, comments="", fmt="%.17g"
        )

    def table(self) -> str:
        """Return a table of the design variables before and after as text."""
        return str(renderer().optimum_table(self))

    def summary(self) -> str:
        """The result in words."""
        return self.table()

    def plot(self, ax: Any = None) -> Any:
        """Draw the convergence; see `sarrus.views.plot_convergence`."""
        return renderer().plot_convergence(self, ax)
