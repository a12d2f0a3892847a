"""Bushing: a linear elastic and damping connection of two frames, with full 6 x 6 matrices.

The six deformations Ξ are measured in the frame of body i: the line d from P_i to P_j, and the small rotation of
frame j,

    Ξ = (f_i·d, g_i·d, h_i·d, (h_i·g_j - g_i·h_j)/2, (f_i·h_j - h_i·f_j)/2, (g_i·f_j - f_i·g_j)/2).

These are three DOT-2 and six DOT-1 functions, whose derivatives it inherits. The work of the force F = K Ξ + C Ξ̇ -
F₀ is that of Ξ: Q = -Ξ_qᵀ F, so that net force and moment on the pair vanish, and energy is conserved for C = 0 and K =
Kᵀ. The angles are exactly n sin φ for a rotation by φ about n: a model for small angles, whose torque is largest at
45°.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import Any

import numpy as np

from ...algebra import Array, Block, Row, outer, scaled, times, total
from ..constraints.dot1 import Dot1
from ..constraints.dot2 import Dot2
from ..element import Force, Grid, Mat66, Pair, Scalar, Vec3, Vec6
from ..output import output

ONE = np.array([1])
FIELDS = ("s_i", "f_i", "g_i", "h_i", "s_j", "f_j", "g_j", "h_j")


class Part:
    """A DOT function of a bushing: its share in a deformation, and the bushing's fields that are its numbers."""

    def __init__(self, deformation: int, share: Any, primitive: Dot1 | Dot2, fields: tuple[str, ...]) -> None:
        self.deformation, self.share, self.primitive, self.fields = deformation, share, primitive, fields


