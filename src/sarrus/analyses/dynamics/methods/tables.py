"""Tables of one operation for one system, derived from its description: where blocks, operators and equations are."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ....algebra import Array
from ....system import System
from ....system.cached import once_alike
from ...equations.block_matrix import LEFT_OUT, UNIT, Numbers, Part, entries_of
from .description import ALL, CONSTRAINTS, HOLONOMIC, NONHOLONOMIC, ROLES, Operation, Stage
from .equations import (
    GROUPS,
    KINDS,
    MULTIPLIERS,
    OF_CONSTRAINTS,
    OPERATOR,
    VELOCITY,
    Call,
    Lagrangian,
    calls_for,
    lagrangians,
)

Sizes = tuple[tuple[str, str], ...]
Term = tuple[str, str]  # what is set, by which block
Quantity = tuple[int, str]  # of a stage
NOWHERE = -1
DRIVERS = tuple(GROUPS)
JACOBIAN, INERTIA, STIFFNESS, GAMMA_V, GAMMA_Q_V = range(5)  # their places


class Structure(NamedTuple):
    """Properties of an operation that do not depend on coefficients: names, and the nonzero blocks."""

    state: Sizes
    unknowns: Sizes
    stages: tuple[tuple[tuple[str, tuple[str, ...]], ...], ...]
    equations: tuple[tuple[str, int, str], ...]
    update: tuple[tuple[str, tuple[str, ...]], ...]


def structure_of(operation: Operation) -> Structure:
    """The structure of an operation."""
    step = operation.step
    quantities = Stage._fields[1:]
    stages = (
        tuple((name, tuple(getattr(one, name))) for name in quantities if getattr(one, name))
        for one in step.stages
    )
    return Structure(
        tuple(operation.state.items()),
        tuple(operation.unknowns.items()),
        tuple(stages),
        tuple((kind, stage, rows) for kind, stage, _, rows in step.equations),
        tuple((name, tuple(by)) for name, by in step.update.items()),
    )  # fmt: skip


class Weight(NamedTuple):
    """Weight of a part of a matrix: a sign times the scale of an equation times a coefficient of a stage (or 1)."""

    sign: float
    equation: int | None = None
    coefficient: tuple[Quantity, str] | None = None


class OperatorTerm(NamedTuple):
    """An operator in an equation: its sign, the quantity of the stage that it multiplies, and the rows that enter."""

    equation: int
    operator: str
    sign: float
    quantity: Quantity
    rows: tuple[int, int] | None


class Group(NamedTuple):
    """Equations of a stage whose Lagrangian is recorded together, and where their rows begin (-1: absent).

    `rows` are those of the constraints that ν has.
    """

    stage: int
    kind: Lagrangian
    xi: int
    nu: int
    xi_equation: int
    nu_equation: int
    rows: tuple[int, int]


@dataclass(frozen=True)
class Tables:
    """Tables derived from the structure of an operation for systems of one structure.

    Attributes
    ----------
    structure : of the operation
    nq, m, holonomic : numbers of coordinates, constraints, and those of them that are holonomic
    """

    structure: Structure
    nq: int
    m: int
    holonomic: int

    def size(self, of: str) -> int:
        """Entries of a block."""
        return self.m if of == CONSTRAINTS else self.nq

    def _rows(self, sizes: Iterable[tuple[str, str]]) -> tuple[dict[str, int], int]:
        found, at = {}, 0
        for name, of in sizes:
            found[name] = at
            at += self.size(of)
        return found, at

    @cached_property
    def state(self) -> dict[str, int]:
        """First indices of the blocks of the state."""
        return self._rows(self.structure.state)[0]

    @cached_property
    def state_size(self) -> int:
        """Entries of the state."""
        return self._rows(self.structure.state)[1]

    @cached_property
    def unknowns(self) -> dict[str, int]:
        """First indices of the blocks of unknowns."""
        return self._rows(self.structure.unknowns)[0]

    @cached_property
    def n(self) -> int:
        """Number of unknowns."""
        return self._rows(self.structure.unknowns)[1]

    @cached_property
    def equations(self) -> list[int]:
        """First rows of the equations."""
        found, end = list[int](), 0
        for kind, _, rows in self.structure.equations:
            shared = rows == NONHOLONOMIC  # of the equation before
            found.append(found[-1] if shared else end)
            end += 0 if shared else self.size(KINDS[kind].size)
        return found

    def rows(self, *chosen: str) -> tuple[int, int] | None:
        """The rows of the constraints that are in all of some choices; None for none."""
        first = self.holonomic if NONHOLONOMIC in chosen else 0
        last = self.holonomic if HOLONOMIC in chosen else self.m
        return (first, last) if first < last else None

    def _some(self, rows: tuple[int, int]) -> tuple[int, int] | None:
        """The same for a part: None for all."""
        return None if rows == (0, self.m) else rows

    def _quantities(self) -> Iterator[tuple[Quantity, tuple[str, ...]]]:
        for s, stage in enumerate(self.structure.stages):
            for name, blocks in stage:
                yield (s, name), blocks

    @cached_property
    def _ordered(self) -> list[Quantity]:
        """Quantities of all stages; those that move with the state come first."""
        return sorted(dict(self._quantities()), key=lambda key: key not in self._moved)

    @cached_property
    def _moved(self) -> set[Quantity]:
        return {key for key, blocks in self._quantities() if any(name in self.state for name in blocks)}

    def _height(self, quantity: Quantity) -> str:
        return CONSTRAINTS if quantity[1] in MULTIPLIERS else ""

    @cached_property
    def stages(self) -> dict[Quantity, int]:
        """First indices of the quantities of the stages."""
        sizes = (self.size(self._height(key)) for key in self._ordered)
        return dict(zip(self._ordered, np.cumsum([0, *sizes])[:-1].tolist(), strict=True))

    @property
    def moving(self) -> list[Quantity]:
        """The quantities that move with the state."""
        return [key for key in self._ordered if key in self._moved]

    @cached_property
    def moved(self) -> int:
        """Entries of the quantities that move with the state."""
        return sum(self.size(self._height(key)) for key in self._moved)

    @cached_property
    def stage_size(self) -> int:
        """Entries of all quantities."""
        return sum(self.size(self._height(key)) for key in self._ordered)

    @cached_property
    def by_state(self) -> list[tuple[Quantity, str]]:
        """The terms of the stages' quantities by blocks of the state."""
        return [(key, name) for key, blocks in self._quantities() for name in blocks if name in self.state]

    @cached_property
    def by_unknowns(self) -> list[tuple[Quantity, str]]:
        """The same by blocks of the unknowns."""
        return [(key, name) for key, blocks in self._quantities() for name in blocks if name in self.unknowns]

    @cached_property
    def from_state(self) -> list[Term]:
        """The terms of the state after the operation by that before."""
        return [(key, name) for key, blocks in self.structure.update for name in blocks if name in self.state]

    @cached_property
    def from_unknowns(self) -> list[Term]:
        """The same by the unknowns."""
        return [
            (key, name) for key, blocks in self.structure.update for name in blocks if name in self.unknowns
        ]

    def stage_terms(self) -> Array:
        """Rows of the stages' quantities, rows of the unknowns, and their numbers."""
        rows = [
            (self.stages[key], self.unknowns[name], self.size(self._height(key)))
            for key, name in self.by_unknowns
        ]
        return np.array(rows, np.int64).reshape(-1, 3)

    def _entering(self) -> Iterator[OperatorTerm]:
        for e, (kind, s, rows) in enumerate(self.structure.equations):
            for name, operators in KINDS[kind].by.items():
                if (s, name) in self.stages:
                    for operator, sign, own in ((*one, ALL)[:3] for one in operators):
                        chosen = self.rows(rows, own)
                        if chosen is not None:
                            yield OperatorTerm(e, operator, sign, (s, name), self._some(chosen))

    @cached_property
    def _parts(self) -> list[tuple[Part, Weight]]:
        blocks = dict(self._quantities())
        found = []
        for e, operator, sign, key, rows in self._entering():
            for name in blocks[key]:
                if name in self.unknowns:
                    part = Part(
                        at_stage(operator, key[0]),
                        self.equations[e],
                        self.unknowns[name],
                        key[1] in MULTIPLIERS,
                        rows,
                    )
                    found.append((part, Weight(sign, e, (key, name))))
        return [*found, *((part, Weight(1.0)) for part in self._without_equation())]

    def _without_equation(self) -> Iterator[Part]:
        """The multipliers of equations that are left out, and of those that a kind has none of, are zero."""
        sizes, own = dict(self.structure.unknowns), self.holonomic
        multipliers = [at for name, at in self.unknowns.items() if sizes[name] == CONSTRAINTS]
        for row, column, solved in zip(self.constraints, multipliers, self.solved, strict=True):
            yield Part(LEFT_OUT, row, column, rows=self._some((0, solved)))
            if solved < self.m:
                yield Part(UNIT, row + own, column + own, rows=(0, self.m - own))

    @cached_property
    def _product(self) -> list[tuple[Part, Weight]]:
        found = []
        for e, operator, sign, key, rows in self._entering():
            if key in self._moved:
                part = Part(
                    at_stage(operator, key[0]),
                    self.equations[e],
                    self.stages[key],
                    key[1] in MULTIPLIERS,
                    rows,
                )
                found.append((part, Weight(-sign, e)))
        return found

    @property
    def parts(self) -> tuple[Part, ...]:
        """Positions of operators in the matrix of the operation."""
        return tuple(part for part, _ in self._parts)

    @property
    def product(self) -> tuple[Part, ...]:
        """Positions of operators in the matrix that multiplies changes of the stages."""
        return tuple(part for part, _ in self._product)

    @property
    def weights(self) -> list[Weight]:
        """Weights of the parts of the matrix."""
        return [weight for _, weight in self._parts]

    @property
    def product_weights(self) -> list[Weight]:
        """Weights of the parts of the product."""
        return [weight for _, weight in self._product]

    @cached_property
    def constraints(self) -> list[int]:
        """First rows of the equations of constraints."""
        return [self.equations[e] for e in self._of_constraints()]

    def _of_constraints(self) -> list[int]:
        """The equations of constraints; those that share the rows of the one before are not counted."""
        every = enumerate(self.structure.equations)
        return [e for e, (kind, _, rows) in every if KINDS[kind].size == CONSTRAINTS and rows != NONHOLONOMIC]

    @cached_property
    def solved(self) -> list[int]:
        """Number of solved rows of each of these equations."""
        chosen = [*(rows for _, _, rows in self.structure.equations), ALL]
        whole = (chosen[e] == ALL or chosen[e + 1] == NONHOLONOMIC for e in self._of_constraints())
        return [self.m if one else self.holonomic for one in whole]

    @property
    def alike_stages(self) -> int:
        """Number of stages, if all have the same unknowns and equations in sequence, else 1."""
        count, sizes = len(self.structure.stages), [of for _, of in self.structure.unknowns]
        kinds = [kind for kind, _, _ in self.structure.equations]
        own = len(sizes) // count, len(kinds) // count
        alike = sizes == sizes[: own[0]] * count and kinds == kinds[: own[1]] * count
        return (
            count
            if alike and [s for _, s, _ in self.structure.equations] == sorted([*range(count)] * own[1])
            else 1
        )

    @cached_property
    def calls(self) -> list[tuple[int, Call]]:
        """Calls that evaluate the operators, with their stages."""
        found = []
        for s in range(len(self.structure.stages)):
            names = {part.name for part in (*self.parts, *self.product)}
            own = {name.partition("@")[0] for name in names if name.endswith(f"@{s}")}
            found += [(s, call) for call in calls_for(own)]
        return found

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The names of the operators' numbers, those that are evaluated first."""
        evaluated = (at_stage(name, s) for s, call in self.calls for name in call.outputs)
        return (*evaluated, LEFT_OUT, UNIT)

    @property
    def like(self) -> dict[str, str]:
        """The operator of each name."""
        return {name: operator_of(name) for name in self.names if name not in (LEFT_OUT, UNIT)}

    @cached_property
    def groups(self) -> list[Group]:
        """Lagrangians of the equations, stage by stage."""
        found = []
        for s in range(len(self.structure.stages)):
            every = [
                (e, kind, rows) for e, (kind, at, rows) in enumerate(self.structure.equations) if at == s
            ]
            own = {kind: e for e, kind, rows in every if rows != NONHOLONOMIC}
            found += [
                self._group(s, one, own.get(one.xi, NOWHERE), own.get(one.nu, NOWHERE))
                for one in lagrangians(set(own))
            ]
            divided = (e for e, _, rows in every if rows == NONHOLONOMIC and self.rows(rows))
            found += [self._group(s, VELOCITY, NOWHERE, e) for e in divided]
        return found

    def _group(self, stage: int, of: Lagrangian, xi: int, nu: int) -> Group:
        at = [NOWHERE if e == NOWHERE else self.equations[e] for e in (xi, nu)]
        chosen = ALL if nu == NOWHERE else self.structure.equations[nu][2]
        return Group(stage, of, at[0], at[1], xi, nu, self.rows(chosen) or (0, self.m))

    @cached_property
    def recorded(self) -> list[Quantity]:
        """The quantities whose values are needed."""
        return [
            (s, name) for s, stage in enumerate(self.structure.stages) for name, _ in stage if name in ROLES
        ]


def at_stage(operator: str, stage: int) -> str:
    return operator if operator == UNIT else f"{operator}@{stage}"


def operator_of(name: str) -> str:
    """The operator that is evaluated under a name."""
    base = name.partition("@")[0]
    return OPERATOR.get(base, base)


@once_alike
def tables_of(system: System, structure: Structure) -> Tables:
    """The tables for systems of one structure."""
    return Tables(structure, system.nq, system.m, system.m_holonomic)


@once_alike
def constrained(system: System, structure: Structure) -> Array:
    """Places of numbers in rows of constraints, and the constraint (entries, 2)."""
    return constrained_values(system, tables_of(system, structure))


def constrained_values(system: System, tables: Tables) -> Array:
    """See `constrained`."""
    numbers, found = Numbers(system, tables.names, tables.like), [np.zeros((0, 2), np.int64)]
    for name in tables.names:
        if name.partition("@")[0] in OF_CONSTRAINTS:
            rows = entries_of(system, operator_of(name))[0]
            found.append(np.column_stack([numbers.start[name] + np.arange(len(rows)), rows]))
    return np.concatenate(found).astype(np.int64)
