"""A finished tape of scalars as sparse matrices: derivatives of a model's construction, all operations at once.

With the slopes L of every entry by its arguments, changes satisfy x' = L x' + s', gradients x̄ = Lᵀ x̄ + s̄, and changes
of gradients x̄' = Lᵀ x̄' + L'ᵀ x̄ + s̄'. I - L is triangular. Where an operation has no slope, as a root at zero, nothing
that moves may pass: what does is not a number.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import csc_array, eye_array
from scipy.sparse.linalg import splu

from ....algebra import Array
from ....model.tape import LINEAR, Operation, Tape, operation


class Kind(NamedTuple):
    """The entries of one operation: their places, and those of their arguments (arguments, entries)."""

    op: str | Operation
    places: Array
    args: Array


class TapeDerivatives:
    """Derivatives of some entries of a tape by its variables; columns are handled together.

    Parameters
    ----------
    tape : of scalars
    variables : places on the tape
    outputs : of what each place on the tape is a part, and that place: (place of the result, place on the tape)
    size : number of results
    """

    def __init__(
        self, tape: Tape, variables: Sequence[int], outputs: Sequence[tuple[int, int]], size: int
    ) -> None:
        self._variables = np.array(variables, dtype=np.int64)
        self._count, self._values = len(tape.entries), np.array(tape.values, dtype=float)
        results, places = np.array(outputs, dtype=np.int64).reshape(-1, 2).T
        self._outputs = csc_array((np.ones(len(places)), (results, places)), shape=(size, self._count))
        self._kinds = _kinds(tape, _between(tape, variables, places.tolist()))

    def along(self, changes: Array) -> Array:
        """The changes of the results (size, k) for changes of the variables (p, k)."""
        return np.asarray(self._outputs @ self._changes(changes))

    def gradient(self, bars: Array) -> Array:
        """The gradients by the variables (p, k) of sums of the results with weights (size, k)."""
        return np.asarray(self._bars(self._outputs.T @ bars)[self._variables])

    def gradient_along(self, bars: Array, bar_dots: Array, change: Array) -> Array:
        """The change of a gradient (p,) where the variables and the weights change."""
        found, dots = self._bars(self._outputs.T @ bars), self._changes(change)
        turned = np.zeros(self._count)
        for op, places, args in self._kinds:
            if op not in LINEAR and np.any(dots[args]):
                for arg, bend in zip(args, self._bends(op, places, args, dots), strict=True):
                    np.add.at(turned, arg, _product(bend, found[places]))
        return np.asarray(self._bars(self._outputs.T @ bar_dots + turned)[self._variables])

    def second(self, change: Array, other: Array) -> Array:
        """The second derivatives of the results (size,) along two changes of the variables (p,)."""
        dots, others = self._changes(change), self._changes(other)
        seeds = np.zeros(self._count)
        for op, places, args in self._kinds:
            if op not in LINEAR and np.any(dots[args]):
                bends = self._bends(op, places, args, dots)
                seeds[places] = sum(_product(x, others[arg]) for x, arg in zip(bends, args, strict=True))
        triangle, _, into = self._triangle
        return np.asarray(self._outputs @ _stopped(triangle.solve(seeds), into))

    def _changes(self, changes: Array) -> Array:
        seeds = np.zeros((self._count, *changes.shape[1:]))
        seeds[self._variables] = changes
        triangle, _, into = self._triangle
        return _stopped(triangle.solve(seeds), into)

    def _bars(self, weights: Array) -> Array:
        triangle, out_of, _ = self._triangle
        return _stopped(triangle.solve(np.ascontiguousarray(weights), "T"), out_of)

    @cached_property
    def _triangle(self) -> tuple[Any, Array, Array]:
        """I - L, factored (nothing fills in); places without a slope, and those of the arguments concerned."""
        slopes = [self._slopes(kind) for kind in self._kinds]
        rows = np.concatenate([np.arange(0), *(np.tile(kind.places, len(kind.args)) for kind in self._kinds)])
        columns = np.concatenate([np.arange(0), *(kind.args.ravel() for kind in self._kinds)])
        data = np.concatenate([np.zeros(0), *(one.ravel() for one in slopes)])
        known = np.isfinite(data)
        entries = (-np.where(known, data, 0.0), (rows, columns))
        matrix = eye_array(self._count, format="csc") + csc_array(entries, shape=(self._count, self._count))
        found = splu(csc_array(matrix), permc_spec="NATURAL", diag_pivot_thresh=0.0)
        return found, rows[~known], columns[~known]

    def _slopes(self, kind: Kind) -> Array:
        """Return the derivatives by each argument (arguments, entries)."""
        with np.errstate(divide="ignore", invalid="ignore"):
            found = operation(kind.op).slopes(self._values[kind.places], *self._values[kind.args])
        return np.array([np.broadcast_to(np.asarray(one), kind.places.shape) for one in found], dtype=float)

    def _bends(self, op: str | Operation, places: Array, args: Array, dots: Array) -> list[Array]:
        """The changes of the slopes by each argument."""
        with np.errstate(divide="ignore", invalid="ignore"):
            bends = operation(op).bends(self._values[places], *self._values[args])
        moved = [[_product(bend, dots[arg]) for bend, arg in zip(row, args, strict=True)] for row in bends]
        return [np.sum(row, axis=0) for row in moved]


def _product(slope: Any, moved: Array) -> Array:
    """Their product; zero where nothing moves, also without a slope."""
    with np.errstate(invalid="ignore"):
        return np.where(moved == 0.0, 0.0, slope * moved)


def _stopped(found: Array, places: Array) -> Array:
    """Not a number in columns in which something moves at places without a slope."""
    if len(places):
        found[..., np.any(found[places] != 0.0, axis=0)] = np.nan
    return np.asarray(found)


def _between(tape: Tape, variables: Sequence[int], ends: Sequence[int]) -> list[bool]:
    """Return the entries that depend on variables and influence the results."""
    moving, wanted = [False] * len(tape.entries), [False] * len(tape.entries)
    for n in variables:
        moving[n] = True
    for n, (_, args) in enumerate(tape.entries):
        for arg in args:
            if moving[arg]:
                moving[n] = True
    for n in ends:
        wanted[n] = True
    for n in range(len(tape.entries) - 1, -1, -1):
        if wanted[n]:
            for arg in tape.entries[n].args:
                wanted[arg] = True
    return [a and b for a, b in zip(moving, wanted, strict=True)]


def _kinds(tape: Tape, chosen: Sequence[bool]) -> list[Kind]:
    """The chosen operations, those of one kind together; a user's own function forms a group of its own."""
    found: dict[Any, list[int]] = {}
    for n, (op, args) in enumerate(tape.entries):
        if chosen[n] and args:
            found.setdefault(op if isinstance(op, str) else (op, n), []).append(n)
    return [
        Kind(
            key if isinstance(key, str) else key[0],
            np.array(places),
            np.array([tape.entries[n].args for n in places], dtype=np.int64).T,
        )
        for key, places in found.items()
    ]
