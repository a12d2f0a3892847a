"""Arrays of several operations as compiled loops take them: one after another, with the places at which each begins."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate
from typing import Any, NamedTuple

import numpy as np

from ...._jit.linking.link import compiled
from ....algebra import Array


class Ragged(NamedTuple):
    """Arrays one after another, and where each begins, and the end."""

    values: Array
    starts: Array


class Row(NamedTuple):
    """An array that is a part of another one, which compiled functions return to those that count no references."""

    values: Array


class Series(NamedTuple):
    """For each operation rows of one width, one for every occurrence: all entries, where each begins, and widths."""

    values: Array
    starts: Array
    widths: Array


@compiled
def row(ragged: Ragged, n: int) -> Row:
    return Row(ragged.values[ragged.starts[n] : ragged.starts[n + 1]])


@compiled
def at(series: Series, op: int, k: int) -> Row:
    """The row of occurrence k of an operation."""
    first = series.starts[op] + k * series.widths[op]
    return Row(series.values[first : first + series.widths[op]])


def ragged(arrays: Sequence[Array], kind: Any = np.int64) -> Ragged:
    """Stacked along the first axis."""
    starts = np.array([0, *accumulate(map(len, arrays))], np.int64)
    return Ragged(np.ascontiguousarray(np.concatenate(arrays), dtype=kind), starts)


def series(arrays: Sequence[Array], kind: Any = float) -> Series:
    """Of arrays (occurrences, width)."""
    starts = np.array([0, *accumulate(x.size for x in arrays)][:-1], np.int64)
    flat = np.concatenate([x.reshape(-1) for x in arrays])
    widths = np.array([x.shape[1] for x in arrays], np.int64)
    return Series(np.ascontiguousarray(flat, dtype=kind), starts, widths)


def parts_of(stacked: Series, shapes: Sequence[tuple[int, ...]]) -> list[Array]:
    """The arrays of a series, as views."""
    pairs = zip(stacked.starts, shapes, strict=True)
    return [stacked.values[first : first + int(np.prod(shape))].reshape(shape) for first, shape in pairs]
