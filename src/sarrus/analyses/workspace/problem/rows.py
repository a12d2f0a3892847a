"""Rows of a workspace problem: Φ and named functions, with all derivatives, independent of units.

The table has the independent rows of Φ, then the functions: outputs, limited and fixed ones, locks of idle freedoms.
Positions are scaled by the size L of the mechanism, and so are the rows: q = S q̂, f = f̂ / R.

Check that a position can be assembled from the parts as drawn: parallel axes have not been reversed.

The equations of a revolute joint hold also with the second body's axis reversed. Assembly from random guesses finds
such positions, which no motion can reach from the model's.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ....algebra import Array
from ....model.geometry.points import GROUND
from ....model.geometry.rotation import matrix
from ....system import System
from ....system.operators.constraints import ConstraintOperators
from ....system.operators.joints import JointCoordinates
from .arguments import Measure

FAR = 1e6  # free of units: from a limit that is not there; a number, so that margins can be subtracted
# Of a gradient of size 1: what round-off leaves of zero; LAPACK's least squares fail on some of it
NOTHING = 1e-20
PARALLEL = 1e-6  # how far the product of unit vectors may be from 1 or -1


@dataclass(eq=False)
class Problem:
    """Rows of a workspace problem and their derivatives at scaled positions.

    Parameters
    ----------
    system : System
    table : all functions
    outputs : places in the table of the outputs
    normal : places of the functions whose gradients become dependent: the outputs, or the inputs
    size : L [m]
    independent : rows of Φ that are independent (and no driver's)
    fixed : place -> value that it keeps
    limits : place -> (lowest, highest), infinite where there is none
    locked : places of functions that hold idle freedoms; they are among the fixed ones
    positions : random ones (nq,) with nothing held fixed, by which axes are found that stay parallel
    typical : some random positions, scaled, that satisfy the constraints and what is fixed

    Attributes
    ----------
    n, m : scaled coordinates; rows before the functions
    freedoms, unfixed : degrees of freedom that are left; those without fixed values
    of_outputs : whether the outputs' gradients become dependent, and not those of the inputs
    """

    system: System
    table: Sequence[Measure]
    outputs: Array
    normal: Array
    size: float
    independent: Array
    fixed: Mapping[int, float] = field(default_factory=dict)
    limits: Mapping[int, tuple[float, float]] = field(default_factory=dict)
    locked: Sequence[int] = ()
    positions: Sequence[Array] = ()
    typical: Sequence[Array] = ()

    def __post_init__(self) -> None:
        system = self.system
        self.n, self.m = system.nq, len(self.independent)
        self.freedoms = self.n - self.m - len(self.fixed)
        self.unfixed = self.freedoms + len(self.fixed) - len(self.locked)
        self.units = np.array([self._unit(k) for k in range(len(self.table))])
        self.scale = np.tile([self.size] * 3 + [1.0] * 4, len(system.bodies))
        self.output_angles = np.array([self.table[k].kind == "angle" for k in self.outputs], dtype=bool)
        self.of_outputs = np.array_equal(self.outputs, self.normal)
        self.has_cusps = len(self.outputs) == 2 and self.of_outputs
        self._handedness = Handedness(system, self.positions)
        self.limited, self.held = (np.array(list(places), dtype=int) for places in (self.limits, self.fixed))
        both = [[self.table[k].value(x) for x in pair] for k, pair in self.limits.items()]
        self.bounds = np.array(both, dtype=float).reshape(-1, 2) / self.units[self.limited][:, None]
        goal = [self.table[k].value(x) for k, x in self.fixed.items()]
        self.targets = np.array(goal, dtype=float) / self.units[self.held]
        self._prepare_operators()

    def held_at(self, k: int, value: float) -> Problem:
        """The same problem with another value of a fixed function."""
        return replace(self, fixed={**self.fixed, k: value}, typical=())

    def _unit(self, k: int) -> float:
        """Return the scale factor of a function."""
        if self.table[k].kind in ("angle", "form"):
            return 1.0
        if self.table[k].kind == "length":
            return self.size
        ends = [abs(x) for x in (*self.limits.get(k, ()), self.fixed.get(k, 0.0)) if np.isfinite(x)]
        return float(2 * self.size * max([*ends, 0.1 * self.size]))

    def _prepare_operators(self) -> None:
        system, every = self.system, np.arange(self.n)
        self.functions = JointCoordinates(self._placed(), system.layout)
        self.row_scale, inverse, count = self._row_scales(), 1 / self.units, len(self.table)
        place_of = np.full(system.m, -1)
        place_of[self.independent] = np.arange(self.m)
        chosen = self.row_scale[self.independent]
        rows = ((system, self.independent, chosen), (self.functions, np.arange(count), inverse))
        places = ((system, place_of, self.row_scale), (self.functions, self.m + np.arange(count), inverse))
        self._Phi = [Vector(of, "Phi", at, factor) for of, at, factor in rows]
        self._gamma = [Vector(of, "gamma", at, factor) for of, at, factor in rows]
        self._Phi_q = [Matrix(of, "Phi_q", at, row, self.scale) for of, at, row in places]
        self._second, self._third = (
            [Matrix(of, name, every, self.scale, self.scale) for of, *_ in places]
            for name in ("Phi_qT_lam_q", "Phi_qT_lam_q_xi_q")
        )

    def _placed(self) -> list[Any]:
        """The measuring elements; angles are counted around the middle of their limits, or the value they keep."""
        found = []
        for k, one in enumerate(self.table):
            placed = one.placed
            if one.kind == "angle":
                ends = [x for x in self.limits.get(k, (self.fixed.get(k, 0.0),)) if np.isfinite(x)]
                values, memory = list(placed.values), [*placed.element.fields.values()].index("Memory")
                values[memory] = float(np.mean(ends)) if ends else 0.0
                placed = placed._replace(values=tuple(values))
            found.append(placed)
        return found

    def _row_scales(self) -> Array:
        """1 / length of every gradient of Φ in scaled coordinates, at the model's position."""
        J = self.system.Phi_q(self.system.q0).multiply(self.scale)
        length = np.sqrt(np.asarray(J.multiply(J).sum(axis=1)).reshape(-1))
        return np.asarray(1 / np.where(length > 0, length, 1.0))

    @property
    def rows(self) -> int:
        return self.m + len(self.table)

    def values(self, q: Array) -> Array:
        """Φ̂ and all functions (rows,) at scaled q; targets are not subtracted."""
        real = q * self.scale
        return np.concatenate([self._Phi[0](real), self._Phi[1](real)])

    def jacobian(self, q: Array) -> Array:
        """The gradients of all rows (rows, n)."""
        real, J = q * self.scale, np.zeros((self.rows, self.n))
        for table in self._Phi_q:
            table.add(J, real)
        J[abs(J) < NOTHING] = 0.0
        return J

    def curvature(self, q: Array, weights: Array) -> Array:
        """Σ weight · second derivative, symmetric (n, n)."""
        real, H = q * self.scale, np.zeros((self.n, self.n))
        for table, lam in zip(self._second, self.unscaled(weights), strict=True):
            table.add(H, real, lam)
        return H

    def curvature_along(self, q: Array, weights: Array, along: Array) -> Array:
        """Σ weight · third derivative contracted with a direction, symmetric (n, n)."""
        real, H = q * self.scale, np.zeros((self.n, self.n))
        for table, lam in zip(self._third, self.unscaled(weights), strict=True):
            table.add(H, real, along * self.scale, lam)
        return H

    def second_along(self, q: Array, along: Array) -> Array:
        """The second derivatives of all rows, contracted twice with a direction (rows,)."""
        real, xi = q * self.scale, along * self.scale
        return -np.concatenate([self._gamma[0](real, xi), self._gamma[1](real, xi)])

    def unscaled(self, weights: Array) -> tuple[Array, Array]:
        """Multipliers of Φ (m,) and of the functions in real units."""
        lam = np.zeros(self.system.m)
        lam[self.independent] = weights[: self.m] * self.row_scale[self.independent]
        return lam, weights[self.m :] / self.units

    def shown(self, k: int, scaled: Any) -> Any:
        """A function's value as the user sees it."""
        return self.table[k].shown(scaled * self.units[k])

    def built(self, q: Array) -> bool:
        """Whether a scaled position can be built from the parts as drawn; see `Handedness`."""
        return self._handedness.preserved(q * self.scale)

    def margins(self, values: Array) -> Array:
        """Return the distances of limited functions from their lowest and highest values (count, 2), scaled."""
        found = values[self.m + self.limited][:, None]
        return np.asarray(np.minimum((found - self.bounds) * (1.0, -1.0), FAR))


class Handedness:
    """Compares the parallel axes of all joints with those of the model's position.

    Parameters
    ----------
    system : System
    positions : (nq,) each, random ones: axes that are parallel in all of them remain so by the constraints
    """

    def __init__(self, system: System, positions: Sequence[Array]) -> None:
        poses = system.model.design_poses()
        number = {name: n for n, name in enumerate((GROUND, *system.bodies))}
        self._joints: list[tuple[int, int, Array, Array]] = []
        for joint in system.model.joints:
            if hasattr(joint, "frames"):
                i, j = joint.frames(poses)
                on_i, on_j = (np.array([frame.f, frame.g, frame.h]) for frame in (i, j))  # axes as rows
                self._joints.append((number[i.body], number[j.body], on_i, on_j))
        self._rotations = system.layout.bodies.rotations
        self._drawn = self._products(system.q0)
        found = abs(np.array([self._products(q) for q in (system.q0, *positions)]))
        self._parallel = np.all(found > 1 - PARALLEL, axis=0) & (len(positions) > 0)

    def _products(self, q: Array) -> Array:
        A = [np.eye(3), *(matrix(p / np.linalg.norm(p)) for p in q[self._rotations])]
        found = [(A[i] @ on_i.T).T @ (A[j] @ on_j.T) for i, j, on_i, on_j in self._joints]
        return np.array(found).reshape(-1)

    def preserved(self, q: Array) -> bool:
        """Whether a position (nq,) is of the drawn kind."""
        return bool(np.all((self._products(q) * self._drawn)[self._parallel] > 0))


class Vector:
    """A vector operator with rows chosen and scaled."""

    def __init__(self, of: ConstraintOperators, name: str, rows: Array, factor: Array) -> None:
        self._of, self._group = of, of.group(name)
        self._out, self._rows, self._factor = self._group.allocate()[0], rows, factor

    def __call__(self, *operands: Any) -> Array:
        """The chosen rows; operands in the order of the group, the time left out."""
        self._group.run(self._of.b, 0.0, *operands, self._out)
        return np.asarray(self._out[self._rows] * self._factor)


class Matrix:
    """A matrix operator whose numbers are added into a dense matrix, rows and columns chosen and scaled."""

    def __init__(self, of: ConstraintOperators, name: str, place: Array, row: Array, column: Array) -> None:
        """`place` is the row of the dense matrix for every row of the operator, or -1."""
        self._of, self._group = of, of.group(name)
        self._out, pattern = self._group.allocate()[0], of.pattern(name)
        rows = np.repeat(np.arange(pattern.shape[0]), np.diff(pattern.indptr))
        self._used = np.flatnonzero(place[rows] >= 0)
        rows, columns = rows[self._used], pattern.indices[self._used]
        self._flat = place[rows] * pattern.shape[1] + columns
        self._factor = row[rows] * column[columns]

    def add(self, into: Array, *operands: Any) -> None:
        """Add the numbers into a matrix that is contiguous."""
        self._group.run(self._of.b, 0.0, *operands, self._out)
        into.reshape(-1)[self._flat] += self._out[self._used] * self._factor
