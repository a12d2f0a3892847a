"""Arguments of step functions and curves in the recorded formulas of forces.

Whether a contact touches is the sign of a step function's argument; which part of a road counts is a curve's argument.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from typing import NamedTuple

import numpy as np

from ...._jit.formulas.expression import Expression, Graph
from ...._jit.formulas.replay import needed
from ...._jit.kernels.emit import Output, Recording
from ....elements import BUILT_IN
from ....elements.operators import OPERATORS
from ....elements.recorder import Variant
from ....model import Formula
from ....model.laws.jumps import TIME, jumps
from ....system import System
from ....system.cached import once
from ....system.curves.curve_derivatives import curves_of, entries_of, formula_graph, steps_in, stored
from ....system.structure.population import Population
from .laws_of_time import fields_of_time

OPERANDS = ("q", "v")


class ForceFunctions(NamedTuple):
    """The forces of a kind of element, arguments whose sign counts, and of curves with their places."""

    graph: Graph
    entries: list[Expression]
    signs: list[Expression]
    curves: list[tuple[int, Expression]]

    @property
    def arguments(self) -> list[Expression]:
        """All arguments, in this order."""
        return [*self.signs, *(x for _, x in self.curves)]


@cache
def force_functions(variant: Variant) -> ForceFunctions:
    """Return the functions in the recorded force of a kind of element."""
    graph, _, entries = entries_of(variant, "Q")
    nodes = {n: graph.nodes[n] for n in needed(graph, entries)}

    def arguments(op: str) -> list[Expression]:
        return [Expression(graph, node.args[-1]) for node in nodes.values() if node.op == op]

    places = [graph.nodes[node.args[0]].value[1] for node in nodes.values() if node.op == "curve"]
    curves = list(zip(places, arguments("curve"), strict=True))
    return ForceFunctions(graph, entries, arguments("positive"), curves)


def law_signs(law: object) -> list[Expression]:
    """The expressions of a formula whose sign changes it."""
    if not isinstance(law, Formula):
        return []
    graph, found = formula_graph(law)
    return steps_in(graph, [found])


def is_force(p: Population) -> bool:
    """Whether elements are forces."""
    return OPERATORS["Q"] in p.kind.family


def has_kinks(p: Population) -> bool:
    """Whether signs change the forces of elements, or formulas in them."""
    return bool(force_functions(p.variant).signs) or any(law_signs(x) for own in p.values for x in own)


@cache
def recorded_arguments(variant: Variant) -> Recording:
    """The arguments, and last the sum of the squares of the force, which is zero where it does not act."""
    known = force_functions(variant)
    wanted = [*known.arguments, sum(entry * entry for entry in known.entries)]
    recording = Recording(
        f"{variant.name}.arguments", known.graph, variant.moving, variant.kind.size(), OPERANDS, ("t",)
    )
    recording.outputs.append(Output([np.array([x], dtype=object) for x in wanted], False))
    return recording


@once
def forces(system: System, wanted: Callable[[Population], bool]) -> list[int]:
    """Indices of the populations of forces that a function is true of."""
    return [n for n, p in enumerate(system.populations) if p.count and is_force(p) and wanted(p)]


@once
def that_jump(system: System) -> tuple[str, ...]:
    """The parts of the model whose forces jump with the state by a user's law: errors may not be seen there."""
    own = (system.populations[n] for n in forces(system, has_kinks))
    return tuple(dict.fromkeys(owner for p in own for owner in _owners_of_jumps(p)))


@cache
def _element_jumps(variant: Variant) -> bool:
    """Whether the recorded force of a kind of element jumps."""
    entries = force_functions(variant).entries
    return any(jumps(x, TIME, "numbers", by=["positive"]) for x in entries)  # angles are nearest to others


def _owners_of_jumps(p: Population) -> Iterator[str]:
    """Those whose element jumps, if it is a user's, or a formula over the state in it."""
    if p.kind not in BUILT_IN and _element_jumps(p.variant):
        yield p.owners[0]
    for _, place in curves_over_states(p):
        for k in range(p.count):
            law = stored(p, k, place)
            if isinstance(law, Formula) and jumps(formula_graph(law)[1]):
                yield p.owners[k]


def curves_over_states(p: Population) -> list[tuple[int, int]]:
    """Return, for each call of a curve with a state variable, its index and the field of the curve."""
    of_time = fields_of_time(p.variant)
    calls = enumerate(force_functions(p.variant).curves)
    fields = {place: field for field, place in curves_of(p.kind)}
    return [(n, place) for n, (place, _) in calls if fields[place] not in of_time]
