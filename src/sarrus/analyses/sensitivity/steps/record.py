"""The operations of a run: their coefficients, the recorded stages, and the times at which they occur."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, Protocol

import numpy as np

from ....algebra import Array
from ....results import StepsTaken
from ....system import System
from ...dynamics.methods.description import (
    Affine,
    Description,
    Operation,
    accelerations,
    projection,
)
from ...dynamics.methods.equations import MULTIPLIERS
from ...dynamics.methods.nonholonomic import method_for, operation_for
from ...dynamics.methods.splitting import Split, StageTables, split_of
from ...dynamics.methods.tables import Quantity, Tables, Weight, structure_of, tables_of
from ...dynamics.step_loop.step_store import writable
from .block_loop import Run
from .references import shared_references
from .split_loop import LEFT
from .stacked import ragged, series

PROJECTION, STEP, ACCELERATIONS = 0, 1, 2  # operations, in the order in which those of one step occur
SOURCES = 20  # arrays of recorded values, some of them empty: as many for all methods
SPLIT_FROM = 100  # unknowns of a stage: smaller systems are solved as fast with factors of all stages
SPLIT_TO_WEIGH_FROM = 50  # the same if adjoints only weigh defects
PLAIN = 1e-12  # see `Operations.plain`, where round-off in multipliers decays
WEIGHING = 1e-7  # relative error of adjoints that only weigh defects, in a step at most
ALLOWED = 3e-2  # the same at the start of a run
STEP_LENGTH = 0.1  # over the time in which a motion changes
VERY_SHORT = 1e-4  # of a step: with such a length pivots are chosen that serve most steps


class Source(NamedTuple):
    """Recorded values: rows of an array, of occurrence k the row first + k stride."""

    values: Array
    first: int = 0
    stride: int = 1

    def all(self, count: int) -> Array:
        """Return all occurrences."""
        return self.values[self.first :: self.stride][:count]


@dataclass(frozen=True)
class Occurrences:
    """All occurrences of an operation in a run.

    Attributes
    ----------
    operation, tables : with coefficients for all of them
    steps : (count,) the step to which each belongs
    nodes : (count,) whose redundant equations are left out
    times : (count, stages) [s]
    sources : values of the stages' quantities
    """

    operation: Operation
    tables: Tables
    steps: Array
    nodes: Array
    times: Array
    sources: Mapping[Quantity, Source]

    def __len__(self) -> int:
        """Return the number of occurrences."""
        return len(self.steps)

    def _columns(self, coefficients: list[Any]) -> Array:
        found = np.empty((len(self), len(coefficients)))
        for k, coefficient in enumerate(coefficients):
            found[:, k] = coefficient
        return found

    def coefficients(self) -> Array:
        """Return the coefficients of the terms of the affine maps, in the order of `Tables` (count, terms)."""
        tables, step = self.tables, self.operation.step
        of_stages = [
            getattr(step.stages[s], name)[by] for (s, name), by in (*tables.by_state, *tables.by_unknowns)
        ]
        return self._columns(
            [*of_stages, *(step.update[to][by] for to, by in (*tables.from_state, *tables.from_unknowns))]
        )

    def weights(self, weights: list[Weight]) -> Array:
        """Return the weights of the parts of a matrix (count, parts)."""
        step, found = self.operation.step, []
        for sign, equation, coefficient in weights:
            weight = sign if equation is None else sign * step.equations[equation].scale
            if coefficient is not None:
                (s, name), by = coefficient
                weight = weight * getattr(step.stages[s], name)[by]
            found.append(weight)
        return self._columns(found)

    def split_weights(self, split: Split) -> Array:
        """Return γ of the parts of the matrix of one stage, then all α, then all β (count, 3 parts)."""
        own = self.tables
        weights = StageTables(split.structure, own.nq, own.m, own.holonomic).weights
        found = [split.weights(self.operation.step, weight) for weight in weights]
        return self._columns([coefficients[n] for n in range(3) for coefficients in found])

    @cached_property
    def scales(self) -> Array:
        """Return the scales of the equations (count, equations)."""
        return self._columns([equation.scale for equation in self.operation.step.equations])

    def stages_at(self, k: int) -> list[dict[str, Array | float]]:
        """The values of all stages at one occurrence."""
        found: list[dict[str, Array | float]] = [{"t": float(t)} for t in self.times[k]]
        for (s, name), source in self.sources.items():
            found[s][name] = np.ascontiguousarray(source.values[source.first + source.stride * k])
        return found


def _stages_of(steps: StepsTaken, tables: Tables) -> dict[Quantity, Source]:
    """Return the records of the stages of all steps."""
    if not steps.stages.shape[1]:
        return {key: Source(getattr(steps, key[1]), 1) for key in tables.recorded}
    sizes = {key: tables.m if key[1] in MULTIPLIERS else tables.nq for key in tables.recorded}
    rows = {key: slice(tables.stages[key], tables.stages[key] + size) for key, size in sizes.items()}
    return {key: Source(np.ascontiguousarray(steps.stages[:, own])) for key, own in rows.items()}


class RecordData(Protocol):
    """Data common to all operations of a record: parameters, state variables, redundant equations.

    memory, left_out : per state, or none; `places` are those of what is stored among the parameters
    """

    @property
    def b(self) -> Array: ...
    @property
    def memory(self) -> Array: ...
    @property
    def places(self) -> Array: ...
    @property
    def left_out(self) -> Array: ...
    def __len__(self) -> int: ...


class Operations:
    """Operations as sweeps take them.

    Attributes
    ----------
    system : System
    steps : what operations remember, row by row
    operations : in the order in which those of one step occur
    extra : blocks of the state besides q, v, a and λ: how each begins, by these
    plain : relative change of a solution by its refinement up to which the others of a block are not refined
    alone : whether the operations of one step do not depend on those of another
    split : of the stages of steps, where this saves time
    left : the relative error that may be left in solutions with split stages
    """

    alone = False
    split: Split | None = None
    left = LEFT
    plain = 0.0
    extra: Mapping[str, Affine] = {}

    def __init__(self, system: System, steps: RecordData, operations: list[Occurrences]) -> None:
        self.system, self.steps, self.operations = system, steps, operations

    def typical(self) -> list[tuple[Occurrences, int]]:
        """For each operation an occurrence at which pivots are chosen that serve most."""
        return [(one, len(one) - 1) for one in self.operations]

    def at_states(
        self, operation: Operation, steps: Array, nodes: Array, times: Array, values: Mapping[Quantity, Array]
    ) -> Occurrences:
        """Occurrences of an operation whose stages' quantities are given, at times of all stages."""
        operation = operation_for(self.system, operation)
        tables = tables_of(self.system, structure_of(operation))
        sources = {key: Source(np.ascontiguousarray(values[key])) for key in tables.recorded}
        stages = np.repeat(times[:, None], len(tables.structure.stages), axis=1)
        return Occurrences(operation, tables, steps, nodes, stages, sources)

    def run(self, first: int = 0) -> Run:
        """The operations as compiled code takes them, from step `first` on."""
        bounds = [(np.searchsorted(one.steps, first), len(one)) for one in self.operations]
        return self._run._replace(bounds=np.array(bounds, np.int64))

    @cached_property
    def _run(self) -> Run:
        steps, operations, none = self.steps, self.operations, np.zeros((0, 0))
        own, present = [one.tables for one in operations], [len(one) > 0 for one in operations]
        weights = [one.weights(one.tables.weights) if len(one) else none for one in operations]
        product = [one.weights(one.tables.product_weights) if len(one) else none for one in operations]
        split = [none for _ in operations]
        if self.split:
            split[STEP] = operations[STEP].split_weights(self.split)
        arrays, pieces = {id(none): none}, []
        for one, there in zip(operations, present, strict=True):
            found = [arrays.setdefault(id(x.values), x.values) for x in one.sources.values()] if there else []
            places = [list(arrays).index(id(x)) for x in found]
            rows = [(at, x.first, x.stride) for at, x in zip(places, one.sources.values(), strict=False)]
            pieces.append(np.array(rows, np.int64).reshape(-1, 3))
        whole = {
            "steps": [one.steps for one in operations], "nodes": [one.nodes for one in operations], "alike": self.alike,
        }  # fmt: skip
        integers: dict[str, Any] = {
            name: series([x[:, None] for x in each], np.int64) for name, each in whole.items()
        }
        return Run(
            coefficients=series([one.coefficients() if len(one) else none for one in operations]),
            unknowns=np.array([len(tables.by_state) for tables in own], np.int64),
            weights=series(weights), product_weights=series(product), split_weights=series(split),
            scales=series([one.scales if len(one) else none for one in operations]),
            times=series([one.times for one in operations]),
            sources=tuple(arrays.values()) + (none,) * (-len(arrays) % SOURCES), pieces=ragged(pieces),
            bounds=np.zeros((0, 2), np.int64), memory=self.state_variables, places=steps.places.copy(),
            left_out=steps.left_out.astype(float) if steps.left_out.any() else none, **integers,
        )  # fmt: skip

    @property
    def state_variables(self) -> Array:
        """What elements remember during each step (steps, k)."""
        return self.steps.memory

    @cached_property
    def alike(self) -> list[Array]:
        """For each operation a number that is the same where elements remembered and left out the same."""
        found = []
        for one in self.operations:
            if not len(self.steps.left_out) and not len(self.steps.places):
                found.append(np.zeros(len(one), np.int64))
                continue
            memory, left_out = self.state_variables[one.steps], self.left_out(one)
            differ = np.any(memory[1:] != memory[:-1], axis=1) | np.any(left_out[1:] != left_out[:-1], axis=1)
            found.append(np.cumsum(np.append(False, differ))[: len(one)])
        return found

    def left_out(self, of: Occurrences) -> Array:
        """Redundant equations at all occurrences of an operation (count, m), or (count, 0) where there are none."""
        known = self.steps.left_out
        return known[of.nodes].astype(float) if len(known) else np.zeros((len(of), 0))

    def memory(self, of: Occurrences) -> dict[int, Array]:
        """State variables of elements at all occurrences, by index in b."""
        return dict(zip(self.steps.places.tolist(), self.state_variables[of.steps].T, strict=True))

    def numbers(self, n: int) -> Array:
        """The elements' numbers, with what they remember during step n."""
        b = self.steps.b.copy()
        b[self.steps.places] = self.state_variables[n]
        return b


