"""Constant angle: a vector fixed in body i and one fixed in body j keep the angle α between them."""

from __future__ import annotations

from ...algebra import Array
from ..element import Pair, Scalar
from .dot1 import Dot1


class ConstantAngle(Dot1, rows=1, derivatives="automatic", rare=True):
    """Φ = a_iᵀ a_j - cos α [1 for unit vectors]. Singular at α = 0 and π: parallel is two DOT-1 constraints.

    All derivatives to q are those of DOT-1; the paper has no such constraint.
    """

    cosine: Scalar  # [-] cos α

    def Phi(self, x: Pair) -> Array:
        return super().Phi(x) - self.cosine
