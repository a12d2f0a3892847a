"""Kernels called on flat vectors: an element's numbers, its bodies' coordinates and the operands of an operator."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from .._jit.formulas.expression import Graph
from ..algebra import Array, Block
from .curve import StoredCurve
from .element import RIGID, Element, ElementError, Pair, Single
from .operators import Axis, Operator
from .surface import StoredSurface

STORED = {"Curve": StoredCurve, "Surface": StoredSurface}
NAMED: dict[Any, Any] = {(RIGID,): Single, (RIGID, RIGID): Pair}
BODY_OPERANDS = ("q", "xi", "eta", "v", "a")


def element_from(kind: type[Element], numbers: Array, store: Any = None, t: Any = 0) -> Element:
    """The element of the flat vector of its numbers; `store` is the array of its curves and surfaces, t the time."""
    values: list[Any] = []
    at = 0
    for field, width in zip(kind.fields.values(), kind.widths(), strict=True):
        if field == "Time":
            values.append(t)
            continue
        value = numbers[at : at + width] if width > 1 else numbers[at]
        values.append(STORED[field](store, value) if field in STORED else value)
        at += width
    return kind(*values)


def partition(kind: type[Element], vector: Array) -> Any:
    """Flat coordinates (or a direction in them) by blocks: `Single`, `Pair`, or for others a plain tuple."""
    parts = np.split(vector, np.cumsum(kind.coordinates())[:-1])
    return NAMED[kind.owners()](*parts) if kind.owners() in NAMED else tuple(parts)


def symbols(graph: Graph, kind: type[Element]) -> tuple[Element, dict[str, Any]]:
    """An element of recorded numbers, and recorded operands: vectors by their places, ``("q", 3)``."""
    operands: dict[str, Any] = {name: graph.inputs(name, sum(kind.coordinates())) for name in BODY_OPERANDS}
    operands |= {"lam": graph.inputs("lam", kind.rows), "t": graph.input("t")}
    operands["numbers"] = graph.inputs("numbers", kind.size())
    return element_from(kind, operands["numbers"], t=operands["t"]), operands


def arguments(kind: type[Element], operator: Operator, operands: Mapping[str, Any]) -> list[Any]:
    """The kernel's arguments after x, from flat operands. Constraints hold the time in a field, not in an argument."""
    names = [n for n in operator.operands if n != "t" or operator.family == "force"]
    return [partition(kind, operands[n]) if n in BODY_OPERANDS else operands[n] for n in names]


def grid(element: Element, operator: Operator, operands: Mapping[str, Any]) -> tuple[tuple[Block, ...], ...]:
    """The kernel's result as rows of blocks; vectors have one column."""
    kind = type(element)
    call = arguments(kind, operator, operands)
    result = getattr(element, operator.name)(partition(kind, operands["q"]), *call)
    rows = widths(kind, operator.axes[0])
    columns = (1,) if operator.is_vector else widths(kind, operator.axes[1])
    lines = [result] if operator.axes[0] is Axis.ROWS else result
    if operator.is_vector and _is_row(lines, len(rows)):
        lines = [[block] for block in lines]
    if not _is_row(lines, len(rows)) or not all(_is_row(line, len(columns)) for line in lines):
        raise _misshapen(kind, operator, rows, columns)
    for height, line in zip(rows, lines, strict=True):
        for width, block in zip(columns, line, strict=True):
            if block is not None and not (isinstance(block, np.ndarray) and block.size == height * width):
                raise _misshapen(kind, operator, rows, columns)
    return tuple(tuple(line) for line in lines)


def _is_row(given: Any, count: int) -> bool:
    """Whether these are so many blocks."""
    return isinstance(given, tuple | list) and len(given) == count


def _misshapen(
    kind: type[Element], operator: Operator, rows: tuple[int, ...], columns: tuple[int, ...]
) -> ElementError:
    if operator.axes[0] is not Axis.ROWS:
        blocks = f"{len(rows)} rows of " if not operator.is_vector else ""
        count = len(rows) if operator.is_vector else len(columns)
        sizes = rows if operator.is_vector else columns
        wanted = f"{blocks}{count} blocks (arrays, or None for zeros) of {', '.join(map(str, sizes))} "
        wanted += "entries" if operator.is_vector else f"columns, and {', '.join(map(str, rows))} rows"
    elif operator.is_vector:
        wanted = f"one array of {rows[0]} entries"
    else:
        wanted = f"{len(columns)} blocks (arrays, or None for zeros) of {rows[0]} rows and "
        wanted += f"{', '.join(map(str, columns))} columns"
    return ElementError(f"element {kind.__name__}: {operator.name} must return {wanted}. Give it this shape.")


def widths(kind: type[Element], axis: Axis) -> tuple[int, ...]:
    """Widths of the blocks along an axis."""
    if axis is Axis.ROWS:
        return (kind.rows,)
    return kind.coordinates() if axis is Axis.COORDINATES else kind.widths()


def dense(element: Element, operator: Operator, operands: Mapping[str, Any]) -> Array:
    """The kernel's result as one dense matrix (or vector)."""
    kind = type(element)
    rows = widths(kind, operator.axes[0])
    columns = (1,) if operator.is_vector else widths(kind, operator.axes[1])
    result = np.zeros((sum(rows), sum(columns)), dtype=object)
    for m, line in enumerate(grid(element, operator, operands)):
        for n, block in enumerate(line):
            if block is not None:
                top, left = sum(rows[:m]), sum(columns[:n])
                shape = (rows[m], columns[n])
                result[top : top + rows[m], left : left + columns[n]] = block.reshape(shape)
    return result[:, 0] if operator.is_vector else result