def error_of_adjoints(steps: int) -> float:
    """Relative error of an adjoint that may be left in each of some steps if it only weighs their defects.

    In a direction without restoring forces, as the angle of a flywheel, errors of the adjoint by the position add up
    over n steps, and backwards in time the adjoint by the velocity is the integral of these. In time scales of the
    motion, an error ε in each step becomes ε n² h / 2.
    """
    return max(LEFT, min(WEIGHING, 2 * ALLOWED / (STEP_LENGTH * max(steps, 1) ** 2)))


class Record(Operations):
    """A run as sweeps take it.

    Parameters
    ----------
    system : System
    steps : of the run
    nodes : at which accelerations and multipliers of the equations of motion are needed, as far as they are not those
        of the steps; by default at all ends of steps
    weighing : number of steps of the whole run if adjoints only weigh their defects, and need no more than some digits:
        stages are split, and solutions not refined, where exact derivatives need more
    """

    def __init__(
        self, system: System, steps: StepsTaken, nodes: Array | None = None, weighing: int = 0
    ) -> None:
        super().__init__(system, steps, [])
        self.steps: StepsTaken = steps
        assert isinstance(steps.scheme, Description)
        self._description = method_for(system, steps.scheme)
        own = self._description
        self.extra, self.plain = own.extra, PLAIN if own.damps else 0.0
        self.operations = [self._projections(), self._steps(), self._accelerations(nodes)]
        tables = self.operations[STEP].tables
        least = SPLIT_TO_WEIGH_FROM if weighing else SPLIT_FROM
        self.split = split_of(own) if tables.n >= least * len(tables.structure.stages) else None
        if weighing:
            self.left = self.plain = error_of_adjoints(weighing)

    @cached_property
    def state_variables(self) -> Array:
        """What elements remember during each step (steps, k), see `references`."""
        steps, of = writable(self.steps), self.operations[STEP]
        stages = [(of.times[:, s], x.all(len(of))) for (s, name), x in of.sources.items() if name == "q"]
        every = [(steps.t[:-1], steps.q[:-1]), *stages, (steps.t[1:], steps.q[1:])]
        times, positions = zip(*every, strict=True)
        return shared_references(
            self.system, steps.b, np.stack(times, axis=1), np.stack(positions, axis=1), steps.memory
        )

    def _steps(self) -> Occurrences:
        steps, h = self.steps, self.steps.h
        ratio = np.append(1.0, h[1:] / h[:-1])
        operation = self._description.operation(h, ratio)
        ends = {0.0: steps.t[:-1], 1.0: steps.t[1:]}
        times = [ends.get(one.time, steps.t[:-1] + one.time * h) for one in operation.step.stages]
        every = np.arange(len(steps))
        tables = tables_of(self.system, structure_of(operation))
        found = _stages_of(writable(steps), tables)
        sources = {key: found[key] for key in tables.recorded}
        return Occurrences(operation, tables, every, every + 1, np.stack(times, axis=1), sources)

    def typical(self) -> list[tuple[Occurrences, int]]:
        """The last of each operation, and a very short step."""
        found = super().typical()
        found[STEP] = self._very_short(), 0
        return found

    def _very_short(self) -> Occurrences:
        """The last step, if it were very short."""
        last, own = self.operations[STEP], self.operations[STEP].steps[-1:]
        operation = self._description.operation(VERY_SHORT * self.steps.h[-1:], np.ones(1))
        sources = {key: Source(x.all(len(last))[-1:]) for key, x in last.sources.items()}
        return Occurrences(operation, last.tables, own, own + 1, last.times[-1:], sources)

    def _projections(self) -> Occurrences:
        steps = self.steps
        if self._description.projects:
            at = np.flatnonzero(steps.removed)
            s, sigma, removed = steps.correction[at], steps.impulse[at], steps.removed[at]
        else:
            at, s, sigma, removed = np.zeros(0, np.int64), steps.q[:0], steps.lam[:0], np.zeros(0)
        operation = projection(self._description.state, removed)
        values = {"q": steps.q[at], "v": steps.v[at] - s, "a": s, "lam": sigma}
        of_stage = {(0, name): x for name, x in values.items()}
        return self.at_states(operation, at, at + 1, steps.t[at], of_stage)

    def _accelerations(self, nodes: Array | None) -> Occurrences:
        steps, operation = self.steps, accelerations(self._description.state)
        given = "a" in self._description.step(1.0, 1.0).update
        at = np.zeros(0, np.int64) if given else np.arange(1, len(steps) + 1) if nodes is None else nodes
        values = {(0, name): getattr(steps, name)[at] for name in ("q", "v", "a", "lam")}
        return self.at_states(operation, at - 1, at, steps.t[at], values)