class Bushing(Force, rare=True):
    """Force K Ξ + C Ξ̇ - preload in the axes of frame i, resisting the deformation Ξ of frame j relative to frame i."""

    s_i: Vec3  # [m] P_i in body i
    f_i: Vec3  # [-] frame in body i
    g_i: Vec3  # [-]
    h_i: Vec3  # [-]
    s_j: Vec3  # [m] P_j in body j
    f_j: Vec3  # [-] frame in body j
    g_j: Vec3  # [-]
    h_j: Vec3  # [-]
    K: Mat66  # [N/m, N/rad; N, N m/rad]
    C: Mat66  # [N s/m, N s/rad; N s, N m s/rad]
    preload: Vec6  # [N, N m] on body j in frame i at rest and undeformed

    def parts(self) -> Iterator[Part]:
        """The DOT functions that Ξ is made of."""
        for n, axis in enumerate("fgh"):
            a_i = getattr(self, f"{axis}_i")
            yield Part(n, 1, Dot2(a_i, self.s_i, self.s_j), (f"{axis}_i", "s_i", "s_j"))
        for n, (a, b) in enumerate((("h", "g"), ("f", "h"), ("g", "f"))):
            for first, second, sign in ((a, b, 1), (b, a, -1)):
                fields = f"{first}_i", f"{second}_j"
                yield Part(
                    3 + n, Fraction(sign, 2), Dot1(*(getattr(self, field) for field in fields)), fields
                )

    def _six(self, of: Any) -> Array:
        """A vector of six from the parts' own values."""
        result = np.zeros(6, dtype=object)
        for part in self.parts():
            result[part.deformation] = result[part.deformation] + part.share * of(part.primitive)
        return result

    def _rows(self, of: Any) -> list[Array]:
        """Six rows by the four blocks of coordinates from the parts' own rows."""
        blocks = [np.zeros((6, width), dtype=object) for width in self.coordinates()]
        for part in self.parts():
            for block, own in zip(blocks, of(part.primitive), strict=True):
                if own is not None:
                    block[part.deformation] = block[part.deformation] + part.share * own[0]
        return blocks

    def _force(self, x: Pair, v: Pair) -> Array:
        strain, rate = self._strain(x), self._rate(x, v)
        return self.K.reshape(6, 6) @ strain + self.C.reshape(6, 6) @ rate - self.preload

    def _strain(self, x: Pair) -> Array:
        return self._six(lambda part: part.Phi(x)[0])

    def _rate(self, x: Pair, v: Pair) -> Array:
        return self._six(lambda part: part.Phi_q_xi(x, v)[0])

    @output("m", vector=True)
    def displacement(self, x: Pair) -> Array:
        """Displacement of P_j from P_i, in the axes of frame i."""
        return self._strain(x)[:3]

    @output("rad", vector=True)
    def rotation(self, x: Pair) -> Array:
        """The small rotation of frame j, in the axes of frame i."""
        return self._strain(x)[3:]

    @output("m/s", vector=True)
    def displacement_rate(self, x: Pair, v: Pair) -> Array:
        """The rate of the displacement."""
        return self._rate(x, v)[:3]

    @output("rad/s", vector=True)
    def rotation_rate(self, x: Pair, v: Pair) -> Array:
        """The rate of the rotation."""
        return self._rate(x, v)[3:]

    def dissipated_power(self, x: Pair, v: Pair, t: Scalar) -> Scalar:
        """Ξ̇ᵀ C Ξ̇."""
        rate = self._rate(x, v)
        return rate @ (self.C.reshape(6, 6) @ rate)

    def supplied_power(self, x: Pair, v: Pair, t: Scalar) -> Scalar:
        """-½ Ξ̇ᵀ (K - Kᵀ) Ξ: zero for symmetric K."""
        K = self.K.reshape(6, 6)
        return self._rate(x, v) @ ((K.T - K) @ self._strain(x)) / 2

    def potential(self, x: Pair) -> tuple[Scalar, ...]:
        """½ Ξᵀ K Ξ - F₀ᵀΞ [J], for symmetric K."""
        strain = self._strain(x)
        return (strain @ (self.K.reshape(6, 6) @ strain) / 2 - self.preload @ strain,)

    def Q(self, x: Pair, v: Pair, t: Scalar) -> Row:
        F = self._force(x, v)
        return tuple(-(F @ block) for block in self._rows(lambda part: part.Phi_q(x)))

    def Q_q(self, x: Pair, v: Pair, t: Scalar) -> Grid:
        strain_q = self._rows(lambda part: part.Phi_q(x))
        rate_q = self._rows(lambda part: part.Phi_q_xi_q(x, v))
        K, C = self.K.reshape(6, 6), self.C.reshape(6, 6)
        change = [K @ first + C @ second for first, second in zip(strain_q, rate_q, strict=True)]
        own = self._curvature(x, self._force(x, v))
        return tuple(
            tuple(total((-(strain_q[m].T @ change[n]), scaled(-1, own[m][n]))) for n in range(4))
            for m in range(4)
        )

    def _curvature(self, x: Pair, F: Array) -> list[list[Block]]:
        """(Ξ_qᵀ F)_q for a fixed F."""
        grids = [
            scaled_grid(p.share * F[p.deformation], p.primitive.Phi_qT_lam_q(x, ONE)) for p in self.parts()
        ]
        return [[total(grid[m][n] for grid in grids) for n in range(4)] for m in range(4)]

    def Q_v(self, x: Pair, v: Pair, t: Scalar) -> Grid:
        strain_q = self._rows(lambda part: part.Phi_q(x))
        change = [self.C.reshape(6, 6) @ block for block in strain_q]
        return tuple(tuple(-(a.T @ b) for b in change) for a in strain_q)

    def Q_b(self, x: Pair, v: Pair, t: Scalar) -> Grid:
        strain_q, F = self._rows(lambda part: part.Phi_q(x)), self._force(x, v)
        by_frames = self._by_frames(x, v, strain_q, F)
        strain, rate = self._strain(x), self._rate(x, v)
        return tuple(
            (*by_frames[m], -_times_each(block, strain), -_times_each(block, rate), block.T)
            for m, block in enumerate(strain_q)
        )

    def _by_frames(self, x: Pair, v: Pair, strain_q: list[Array], F: Array) -> list[list[Block]]:
        """Q to the points and axes: -(Ξ_qᵀF)_b - Ξ_qᵀ (K Ξ_b + C Ξ̇_b)."""
        K, C = self.K.reshape(6, 6), self.C.reshape(6, 6)
        columns: dict[str, list[Block]] = {field: [None] * 4 for field in FIELDS}
        for part in self.parts():
            first, second = part.primitive.Phi_b(x), part.primitive.Phi_q_xi_b(x, v)
            own = part.primitive.Phi_qT_lam_b(x, ONE)
            for n, field in enumerate(part.fields):
                change = total((_along(K, part, first[n]), _along(C, part, second[n])))
                for m in range(4):
                    terms = columns[field][m], times(-strain_q[m].T, change) if change is not None else None
                    columns[field][m] = total((*terms, scaled(-part.share * F[part.deformation], own[m][n])))
        return [[columns[field][m] for field in FIELDS] for m in range(4)]


def scaled_grid(factor: Any, grid: Grid) -> list[list[Block]]:
    """Number times a grid of blocks."""
    return [[scaled(factor, block) for block in line] for line in grid]


def _along(matrix: Array, part: Part, row: Block) -> Block:
    """Matrix times a column of one part's row."""
    return None if row is None else outer(part.share * matrix[:, part.deformation], row[0])


def _times_each(block: Array, y: Array) -> Array:
    """Derivative of blockᵀ M y to the 36 numbers of M."""
    rows = block.T
    return np.concatenate([outer(rows[:, m], y) for m in range(6)], axis=1)
