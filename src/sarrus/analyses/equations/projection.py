"""States on the constraints: tolerances of the equations, the metric, and projections onto them."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import lstsq
from scipy.sparse import csr_array

from ...algebra import Array
from ...linalg.rank import DEPENDENT, rows_of_entries
from ...system import System
from ...system.layout import Layout
from ..arguments import kind
from .block_matrix import UNIT
from .length import lever, row_sizes, unit_displacement
from .motion import KKTMatrix
from .nullspace import scaled_rows

ROUND_OFF = 16 * np.finfo(float).eps  # of the terms of an equation before they cancel, |Φ_q| |q|


def allowed(layout: Layout, J: csr_array, q: Array, length: float, tolerance: float) -> Array:
    """The largest |Φ| that is allowed, for each equation (m,).

    `tolerance` is a displacement in parts of the length, or a rotation [rad]; round-off is always allowed, so that a
    mechanism far from the origin can be assembled, too.
    """
    return np.maximum(tolerance * row_sizes(J, layout, length), round_off_of(J, q))


def round_off_of(J: csr_array, q: Array) -> Array:
    """The round-off of Φ, for each equation (m,)."""
    return np.asarray(ROUND_OFF * np.bincount(rows_of_entries(J), abs(J.data * q[J.indices]), J.shape[0]))


def metric(system: System, given: str | ArrayLike, q: Array) -> Array:
    """The diagonal of W (nq,).

    Parameters
    ----------
    system : System
    given : "unit": 1 rad counts like a displacement by the root mean square of the model's dimensions, which are
        distances of joint points and ends of springs from the origins of their bodies, radii of rolling bodies, and
        distances of these origins, and of points on the ground, from their mean. "mass": of every body its mass for r,
        and 4/3 of the trace of its inertia about the body's origin for p, so that heavy bodies move less. Or (nq,)
        positive numbers.
    q : (nq,) the estimate of the coordinates

    Raises
    ------
    ValueError
        For another word, a wrong shape, or numbers that are not positive.
    """
    if isinstance(given, str):
        if given not in ("unit", "mass"):
            raise ValueError(
                f'metric must be "unit", "mass" or {system.nq} positive numbers, but is {given!r}. Give one of them.'
            )
        return (
            system.layout.scales(unit_displacement(system, q)) ** -2.0 if given == "unit" else _mass(system)
        )
    try:
        weight = np.array(given, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise TypeError(
            f'metric must be "unit", "mass" or numbers, got {kind(given)}. Choose one of them.'
        ) from None
    if weight.shape != (system.nq,) or not np.all((weight > 0) & np.isfinite(weight)):
        raise ValueError(f"metric: it must be {system.nq} positive numbers. Give one for each coordinate.")
    return weight


def _mass(system: System) -> Array:
    weight, place = system.M(system.q0).diagonal(), system.layout.rotations
    weight[place] = weight[place].sum(axis=1, keepdims=True) / 3
    weight[system.moving :] = 1.0
    return np.asarray(weight)


TOLERANCE = 1e-13  # of |Φ|, relative to the gradient of each equation; round-off is a few times smaller
ACCEPTED = 1e-10  # the same, where the improvement ends earlier


def onto(
    system: System,
    q: Array,
    t: float,
    *,
    b: Array | None = None,
    steps: int = 20,
    length: float | None = None,
) -> tuple[Array, bool]:
    """Coordinates near q with Φ(q, t) = 0, and whether they were reached.

    Parameters
    ----------
    system : System
    q : (nq,)
    t : time [s]
    b : (nb,) other numbers than the model's
    steps : at most so many Gauss-Newton steps, each halved while it makes |Φ| larger
    length : by which displacements are measured, by default the largest lever arm at q [m]
    """
    J, residual = system.Phi_q(q, t, b=b), system.Phi(q, t, b=b)
    layout, unit = system.layout, system.layout.scales(length := length or lever(system, q, J))
    for _ in range(steps):
        if np.all(abs(residual) <= allowed(layout, J, q, length, TOLERANCE)):
            return q, True
        rows, lengths = scaled_rows(J, unit)
        change = lstsq(rows, -residual / lengths, DEPENDENT, check_finite=False, lapack_driver="gelsy")[0]
        there, after = _shortened(system, q, t, b, unit * change, residual, lengths)
        if largest(after / lengths) >= largest(residual / lengths):
            break
        q, residual, J = there, after, system.Phi_q(there, t, b=b)
    return q, bool(np.all(abs(residual) <= allowed(layout, J, q, length, ACCEPTED)))


def largest(vector: Array) -> float:
    """Largest entry of |vector|."""
    return float(abs(vector).max(initial=0.0))


def _shortened(
    system: System, q: Array, t: float, b: Array | None, step: Array, residual: Array, rows: Array
) -> tuple[Array, Array]:
    there, after, before = q, residual, largest(residual / rows)
    for halvings in range(10):
        there = q + step * 0.5**halvings
        after = system.Phi(there, t, b=b)
        if largest(after / rows) < before:
            break
    return there, after


STEPS = 5


class Projection:
    """Projects states of one system onto Φ = 0 and Φ_q v = -Φ_t; the Jacobian's factors serve both.

    `b` are the numbers of the elements, with what they remember; the caller keeps them up to date.
    """

    def __init__(self, system: System, b: Array | None = None, rows: Array | None = None) -> None:
        self._system, self._nothing = system, np.zeros(system.nq)
        self._b = system.b if b is None else b
        self.keep(rows)

    def keep(self, rows: Array | None) -> None:
        """Go on with another choice of independent equations."""
        self._kkt = KKTMatrix(self._system, UNIT, rows)

    def __call__(self, t: float, q: Array, v: Array) -> tuple[Array, Array]:
        """The projected q and v."""
        self._kkt.factor_at(self._b, t, q)
        for _ in range(STEPS):
            residual = self._system.Phi(q, t, b=self._b)
            if abs(residual).max(initial=0.0) <= TOLERANCE:
                break
            q = q + self._kkt.solve_pair(self._nothing, -residual)[0]
        residual = self._system.Phi_q_xi(q, v, t, b=self._b) + self._system.Phi_t(q, t, b=self._b)
        return q, v + self._kkt.solve_pair(self._nothing, -residual)[0]
