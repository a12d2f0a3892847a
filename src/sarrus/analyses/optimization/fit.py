"""Parameters of a model from measurements: least squares with exact Jacobians, and the uncertainty of the answer."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Literal

import numpy as np

from ...algebra import Array
from ...linalg.threads import one_thread_if_small
from ...model.announcement import announce, collecting, reports_warnings
from ...outputs import find_output
from ...results import Optimum
from ...results.optimum import Fitted
from ...system import System
from ..arguments import refuse_other_system
from ..position.initial_state import Start
from ..sensitivity.parameters.design_start import DesignStart
from ..sensitivity.responses.responses import Misfit
from ..sensitivity.responses.undefined import refuse_infinite
from .point import DesignError
from .problem import Analysis, Problem, refuse_unknown
from .search import Bounds, Progress, Search, Variables, reporting
from .solvers import Answer, in_words
from .task import guarded, normalize, optimum_of

LARGE = 2.0  # [-] residuals over sigma, on the average, that noise does not explain
WORTH = 0.2  # share of a parameter in a combination, above which it is named
CONFIDENCE = 0.95
# Column of the Jacobian, relative to the largest, that is the rounding of nothing: it would move the other parameters
NOTHING = 1e-13


@reports_warnings
@one_thread_if_small
def fit(
    system: System,
    misfits: Misfit | Sequence[Misfit],
    wrt: Sequence[str] | None = None,
    *,
    bounds: Bounds | None = None,
    scale: Mapping[str, float] | None = None,
    design: Mapping[str, float] | None = None,
    formula: Any = None,
    noise: Literal["given", "estimated"] = "given",
    until: float | None = None,
    analysis: Analysis | None = None,
    start: Start | DesignStart | None = None,
    iterations: int = 50,
    tolerance: float = 1e-10,
    progress: Progress | None = None,
    total_time_limit: float | None = None,
    **settings: Any,
) -> Optimum:
    """Estimate parameters by fitting a simulation to measurements (least squares).

    Parameters
    ----------
    system : with an initial estimate of the parameters
    misfits : measured outputs: times, data, and their standard deviation `sigma`
    wrt : names of the parameters, see `sensitivity`
    bounds, scale, design, formula, start, progress, total_time_limit, settings : see `optimize`
    noise : "given": `sigma` is the standard deviation. "estimated": only the ratios of the `sigma` are known, the
        noise is estimated from the residuals
    until : end of the simulation [s]; by default the last time of the measurements
    analysis : another analysis instead of a simulation, such as `Kinematics`, see `Problem`
    iterations, tolerance : limits of the solver

    Returns
    -------
    Optimum
        `value` is half the sum of squares; `covariance` is (JᵀJ)⁻¹ of residuals over sigma; `poor` names combinations
        of parameters that the data hardly determine.

    Raises
    ------
    ValueError
        If there are fewer measured values than parameters.
    SarrusError
        If the initial estimate cannot be simulated.
    """
    refuse_unknown(fit, settings)
    refuse_other_system(system, "fit", unset=bool(settings.get("controllers")))
    measured = _misfits(misfits)
    end = max(max(misfit.at) for misfit in measured) if until is None and analysis is None else until
    named: dict[str, Any] = {"design": design, "formula": formula, "start": start}
    problem = Problem(system, measured, wrt, until=end, analysis=analysis, **named, **settings)
    problem.end_after(total_time_limit)
    count, size = sum(len(misfit.at) for misfit in measured), len(problem.names)
    if count < size:
        raise ValueError(
            f"{count} measured numbers cannot determine {size} parameters. Measure more, or fit fewer."
        )
    with collecting(), reporting(progress) as report:
        search = Search(
            problem, Variables(problem.names, problem.x0, bounds, scale, problem.units), (), report
        )
        squares = Squares(search, measured)
        answer = guarded(search, lambda: _answer(squares, iterations, tolerance))
        optimum = optimum_of(search, answer, gauss_newton=squares)
        z = optimum.x / search.variables.scale
        jacobian, measurements = squares.jacobian(z), squares.fitted(z)
    announce(optimum.warnings)
    spare, spread = count - size, 1.0
    if noise == "estimated":
        spread = 2 * optimum.value / spare if spare else np.inf
    quantile = _quantile(noise, spare)
    sizes = np.maximum(abs(optimum.x), search.variables.scale)
    relative = jacobian * sizes / search.variables.scale
    covariance, poor = _covariance(relative, sizes, problem.names, float(np.sqrt(spread)), quantile)
    return replace(
        optimum, covariance=covariance, poor=poor, spare=spare, quantile=quantile,
        measurements=measurements, message=optimum.message + _doubt(optimum.value, spare, noise),
    )  # fmt: skip


def _misfits(misfits: Any) -> list[Misfit]:
    """Return one or several misfits as a list.

    Raises
    ------
    TypeError
        For other responses: only measurements can be fitted.
    """
    listed = list(misfits) if isinstance(misfits, Iterable) else [misfits]
    wrong = next((misfit for misfit in listed if not isinstance(misfit, Misfit)), None)
    if wrong is not None or not listed:
        message = f"fit needs one or several Misfit, got {type(wrong).__name__ if listed else 'none'}"
        raise TypeError(
            f"{message}. Give sr.Misfit(output, at=times, data=measured), or use optimize for other responses."
        )
    return listed


def _answer(squares: Squares, iterations: int, tolerance: float) -> Answer:
    """SciPy's least squares, residuals divided so that the gradient of their squares is `FIRST` at the start.

    Its `ftol` is relative to the sum of squares, most of which the parameters may not change: it is given smaller by so
    much.
    """
    from scipy.optimize import least_squares

    search = squares.search
    normalize(search, squares.slope)
    variables, root = search.variables, np.sqrt(search.size)
    share = min(search.size / abs(search.origin), 1.0) if search.origin else 1.0
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Setting `ftol` below the machine epsilon", UserWarning)
        solution = least_squares(
            lambda z: squares.residuals(z) / root, variables.z0, jac=lambda z: squares.jacobian(z) / root,
            bounds=variables.ends.T, xtol=tolerance, ftol=tolerance * share, gtol=tolerance, max_nfev=iterations,
        )  # fmt: skip
    return Answer(bool(solution.success), in_words(str(solution.message)))


def _doubt(value: float, spare: int, noise: str) -> str:
    """The warning where residuals are much larger than the stated noise."""
    ratio = float(np.sqrt(2 * value / spare)) if spare else 0.0
    if ratio < LARGE:
        return ""
    valid = "not valid" if noise == "given" else "valid for larger noise only"
    return (
        f"; the residuals are {ratio:.2g} times as large as sigma: from this start the model does not reach the data, "
        f"or the noise is larger than stated. The intervals are {valid}"
    )


class Squares:
    """Residuals and their Jacobian for a search."""

    def __init__(self, search: Search, misfits: Sequence[Misfit]) -> None:
        self.search, self.misfits = search, misfits

    def residuals(self, z: Array) -> Array:
        """(output - data) / sigma of all measurements; infinite where nothing can be simulated."""
        self.search.value(z)
        try:
            return self._known(z)
        except DesignError:
            return np.full(sum(len(misfit.at) for misfit in self.misfits), np.inf)

    def jacobian(self, z: Array) -> Array:
        """Their derivatives by z, by one sweep forwards."""
        _, slopes = self.search.point(z).signals()
        refuse_infinite((misfit.title for misfit in self.misfits), slopes)
        pairs = zip(self.misfits, slopes, strict=True)
        derivatives = np.concatenate([slope / misfit.sigma for misfit, slope in pairs])
        scaled = np.asarray(derivatives * self.search.variables.scale)
        sizes = np.linalg.norm(scaled, axis=0)
        scaled[:, sizes <= NOTHING * sizes.max(initial=0.0)] = 0.0
        self.search.noted(z, scaled.T @ self._known(z))
        self.search.iterate(z)
        return scaled

    def slope(self, z: Array) -> Array:
        """The gradient of half the sum of squares by z."""
        return np.asarray(self.jacobian(z).T @ self._known(z))

    def step(self, z: Array, free: Array) -> Array:
        """The step of Gauss and Newton along some directions, to be subtracted."""
        return np.asarray(free @ np.linalg.lstsq(self.jacobian(z) @ free, self._known(z))[0])

    def fitted(self, z: Array) -> tuple[Fitted, ...]:
        """The measurements with the values of a design."""
        pairs = zip(self.misfits, self.search.point(z).evaluation().signals, strict=True)
        return tuple(_fitted(self.search.problem.system, *pair) for pair in pairs)

    def _known(self, z: Array) -> Array:
        signals = self.search.point(z).evaluation().signals
        return np.concatenate([misfit.residuals(g) for misfit, g in zip(self.misfits, signals, strict=True)])


def _fitted(system: System, misfit: Misfit, values: Array) -> Fitted:
    unit = find_output(system, misfit.of).unit if isinstance(misfit.of, str) else ""
    t, data = (np.asarray(x, dtype=float) for x in (misfit.at, misfit.data))
    return Fitted(misfit.output_label, unit, t, data, misfit.sigma, values)


def _quantile(noise: str, spare: int) -> float:
    """Standard deviations on both sides that hold 95 %: of the normal distribution, or of Student's."""
    from scipy.special import ndtri, stdtrit

    share = (1 + CONFIDENCE) / 2
    if noise == "given":
        return float(ndtri(share))
    return float(stdtrit(spare, share)) if spare else np.inf


