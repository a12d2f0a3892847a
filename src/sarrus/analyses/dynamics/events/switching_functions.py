"""Switching functions of forces: scalars of the state whose signs select a smooth branch of the equations.

They are in the recorded formulas of elements: a contact that touches or leaves, the ends of a rounding, an absolute
value or a maximum in a user's formula. A table over a state has a mode for each part in which it is nearly a cubic.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
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
from ....system.operators.element_values import ElementValues
from ..inputs.force_arguments import (
    OPERANDS,
    curves_over_states,
    force_functions,
    forces,
    is_force,
    law_signs,
    recorded_arguments,
)
from ..inputs.laws_of_time import parts_of
from ..step_loop.crossing import SHIFT, Switching

SHIFTS = 3  # random changes of a state, which show the size of the terms of a function
ROWS = {"value": 8, "mode": 8, "acts": 8, "rate": 5}  # of what is evaluated within a step


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


@cache
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
        shifts=shifts(nq),
        arguments=np.zeros(size),
        **{name: np.zeros((rows, n)) for name, rows in ROWS.items()},
        **{name: np.zeros(n) for name in ("changes", "ignored")},
        **{name: np.zeros(nq) for name in "qva"},
    )  # fmt: skip


@cache
def shifts(nq: int) -> Array:
    """Random displacements and velocities (SHIFTS, 2, nq), see `Switching`."""
    return SHIFT * np.random.default_rng(0).standard_normal((SHIFTS, 2, nq))


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

    Attributes
    ----------
    all : list of Switch
    """

    def __init__(self, system: System) -> None:
        self._system, self._found = system, switches_of(system)
        self.all = [switch for own in self._found.values() for switch in own]

    def compiled(self, returns: Callable[[Switch], bool], near: bool) -> Switching:
        """All of them for the loop of steps, see `Switching`."""
        kinds = [self._system.populations[n] for n in self._found]
        values = ElementValues("force_arguments", kinds, recorded_arguments, OPERANDS)
        places = dict(zip(self._found, zip(values.starts, values.widths, strict=True), strict=True))

        def column(corner: Corner, argument: int) -> int:
            """The place of an argument of an element; that of the force itself for -1."""
            start, width = places[corner.population]
            return int(start + corner.element * width + argument % width)

        return _compiled(self.all, values.entry(), column, values.size, self._system.nq, returns, near)


@once
def switches_of(system: System) -> dict[int, tuple[Switch, ...]]:
    """The switches of each kind of force that has some, by its index among the populations."""
    every = {n: tuple(_switches(system, n)) for n in forces(system, is_force)}
    return {n: own for n, own in every.items() if own}


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
