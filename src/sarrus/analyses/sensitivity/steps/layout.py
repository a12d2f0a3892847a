"""Positions of the tables and buffers of several operations in the arrays of compiled loops."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...._jit.linking.link import compiled
from ....algebra import Array
from ....system import System
from ....system.cached import once_alike
from ...dynamics.methods.equations import MULTIPLIERS
from ...dynamics.methods.tables import DRIVERS, NOWHERE, Structure, Tables, at_stage, constrained, tables_of
from ...equations.block_matrix import Numbers
from .stacked import Ragged, ragged

TABLES = ("by_unknowns", "pieces", "calls", "constrained", "constraints", "groups")
SIZES = ("n", "moved", "stages", "times", "values", "adjoints")


class Layout(NamedTuple):
    """Tables of all operations, in the order of `record`; places in lanes count entries, of all lanes.

    Attributes
    ----------
    n, moved, stages : (operations,) unknowns; entries of the stages' quantities, those that move with the state, all
    node : (4,) where q, v, a and λ begin in the state
    by_unknowns : terms of the stages, see `Tables.stage_terms`
    pieces : places of recorded values among the states in lanes
    times : (operations, 2) place of the stages' times there, and how many
    calls : of drivers: which, places of t and three operands, places of the outputs among the values
    values : (operations, 3) places of all values, of those that are not evaluated, and of those of redundant equations
    constrained : places of values in rows of constraints, and the constraint
    constraints : where rows of equations of constraints begin
    groups : see `groups_of`
    adjoints : (operations, 2) where the adjoint variables of their groups begin, and end
    states_size, values_size : entries in lanes
    """

    n: Array
    moved: Array
    stages: Array
    node: Array
    by_unknowns: Ragged
    pieces: Ragged
    times: Array
    calls: Ragged
    values: Array
    constrained: Ragged
    constraints: Ragged
    groups: Ragged
    adjoints: Array
    states_size: int
    values_size: int


class EquationGroup(NamedTuple):
    """A group of equations whose Lagrangian is recorded together.

    Attributes
    ----------
    kind : of the Lagrangian
    t, q, v, a, lam : places among the states in lanes
    xi, nu : places among the adjoint variables
    xi_row, nu_row, xi_equation, nu_equation : rows and numbers of the equations, -1 where one is absent
    sign : of ν
    by_q, by_v, by_a, by_lam : where the gradient belongs among the stages' quantities
    first, last : the first of the constraints that ν has, and the end of these
    """

    kind: int
    t: int
    q: int
    v: int
    a: int
    lam: int
    xi: int
    nu: int
    xi_row: int
    nu_row: int
    xi_equation: int
    nu_equation: int
    sign: int
    by_q: int
    by_v: int
    by_a: int
    by_lam: int
    first: int
    last: int


GROUP_SIZE = len(EquationGroup._fields)


@compiled
def group_of(groups: Array, n: int) -> EquationGroup:
    """One of some groups, which are rows."""
    x = groups[n]
    return EquationGroup(
        x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7], x[8], x[9], x[10], x[11], x[12], x[13], x[14], x[15], x[16],
        x[17], x[18],
    )  # fmt: skip


class States:
    """Places of the recorded quantities of an operation's stages among the states in lanes, from a place on."""

    def __init__(self, tables: Tables, first: int) -> None:
        self.times, count = first, len(tables.structure.stages)
        self._at: dict[tuple[int, str], int] = {(s, "t"): first + s for s in range(count)}
        at = first + count
        for key in tables.recorded:
            self._at[key] = at
            at += tables.m if key[1] in MULTIPLIERS else tables.nq
        self._none, self.end = at, at + max(tables.nq, tables.m)

    def place(self, stage: int, name: str | None) -> int:
        """Of a quantity; of one that a stage does not have, zeros."""
        return self._at.get((stage, name or ""), self._none)