def _covariance(
    jacobian: Array, sizes: Array, names: Sequence[str], sigma: float, quantile: float
) -> tuple[Array, tuple[str, ...]]:
    """σ²(JᵀJ)⁻¹ of parameters by the Jacobian in relative changes, and combinations that are hardly determined.

    These are combinations of relative changes whose confidence interval is wider than the parameters are large, and
    those that change no residual by more than round-off.
    """
    _, values, rows = np.linalg.svd(jacobian, full_matrices=False)
    deviations = sigma / np.maximum(values, np.finfo(float).tiny ** 0.4)
    half = rows.T * deviations
    weak = (quantile * deviations > 1) | (values <= max(jacobian.shape) * np.finfo(float).eps * values[0])
    described = tuple(_described(rows[k], quantile * deviations[k], names) for k in np.flatnonzero(weak))
    return (half @ half.T) * np.outer(sizes, sizes), described


def _described(row: Array, wide: float, names: Sequence[str]) -> str:
    order = np.argsort(-abs(row))
    sign = 1.0 if row[order[0]] >= 0 else -1.0
    parts = [f"{sign * row[k]:+.2f} {names[k]}" for k in order if abs(row[k]) > WORTH]
    return f"{' '.join(parts)} (relative changes) is known to ± {wide:.1e} only"
