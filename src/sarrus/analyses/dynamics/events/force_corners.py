"""Corners of force laws along a run: functions whose sign changes a law, found in the recorded formulas of elements.

A contact that touches or leaves, the ends of a rounding, an absolute value and a maximum in a user's formula; a length
whose ends pass through each other, so that its force reverses. A step ends at each of them, so that the law is smooth
within every step.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...._jit.formulas.expression import Expression, Graph
from ...._jit.formulas.replay import needed
from ....algebra import Array
from ....model.tape import Traced
from ....outputs.recording import TRACED, Recording
from ....system import System
from ....system.curves.curve_derivatives import MANY, evaluated, formula_graph, stored
from ..inputs.force_arguments import (
    END,
    ForceArguments,
    Length,
    force_functions,
    forces,
    has_corners,
    has_kinks,
    law_signs,
)
from ..stepping.nodes import Nodes

SHIFT = 1e-6  # of the states, at random: the change of a function shows the size of its terms
SHIFTS = 3  # how often
MEETS = 1e-8  # of tan² between a length and its rate at the end of a step: its ends meet
ROUND_OFF = 1e-12  # of that size: what integration leaves of a function that decays to zero


@dataclass(frozen=True, eq=False)
class Corner:
    """A function of one element whose sign changes its force: one of the force, or of a formula or length in it.

    Attributes
    ----------
    owner : the part of the model
    population, element : index among the system's populations, and the element in it
    sign : index of the function
    curve : index of the formula among those of the force; negative for the force itself
    length : whether the index is that of a length, and the function the rate of its square
    """

    owner: str
    population: int
    element: int
    sign: int
    curve: int = -1
    length: bool = False

    def record(self, recording: Recording) -> Traced:
        """Its value along a recorded motion, which can be differentiated."""
        p = recording.system.populations[self.population]
        known = force_functions(p.variant)
        if self.length:
            return recording.replayed(p, self.element, known.graph, [known.lengths[self.sign].rate])[0]
        if self.curve < 0:
            return recording.replayed(p, self.element, known.graph, [known.signs[self.sign]])[0]
        place, x = known.curves[self.curve]
        law = stored(p, self.element, place)
        argument = recording.replayed(p, self.element, known.graph, [x])[0]
        graph, signs = formula_graph(law)[0], law_signs(law)
        found: Traced = evaluated(graph, [signs[self.sign]], {("x",): argument}, TRACED)[0]
        return found


class ForceCorners:
    """The corners of all forces of a system; `lengths`: those of lengths that vanish, too."""

    def __init__(self, system: System, lengths: bool = True) -> None:
        own = forces(system, has_corners if lengths else has_kinks)
        self._arguments, self._system = ForceArguments(system, own), system
        self.all, self._columns, self._forces = list[Corner](), list[int](), list[int]()
        self._laws: dict[int, tuple[Graph, list[Expression], list[int]]] = {}
        self._lengths: dict[int, list[int]] = {}  # columns of each length
        for n in own:
            for k in range(system.populations[n].count):
                self._add_element(n, k)
                if lengths:
                    self._add_lengths(n, k)

    def _add_element(self, n: int, k: int) -> None:
        p = self._system.populations[n]
        known = force_functions(p.variant)
        for sign in range(len(known.signs)):
            self._add(Corner(p.owners[k], n, k, sign), sign)
        first = len(known.signs) + len(known.reversals)
        for curve, (place, _) in enumerate(known.curves):
            for sign, found in enumerate(law_signs(stored(p, k, place))):
                self._laws[len(self.all)] = found.graph, [found], needed(found.graph, [found])
                self._add(Corner(p.owners[k], n, k, sign, curve), first + curve)

    def _add_lengths(self, n: int, k: int) -> None:
        p = self._system.populations[n]
        known = force_functions(p.variant)
        first, width = len(known.arguments), len(Length._fields)
        for length, at in enumerate(range(first - width * len(known.lengths), first, width)):
            self._lengths[len(self.all)] = [self._arguments.column(n, k, at + i) for i in range(width)]
            self._add(Corner(p.owners[k], n, k, length, length=True), at)

    def _add(self, corner: Corner, argument: int) -> None:
        at = corner.population, corner.element
        self.all.append(corner)
        self._columns.append(self._arguments.column(*at, argument))
        self._forces.append(self._arguments.column(*at, -1))

    def __bool__(self) -> bool:
        return bool(self.all)

    def all_at(self, nodes: Nodes, b: Array, parts: Array, apart: bool) -> tuple[Array, Array]:
        """The functions of all corners, and whether their forces act (corners, 1 + steps * parts).

        At the first node, then at parts of every step.
        """
        found = self._arguments(nodes, b, parts, apart)
        values, acts = found[:, self._columns].T.copy(), found[:, self._forces].T != 0
        for number in self._laws:
            values[number] = self._of(number, found)
        steps = np.repeat(np.diff(nodes.t), len(parts))
        for number in self._lengths:
            acts[number] &= self._length(number, found).meets(np.concatenate([steps[:1], steps]))
            if not acts[number].any():
                values[number] = 1.0  # a length that does not come to zero has no corner near
        return values, acts

    def are_far(self, nodes: Nodes, b: Array) -> bool:
        """Whether there are no corners but lengths, which come near to zero nowhere between nodes, by these alone."""
        if len(self._lengths) < len(self.all):
            return False
        found, h = self._arguments(nodes, b, END), np.diff(nodes.t)
        each = (self._length(number, found) for number in self._lengths)
        return all((own.is_far(np.append(h[0], h)) & own.is_far(np.append(h, h[-1]))).all() for own in each)

    def one_at(self, number: int, pair: Nodes, b: Array, parts: Array, apart: bool) -> tuple[Array, Array]:
        """The function of one corner at parts of a step, and whether its force acts (parts,)."""
        found = self._arguments(pair, b, parts, apart)[1:]
        return self._of(number, found), found[:, self._forces[number]] != 0

    def meets(self, number: int, pair: Nodes, b: Array) -> bool:
        """Whether the ends of a length meet after a step, but for round-off."""
        found = self._length(number, self._arguments(pair, b, END))
        return bool(found.meets(pair.t[1] - pair.t[0], MEETS)[-1])

    def round_off(self, number: int, pair: Nodes, b: Array) -> float:
        """Below which a function at the end of a step is round-off of its terms; velocities have that of q/h, too."""
        own, rng = self.one_at(number, pair, b, END, False)[0], np.random.default_rng(0)
        sizes = abs(pair.q), abs(pair.v) + abs(pair.q) / (pair.t[1] - pair.t[0])
        changes = []
        for _ in range(SHIFTS):
            q, v = (SHIFT * size * rng.standard_normal(size.shape[1]) for size in sizes)
            shifted = pair._replace(q=pair.q + q, v=pair.v + v)
            changes.append(abs(self.one_at(number, shifted, b, END, False)[0] - own))
        return ROUND_OFF / SHIFT * float(np.max(changes))

    def _length(self, number: int, found: Array) -> Length:
        return Length(*found.T[self._lengths[number]])

    def _of(self, number: int, found: Array) -> Array:
        """The function of one corner (nt,), of the arguments (nt, size)."""
        x: Array = found[:, self._columns[number]]
        if number not in self._laws:
            return x
        graph, wanted, order = self._laws[number]
        value = evaluated(graph, wanted, {("x",): x}, MANY, order)[0]
        return np.broadcast_to(np.asarray(value, dtype=float), x.shape)
