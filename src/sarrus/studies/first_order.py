"""Uncertainty of responses to first order, from one run and one adjoint sweep instead of thousands of random runs.

With independent parameters of mean μ_i and standard deviation σ_i a response R has about the mean R(μ) and the variance
Σ (∂R/∂μ_i σ_i)². It is what Monte Carlo converges to where R is nearly linear over the spread of the parameters.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..analyses import Limits, simulate
from ..analyses.progress import Progress
from ..analyses.sensitivity import sensitivity
from ..analyses.sensitivity.combined import Composite
from ..analyses.sensitivity.parameters.design_start import DesignStart
from ..analyses.sensitivity.parameters.parameters import Parameters as Variables
from ..model import Model, SarrusError
from ..model.announcement import announce, reports_warnings
from ..outputs.output import labelled
from ..results.result import Result
from ..system import System
from .conduct import Request, ask
from .parameters import Array, Distribution, Parameter, Range, Values
from .responses import differentiable
from .runs import Simulation
from .samples import Listed
from .source import Start


@dataclass(frozen=True, eq=False)
class Uncertainty(Result):
    """Result of `uncertainty`: means and standard deviations of responses, to first order.

    Attributes
    ----------
    parameters, responses : names
    values : (r,) the responses at the means of the parameters
    matrix : (r, p) their derivatives there
    deviations : (p,) standard deviations of the parameters
    std : (r,) of the responses
    units : of the responses; empty where they are not known
    """

    parameters: tuple[str, ...]
    responses: tuple[str, ...]
    values: Array = field(repr=False)
    matrix: Array = field(repr=False)
    deviations: Array = field(repr=False)
    units: tuple[str, ...] = field(default=(), repr=False)

    @property
    def std(self) -> Array:
        """√(Σ (∂R/∂μ_i σ_i)²) (r,)."""
        return np.asarray(np.sqrt(np.sum((self.matrix * self.deviations) ** 2, axis=1)))

    @property
    def shares(self) -> Array:
        """The fraction of the variance of each response that is due to each parameter (r, p); rows add up to 1."""
        parts = (self.matrix * self.deviations) ** 2
        whole = parts.sum(axis=1, keepdims=True)
        return np.asarray(parts / np.where(whole > 0, whole, 1.0))

    def summary(self) -> str:
        """The result in words."""
        names = [*map(labelled, self.responses, self.units or [""] * len(self.responses))]
        width = max(8, *map(len, names))
        lines = [f"{'response':<{width}}{'mean':>14}{'std':>14}  parts in the variance"]
        for name, mean, std, parts in zip(names, self.values, self.std, self.shares, strict=True):
            order = [k for k in np.argsort(-parts, kind="stable") if parts[k] > 0.005][:4]
            message = ", ".join(f"{self.parameters[k]} {100 * parts[k]:.0f} %" for k in order)
            lines.append(f"{name:<{width}}{mean:>14.6g}{std:>14.6g}  {message}")
        return "\n".join(lines)


@reports_warnings
def uncertainty(
    model: Model | System,
    parameters: Mapping[str, Any],
    responses: Any,
    *,
    analysis: Any,
    progress: bool | Progress | None = None,
    time_limit: float | None = None,
) -> Uncertainty:
    """Propagate the uncertainty of parameters to responses, to first order, with exact derivatives.

    Parameters
    ----------
    model, parameters, responses : as for `study`; responses are formulas
    analysis : `Simulation`, `Kinematics`, `Statics`, `Vibration`, `Linearization`, `InverseDynamics`, or a
        function of the system that returns the result of one of these analyses or of inverse dynamics
    progress, time_limit : of a simulation, as for `simulate`

    Returns
    -------
    Uncertainty

    Raises
    ------
    SarrusError
        If an argument is wrong, or the run fails or does not end within the time limit.
    """
    request = ask(model, parameters, responses, analysis=analysis, sample=Listed(()))
    announce(request.start_warnings())
    return uncertainty_of(request, progress, time_limit)


def uncertainty_of(
    request: Request, progress: bool | Progress | None = None, time_limit: float | None = None
) -> Uncertainty:
    """The same for a study that was checked."""
    run = request.task.run
    moments = np.array([_moments(parameter) for parameter in request.parameters.values()]).reshape(-1, 2)
    names = tuple(request.parameters)
    system, start = request.task.source.made(dict(zip(names, moments[:, 0], strict=True)))
    outer = Composite([differentiable(response) for response in request.task.responses])
    if isinstance(run, Simulation):
        motion = _simulated(
            run, system, start, names, {"progress": progress, "limits": Limits(time=time_limit)}
        )
    else:
        motion = run.result(system, start, tuple(outer.times()), np.inf)
    if getattr(motion, "status", "") == "stopped":
        raise KeyboardInterrupt
    if not motion.success:
        raise SarrusError(motion.message)
    gradient = sensitivity(motion, outer.asked, list(names))
    if gradient.undefined:
        raise SarrusError(
            f"{gradient.undefined[0]} alone cannot vary: there is no derivative by it. See Gradient.undefined."
        )
    return Uncertainty(
        names, outer.titles, gradient.values, gradient.matrix, moments[:, 1], gradient.response_units
    )


def _simulated(
    run: Simulation, system: System, start: Start, names: Sequence[str], watched: Mapping[str, Any]
) -> Any:
    """The simulation at the means, with its steps."""
    if isinstance(run.start, DesignStart):
        run.start.refuse_moved(system, Variables(system, names))
    begin = run.assembled(system, start)
    return simulate(system, begin, until=run.until, store="steps", method=run.method, **watched)


def _moments(parameter: Parameter) -> tuple[float, float]:
    """Mean and standard deviation."""
    if isinstance(parameter, Distribution):
        frozen = parameter.frozen()
        return float(frozen.mean()), float(frozen.std())
    if isinstance(parameter, Values):
        return float(np.mean(parameter.values)), float(np.std(parameter.values))
    if isinstance(parameter, Range) and not parameter.log:
        return (parameter.low + parameter.high) / 2, (parameter.high - parameter.low) / 12**0.5
    x = parameter.at((np.arange(4096) + 0.5) / 4096)
    return float(x.mean()), float(x.std())
