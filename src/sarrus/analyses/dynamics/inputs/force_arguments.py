"""Arguments of step functions, curves and lengths in the recorded formulas of forces.

Whether a contact touches is the sign of a step function's argument; which part of a road counts is a curve's argument.
A length |d| has a corner where its ends pass through each other: there the rate of |d|² changes its sign.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ...._jit.formulas.differentiate import directional
from ...._jit.formulas.expression import Expression, Graph
from ...._jit.formulas.replay import needed
from ...._jit.kernels.emit import Output, Recording
from ...._jit.kernels.pointer import KernelTable, call_kernels
from ...._jit.linking.link import compiled, link
from ....algebra import Array
from ....elements import BUILT_IN
from ....elements.operators import OPERATORS
from ....elements.recorder import Variant
from ....model import Formula
from ....model.laws.jumps import TIME, jumps
from ....system import System
from ....system.cached import once
from ....system.curves.curve_derivatives import curves_of, entries_of, formula_graph, steps_in, stored
from ....system.operators.element_values import ElementValues
from ....system.structure.population import Population
from ..stepping.nodes import Nodes, between
from .laws_of_time import fields_of_time

OPERANDS = ("q", "v")
END = np.ones(1)
WITHIN = 2.0  # steps
MEETS = 1e-8  # [-] of tan² between a length and its rate: below, its ends pass through each other
POLYNOMIAL = {"add", "sub", "mul", "neg", "input", "constant"}  # operations of |d|² of positions


class Length(NamedTuple):
    """The rate of the square s of a length |d| in a force, 2 s s̈ - ṡ² of a d that moves evenly, and that s̈.

    The second is ṡ² tan² of the angle between d and its rate: zero where one end is about to meet the other.
    """

    rate: Any
    aside: Any
    bend: Any

    def meets(self, h: Any) -> Any:
        """Whether the ends, with their present velocities, meet within a time h, or did so, but for round-off."""
        return (self.aside < MEETS * self.rate * self.rate) & (abs(self.rate) < WITHIN * h * self.bend)


class ForceFunctions(NamedTuple):
    """The forces of a kind of element, arguments whose sign counts, of curves with their places; lengths."""

    graph: Graph
    entries: list[Expression]
    signs: list[Expression]
    curves: list[tuple[int, Expression]]
    lengths: list[Length]

    @property
    def arguments(self) -> list[Expression]:
        """All arguments, in this order; three of each length."""
        lengths = (x for one in self.lengths for x in one)
        return [*self.signs, *(x for _, x in self.curves), *lengths]


@cache
def force_functions(variant: Variant) -> ForceFunctions:
    """Return the functions in the recorded force of a kind of element."""
    graph, _, entries = entries_of(variant, "Q")
    nodes = {n: graph.nodes[n] for n in needed(graph, entries)}

    def arguments(op: str) -> list[Expression]:
        return [Expression(graph, node.args[-1]) for node in nodes.values() if node.op == op]

    places = [graph.nodes[node.args[0]].value[1] for node in nodes.values() if node.op == "curve"]
    curves = list(zip(places, arguments("curve"), strict=True))
    lengths = [found for x in arguments("sqrt") if (found := _length(graph, x))]
    return ForceFunctions(graph, entries, arguments("positive"), curves, lengths)


def _length(graph: Graph, square: Expression) -> Length | None:
    """A length by its square, unless that is a function of velocities or none of positions."""
    nodes = [graph.nodes[n] for n in needed(graph, [square])]
    names = [node.value for node in nodes if node.op == "input"]
    moving = [name for name in names if name[0] == "q"]
    if (
        not moving
        or any(node.op not in POLYNOMIAL for node in nodes)
        or any(name[0] == "v" for name in names)
    ):
        return None
    pairs = [(graph.input(*name), graph.input("v", *name[1:])) for name in moving]
    (rate,) = directional(graph, [square], pairs)
    (bend,) = directional(graph, [rate], pairs)
    found = Length._make(graph.expressions([rate, 2 * square * bend - rate * rate, bend]))
    return None if found.rate.constant == 0 else found


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
def _recorded(variant: Variant) -> Recording:
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


class ForceArguments:
    """The arguments of some of a system's forces along a motion, compiled.

    Parameters
    ----------
    system : System
    populations : indices of the forces' kinds among the system's populations, see `forces`

    Attributes
    ----------
    entry : kernels of all values
    size : number of values at each state
    """

    def __init__(self, system: System, populations: Sequence[int]) -> None:
        self._system, self._b = system, system.b.copy()
        own = [system.populations[n] for n in populations]
        self._values = ElementValues("force_arguments", own, _recorded, OPERANDS)
        self.entry, self.size = self._values.entry(), self._values.size
        places = zip(self._values.starts, self._values.widths, strict=True)
        self._first: dict[int, tuple[int, int]] = dict(zip(populations, places, strict=True))
        self._work = np.zeros((3, system.nq))

    def column(self, population: int, element: int, argument: int) -> int:
        """The place of an argument of an element; that of the force itself for -1."""
        start, width = self._first[population]
        return start + element * width + argument % width

    def __call__(self, nodes: Nodes, b: Array, parts: Array = END, apart: bool = False) -> Array:
        """All values (1 + steps * parts, size): at the first node, then at parts of every step, from 0 to 1."""
        self._b[:] = b
        found = np.zeros((1 + (len(nodes.t) - 1) * len(parts), self.size))
        if self.size:
            given = (self.entry, self._b, self._system.memory_places, nodes, parts, apart, self._work)
            link(look)(*given, found)
        return found


@compiled(entry=True)
def look(
    entry: KernelTable,
    b: Array,
    places: Array,
    nodes: Nodes,
    parts: Array,
    apart: bool,
    work: Array,
    found: Array,
) -> None:
    """Values at the first node, then at parts of every step; elements remember what they did as the step began."""
    remind(b, places, nodes.memory, 0)
    call_kernels(entry, b, nodes.t[0], nodes.q[0], nodes.v[0], found[0])
    row = 1
    for n in range(len(nodes.t) - 1):
        h = nodes.t[n + 1] - nodes.t[n]
        remind(b, places, nodes.memory, n)
        for s in parts:
            if s == 1.0:
                call_kernels(entry, b, nodes.t[n + 1], nodes.q[n + 1], nodes.v[n + 1], found[row])
            else:
                between(nodes.q[n], nodes.v[n], nodes.a[n], nodes.q[n + 1], nodes.v[n + 1], nodes.a[n + 1],
                        s, h, apart, work[0], work[1], work[2])  # fmt: skip
                call_kernels(entry, b, nodes.t[n] + s * h, work[0], work[1], found[row])
            row += 1


@compiled
def remind(b: Array, places: Array, memory: Array, n: int) -> None:
    """Write what elements remembered at a node to their numbers."""
    for k in range(len(places)):
        b[places[k]] = memory[n, k]
