"""Singular configurations along a motion: branch points of the constraints, dead centres of inputs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq, minimize_scalar
from scipy.sparse import csr_array, vstack

from ...algebra import Array
from ...linalg.rank import independent_rows, rank_of, unit_rows
from ...linalg.threads import one_thread_if_small
from ...model.announcement import reports_warnings
from ...results import Singularities, Singularity, Trajectory
from ...system import System
from ..arguments import refuse_for_positions
from ..equations.length import lever, scaled
from ..equations.nullspace import normalizations
from ..position.coordinate_set import of_names
from ..position.least_change import FeasibleSearch

TOLERANCE, STEPS = 1e-13, 30


class Path:
    """q(s), brought onto Φ = 0 by the least change.

    Parameters
    ----------
    system : System
    motion : a trajectory (s is time, in between cubic Hermite interpolation), or a function of s that returns q (nq,)
    grid : values of s, rising; by default the times of the trajectory

    Raises
    ------
    ValueError
        If a function comes without a grid, or the grid does not rise.
    """

    def __init__(
        self, system: System, motion: Trajectory | Callable[[float], ArrayLike], grid: ArrayLike | None
    ) -> None:
        if not isinstance(motion, Trajectory) and grid is None:
            raise ValueError(
                "grid: a function of positions needs one. Give the parameters at which it is evaluated."
            )
        values = motion.t if grid is None and isinstance(motion, Trajectory) else grid
        self.grid = np.asarray(values, dtype=float)
        if self.grid.ndim != 1 or len(self.grid) < 2 or np.any(np.diff(self.grid) <= 0):
            raise ValueError("grid: it must rise. Give at least two numbers.")
        self._guess = _interpolant(motion) if isinstance(motion, Trajectory) else motion
        self._system, self._timed = system, isinstance(motion, Trajectory)

    def time(self, s: float) -> float:
        """The time at s [s]: s itself on a trajectory, 0 in a family of positions."""
        return s if self._timed else 0.0

    def __call__(self, s: float) -> Array:
        """q (nq,) at s."""
        onto = FeasibleSearch(self._system, np.ones(self._system.nq), self.time(s))
        return onto(np.asarray(self._guess(s), dtype=float), TOLERANCE, STEPS).q


def _interpolant(motion: Trajectory) -> Callable[[float], ArrayLike]:
    return CubicHermiteSpline(motion.t, motion.q, motion.v)  # type: ignore[no-any-return]


SINGULAR = 1e-6  # a smallest singular value that counts as zero, rows scaled to unit length
SAME = 1e-7  # of the length of the path: nearer ones are the same
INWARD = 1e-5  # of an interval: how near to a grid point a minimum may be and still be seen
SAMPLES = 5  # positions of the grid from which the regular rank is taken


@reports_warnings
@one_thread_if_small
def singularities(
    system: System,
    motion: Trajectory | Callable[[float], ArrayLike],
    grid: ArrayLike | None = None,
    *,
    inputs: Iterable[str] = (),
) -> Singularities:
    """Find and locate singular configurations along a motion or a one-parameter family of positions.

    The analysed function is ± the smallest singular value of [Φ_q; X] with rows of unit length. X contains the rows of
    the rates of the inputs, or without inputs the directions of motion at the previous grid point. The sign is that of
    the determinant with a constant choice of independent rows. It changes at a simple singularity, which Brent's method
    (bisection and secant) locates. Minima without a change of sign are searched as well.

    Parameters
    ----------
    system : System
    motion : a trajectory, or a function of one parameter that returns positions (nq,), at least nearly consistent
    grid : parameter values, with small distances between neighbours; by default the times of the trajectory
    inputs : as many coordinates (``"slider.x"``) or joints (``"crank_pin"``) as there are degrees of freedom, whose
        singular configurations are included; without inputs only those of the constraints are found

    Returns
    -------
    Singularities
        a tuple of `Singularity`, in the order of the path, with ``warnings``

    Raises
    ------
    ValueError
        If the number of inputs is not the number of degrees of freedom.
    KeyError
        If a coordinate or joint is unknown.
    """
    refuse_for_positions(system, "singularities")
    path, names = Path(system, motion, grid), tuple(inputs)
    watch, located = _Watch(system, path, names), list[Singularity]()
    for s in _roots(watch):
        if not located or abs(s - located[-1].at) > SAME * (path.grid[-1] - path.grid[0]):
            located.append(_describe(watch, s, names))
    return Singularities(located)


class _Watch:
    """The signed smallest singular value along a path, with the inputs fixed."""

    def __init__(self, system: System, path: Path, names: tuple[str, ...]) -> None:
        self.system, self.path = system, path
        self._inputs = of_names(system, names, "an input")
        first, t = self.path(self.path.grid[0]), self.path.time(self.path.grid[0])
        self.length = lever(system, first, system.Phi_q(first, t))
        self._unit = system.layout.scales(self.length)
        self._rows = self._regular()
        self.freedom = system.nq - len(self._rows)
        if names and len(names) != self.freedom:
            raise ValueError(
                f"{system.name}: {self.freedom} degrees of freedom need as many inputs, got {len(names)}. "
                f"Name {self.freedom}."
            )
        self.motions = [] if names else list(self._directions())

    def rows(self, s: float) -> csr_array:
        """Φ_q with rows of unit length, where displacements are measured in a length of the system."""
        return unit_rows(scaled(self.system.Phi_q(self.path(s), self.path.time(s)), self._unit))

    def _regular(self) -> Array:
        """A choice of independent rows where the rank is greatest."""
        some = np.linspace(0, len(self.path.grid) - 1, SAMPLES).astype(int)
        ranks = [rank_of(self.rows(s), SINGULAR) for s in self.path.grid[some]]
        best = min(ranks, key=lambda rank: (rank.null.shape[1], -rank.smallest))
        return independent_rows(best.null, normalizations(self.system))

    def _directions(self) -> Iterator[Array]:
        """The directions of motion at every grid point; at singular ones those of the point before."""
        last, regular = np.zeros((self.freedom, self.system.nq)), self.system.nq - self.freedom
        for s in self.path.grid:
            values, right = np.linalg.svd(self.rows(s).toarray())[1:]
            if values[regular - 1] > SINGULAR or not last.any():
                last = right[regular:]
            yield last

    def value(self, s: float, interval: int) -> float:
        """± the smallest singular value of [Φ_q; X] at s, for the interval that begins at a grid point."""
        J, X = self.rows(s), csr_array(self._second_rows(s, interval))
        square = vstack([J[self._rows], X]).toarray()
        values = np.linalg.svd(vstack([J, X]).toarray(), compute_uv=False)
        return float(np.linalg.slogdet(square)[0] * values[self.system.nq - 1])

    def _second_rows(self, s: float, interval: int) -> Array:
        if not self._inputs.outputs:
            return self.motions[interval]
        rows = self._inputs.gradients(self.path(s)) * self._unit
        return np.asarray(rows / np.linalg.norm(rows, axis=1, keepdims=True))

    def constraints(self, s: float) -> float:
        """The smallest singular value of Φ_q that is not zero at regular positions."""
        values = np.linalg.svd(self.rows(s).toarray(), compute_uv=False)
        return float(values[len(self._rows) - 1])


def _roots(watch: _Watch) -> Iterator[float]:
    """Parameters of singular configurations, rising."""
    grid = watch.path.grid
    for k, (a, b) in enumerate(pairwise(grid.tolist())):
        left, right = watch.value(a, k), watch.value(b, k)
        if abs(left) < SINGULAR:
            yield a
        elif abs(right) >= SINGULAR:
            yield from _inside(partial(watch.value, interval=k), a, b, left, right)
    if abs(watch.value(grid[-1], len(grid) - 2)) < SINGULAR:
        yield float(grid[-1])


def _inside(
    value: Callable[[float], float], a: float, b: float, left: float, right: float
) -> Iterator[float]:
    """A zero inside an interval: by Brent's method, or, without a change of sign, by minimization if |value| dips."""
    if left * right < 0:
        s = float(brentq(value, a, b, xtol=1e-13, rtol=1e-14))
    elif abs(value(a + INWARD * (b - a))) < abs(left) and abs(value(b - INWARD * (b - a))) < abs(right):
        options = {"xatol": 1e-12 * (b - a)}
        s = float(
            minimize_scalar(lambda s: abs(value(s)), bounds=(a, b), method="bounded", options=options).x
        )
    else:
        return
    if abs(value(s)) < SINGULAR:
        yield s


def _describe(watch: _Watch, s: float, names: tuple[str, ...]) -> Singularity:
    name, q, smallest = watch.system.name, watch.path(s), watch.constraints(s)
    if smallest < SINGULAR:
        what = "the constraints lose rank, and motions meet"
        return Singularity(s, q, "branch", smallest, f"{name} at {s:.9g}: {what}")
    stand = f"{' and '.join(names)} stand{'s' * (len(names) == 1)} still"
    what = f"dead centre: the mechanism moves here while {stand}"
    return Singularity(s, q, "dead centre", abs(watch.value(s, 0)), f"{name} at {s:.9g}: {what}")
