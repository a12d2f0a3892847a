"""The coefficients of a tyre from measurements on a test rig: least squares with the exact derivatives of its law."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..algebra import Array
from ..elements.forces.tyres import Slip, TyreLaw, Wrench, sampled
from ..model.announcement import announce
from ..model.errors import ModelError
from ..model.show import quote, suggest

if TYPE_CHECKING:
    from .tir import TyreFile

SLIPS = ("kappa", "alpha", "gamma", "load", "speed")
ANGLE = (lambda x: abs(x) < np.pi / 2, "Give angles in rad, between -pi/2 and pi/2.")
SENSE: dict[str, tuple[Callable[[Array], Array], str]] = {  # what columns must be
    "alpha": ANGLE,
    "gamma": ANGLE,
    "load": (lambda x: x >= 0, "Give the load in N, positive where the tyre is pressed on the road."),
    "speed": (lambda x: x > 0, "Give the speed in m/s, positive forwards."),
}


@dataclass(frozen=True, eq=False)
class TyreFit:
    """Coefficients of a tyre that are estimated from measurements.

    Attributes
    ----------
    tyre : with the estimated coefficients, and the others as they were
    names : of the estimated coefficients (k,)
    covariance : of the coefficients (k, k)
    residuals : of each force and moment, measured less computed [N, N m] (n,)
    quantile : half width of the 95 % interval over the standard deviation
    """

    tyre: TyreFile
    names: tuple[str, ...]
    covariance: Array
    residuals: Mapping[str, Array]
    quantile: float

    def interval(self, name: str) -> tuple[float, float]:
        """Return the 95 % confidence interval of a coefficient."""
        value, half = self.tyre.coefficients[name], self.quantile * self._deviation(name)
        return value - half, value + half

    def _deviation(self, name: str) -> float:
        if name not in self.names:
            raise ModelError(f"{quote(name)} was not estimated. {suggest(name, self.names)}")
        place = self.names.index(name)
        return float(np.sqrt(self.covariance[place, place]))

    def __str__(self) -> str:
        """The estimates with their intervals, and the mean residuals."""
        lines = [
            f"{name:8}{self.tyre.coefficients[name]:12.5g} ± {self.quantile * self._deviation(name):.2g}"
            for name in self.names
        ]
        means = [f"{name} {np.sqrt(np.mean(left**2)):.4g}" for name, left in self.residuals.items()]
        return "\n".join([*lines, f"root mean square of residuals: {', '.join(means)}"])


def fitted(
    tyre: TyreFile,
    measured: Any,
    wrt: Sequence[str],
    sigma: Mapping[str, float] | None,
    bounds: Mapping[str, tuple[float, float]] | None,
) -> TyreFit:
    """The fit of `TyreFile.fit`.

    Raises
    ------
    ModelError
        If columns or coefficients are missing or unknown, or the measurements do not determine the coefficients.
    """
    from scipy.optimize import least_squares
    from scipy.stats import t

    law, names = tyre.law(), (wrt,) if isinstance(wrt, str) else tuple(wrt)
    slip, forces = columns(measured, law, "measured")
    if not names:
        raise ModelError("wrt is empty. Name the coefficients to estimate, such as wrt=['PDY1'].")
    if repeated := [name for name in names if names.count(name) > 1]:
        raise ModelError(f"wrt has {quote(repeated[0])} more than once. Name each coefficient once.")
    if not forces:
        raise ModelError("measured needs at least one of the columns F_x, F_y, M_x, M_y and M_z.")
    announce(_doubts(tyre, measured, law))
    _check(law, names, forces, bounds, sigma)
    rows, data = [Wrench._fields.index(name) for name in forces], np.array([*forces.values()])
    largest = dict(zip(forces, abs(data).max(axis=1).tolist(), strict=True))
    scales = np.array([[(sigma or {}).get(name, largest[name] or 1.0)] for name in forces])

    def computed(x: Array) -> tuple[Array, Array]:
        moved = type(law)({**law.given, **dict(zip(names, x.tolist(), strict=True))})
        values, slopes = sampled(moved, slip, names)
        residuals, slopes = (values[rows] - data) / scales, slopes[rows] / scales[..., None]
        return residuals.ravel(), slopes.reshape(-1, len(names))

    start = np.array([float(law.given[name]) for name in names])
    ends = np.array([(bounds or {}).get(name, (-np.inf, np.inf)) for name in names]).T
    answer = least_squares(
        lambda x: computed(x)[0], start, jac=lambda x: computed(x)[1], bounds=ends, x_scale="jac", xtol=1e-12
    )
    inverse, spare = _inverse(answer.jac, names), answer.fun.size - len(names)
    spread = 1.0 if sigma else 2 * answer.cost / spare
    values = dict(zip(names, answer.x.tolist(), strict=True))
    residuals = dict(zip(forces, -answer.fun.reshape(data.shape) * scales, strict=True))
    best = type(tyre)(tyre.name, dict(tyre.coefficients) | values, tyre.side, tyre.notes)
    best.law()
    return TyreFit(best, names, inverse * spread, residuals, float(t.ppf(0.975, spare)))


def columns(measured: Any, law: Any, field: str) -> tuple[Slip, dict[str, Array]]:
    """The slips, and forces and moments by name.

    Raises
    ------
    ModelError
        If columns are missing, unknown, of other lengths or not finite, or have values without sense.
    """
    found = {str(name): _column(str(name), measured[name], field) for name in measured}
    allowed = (*SLIPS, *Wrench._fields)
    for name, column in found.items():
        if name not in allowed:
            raise ModelError(f"{field} has the unknown column {quote(name)}. {suggest(name, allowed)}")
        if not np.isfinite(column).all():
            raise ModelError(f"{field} has values in {quote(name)} that are not finite. Remove these rows.")
    for name, (has_sense, remedy) in SENSE.items():
        wrong = np.flatnonzero(~has_sense(found.get(name, np.ones(1))))
        if len(wrong):
            value = found[name].flat[wrong[0]]
            raise ModelError(f"{name} in row {wrong[0]} of {field} is {value:g}. {remedy}")
    if "load" not in found:
        raise ModelError(f"{field} needs the column load.")
    if len({column.shape for column in found.values()}) > 1 or found["load"].ndim != 1:
        raise ModelError(f"{field}: its columns must be lists of the same length. Give each its values.")
    zero = np.zeros_like(found["load"])
    kappa, alpha, gamma = (found.get(name, zero) for name in ("kappa", "alpha", "gamma"))
    slip = Slip(kappa, np.tan(alpha), gamma, found["load"], found.get("speed", zero + float(law.LONGVL)))
    return slip, {name: found[name] for name in Wrench._fields if name in found}


def _doubts(tyre: TyreFile, measured: Any, law: Any) -> Iterator[str]:
    """Yield a message for each range of the tyre that measurements leave, and for forces against those of the tyre."""
    ranges, start = law.ranges(), tyre.forces(measured)
    least = tyre.coefficients.get("FZMIN", 0.0)
    ranges["load"] = ranges["load"]._replace(low=least, coefficients="FZMIN and FZMAX")
    for name, limits in ranges.items():
        column = np.asarray(measured.get(name, 0.0), dtype=float)
        if count := np.count_nonzero((column < limits.low) | (column > limits.high)):
            what = f"measured: {count} of {column.size} rows have {name} outside of {limits.low:g} to {limits.high:g}"
            yield f"{what}, the range of the tyre. Remove these rows, or change {limits.coefficients}."
    for name in ("F_x", "F_y"):
        if np.sum(np.asarray(measured.get(name, 0.0), dtype=float) * start[name]) < 0.0:
            yield f"{name} of measured has the opposite sign: ISO has F_x > 0 for κ > 0, F_y < 0 for α > 0. Change it."


def _column(name: str, values: Any, field: str) -> Array:
    try:
        return np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise ModelError(f"{field} must have numbers in {quote(name)}. Remove texts.") from None


def _check(
    law: TyreLaw,
    names: tuple[str, ...],
    forces: Mapping[str, Array],
    bounds: Mapping[str, Any] | None,
    sigma: Mapping[str, float] | None,
) -> None:
    for field, given, allowed in (
        ("wrt", names, [*law.given]),
        ("bounds", bounds or (), names),
        ("sigma", sigma or (), [*forces]),
    ):
        for name in given:
            if name not in allowed:
                raise ModelError(f"{field} has the unknown name {quote(name)}. {suggest(name, allowed)}")
    if sigma and ({*sigma} != {*forces} or not all(value > 0.0 for value in sigma.values())):
        raise ModelError(f"sigma must have a positive number for each of {', '.join(forces)}.")
    for name, (low, high) in (bounds or {}).items():
        if not low <= (value := float(law.given[name])) <= high or low == high:
            limits = f"which is not within its bounds {low:g} and {high:g}"
            raise ModelError(f"{name} starts at {value:.6g}, {limits}. Correct them.")
    count = sum(map(len, forces.values()))
    if not len(names) < count:
        raise ModelError(f"{count} measured values cannot determine {len(names)} coefficients.")


def _inverse(J: Array, names: Sequence[str]) -> Array:
    """(JᵀJ)⁻¹.

    Raises
    ------
    ModelError
        If a combination of coefficients changes nothing.
    """
    sizes = np.linalg.norm(J, axis=0)
    sizes[sizes == 0.0] = 1.0
    _, values, rows = np.linalg.svd(J / sizes, full_matrices=False)
    if values[-1] <= max(J.shape) * np.finfo(float).eps * values[0]:
        worst = [names[k] for k in np.flatnonzero(abs(rows[-1]) > 0.1).tolist()]
        message = f"the measurements do not determine {', '.join(worst)}"
        raise ModelError(f"{message}. Remove one of them from wrt.")
    half = rows.T / values / sizes[:, None]
    return np.asarray(half @ half.T)
