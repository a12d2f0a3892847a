"""Parameters of a model from measurements: least squares with exact Jacobians, and what the data say of the answer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...algebra import Array
from ...results import Optimum
from ...system import System
from ..sensitivity.responses import Misfit
from .search import Bounds, Progress, Search
from .study import Study

POOR = 1e-3  # singular value, relative to the largest, of the Jacobian in parameters relative to their sizes
WORTH = 0.2  # share of a parameter in a combination, above which it is named


def fit(
    system: System,
    misfits: Misfit | Sequence[Misfit],
    wrt: Sequence[str],
    *,
    bounds: Bounds | None = None,
    design: Mapping[str, float] | None = None,
    formula: Any = None,
    until: float | None = None,
    iterations: int = 50,
    tolerance: float = 1e-10,
    progress: Progress | None = None,
    **settings: Any,
) -> Optimum:
    """Find the parameters with which a simulation is nearest to measurements.

    Parameters
    ----------
    system : with a first guess of the parameters
    misfits : measured outputs: times, data, and their standard deviation `sigma`
    wrt : names of the parameters, see `sensitivity`
    bounds, design, formula, progress, settings : see `optimize`
    until : end of the simulation [s]; by default the last time measured
    iterations, tolerance : when the solver ends

    Returns
    -------
    Optimum
        `value` is half the sum of squares; `covariance` is (JᵀJ)⁻¹ of residuals over sigma; `poor` names combinations
        of parameters that the data hardly determine.

    Raises
    ------
    SarrusError
        If the first guess cannot be simulated.
    """
    from scipy.optimize import least_squares

    some = [misfits] if isinstance(misfits, Misfit) else list(misfits)
    end = max(max(one.at) for one in some) if until is None else until
    search = Search(Study(system, some, wrt, end, design, formula, **settings), bounds, progress)
    kept: dict[bytes, tuple[Array, Array]] = {}

    def solved(z: Array) -> tuple[Array, Array]:
        if z.tobytes() not in kept:
            point = search.at(z)
            signals, slopes = point.signals()
            rest = np.concatenate([one.residuals(g) for one, g in zip(some, signals, strict=True)])
            jacobian = np.concatenate([slope / one.sigma for one, slope in zip(some, slopes, strict=True)])
            search.note(point, 0.5 * float(rest @ rest), jacobian.T @ rest)
            kept.clear()
            kept[z.tobytes()] = rest, jacobian * search.scale
        return kept[z.tobytes()]

    low, high = np.array(search.scaled_limits).T
    answer = least_squares(
        lambda z: solved(z)[0], search.x0 / search.scale, jac=lambda z: solved(z)[1], bounds=(low, high),
        xtol=tolerance, ftol=tolerance, gtol=tolerance, max_nfev=iterations,
    )  # fmt: skip
    point, jacobian = search.at(answer.x), np.asarray(answer.jac)
    covariance, poor = _covariance(jacobian, search.scale, search.names)
    return Optimum(
        tuple(search.names), answer.x * search.scale, search.x0, float(answer.cost), search.history[0][0],
        bool(answer.success), f"{str(answer.message).strip('`.').lower()} after {len(search.history)} simulations",
        np.array(search.history), np.array(search.trace), {}, covariance, poor, point.system.model, point.run,
    )  # fmt: skip


def _covariance(jacobian: Array, scale: Array, names: Sequence[str]) -> tuple[Array, tuple[str, ...]]:
    """(JᵀJ)⁻¹ for the parameters themselves, and combinations that are hardly determined."""
    _, values, rows = np.linalg.svd(jacobian, full_matrices=False)
    whole = np.zeros(len(names))
    whole[: len(values)] = values
    weak = whole <= POOR * whole[0]
    inverse = 1 / np.maximum(values, np.finfo(float).tiny)
    half = rows.T * inverse[: len(values)]
    covariance = (half @ half.T) * np.outer(scale, scale)
    return covariance, tuple(
        _told(rows[k], whole[k] / whole[0], names) for k in np.flatnonzero(weak[: len(rows)])
    )


def _told(row: Array, ratio: float, names: Sequence[str]) -> str:
    order = np.argsort(-abs(row))
    parts = [f"{row[k]:+.2f} {names[k]}" for k in order if abs(row[k]) > WORTH]
    return f"{' '.join(parts)} (relative changes) is {ratio:.1e} times as well determined as the best combination"
