"""TSDA: a spring, damper and actuator along the line between two points."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from ... import elements
from ..law import Law, scaled, varies
from ..measure import In, Length
from ..placement import points_apart
from ..point import Point
from ..pose import Poses
from ..primitive import Primitive
from ..quantity import not_negative
from .force import Force


@dataclass(frozen=True, eq=False)
class TSDA(Force):
    """A tension f = k (l − length) + c l̇ + force between two points at the distance l, Eq. (60).

    Parameters
    ----------
    point_i, point_j
        The ends; they must not coincide.
    k
        Stiffness [N/m], or a law k(l) over the length l [m].
    length
        Free length [m].
    c
        Damping [N s/m], or a law c(l̇) over the rate l̇ [m/s].
    force
        Actuator's tension [N], or a law over time [s].

    Notes
    -----
    A law is a table of pairs, a `Curve`, or a function made of arithmetic and of `sarrus.functions`.
    """

    point_i: Point
    point_j: Point
    k: Annotated[Law, In("N/m", over="m")]
    length: Length
    c: Annotated[Law, In("N s/m", over="m/s")] = 0.0
    force: Annotated[Law, In("N", over="s")] = 0.0

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the linear TSDA, or the nonlinear one if a law is a curve."""
        i, j = points_apart(self.point_i, self.point_j, poses)
        length = not_negative(self.length, "length", "give the free length in m")
        laws = ((self.k, "k"), (self.c, "c"), (self.force, "force"))
        (k, kappa), (c, chi), (force, phi) = (scaled(value, field) for value, field in laws)
        values = (i.s, j.s, k, c, length, force)
        if any(varies(value) for value, _ in laws):
            yield Primitive(elements.NonlinearTSDA, (i.body, j.body), (*values, kappa, chi, phi), "tsda")
        else:
            yield Primitive(elements.TSDA, (i.body, j.body), values, "tsda")
