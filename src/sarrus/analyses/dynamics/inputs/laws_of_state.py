"""Laws over a length, an angle, a rate or a place along a motion: profiles of roads, tables and formulas of forces.

Their features are found as those of laws over the time are, within the arguments that the motion has reached.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ....elements import BUILT_IN
from ....elements.operators import OPERATORS
from ....model import Curve, Formula
from ....model.laws.jumps import TIME, jumps
from ....system import System
from ....system.cached import once
from ....system.curves.curve_derivatives import MANY, CurveDerivatives, curves_of, formula_graph, stored
from ....system.structure.population import Population
from ..stepping.nodes import Nodes
from .expressions_of_state import expressions_of_state, law_of
from .features import Law, formula_law
from .force_arguments import ForceArguments, force_functions, forces, has_kinks
from .laws_of_time import fields_of_time


class Table:
    """A table over a state variable, as `features` examines laws; two are equal if their numbers are."""

    def __init__(self, curve: Curve) -> None:
        self._curve = curve

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Table) and self._curve == other._curve

    def __hash__(self) -> int:
        return hash(self._curve)

    def __call__(self, x: Array) -> Array:
        """Its values (n,)."""
        return np.asarray(MANY["curve"](self._curve, x))

    def zeros(self, x: Array) -> tuple[Array, Array]:
        """No corners, and its points: between them it is a cubic."""
        return np.zeros(0), self._curve.knots_within(x.min(), x.max())


class StateLaw(NamedTuple):
    """A law, the part of the model that has it, its element's population and index there, which argument it has."""

    law: Law | Table
    owner: str
    population: int
    element: int
    argument: int


@once
def _laws(system: System) -> tuple[StateLaw, ...]:
    return tuple(
        StateLaw(law, p.owners[k], number, k, argument)
        for number, p in enumerate(system.populations)
        if p.count and OPERATORS["Q"] in p.kind.family
        for k in range(p.count)
        for argument, law in (*_curves(system, p, k), *_expressions(p, k))
    )


class StateLaws:
    """The laws of a system's forces over state variables.

    Attributes
    ----------
    all : of them
    """

    def __init__(self, system: System) -> None:
        self.all = _laws(system)
        self._arguments = ForceArguments(system, sorted({one.population for one in self.all}))
        self._columns = [
            self._arguments.column(one.population, one.element, one.argument) for one in self.all
        ]

    def arguments(self, b: Array, at: Nodes, parts: Array, apart: bool) -> Array:
        """Their arguments (laws, 1 + steps * parts), at the first node, then at parts of every step."""
        return self._arguments(at, b, parts, apart)[:, self._columns].T


def _curves(system: System, p: Population, k: int) -> Iterator[tuple[int, Law | Table]]:
    """The curves of an element over state variables, each with the place of its argument."""
    if CurveDerivatives(system).concerns(p):
        known = force_functions(p.variant)
        first = len(known.signs) + len(known.reversals)
        for n, place in _over_states(p):
            if (law := _examined(stored(p, k, place))) is not None:
                yield first + n, law


def _expressions(p: Population, k: int) -> Iterator[tuple[int, Law]]:
    """The same of the expressions in its formulas that depend on one quantity of the state."""
    if found := expressions_of_state(p.variant):
        known = force_functions(p.variant)
        first = len(known.signs) + len(known.reversals) + len(known.curves)
        for n, one in enumerate(found, first):
            yield n, law_of(p.variant, one, p.values[k])


@once
def that_jumps(system: System) -> str:
    """The part of the model whose force jumps with the state by a user's law, if any: errors may not be seen there."""
    own = (system.populations[n] for n in forces(system, has_kinks))
    return next((owner for p in own for owner in _owners_of_jumps(p)), "")


def _owners_of_jumps(p: Population) -> Iterator[str]:
    """Those whose element jumps, if it is a user's, or a formula over the state in it."""
    entries = [] if p.kind in BUILT_IN else force_functions(p.variant).entries
    if any(jumps(x, TIME, "numbers", by=["positive"]) for x in entries):  # angles are nearest to others
        yield p.owners[0]
    for _, place in _over_states(p):
        for k in range(p.count):
            law = stored(p, k, place)
            if isinstance(law, Formula) and jumps(formula_graph(law)[1]):
                yield p.owners[k]


def _over_states(p: Population) -> list[tuple[int, int]]:
    """Return, for each call of a curve with a state variable, its index and the field of the curve."""
    of_time = fields_of_time(p.variant)
    calls = enumerate(force_functions(p.variant).curves)
    fields = {place: field for field, place in curves_of(p.kind)}
    return [(n, place) for n, (place, _) in calls if fields[place] not in of_time]


def _examined(curve: object) -> Law | Table | None:
    """A law with features that can be short; a single cubic has none."""
    if isinstance(curve, Curve):
        return Table(curve) if len(curve.cubics) > 1 else None
    return formula_law(curve) if isinstance(curve, Formula) else None
