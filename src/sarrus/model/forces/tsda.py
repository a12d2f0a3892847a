"""TSDA: a spring, damper and actuator along the line between two points."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, ClassVar

from ... import elements
from ..geometry.placement import points_apart
from ..geometry.point import Point
from ..geometry.pose import Poses
from ..laws.law import Law, of_one_variable, refuse_negative, scaled, varies
from ..measure import In, Length
from ..primitive import Primitive
from ..quantity import not_negative
from .force import Force


@dataclass(frozen=True, eq=False)
class TSDA(Force):
    """Translational spring-damper-actuator: tension f = k (l − length) + c l̇ + force at the distance l, Eq. (60).

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
    A law is a function of the variable named above only (`Force` takes formulas of several): a formula in a text (in
    t over time, else in x, ``"50 + 10*abs(x - 2)"``), a table of pairs, a `Curve`, or a Python function made of
    arithmetic and of `sarrus.functions`. Numbers for k and c are not negative; laws may be.
    """

    of_several: ClassVar[str] = "sr.Force for a formula of length, rate and t"

    point_i: Point
    point_j: Point
    k: Annotated[Law, In("N/m", over="m")]
    length: Length
    c: Annotated[Law, In("N s/m", over="m/s")] = 0.0
    force: Annotated[Law, In("N", over="s")] = 0.0

    def primitives(self, poses: Poses) -> Iterator[Primitive]:
        """Yield the linear TSDA, or the nonlinear one if a law is a curve."""
        i, j = points_apart(self.point_i, self.point_j, poses)
        length = not_negative(self.length, "length", "Give the free length in m.")
        laws = ((self.k, "k", "x"), (self.c, "c", "x"), (self.force, "force", "t"))
        with of_one_variable(self):
            (k, kappa), (c, chi), (force, phi) = (scaled(*law) for law in laws)
        refuse_negative(k, "k")
        refuse_negative(c, "c")
        values = (i.s, j.s, k, c, length, force)
        if any(varies(value) for value, *_ in laws):
            yield Primitive(elements.NonlinearTSDA, (i.body, j.body), (*values, kappa, chi, phi), "tsda")
        else:
            yield Primitive(elements.TSDA, (i.body, j.body), values, "tsda")
