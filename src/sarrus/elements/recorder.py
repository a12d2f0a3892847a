"""Recording an element's kernels: which blocks an operator has, and what is compiled for a group of operators."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from .._jit.emit import Output, Recording
from .._jit.expression import Expression, Graph
from ..algebra import Block
from .element import Element
from .evaluation import BODY_OPERANDS, element_from, grid
from .operators import OPERATORS, Operator

SCALARS = ("t",)


def operands_of(names: tuple[str, ...]) -> tuple[str, ...]:
    """All operands of a group of operators, q first, in a fixed order."""
    wanted = {operand for name in names for operand in OPERATORS[name].operands}
    return ("q", *(operand for operand in ("xi", "eta", "v", "a", "lam", "t") if operand in wanted))


def record(kind: type[Element], names: tuple[str, ...]) -> Recording:
    """Record the operators `names` of an element type in one graph."""
    graph = Graph()
    operands = {name: _symbols(graph, kind, name) for name in operands_of(names)}
    element = element_from(kind, graph.inputs("numbers", kind.size()))
    arrays = tuple(name for name in operands if name not in SCALARS)
    scalars = tuple(name for name in operands if name in SCALARS)
    title = f"{kind.__name__}.{'+'.join(names)}"
    recording = Recording(title, graph, kind.bodies, kind.size(), kind.rows, arrays, scalars)
    for name in names:
        lines = grid(element, OPERATORS[name], operands)
        blocks = [block for line in lines for block in line if not is_zero(block)]
        recording.outputs.append(Output([block for block in blocks if block is not None], OPERATORS[name].sums))
    return recording


def _symbols(graph: Graph, kind: type[Element], name: str) -> Any:
    if name in SCALARS:
        return graph.input(name)
    if name in BODY_OPERANDS:
        return graph.inputs(name, kind.bodies, 7).reshape(-1)
    return graph.inputs(name, kind.rows)


def is_zero(block: Block) -> bool:
    """Whether a recorded block is zero whatever the state."""
    if block is None:
        return True
    return all((e.constant if isinstance(e, Expression) else e) == 0 for e in np.ravel(block))


@cache
def structure(kind: type[Element], operator: Operator) -> tuple[tuple[int, int], ...]:
    """Places (row block, column block) of an operator's blocks that are not always zero, in the recorded order."""
    graph = Graph()
    operands = {name: _symbols(graph, kind, name) for name in operands_of((operator.name,))}
    lines = grid(element_from(kind, graph.inputs("numbers", kind.size())), operator, operands)
    return tuple((m, n) for m, line in enumerate(lines) for n, block in enumerate(line) if not is_zero(block))
