"""Rounded data of redundant joints: the least change of points and axes with which they agree."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import csr_array

from ...algebra import Array
from ...linalg.kkt import KKT
from ...linalg.rank import TOLERANCE, divided, rank_of, row_lengths
from ...linalg.threads import one_thread_if_small
from ...model.errors import listed
from ...system import System
from ...system.structure.population import Population
from ..equations.length import POINTS, first_places, lever, scaled
from ..equations.projection import allowed
from .redundant_constraints import SHARE

ROUNDING = (
    1e-5  # of the largest lever arm: joints that disagree by more are refused; documented in troubleshooting
)
AGREEMENT = (
    1e-12  # the same: joints that disagree by less can be assembled, by the default tolerance of `assemble`
)


class Closure(NamedTuple):
    """A position in which the joints are as closed as the bodies' motion can close them.

    Attributes
    ----------
    q : (nq,)
    Phi : (m,) in rows of Φ_q at unit length, as J
    J : (m, nq) in coordinates without unit
    null : (m, k) combinations of equations that vanish
    by_data : (k, number of components) derivatives of these combinations of Φ by points and axes
    """

    q: Array
    Phi: Array
    J: csr_array
    null: Array
    by_data: Array


@one_thread_if_small
def corrected(system: System) -> tuple[Array, tuple[str, ...]]:
    """The parameters of a system, corrected where redundant joints disagree by rounding, and a warning if they are."""
    joints = Rounding(system) if _has_loops(system) else None
    b = joints.correct() if joints and joints.suspected else None
    return (b, (joints.warning(b),)) if joints and b is not None else (system.b, ())


class Rounding:
    """The joints of a system without its drivers, displacements relative to its size.

    Redundant joints contradict each other where nᵀΦ ≠ 0 for a combination n of equations with nᵀΦ_q = 0: no motion of
    bodies closes them. The least change of points and axes with nᵀ(Φ + Φ_b δb) = 0, repeated to round-off, lets them
    agree in one position. They have to agree in the drawn position, and in as many others along the mechanism's
    motions as it takes until it moves on without opening a joint. Where the equations are dependent in the drawn
    position only, nothing is corrected.

    Attributes
    ----------
    suspected : whether joints are open in the drawn position, but not by more than rounding
    """

    def __init__(self, system: System) -> None:
        self._system, self._own, q = system, _untimed(system), system.q0
        rows = [np.add.outer(p.rows, np.arange(p.kind.rows)).ravel() for p in self._own]
        self._rows = np.sort(np.concatenate(rows)) if rows else np.zeros(0, dtype=np.int64)
        Phi, J = abs(system.Phi(q)[self._rows]), csr_array(system.Phi_q(q)[self._rows])
        self._length = lever(system, q, J)
        self._unit = system.layout.scales(self._length)
        near = np.all(Phi <= ROUNDING * row_lengths(scaled(J, self._unit)))
        self.suspected = bool(near and np.any(Phi > allowed(system.layout, J, q, self._length, AGREEMENT)))

    def _changes(self, b: Array) -> Array:
        """How far each point, relative to the length, and each axis is from the data given."""
        return np.asarray(np.linalg.norm((b - self._system.b)[self._places] / self._sizes, axis=1))

    def correct(self) -> Array | None:
        """The corrected parameters (len(b),); None where the joints agree, or no small change lets them agree."""
        fields = [(p, name) for p in self._own for name, kind in p.kind.fields.items() if kind == "Vec3"]
        self._owners = [owner for p, _ in fields for owner in p.owners]
        first = [np.zeros(0, dtype=np.int64), *(first_places(p, name) for p, name in fields)]
        self._places = np.add.outer(np.concatenate(first), np.arange(3))
        points = np.repeat([name in POINTS for _, name in fields], [p.count for p, _ in fields])
        self._sizes = np.where(points, self._length, 1.0)[:, None] * np.ones(3)
        random, b, agreeing = np.random.default_rng(0), self._system.b, 0
        amplitude = 1.0  # in rad, and of the length: how far the positions are in which joints have to agree
        there = self._closed(self._system.q0, b)
        drawn, positions = there.null.shape, [there]
        if not drawn[1] or abs(there.Phi).max() <= AGREEMENT:
            return None
        while amplitude > ROUNDING:
            if not agreeing:
                b, positions = self._agreeing(b, positions)
                there = positions[-1]
            if self._changes(b).max() > ROUNDING or any(p.null.shape != drawn for p in (*positions, there)):
                return None
            if agreeing == len(positions):
                return b if rank_of(there.J).null.shape == drawn else None
            last, there = there, self._closed(self._moved(there, amplitude, random), b)
            gap = float(abs(there.Phi).max())
            if gap <= AGREEMENT:
                agreeing += 1
            elif gap > ROUNDING:
                there, amplitude = last, amplitude / 2
            else:
                positions, agreeing = [*positions, there], 0
        return None

    def warning(self, b: Array) -> str:
        """Name the joints that were changed, and by how much."""
        changes = self._changes(b)
        order = np.argsort(-changes)
        names = [*dict.fromkeys(self._owners[n] for n in order if changes[n] > SHARE * changes.max())]
        largest = changes.max() * self._length
        return (
            f"{self._system.name}: the data of the redundant joints {listed(names)} disagree by rounding, and their "
            f"points and axes are changed by up to {largest:.2g} m so that they agree. Give them with more digits."
        )

    def _agreeing(self, b: Array, positions: list[Closure]) -> tuple[Array, list[Closure]]:
        """Change the data until the joints agree in all positions, which follow."""
        before = np.inf
        while True:
            gaps = np.concatenate([p.null.T @ p.Phi for p in positions])
            if not (gap := abs(gaps).max(initial=0.0)) < before / 2:
                return b, positions
            before, b = gap, b.copy()
            change = np.linalg.lstsq(np.vstack([p.by_data for p in positions]), gaps, rcond=TOLERANCE)[0]
            b[self._places] -= self._sizes * change.reshape(-1, 3)
            positions = [self._closed(p.q, b) for p in positions]

    def _closed(self, q: Array, b: Array) -> Closure:
        """Close the joints from a position by Newton's method."""
        before, at = np.inf, self._at(q, b)
        while True:
            step = _motion(at, -at.Phi)
            change = float(abs(step).max(initial=0.0))
            if not change < before / 2:
                return at
            before, at = change, self._at(at.q + self._unit * step, b)

    def _at(self, q: Array, b: Array) -> Closure:
        """Linearize; singular values of Φ_q count as zero if rounded data can cause them, by Weyl's inequality."""
        J = scaled(csr_array(self._system.Phi_q(q, b=b)[self._rows]), self._unit)
        lengths = row_lengths(J)
        Phi, J = self._system.Phi(q, b=b)[self._rows] / lengths, divided(J, lengths)
        null = rank_of(J, ROUNDING * np.sqrt(len(Phi))).null
        by_b = csr_array(self._system.Phi_b(q, b=b)[self._rows])[:, self._places.ravel()]
        return Closure(q, Phi, J, null, (null / lengths[:, None]).T @ by_b * self._sizes.ravel())

    def _moved(self, at: Closure, amplitude: float, random: np.random.Generator) -> Array:
        """Coordinates along a random motion of the mechanism from a position."""
        xi = amplitude * random.normal(size=len(at.q))
        return np.asarray(at.q + self._unit * (xi - _motion(at, at.J @ xi)))


def _untimed(system: System) -> list[Population]:
    """The constraints of joints, and normalizations."""
    constraints = [p for p in system.populations if p.count and p.kind.rows]
    return [p for p in constraints if not (p.kind.timed or p.kind.nonholonomic)]


def _has_loops(system: System) -> bool:
    """Whether joints form loops with bodies: in an open chain none is redundant."""
    graph = {
        (owner, body)
        for p in _untimed(system)
        for owner, bodies in zip(p.owners, p.bodies, strict=True)
        for body in (*bodies, *([-1] if p.kind.bodies > p.variant.moving else []))
        if owner
    }
    above = dict[Any, Any]()  # of each joint and body but the roots of trees, which grow with each edge

    def root(node: Any) -> Any:
        while node in above:
            node = above[node]
        return node

    for edge in graph:
        joint, body = map(root, edge)
        if joint == body:
            return True
        above[joint] = body
    return False


def _motion(at: Closure, g: Array) -> Array:
    """The least ξ with Φ_q ξ = g, but for combinations of equations that vanish."""
    n = at.J.shape[1]
    return KKT(None, at.J, np.ones(n)).solve(np.zeros(n), g - at.null @ (at.null.T @ g))[0]
