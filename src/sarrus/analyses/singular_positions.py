"""Singular positions along a motion: branch points of the constraints, dead centres of inputs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq, minimize_scalar
from scipy.sparse import csr_array, vstack

from ..algebra import Array
from ..results import Singularity, Trajectory
from ..system import System
from .degrees_of_freedom import normalizations
from .joint_rate import Rate, rate
from .path import Path
from .rank import independent_rows, rank_of, unit_rows

SINGULAR = 1e-6  # a smallest singular value that counts as zero, rows scaled to unit length
SAMPLES = 5  # positions of the grid from which the regular rank is taken


def singularities(
    system: System,
    motion: Trajectory | Callable[[float], ArrayLike],
    grid: ArrayLike | None = None,
    *,
    inputs: Iterable[str] = (),
) -> tuple[Singularity, ...]:
    """Find and locate singular positions along a motion or a one-parameter family of positions.

    The function that is followed is ± the smallest singular value of [Φ_q; X], its rows scaled to unit length; X are
    the rows of the inputs' rates, or without inputs the directions of motion at the grid point before. Its sign is that
    of the determinant with a fixed choice of independent rows: it changes at a simple singularity, which is then
    located by Brent's method (bisection and secant). Minima without a change of sign are searched as well.

    Parameters
    ----------
    system : System
    motion : a trajectory, or a function of one parameter that returns positions (nq,), at least nearly consistent
    grid : parameters at which to look, fine enough that neighbours are not far apart; by default the times of the
        trajectory
    inputs : as many coordinates (``"slider.x"``) or joints (``"crank_pin"``) as there are degrees of freedom, whose
        singular positions are wanted too; without them only those of the constraints are found

    Returns
    -------
    tuple of Singularity, in the order of the path

    Raises
    ------
    ValueError
        If the number of inputs is not the number of degrees of freedom.
    KeyError
        If there is no such coordinate or joint.
    """
    path, names = Path(system, motion, grid), tuple(inputs)
    watch = _Watch(system, [path(s) for s in path.grid], names)
    found: list[Singularity] = []
    for s in _roots(path, watch):
        if not found or abs(s - found[-1].at) > 1e-7 * (path.grid[-1] - path.grid[0]):
            found.append(_describe(system, watch, s, path(s), names))
    return tuple(found)


class _Watch:
    """The signed smallest singular value, with what is kept fixed along the path."""

    def __init__(self, system: System, positions: list[Array], names: tuple[str, ...]) -> None:
        self.system, self.positions = system, positions
        self.inputs: list[Rate] = [rate(system, name) for name in names]
        self.kept = self._regular()
        self.freedom = system.nq - len(self.kept)
        if names and len(names) != self.freedom:
            raise ValueError(
                f"{system.name} has {self.freedom} degrees of freedom; name as many inputs, not {len(names)}"
            )
        self.motions = list(self._directions())

    def _regular(self) -> Array:
        """A choice of independent rows where the rank is greatest."""
        some = np.linspace(0, len(self.positions) - 1, SAMPLES).astype(int)
        ranks = [rank_of(self.system.Phi_q(self.positions[k]), SINGULAR) for k in some]
        best = min(ranks, key=lambda rank: (rank.null.shape[1], -rank.smallest))
        return independent_rows(best.null, normalizations(self.system))

    def _directions(self) -> Iterator[Array]:
        """The directions of motion at every position; at singular ones those of the position before."""
        last = np.zeros((self.freedom, self.system.nq))
        for q in self.positions:
            values, right = np.linalg.svd(self.rows(q).toarray())[1:]
            regular = self.system.nq - self.freedom
            if values[regular - 1] > SINGULAR or not last.any():
                last = right[regular:]
            yield last

    def rows(self, q: Array) -> csr_array:
        """Φ_q with rows of unit length."""
        return unit_rows(self.system.Phi_q(q))

    def value(self, q: Array, interval: int) -> float:
        """± the smallest singular value of [Φ_q; X] at q, for the interval that begins at a grid point."""
        X = (
            unit_rows(csr_array(np.array([r.row(q) for r in self.inputs])))
            if self.inputs
            else self.motions[interval]
        )
        J = self.rows(q)
        square = vstack([J[self.kept], csr_array(X)]).toarray()
        smallest = np.linalg.svd(vstack([J, csr_array(X)]).toarray(), compute_uv=False)[self.system.nq - 1]
        return float(np.linalg.slogdet(square)[0] * smallest)

    def constraints(self, q: Array) -> float:
        """The smallest singular value of Φ_q that is not zero at regular positions."""
        values = np.linalg.svd(self.rows(q).toarray(), compute_uv=False)
        return float(values[len(self.kept) - 1])


def _roots(path: Path, watch: _Watch) -> Iterator[float]:
    """Parameters of singular positions, rising."""
    grid, positions = path.grid, watch.positions
    for k in range(len(grid) - 1):
        left, right = (watch.value(positions[n], k) for n in (k, k + 1))
        if abs(left) < SINGULAR:
            yield float(grid[k])
        elif abs(right) >= SINGULAR and left * right < 0:
            s = float(
                brentq(lambda s, k=k: watch.value(path(s), k), grid[k], grid[k + 1], xtol=1e-13, rtol=1e-14)
            )
            if abs(watch.value(path(s), k)) < SINGULAR:
                yield s
        elif abs(right) >= SINGULAR:
            yield from _touching(path, watch, k, abs(left), abs(right))
    if abs(watch.value(positions[-1], len(grid) - 2)) < SINGULAR:
        yield float(grid[-1])


def _touching(path: Path, watch: _Watch, k: int, left: float, right: float) -> Iterator[float]:
    """A zero without a change of sign inside an interval, if the ends' slopes allow one."""
    a, b = path.grid[k], path.grid[k + 1]
    inner = [abs(watch.value(path(a + part * (b - a)), k)) for part in (0.01, 0.99)]
    if not (inner[0] < left and inner[1] < right):
        return
    found = minimize_scalar(
        lambda s: abs(watch.value(path(s), k)),
        bounds=(a, b),
        method="bounded",
        options={"xatol": 1e-12 * (b - a)},
    )
    if found.fun < SINGULAR:
        yield float(found.x)


def _describe(system: System, watch: _Watch, s: float, q: Array, names: tuple[str, ...]) -> Singularity:
    smallest = watch.constraints(q)
    if smallest < SINGULAR:
        told = "the constraints lose rank, and motions meet"
        return Singularity(s, q, "branch", smallest, f"{system.name} at {s:.9g}: {told}")
    value = abs(watch.value(q, 0))
    told = f"dead centre: the mechanism moves here while {' and '.join(names)} stand{'s' * (len(names) == 1)} still"
    return Singularity(s, q, "dead centre", value, f"{system.name} at {s:.9g}: {told}")
