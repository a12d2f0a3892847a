"""Recording an element's kernels: which blocks an operator has, and what is compiled for a group of operators."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from .._jit.emit import Output, Recording
from .._jit.expression import Expression, Graph
from ..algebra import Array
from .element import Element
from .evaluation import BODY_OPERANDS, element_from, grid
from .operators import OPERATORS, Axis, Operator

SCALARS = ("t",)
GROUND = (0, 0, 0, 1, 0, 0, 0)


def operands_of(names: tuple[str, ...]) -> tuple[str, ...]:
    """All operands of a group of operators, q first, in a fixed order."""
    wanted = {operand for name in names for operand in OPERATORS[name].operands}
    return ("q", *(operand for operand in ("xi", "eta", "v", "a", "lam", "t") if operand in wanted))


@dataclass(frozen=True)
class Variant:
    """An element type, and which of its bodies is the ground (None: none is). Ground is known when recording, so
    that all that it makes constant is folded away, and its blocks are not computed."""

    kind: type[Element]
    ground: int | None = None

    @property
    def name(self) -> str:
        return self.kind.__name__ + ("" if self.ground is None else f"_ground_{'ij'[self.ground]}")


def variants(kind: type[Element]) -> tuple[Variant, ...]:
    """All variants of an element type, in a fixed order."""
    grounds = (None, 0, 1) if kind.bodies == 2 else (None,)
    return tuple(Variant(kind, ground) for ground in grounds)


def record(variant: Variant, names: tuple[str, ...]) -> Recording:
    """Record the operators `names` of an element type in one graph."""
    graph, kind = Graph(), variant.kind
    operands = {name: _symbols(graph, variant, name) for name in operands_of(names)}
    element = element_from(kind, graph.inputs("numbers", kind.size()))
    arrays = tuple(name for name in operands if name not in SCALARS)
    scalars = tuple(name for name in operands if name in SCALARS)
    title = f"{variant.name}.{'+'.join(names)}"
    recording = Recording(title, graph, kind.bodies, kind.size(), arrays, scalars)
    for name in names:
        blocks = _blocks(variant, element, OPERATORS[name], operands)
        recording.outputs.append(Output(list(blocks.values()), OPERATORS[name].sums))
    return recording


@cache
def structure(variant: Variant, operator: Operator) -> tuple[tuple[int, int], ...]:
    """Places (row block, column block) of an operator's blocks that are not always zero, in the recorded order."""
    graph = Graph()
    operands = {name: _symbols(graph, variant, name) for name in operands_of((operator.name,))}
    element = element_from(variant.kind, graph.inputs("numbers", variant.kind.size()))
    return tuple(_blocks(variant, element, operator, operands))


def _symbols(graph: Graph, variant: Variant, name: str) -> Any:
    if name in SCALARS:
        return graph.input(name)
    if name not in BODY_OPERANDS:
        return graph.inputs(name, variant.kind.rows)
    symbols = graph.inputs(name, variant.kind.bodies, 7)
    if variant.ground is not None:
        symbols[variant.ground] = GROUND if name == "q" else 0
    return symbols.reshape(-1)


def _blocks(
    variant: Variant, element: Element, operator: Operator, operands: dict[str, Any]
) -> dict[tuple[int, int], Array]:
    """The blocks that are neither always zero nor ground's, by place."""

    def is_ground(axis: Axis, piece: int) -> bool:
        return axis is Axis.COORDINATES and piece // 2 == variant.ground

    columns = operator.axes[1] if len(operator.axes) == 2 else Axis.ROWS
    return {
        (m, n): block
        for m, line in enumerate(grid(element, operator, operands))
        for n, block in enumerate(line)
        if block is not None
        and not is_zero(block)
        and not is_ground(operator.axes[0], m)
        and not is_ground(columns, n)
    }


def is_zero(block: Array) -> bool:
    """Whether a recorded block is zero whatever the state."""
    return all((e.constant if isinstance(e, Expression) else e) == 0 for e in np.ravel(block))
