"""Named coordinates c(q) of a mechanism: of bodies, and outputs of the position that elements measure."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...algebra import Array
from ...outputs.measure import placed_of
from ...outputs.output import Level, Output, find_output
from ...system import System
from ...system.cached import once
from ...system.operators.joints import JointCoordinates


class CoordinateSet(NamedTuple):
    """Coordinates c(q).

    Attributes
    ----------
    outputs : as outputs of the system
    measured : those that elements measure, with all derivatives
    row, place : (n,) row in `measured`, or -1 and the place in q
    """

    outputs: tuple[Output, ...]
    measured: JointCoordinates
    row: Array
    place: Array

    def gradients(self, q: Array) -> Array:
        """c_q (n, nq)."""
        gradients, by_elements = np.zeros((len(self.row), len(q))), self.row >= 0
        gradients[np.arange(len(self.row)), self.place] = 1.0
        if self.measured.m:
            gradients[by_elements] = self.measured.Phi_q(q).toarray()[self.row[by_elements]]
        return gradients

    def values(self, q: Array, v: Array) -> tuple[Array, Array]:
        """c and ċ (n,)."""
        by_elements, c, rates = self.row >= 0, q[self.place], v[self.place]
        of = self.measured
        if of.m:
            values, changes = np.zeros((2, of.m))
            of.group("Phi").run(of.b, 0.0, q, values)
            of.group("Phi_q_xi").run(of.b, 0.0, q, v, changes)
            c[by_elements], rates[by_elements] = (x[self.row[by_elements]] for x in (values, changes))
        return c, rates

    def labels(self) -> tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]]:
        """Names of the coordinates, names of their rates, and units of the coordinates."""
        names = tuple(output.name for output in self.outputs)
        measured = (output.place is None for output in self.outputs)
        rates = tuple(f"{n}.rate" if m else f"d({n})/dt" for n, m in zip(names, measured, strict=True))
        return names, rates, tuple(output.unit for output in self.outputs)


@once
def of_names(
    system: System, names: tuple[str, ...], where: str = "an independent coordinate"
) -> CoordinateSet:
    """The coordinates of some names; `where` is what they are, for messages.

    Raises
    ------
    UnknownOutput
        If one is no output of the position, or no element measures it.
    """
    outputs = tuple(find_output(system, name, Level.POSITION, where) for name in names)
    by_elements = [output for output in outputs if output.place is None]
    elements = [placed_of(system, output, where) for output in by_elements]
    measured = JointCoordinates(elements, system.layout)
    row = [by_elements.index(output) if output.place is None else -1 for output in outputs]
    place = [output.place or 0 for output in outputs]
    return CoordinateSet(outputs, measured, np.array(row, np.int64), np.array(place, np.int64))
