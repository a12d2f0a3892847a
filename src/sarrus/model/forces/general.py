"""A force by a formula or function of outputs and the time, between two points or along a joint's displacement."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..errors import ModelError
from ..primitive import Primitive
from ..signals import Signals
from .by_formula import ByFormula, own_names
from .force import Force as BaseForce
from .two_points import OnLine


@dataclass(frozen=True, eq=False)
class Force(OnLine, ByFormula, BaseForce):
    """A force [N] between two points, or along the displacement of a joint, by a formula of outputs and the time.

    A positive value pushes the points apart, or increases the displacement: it does work at the rate value · v. (The
    ``force`` of a TSDA is a tension, with the opposite sign.)

    Parameters
    ----------
    point_i, point_j
        The ends, which must not coincide; x is their distance [m], v its rate. Or instead of both the name of a joint,
        ``Force("jack", "slide", value=5)``.
    joint
        Instead of points, a joint by name, ``slide``, or if it has several displacements ``table.displacement_x``; x is
        the displacement of its second body [m].
    value
        See above; for example ``"p*A*step(t, 0, 0, 1 ms, 1) - c*v"``, or ``lambda x, v, t: -100*x**3``.
    """

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        """Yield the load."""
        if self.value is None:
            raise ModelError(
                "value is missing. Give a number, a formula, a function or a table.", field="value"
            )
        target, x, v = self.along(signals)
        named = "length" if self.joint is None else "displacement"
        yield self.loaded(target, own_names(x, v) | {named: x}, signals)
