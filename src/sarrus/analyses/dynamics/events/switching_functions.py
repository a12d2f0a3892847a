"""Switching functions of forces: scalars of the state whose signs select a smooth branch of the equations.

They are in the recorded formulas of elements: a contact that touches or leaves, the ends of a rounding, an absolute
value or a maximum in a user's formula. A table over a state has a mode for each part in which it is nearly a cubic.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...._jit.formulas.program import program_of
from ...._jit.formulas.replay import replay
from ...._jit.kernels.pointer import NONE, KernelTable
from ....algebra import Array
from ....model import Curve
from ....model.tape import Tracer
from ....outputs.recording import TRACED, Recording
from ....system import System
from ....system.cached import once
from ....system.curves.curve_derivatives import MANY, formula_graph, stored
from ..inputs.force_arguments import (
    ForceArguments,
    Length,
    curves_over_states,
    force_functions,
    forces,
    is_force,
    law_signs,
)
from ..inputs.laws_of_time import parts_of
from ..step_loop.crossing import SHIFT, Switching
from ..stepping.nodes import Nodes

SHIFTS = 3  # random changes of a state, which show the size of the terms of a function
ROWS = {"value": 8, "mode": 8, "acts": 8, "rate": 5}  # of what is evaluated within a step
CLOSE = 0.999  # of the way to where the ends of a length meet
SMALL = 1e-5  # of the square of a force at the begin of that way; in proportion to the length it would be 1e-6 there


@dataclass(frozen=True, eq=False)
class Corner:
    """A function of one element whose sign changes its force: one of the force, or of a formula in it.

    Attributes
    ----------
    owner : the part of the model
    population, element : index among the system's populations, and the element in it
    sign : index of the function
    curve : index of the formula among those of the force; negative for the force itself
    """

    owner: str
    population: int
    element: int
    sign: int
    curve: int = -1

    def record(self, recording: Recording) -> Tracer:
        """Its value along a recorded motion, which can be differentiated."""
        p = recording.system.populations[self.population]
        known = force_functions(p.variant)
        if self.curve < 0:
            return recording.replayed(p, self.element, known.graph, [known.signs[self.sign]])[0]
        place, x = known.curves[self.curve]
        law = stored(p, self.element, place)
        argument = recording.replayed(p, self.element, known.graph, [x])[0]
        graph, signs = formula_graph(law)[0], law_signs(law)
        found: Tracer = replay(graph, [signs[self.sign]], {("x",): argument}, TRACED)[0]
        return found


@dataclass(frozen=True)
class Table:
    """A table over a state, as laws over the time are examined."""

    curve: Curve

    def __call__(self, x: Array) -> Array:
        """Its values (n,)."""
        return np.asarray(MANY["curve"](self.curve, x))

    def zeros(self, x: Array) -> tuple[Array, Array]:
        """No corners, and its points: between them it is a cubic."""
        return np.zeros(0), np.array(self.curve.knots)


def parts_of_table(curve: Curve) -> Array:
    """Rising ends within a table of the parts in which it is nearly a cubic."""
    return parts_of(Table(curve), curve.knots[0], curve.knots[-1]).ends[1:-1]


class Switch(NamedTuple):
    """One switching function.

    Attributes
    ----------
    corner : what derivatives need of it
    argument : index of its argument among those of its force
    formula : of the argument, as numbers, whose value it is, if any
    table : over the argument, if its modes are parts of one
    """

    corner: Corner
    argument: int
    formula: tuple[float, ...] = ()
    table: Curve | None = None


def no_switching(nq: int) -> Switching:
    """Switching functions of a run whose steps end at none."""
    return _compiled((), NONE, lambda one, argument: 0, 0, nq, lambda one: False, False)


def _compiled(
    own: Sequence[Switch], entry: KernelTable, column: Callable[[Corner, int], int], size: int, nq: int,
    returns: Callable[[Switch], bool], near: bool,
) -> Switching:  # fmt: skip
    """Switching functions for the loop of steps; columns are those of the kernels."""
    n, places = len(own), np.int64
    tables = [parts_of_table(one.table) if one.table else np.zeros(0) for one in own]
    lengths = [len(one.formula) for one in own]
    return Switching(
        entry=entry,
        columns=np.array([column(one.corner, one.argument) for one in own], dtype=places),
        forces=np.array([column(one.corner, -1) for one in own], dtype=places),
        formulas=np.where(lengths, np.cumsum([0, *lengths])[:n], -1).astype(places),
        numbers=np.array([x for one in own for x in one.formula]),
        starts=np.cumsum([0, *map(len, tables)]).astype(places),
        parts=np.concatenate([np.zeros(0), *tables]),
        first=np.array([one.table.knots[0] if one.table else 0.0 for one in own]),
        period=np.array([_period(one.table) for one in own]),
        returns=np.array([returns(one) for one in own], dtype=bool),
        near=np.array([near]),
        shifts=SHIFT * np.random.default_rng(0).standard_normal((SHIFTS, 2, nq)),
        arguments=np.zeros(size),
        **{name: np.zeros((rows, n)) for name, rows in ROWS.items()},
        **{name: np.zeros(n) for name in ("changes", "ignored")},
        **{name: np.zeros(nq) for name in "qva"},
    )  # fmt: skip


def _period(table: Curve | None) -> float:
    """The period of a table, infinite if it has none; 0 without a table."""
    if table is None:
        return 0.0
    return table.knots[-1] - table.knots[0] if table.periodic else np.inf


class SwitchingFunctions:
    """The switching functions of all forces of a system.

    Parameters
    ----------
    system : System
    lengths : whether lengths that vanish are looked for, too

    Attributes
    ----------
    all : list of Switch
    """

    def __init__(self, system: System, lengths: bool) -> None:
        found, with_lengths = switches_of(system)
        own = sorted({*found, *(with_lengths if lengths else ())})
        self._system, self._arguments = system, ForceArguments(system, own)
        self.all = [switch for n in own for switch in found.get(n, ())]
        self._lengths = [one for n in own for one in self._lengths_of(n)] if lengths else []

    def compiled(self, returns: Callable[[Switch], bool], near: bool) -> Switching:
        """All of them for the loop of steps, see `Switching`."""
        arguments = self._arguments
        given = self.all, arguments.entry, self._column, arguments.size, self._system.nq
        return _compiled(*given, returns, near)

    def _column(self, corner: Corner, argument: int) -> int:
        return self._arguments.column(corner.population, corner.element, argument)

    def _lengths_of(self, n: int) -> Iterator[tuple[str, list[int]]]:
        """Owners of lengths in the forces of a kind, and the places of their arguments."""
        p, width = self._system.populations[n], len(Length._fields)
        known = force_functions(p.variant)
        for k in range(p.count):
            for at in range(len(known.arguments) - width * len(known.lengths), len(known.arguments), width):
                yield p.owners[k], [self._arguments.column(n, k, i) for i in (-1, *range(at, at + width))]

    def vanishing(self, nodes: Nodes, b: Array, apart: bool) -> tuple[float, str] | None:
        """When first the ends of a length pass through each other and its force reverses [s], and whose it is."""
        if not self._lengths:
            return None
        h, arguments = np.diff(nodes.t), self._arguments(nodes, b)
        for owner, columns in self._lengths:
            before, behind = (Length(*x[:, columns[1:]].T) for x in (arguments[:-1], arguments[1:]))
            passed = (before.rate < 0) & (behind.rate > 0) & before.meets(h) & behind.meets(h)
            for step in np.flatnonzero(passed).tolist():
                part = -before.rate[step] / before.bend[step] / h[step]
                near = self._arguments(nodes.part(slice(step, step + 2)), b, np.array([CLOSE * part]), apart)[
                    :, columns[0]
                ]
                if near[1] > SMALL * near[0]:
                    return float(nodes.t[step] + part * h[step]), owner
        return None


@once
def switches_of(system: System) -> tuple[dict[int, tuple[Switch, ...]], tuple[int, ...]]:
    """The switches of each kind of force that has some, by its index among the populations; kinds with lengths."""
    known = {n: force_functions(system.populations[n].variant) for n in forces(system, is_force)}
    every = {n: tuple(_switches(system, n)) for n in known}
    return {n: own for n, own in every.items() if own}, tuple(n for n, one in known.items() if one.lengths)


def _switches(system: System, n: int) -> Iterator[Switch]:
    """Those of a kind of force."""
    p = system.populations[n]
    known = force_functions(p.variant)
    first, over_states = len(known.signs), dict(curves_over_states(p))
    for k in range(p.count):
        for sign in range(first):
            yield Switch(Corner(p.owners[k], n, k, sign), sign)
        for curve, (place, _) in enumerate(known.curves):
            law = stored(p, k, place)
            for sign, found in enumerate(law_signs(law)):
                yield Switch(Corner(p.owners[k], n, k, sign, curve), first + curve, program_of(found))
            if curve in over_states and isinstance(law, Curve) and len(law.cubics) > 1 and not law.passed:
                yield Switch(Corner(p.owners[k], n, k, 0, curve), first + curve, table=law)
