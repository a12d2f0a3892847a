"""A description as the time integration loop takes it: places in a work array, affine maps between them, and formulas.

All vectors of a step (state before and after, unknowns, stages, outputs of operators) are parts of one array x. An
affine map is a list of terms x[to] = x[base] + r[register] x[of]. What the state before the step gives to the stages
(`BASE`) is computed once a step, what the unknowns add (`STAGES`) in every iteration. The registers r are the
coefficients, which depend on the step size h and its ratio to the step before: their formulas are recorded once, and
evaluated whenever h or the ratio changes. Nothing is compiled for a method.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from ...._jit.formulas.curves import CODES
from ...._jit.formulas.expression import Expression, Graph
from ...._jit.formulas.replay import needed
from ....algebra import Array
from ....system import System
from ...equations.block_matrix import Numbers
from .description import (
    CONSTRAINTS,
    Affine,
    Description,
    FilteredEstimate,
    Operation,
    Stage,
    StepLengths,
    combined,
)
from .equations import KINDS
from .splitting import Split, StageTables, split_of
from .tables import DRIVERS, Tables, at_stage, constrained_values, structure_of

STAGES, UPDATE, CHANGE, ERROR, GUESS, BASE, CONTINUED, EQUATIONS = range(8)  # affine maps
RESIDUAL, MOMENTUM, FORCE, VELOCITY, GAMMA = range(5)  # groups of operators in the equations
OF_EQUATIONS = 5  # how many these are
PREDICTED = ("q", "v", "a", "lam")  # quantities of the stages that are known from the motion so far
NODE = ("q", "v", "a", "lam")
TERMS: dict[
    str, tuple[tuple[int, str, float], ...]
] = {  # of equations: groups, which of their outputs, and signs
    "motion": (
        (MOMENTUM, "M_a", 1.0),
        (RESIDUAL, "Phi_qT_lam", 1.0),
        (FORCE, "Q", -1.0),
        (MOMENTUM, "S", -1.0),
    ),
    "position": ((RESIDUAL, "Phi", 1.0),),
    "velocity": ((VELOCITY, "Phi_q_xi", 1.0), (VELOCITY, "Phi_t", 1.0)),
    "acceleration": ((VELOCITY, "Phi_q_xi", 1.0), (GAMMA, "gamma", -1.0)),
    "kinematic": ((RESIDUAL, "Phi_qT_lam", 1.0),),
}
OUTPUTS: dict[int, tuple[str, ...]] = {
    RESIDUAL: ("Phi", "Phi_qT_lam"),
    MOMENTUM: ("M_a", "S"),
    FORCE: ("Q",),
    VELOCITY: ("Phi_q_xi", "Phi_t"),
    GAMMA: ("gamma",),
}
OF_COORDINATES = ("Phi_qT_lam", "M_a", "S", "Q")


class Program(NamedTuple):
    """Tables of one method for one system.

    Attributes
    ----------
    tape, constants : of the formulas: operation, and the registers that it takes; constants by register
    terms, bounds : (n, 5) of all maps: to, of, how many entries, register, base; where each map begins
    times : (stages,) parts of the step
    calls : (n, 9) operators of the equations: group, stage, places of q and two operands; of two outputs begin, end
    positions : (n, 2) equations of positions: row, register of the scale
    rates : (n, 2) rates of kinematic equations: where they are, and where times W, see `kinematic_weights`
    operators : (n, 13) those of the matrix; of four outputs, in their values
    constrained : (n, 2) places of values in rows of constraints, and the constraint
    multipliers : (n, 3) rows of constraints, the unknowns that are zero where these are redundant, and how many of the
        rows are solved
    weights : (parts,) registers of the weights of the matrix's parts; of the real matrix, where stages are split
    pair_weights : (parts, 2) registers of α and β of the complex matrix's parts; (0, 2) where stages are not split
    T, T_inverse : see `splitting`; (0, 0) where stages are not split
    filtered : of the kinematic equation and of that of motion, for the estimate: registers of the weights of slopes and
        of scales; rows in the system of one stage, and columns of q and v; none where the estimate is not filtered
    n, right, unknowns, state, after, stages, change, moved, error, before : sizes and places in x: how many unknowns;
        the right side of Newton's method, the unknowns, the states before and after the step, all stages, changes of
        the unknowns, of q₁ and v₁, the error, the last step's unknowns
    former, inertia : places in x: the state before the last step; outputs of M a and S
    end_slope : where the acceleration of the last stage is
    slope, lam_slope : where the rates of change of a and λ are
    exponent, constant : of the leading error
    estimated : whether the method gives an estimate of its error
    own_accelerations : whether its update gives a and λ
    projects, lengths : see `Description`
    """

    tape: Array
    constants: Array
    terms: Array
    bounds: Array
    times: Array
    calls: Array
    positions: Array
    rates: Array
    operators: Array
    constrained: Array
    multipliers: Array
    weights: Array
    pair_weights: Array
    T: Array
    T_inverse: Array
    filtered: Array
    n: int
    right: int
    unknowns: int
    state: int
    after: int
    stages: int
    change: int
    moved: int
    error: int
    before: int
    former: int
    inertia: int
    end_slope: int
    slope: int
    lam_slope: int
    exponent: int
    constant: float
    estimated: bool
    continues: bool
    own_accelerations: bool
    projects: bool
    lengths: StepLengths


class Formulas:
    """The coefficients of a method as expressions of h and of its ratio, and their registers."""

    def __init__(self, method: Description) -> None:
        self._graph, self._wanted = Graph(), list[Expression]()
        self.h, self.ratio = (self._graph.input(name) for name in ("h", "ratio"))
        self.step = method.step(self.h, self.ratio)
        error = method.error.of(self.h, self.ratio) if method.error else {}
        self.error: tuple[Affine, ...] = error if isinstance(error, tuple) else (error,)

    def register(self, formula: Any) -> int:
        """A place that `tape` replaces by a register."""
        self._wanted.append(
            formula if isinstance(formula, Expression) else self._graph.constant(float(formula))
        )
        return len(self._wanted) - 1

    def tape(self, name: str) -> tuple[Array, Array, Array]:
        """Operations, constants, and the register of each place.

        Raises
        ------
        TypeError
            If a coefficient uses a function that is not supported.
        """
        order = needed(self._graph, self._wanted)
        place = {identity: n for n, identity in enumerate(order)}
        tape, constants = np.zeros((len(order), 3), np.int64), np.zeros(len(order))
        for n, identity in enumerate(order):
            op, args, value = self._graph.nodes[identity]
            if op not in CODES:
                raise TypeError(f"{name}: coefficients cannot use {op}. Choose from {', '.join(CODES)}.")
            tape[n, : 1 + len(args)] = [CODES[op], *(place[arg] for arg in args)]
            if op == "constant":
                constants[n] = value
            elif op == "input":
                tape[n, 1] = value == ("ratio",)
        return tape, constants, np.array([place[one.id] for one in self._wanted], np.int64)


class ProgramBuilder:
    """Lays out x and writes the tables of a method for one system."""

    def __init__(self, system: System, method: Description) -> None:
        self.method, self.formulas = method, Formulas(method)
        self.step = self.formulas.step
        structure = structure_of(Operation(method.state, method.unknowns, self.step))
        counts = system.nq, system.m, system.m_holonomic
        self.tables = Tables(structure, *counts)
        self.split: Split | None = split_of(method)
        self.of_matrix = StageTables(self.split.structure, *counts) if self.split else self.tables
        self._system, self._nq, self._m = system, system.nq, system.m
        self._rates = list[list[int]]()
        self.size, tables = 0, self.tables
        widest = max(system.nq, system.m)
        names = (
            "state",
            "after",
            "unknowns",
            "before",
            "change",
            "right",
            "stages",
            "moved",
            "error",
            "zero",
            "former",
            "inertia",
        )
        sizes = (tables.state_size, tables.state_size, *[tables.n] * 4, tables.stage_size, 2 * self._nq,
                 2 * self._nq, widest, tables.state_size, 2 * self._nq)  # fmt: skip
        self.place = {name: self._take(size) for name, size in zip(names, sizes, strict=True)}
        self.place |= {"slope": self._take(self._nq), "lam_slope": self._take(self._m)}

    def _take(self, size: int) -> int:
        self.size += size
        return self.size - size

    def _taken(self, size: int) -> tuple[int, int]:
        return self._take(size), self.size

    def block(self, where: str, name: str) -> int:
        """The place of a block of the state or of the unknowns."""
        blocks = self.tables.state if where in ("state", "after", "former") else self.tables.unknowns
        return self.place[where] + blocks[name]

    def quantity(self, stage: int, name: str | None) -> int:
        """The place of a stage's quantity; zeros where it has none."""
        at = self.tables.stages.get((stage, name or ""))
        return self.place["zero"] if at is None else self.place["stages"] + at

    def _height(self, name: str) -> int:
        return self._m if name in ("lam", "mu") else self._nq

    # ------------------------------------------------------------------------------------------------- affine maps
    def _map(
        self,
        to: int,
        affine: Affine,
        height: int,
        unknowns: str = "unknowns",
        base: int | None = None,
        state: str = "state",
    ) -> list[list[int]]:
        rows = list[list[int]]()
        base = self.place["zero"] if base is None else base
        for name, coefficient in affine.items():
            of = self.block(state, name) if name in self.tables.state else self.block(unknowns, name)
            rows.append([to, of, height, self.formulas.register(coefficient), to if rows else base])
        return rows

    def _split(self, to: int, affine: Affine, height: int) -> tuple[list[list[int]], list[list[int]]]:
        """The part of a map that the state before the step gives, and what the unknowns add to it."""
        known = {name: c for name, c in affine.items() if name in self.tables.state}
        own = {name: c for name, c in affine.items() if name not in known}
        if not own or not known:
            return self._map(to, known, height), self._map(to, own, height)
        base = self._take(height)
        return self._map(base, known, height), self._map(to, own, height, base=base)

    def _stages(self) -> tuple[list[list[int]], list[list[int]]]:
        """Stages, and q and v after the step: both parts, see `_split`."""
        base, found, places = list[list[int]](), list[list[int]](), dict[int, int]()
        after = [(self.block("after", name), self.step.update[name], name) for name in ("q", "v")]
        for s, stage in enumerate(self.step.stages):
            after += [(self.quantity(s, name), getattr(stage, name), name) for name in Stage._fields[1:]]
        for to, affine, name in after[2:] + after[:2]:
            height = self._height(name)
            if id(affine) in places:  # as the stage at the end
                found.append(
                    [to, places[id(affine)], height, self.formulas.register(1.0), self.place["zero"]]
                )
                continue
            known, own = self._split(to, affine, height)
            base, found, places = base + known, found + own, places | ({id(affine): to} if affine else {})
        return base, found

    def _update(self) -> list[list[int]]:
        """The state after the step, but for q and v."""
        found = list[list[int]]()
        for name, size in self.method.state.items():
            if name in self.step.update and name not in ("q", "v"):
                affine = self.step.update[name]
                found += self._map(self.block("after", name), affine, self.tables.size(size))
        return found

    def _change(self) -> list[list[int]]:
        """Changes of q and v after the step by those of the unknowns."""
        found = list[list[int]]()
        for n, name in enumerate(("q", "v")):
            own = {u: c for u, c in self.step.update[name].items() if u in self.tables.unknowns}
            found += self._map(self.place["moved"] + n * self._nq, own, self._nq, "change")
        return found

    def _continued(self) -> list[list[int]]:
        """First guess by the last step."""
        found, method = list[list[int]](), self.method
        guess = method.continued(self.formulas.h, self.formulas.ratio) if method.continued else {}
        for name, size in method.unknowns.items() if guess else ():
            to, height = self.block("unknowns", name), self.tables.size(size)
            found += self._map(to, guess.get(name) or {name: 0.0}, height, "before", state="former")
        return found

    def _guess(self) -> list[list[int]]:
        """The unknowns that belong to the motion so far, continued: q''' and λ' stay.

        An unknown of which no quantity of a stage alone depends begins where it was in the last step.
        """
        found = list[list[int]]()
        for name, size in self.method.unknowns.items():
            own = self._predicted(name)
            to, height = self.block("unknowns", name), self.tables.size(size)
            of = own or [(self.block("before", name), 1.0)]
            for n, (place, coefficient) in enumerate(of):
                base = to if n else self.place["zero"]
                found.append([to, place, height, self.formulas.register(coefficient), base])
        return found

    def _predicted(self, unknown: str) -> list[tuple[int, Any]] | None:
        """Places and coefficients by which an unknown follows from the motion so far, or None."""
        found = [
            (affine, quantity, stage.time)
            for stage in self.step.stages
            for quantity in PREDICTED
            for affine in [getattr(stage, quantity)]
            if [name for name in affine if name in self.tables.unknowns] == [unknown]
        ]
        for affine, quantity, time in sorted(
            found, key=lambda one: len(one[0]) > 1
        ):  # best: nothing but the unknown
            known = {name: c for name, c in affine.items() if name != unknown}
            wanted = combined((1.0, self._motion(quantity, time)), (-1.0, known))
            factor = 1 / affine[unknown]
            return [(self._moving(name), factor * c) for name, c in wanted.items()]
        return None

    def _motion(self, quantity: str, part: float) -> Affine:
        """A quantity at a part of the step, by the state before and the slopes."""
        t = part * self.formulas.h
        return {
            "q": {"q": 1.0, "v": t, "a": t * t / 2, "slope": t * t * t / 6},
            "v": {"v": 1.0, "a": t, "slope": t * t / 2},
            "a": {"a": 1.0, "slope": t},
            "lam": {"lam": 1.0, "lam_slope": t},
        }[quantity]

    def _moving(self, name: str) -> int:
        return self.place[name] if name in ("slope", "lam_slope") else self.block("state", name)

    # --------------------------------------------------------------------------------------------------- equations
    def _calls(self) -> tuple[list[list[int]], list[list[int]]]:
        """Operators of the equations, and the terms of these, scaled."""
        calls, terms = list[list[int]](), list[list[int]]()
        known, filled = dict[tuple[int, int, str], int](), set[int]()

        def add(row: int, of: int, height: int, factor: Any) -> None:
            to = self.place["right"] + row
            terms.append(
                [to, of, height, self.formulas.register(factor), to if row in filled else self.place["zero"]]
            )
            filled.add(row)

        for row, (kind, s, scale, rows) in zip(self.tables.equations, self.step.equations, strict=True):
            for group, output, sign in TERMS[kind]:
                third, fourth = self._operands(group, kind)
                key = group, s, third
                if key not in known:
                    known[key] = len(calls)
                    places = [self.quantity(s, name) for name in ("q", third, fourth)]
                    outputs = [self._taken(self._output_size(name)) for name in OUTPUTS[group]]
                    calls.append([group, s, *places, *_ends(outputs, 2)])
                place = calls[known[key]][5 + 2 * OUTPUTS[group].index(output)]
                first, last = self.tables.rows(rows) or (0, 0)
                height = last - first if KINDS[kind].size == CONSTRAINTS else self._nq
                add(row + first, place + first, height, sign * scale)
            if kind == "kinematic":
                weighted = self._take(self._nq)
                self._rates.append([self.quantity(s, "rate"), weighted])
                add(row, weighted, self._nq, scale)
        return calls, terms

    def _output_size(self, name: str) -> int:
        return self._nq if name in OF_COORDINATES else self._m

    @staticmethod
    def _operands(group: int, kind: str) -> tuple[str, str]:
        if group == RESIDUAL:
            return ("mu" if kind == "kinematic" else "lam"), ""
        if group == VELOCITY and kind == "acceleration":
            return "a", ""
        return "v", "a"

    def _positions(self) -> list[list[int]]:
        rows = zip(self.tables.equations, self.step.equations, strict=True)
        return [[row, self.formulas.register(one.scale)] for row, one in rows if one.kind == "position"]

    def _split_weights(self, split: Split) -> list[list[int]]:
        """γ, α and β of the parts of the matrices."""
        weights = (split.weights(self.step, weight) for weight in self.of_matrix.weights)
        return [[self.formulas.register(one) for one in own] for own in weights]

    def _filtered(self, split: Split) -> list[int]:
        """See `Program.filtered`."""
        if not isinstance(self.method.error, FilteredEstimate):
            return []
        kinds = [kind for kind, _, _ in split.structure.equations]
        own = [kinds.index(kind) for kind in ("kinematic", "motion")]
        slopes = [
            next(n for n, weight in enumerate(self.of_matrix.weights)
                 if weight.equation == e and weight.coefficient and weight.coefficient[0][1] == name
                 and weight.coefficient[1] in self._alone(split, other))
            for e, name, other in zip(own, ("rate", "a"), ("q", "v"), strict=True)
        ]  # fmt: skip
        rows = [self.of_matrix.equations[e] for e in own]
        scales = [self.formulas.register(self.step.equations[e].scale) for e in own]
        gammas = [
            self.formulas.register(split.weights(self.step, self.of_matrix.weights[n])[0]) for n in slopes
        ]
        columns = [self.of_matrix.unknowns[self._alone(split, name)[0]] for name in ("q", "v")]
        return [*gammas, *scales, *rows, *columns]

    @staticmethod
    def _alone(split: Split, name: str) -> tuple[str, ...]:
        """The unknowns of which a quantity of a stage is made."""
        return dict(split.structure.stages[0])[name]

    def _weights(self) -> list[int]:
        found = []
        for sign, equation, coefficient in self.tables.weights:
            weight = sign if equation is None else sign * self.step.equations[equation].scale
            if coefficient is not None:
                (s, name), by = coefficient
                weight = weight * getattr(self.step.stages[s], name)[by]
            found.append(self.formulas.register(weight))
        return found

    def _operators(self, values: Mapping[str, tuple[int, int]]) -> list[list[int]]:
        """Operators of the matrix; `values` is where the values of each begin and end."""
        found = []
        for at, call in self.of_matrix.calls:
            s = self.split.stage if self.split else at
            third = call.operands[1 if call.group == "inertia" else -1]
            operands = [self.quantity(s, name) for name in ("q", third, "a")]
            outputs = [values[at_stage(name, at)] for name in call.outputs]
            found.append([DRIVERS.index(call.group), s, *operands, *_ends(outputs, 4)])
        return found

    def _multipliers(self) -> list[list[int]]:
        unknowns = [
            self.block("unknowns", name) for name, size in self.method.unknowns.items() if size == CONSTRAINTS
        ]
        return [list(one) for one in zip(self.tables.constraints, unknowns, self.tables.solved, strict=True)]

    def program(self, numbers: Numbers, exponent: int, constant: float) -> Program:
        """All tables; `numbers` are those of the matrix's operators."""
        values = {name: (at, at + len(numbers.views[name])) for name, at in numbers.start.items()}
        error = [
            row for n, one in enumerate(self.formulas.error)
            for row in self._map(self.place["error"] + n * self._nq, one, self._nq)
        ]  # fmt: skip
        base, stages = self._stages()
        continued = self._continued()
        calls, equations = self._calls()
        maps = [stages, self._update(), self._change(), error, self._guess(), base, continued, equations]
        bounds = np.cumsum([0, *map(len, maps)])
        terms = _table((row for rows in maps for row in rows), 5)
        positions = _table(self._positions(), 2)
        split = self.split
        weights = _table(self._split_weights(split) if split else ([n, n, n] for n in self._weights()), 3)
        filtered = np.array(self._filtered(split) if split else [], np.int64)
        tape, constants, registers = self.formulas.tape(self.method.name)
        terms[:, 3] = registers[terms[:, 3]]
        positions[:, 1] = registers[positions[:, 1]]
        weights, filtered[:4] = registers[weights], registers[filtered[:4]]
        none = np.zeros((0, 0))
        places = {name: self.place[name] for name in Program._fields if name in self.place}
        return Program(
            tape=tape, constants=constants, terms=terms, bounds=bounds, calls=_table(calls, 9),
            times=np.array([stage.time for stage in self.step.stages]),
            positions=positions, rates=_table(self._rates, 2),
            operators=_table(self._operators(values), 13), constrained=constrained_values(self._system, self.of_matrix),
            multipliers=_table(self._multipliers(), 3), weights=np.ascontiguousarray(weights[:, 0]),
            pair_weights=np.ascontiguousarray(weights[:, 1:] if split else weights[:0, 1:]),
            T=split.T if split else none, T_inverse=split.inverse if split else none, filtered=filtered,
            end_slope=self.quantity(len(self.step.stages) - 1, "a"), continues=bool(continued), n=self.tables.n,
            exponent=exponent, constant=constant, estimated=bool(error), own_accelerations="a" in self.step.update,
            projects=self.method.projects, lengths=self.method.lengths, **places,
        )  # fmt: skip


def _table(rows: Iterable[list[int]], width: int) -> Array:
    return np.array(list(rows), np.int64).reshape(-1, width)


def _ends(outputs: list[tuple[int, int]], count: int) -> list[int]:
    """Begins and ends of some outputs; of those that are missing zeros."""
    return [place for pair in (outputs + [(0, 0)] * count)[:count] for place in pair]
