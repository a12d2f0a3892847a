"""Steps that pass over no part of a table over a state: a bump of a road that a vehicle reaches after a long calm.

In a calm motion steps are long, and a force is looked at in few places of each. So a table is divided into parts in
which it is nearly a cubic, and a step that passes over a whole one is taken again and ends within it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ....algebra import Array
from ....elements.operators import OPERATORS
from ....model import Curve
from ....system import System
from ....system.cached import once
from ....system.curves.curve_derivatives import MANY, stored
from ..inputs.force_arguments import ForceArguments, curves_over_states, force_functions
from ..inputs.laws_of_time import parts_of
from ..stepping.nodes import Nodes
from ..stepping.stepper import Stepper
from .rewind import Rewind

FEW, MOST = 8, 400  # steps that are taken at once
PLACES = np.linspace(0, 1, 33)[1:]  # of a step that passes over a part, and every eighth of other steps


class Table:
    """A table over a state, as laws over the time are examined; two are equal if their numbers are."""

    def __init__(self, curve: Curve) -> None:
        self.curve = curve

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Table) and self.curve == other.curve

    def __hash__(self) -> int:
        return hash(self.curve)

    def __call__(self, x: Array) -> Array:
        """Its values (n,)."""
        return np.asarray(MANY["curve"](self.curve, x))

    def zeros(self, x: Array) -> tuple[Array, Array]:
        """No corners, and its points: between them it is a cubic."""
        return np.zeros(0), np.array(self.curve.knots)

    @cached_property
    def ends(self) -> Array:
        """Rising ends of the parts in which it is nearly a cubic."""
        return parts_of(self, self.curve.knots[0], self.curve.knots[-1]).ends

    def part_of(self, x: Array) -> Array:
        """The number of the part in which an argument is, of the first and the last one also beyond."""
        knots = self.curve.knots
        period = knots[-1] - knots[0]
        periods = np.floor((x - knots[0]) / period) if self.curve.periodic else 0
        return np.searchsorted(self.ends[1:-1], x - periods * period, side="right") + periods * (
            len(self.ends) - 1
        )


class StateTable(NamedTuple):
    """A table, the part of the model that has it, its element's population and index there, which argument it has."""

    table: Table
    owner: str
    population: int
    element: int
    argument: int


@once
def tables_over_states(system: System) -> tuple[StateTable, ...]:
    """Those of all forces that are no single cubic."""
    return tuple(found for number in range(len(system.populations)) for found in _tables(system, number))


def _tables(system: System, number: int) -> Iterator[StateTable]:
    p = system.populations[number]
    if not p.count or OPERATORS["Q"] not in p.kind.family:
        return
    known = force_functions(p.variant)
    for n, place in curves_over_states(p):
        for k in range(p.count):
            law = stored(p, k, place)
            if isinstance(law, Curve) and len(law.cubics) > 1:
                yield StateTable(
                    Table(law), p.owners[k], number, k, len(known.signs) + len(known.reversals) + n
                )


class TableSteps:
    """The tables over states of one run.

    Parameters
    ----------
    system : System
    stepper : the method at work
    rewind : takes steps again, if it is free to; else a warning names the first table of which one passes over a part

    Attributes
    ----------
    portion : how many steps are taken at once: few behind one that has been taken again
    """

    def __init__(self, system: System, stepper: Stepper, rewind: Rewind) -> None:
        self._stepper, self._rewind, self._tables = stepper, rewind, tables_over_states(system)
        self._arguments = ForceArguments(system, sorted({one.population for one in self._tables}))
        self._columns = [self._arguments.column(*one[2:]) for one in self._tables]
        self.portion = MOST

    def __bool__(self) -> bool:
        return bool(self._tables)

    def state(self) -> dict[str, Array]:
        """Return the data that a continued run needs, see `Stepper.state`."""
        return {"table_portion": np.array(self.portion)}

    def resume(self, state: Mapping[str, Array]) -> None:
        """Go on from such a state."""
        self.portion = int(state.get("table_portion", MOST))

    def seen(self, mark: dict[str, Any], nodes: Nodes) -> Nodes:
        """The steps since then, up to the first part of a table that one of them passes over."""
        self.portion = min(MOST, 2 * self.portion)
        while self and (passed := self._passed(mark, nodes)) and nodes.t[0] < passed[0] < nodes.t[-1]:
            t, owner = passed
            if not self._rewind.free:
                self._rewind.warn(
                    f"{owner}: its table varies near t = {t:.6g} s within less than a step, so that steps may pass "
                    "over it. Take shorter ones, or the default method, whose steps end there."
                )
                break
            self.portion = FEW
            self._rewind.back(mark)
            nodes = self._rewind.until(t)
        return nodes

    def _passed(self, mark: dict[str, Any], nodes: Nodes) -> tuple[float, str] | None:
        """The first time at which a step should have ended, and whose table it is."""
        steps = self._stepper.tally.history[mark["chunks"] :]
        if not steps or len(nodes.t) < 2:
            return None
        ends = np.append(0, np.searchsorted(nodes.t, np.concatenate(steps)[:, 0]))
        at = Nodes._make(column[ends] for column in nodes)
        parts = self._parts(at, PLACES[7::8])
        each = np.concatenate([parts[:, :-1:4, None], parts[:, 1:].reshape(len(parts), -1, 4)], axis=2)
        passing = np.ptp(each, axis=2) > 1
        if not passing.any():
            return None
        step = int(np.argmax(passing.any(axis=0)))
        pair = at.part(slice(step, step + 2))
        places = [_end(own) for own in self._parts(pair, PLACES)[passing[:, step]]]
        owners = [one.owner for one, wanted in zip(self._tables, passing[:, step], strict=True) if wanted]
        place, owner = min(zip(places, owners, strict=True))
        return float(pair.t[0] + place * (pair.t[1] - pair.t[0])), owner

    def _parts(self, at: Nodes, places: Array) -> Array:
        """The parts in which arguments are (tables, 1 + steps * places), at the first node, then within every step."""
        x = self._arguments(at, self._stepper.b, places, self._stepper.apart)[:, self._columns]
        return np.array([one.table.part_of(own) for one, own in zip(self._tables, x.T, strict=True)])


def _end(parts: Array) -> float:
    """The place in a step where it should end: in the middle of its way through the second part of a table."""
    places = np.append(0.0, PLACES)
    passed = np.maximum.accumulate(parts) - np.minimum.accumulate(parts)
    second, third = (int(np.argmax(passed > n)) for n in (0, 1))
    return float(places[second - 1] + places[third]) / 2