def groups_of(tables: Tables, states: States, kinds: Sequence[str], adjoint: int) -> tuple[Array, int]:
    """An `EquationGroup` in each row, and the end of their adjoint variables."""
    found = []
    for group in tables.groups:
        s, one = group.stage, group.kind
        operands = [states.place(s, name) for name in ("t", "q", "v", one.acceleration, one.multipliers)]
        by = [
            tables.stages.get((s, name or ""), NOWHERE)
            for name in ("q", "v", one.acceleration, one.multipliers)
        ]
        places = [adjoint, adjoint + tables.nq]
        adjoint += tables.nq + tables.m
        rows = [group.xi, group.nu, group.xi_equation, group.nu_equation, int(one.sign)]
        found.append([kinds.index(one.kind), *operands, *places, *rows, *by, *group.rows])
    return np.array(found, np.int64).reshape(-1, GROUP_SIZE), adjoint


def kinds_of(structures: Sequence[Structure], system: System) -> list[str]:
    """The kinds of Lagrangians that operations need."""
    groups = (group for one in structures for group in tables_of(system, one).groups)
    return list(dict.fromkeys(group.kind.kind for group in groups))


def drivers_of(structures: Sequence[Structure], system: System) -> list[str]:
    """The groups of operators that operations need."""
    return [
        name
        for name in DRIVERS
        for one in structures
        for _, call in tables_of(system, one).calls
        if call.group == name
    ]


@once_alike
def layout_of(system: System, structures: tuple[Structure | None, ...]) -> Layout:
    """The layout for operations of some structures; None for one that does not occur."""
    present = [one for one in structures if one is not None]
    kinds = kinds_of(present, system)
    fields: dict[str, list[Any]] = {name: [] for name in Layout._fields}
    states_at, values_at, adjoint = 0, 0, 0
    none = np.zeros((0, GROUP_SIZE), np.int64)
    for structure in structures:
        if structure is None:
            rows: dict[str, Any] = dict.fromkeys(("n", "moved", "stages"), 0)
            rows |= {"times": (0, 0), "values": (0, 0, 0), "adjoints": (adjoint, adjoint)}
            widths = {"by_unknowns": 3, "calls": 9, "constrained": 2, "groups": GROUP_SIZE}
            rows |= {name: none[:, :width] for name, width in widths.items()} | {
                "constraints": none[:, 0],
                "pieces": none[:, 0],
            }
        else:
            tables = tables_of(system, structure)
            states, numbers = States(tables, states_at), Numbers(system, tables.names, tables.like)
            groups, end = groups_of(tables, states, kinds, adjoint)
            start = {name: values_at + at for name, at in numbers.start.items()}
            calls = np.array([_call(s, call, states, start) for s, call in tables.calls], np.int64)
            own = constrained(system, structure) + [values_at, 0]
            rows = {
                "n": tables.n, "moved": tables.moved, "stages": tables.stage_size, "by_unknowns": tables.stage_terms(),
                "pieces": np.array([states.place(*key) for key in tables.recorded], np.int64),
                "times": (states.times, len(structure.stages)), "calls": calls,
                "values": (values_at, start["left_out"], values_at + len(numbers.values)), "constrained": own,
                "constraints": np.array(tables.constraints, np.int64), "groups": groups, "adjoints": (adjoint, end),
            }  # fmt: skip
            adjoint, states_at, values_at = end, states.end, values_at + len(numbers.values)
        for name, value in rows.items():
            fields[name].append(value)
    first = tables_of(system, present[0]).state
    made: dict[str, Any] = {name: ragged(fields[name]) for name in TABLES}
    made |= {name: np.array(fields[name], np.int64) for name in SIZES}
    made["node"] = np.array([first[name] for name in ("q", "v", "a", "lam")])
    return Layout(**made, states_size=states_at, values_size=values_at)


def _call(stage: int, call: Any, states: States, start: dict[str, int]) -> list[int]:
    """Driver, places of t and of three operands, places of at most four outputs."""
    third = call.operands[1 if call.group == "inertia" else -1]
    outputs = [start[at_stage(name, stage)] for name in call.outputs]
    places = [states.place(stage, name) for name in ("t", "q", third, "a")]
    return [DRIVERS.index(call.group), *places, *outputs, *[0] * (4 - len(outputs))]
