"""A planar curve of quintic pieces: points, tangents, parts, nearest point, area and length."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ....algebra import Array
from ....results.maps.workspace import DENSE, POWERS, TRACED, finely, sampled
from ..tracing.point import gauss


class Arc:
    """A curve of pieces, each a polynomial of degree 5; its parameter counts pieces, 0 ... count.

    Parameters
    ----------
    pieces : (count, 6, 2) coefficients
    """

    def __init__(self, pieces: Array) -> None:
        self.pieces = pieces

    @property
    def end(self) -> float:
        """The last parameter."""
        return float(len(self.pieces))

    def _place(self, at: float) -> tuple[int, float]:
        k = min(int(at), len(self.pieces) - 1)
        return k, at - k

    def point(self, at: float) -> Array:
        """The point at a parameter (2,)."""
        k, tau = self._place(at)
        return np.asarray(tau**POWERS @ self.pieces[k])

    def slope(self, at: float) -> Array:
        """Its derivative by the parameter (2,)."""
        k, tau = self._place(at)
        return np.asarray((POWERS[1:] * tau ** POWERS[:-1]) @ self.pieces[k][1:])

    @cached_property
    def polyline(self) -> Array:
        """Points along it, `DENSE` per piece (n, 2); row i is at parameter i / DENSE."""
        return sampled(self.pieces)

    @cached_property
    def fine(self) -> Array:
        """Points along it, so many that a polygon of them is exact to `TRACED` (n, 2)."""
        return finely(self.pieces, TRACED)

    @cached_property
    def box(self) -> Array:
        """Bounds of its coordinates (2, 2): those of the polyline, wider by how far the curve may bulge from it."""
        bends = np.einsum("kpd,p->kd", abs(self.pieces), POWERS * (POWERS - 1.0))
        bulge = bends.max(axis=0) / (8 * DENSE**2)
        return np.array([self.polyline.min(axis=0) - bulge, self.polyline.max(axis=0) + bulge])

    @cached_property
    def area(self) -> float:
        """½ ∮ x dy - y dx along it."""
        p, slope, weights = self._at_nodes()
        return float(0.5 * np.sum((p[..., 0] * slope[..., 1] - p[..., 1] * slope[..., 0]) @ weights))

    @cached_property
    def length(self) -> float:
        _, slope, weights = self._at_nodes()
        return float(np.sum(np.hypot(slope[..., 0], slope[..., 1]) @ weights))

    def _at_nodes(self) -> tuple[Array, Array, Array]:
        nodes, weights = gauss()
        power, rate = nodes[:, None] ** POWERS, POWERS[1:] * nodes[:, None] ** POWERS[:-1]
        p = np.einsum("tp,kpd->ktd", power, self.pieces)
        return p, np.einsum("tp,kpd->ktd", rate, self.pieces[:, 1:]), weights

    def part(self, a: float, b: float) -> Arc:
        """The part between two parameters."""
        first, last = int(a), int(np.ceil(b))
        found = []
        for k in range(first, max(last, first + 1)):
            low, high = max(a - k, 0.0), min(b - k, 1.0)
            if high - low > 1e-14:
                found.append(_between(self.pieces[min(k, len(self.pieces) - 1)], low, high))
        return Arc(np.array(found))

    def reversed(self) -> Arc:
        """The same curve run through the other way."""
        return Arc(np.array([_between(piece, 1.0, 0.0) for piece in self.pieces[::-1]]))

    def nearest(self, p: Array) -> tuple[float, float]:
        """Parameter and distance of the point nearest to p, among those near the polyline's nearest."""
        line = self.polyline
        d = np.diff(line, axis=0)
        share = np.einsum("kd,kd->k", p - line[:-1], d) / np.maximum(np.einsum("kd,kd->k", d, d), 1e-300)
        share = np.clip(share, 0.0, 1.0)
        away = line[:-1] + share[:, None] * d - p
        k = int(np.argmin(np.einsum("kd,kd->k", away, away)))
        return self._polished((k + float(share[k])) / DENSE, p)

    def _polished(self, at: float, p: Array) -> tuple[float, float]:
        for _ in range(6):
            r, slope = self.point(at) - p, self.slope(at)
            at = float(np.clip(at - (r @ slope) / max(float(slope @ slope), 1e-300), 0.0, self.end))
        return at, float(np.linalg.norm(self.point(at) - p))


def _between(piece: Array, low: float, high: float) -> Array:
    """Coefficients of a polynomial for a part of its parameter, by substitution (Horner)."""
    found = np.zeros_like(piece)
    width = high - low
    for row in piece[::-1]:
        shifted = low * found
        shifted[1:] += width * found[:-1]
        shifted[0] += row
        found = shifted
    return found
