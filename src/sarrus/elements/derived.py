"""Kernels that nobody writes: the exact derivative of another kernel, by differentiating what that one records.

Called with numbers of any kind, or with recorded ones, such a kernel computes the differentiated graph again on them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from .._jit.formulas.differentiate import directional, jacobian
from .._jit.formulas.expression import Expression, Graph
from .._jit.formulas.replay import replay
from .._jit.formulas.reverse import gradient
from ..algebra import Array, Block
from .operators import DERIVATIVES, OPERATORS, Axis, Derivative

HELD = (
    "Curve",
    "Surface",
    "Memory",
)  # kinds of fields that are no parameters: nothing is differentiated with respect to them


@dataclass(frozen=True)
class Recipe:
    """A differentiated graph: what it takes and the grid of blocks that it gives (None for zeros)."""

    graph: Graph
    grid: tuple[tuple[Block, ...], ...]


def derived(name: str) -> Callable[..., Any]:
    """The kernel `name`, made for each element type from the operator that it is the derivative of."""
    operator = OPERATORS[name]

    def kernel(self: Any, x: Any, *arguments: Any) -> Any:
        owner: Any = type(self)
        recipe = recipe_of(owner, name)
        given = dict(
            zip([o for o in operator.operands if o != "t" or _passes_t(operator)], arguments, strict=True)
        )
        grid = _replayed(recipe, _inputs(self, {"q": x, **given}))
        if operator.is_vector:
            return grid[0][0] if operator.axes[0] is Axis.ROWS else tuple(line[0] for line in grid)
        return grid[0] if operator.axes[0] is Axis.ROWS else grid

    kernel.__name__ = name
    kernel.__doc__ = f"{operator.formula}, by differentiating {DERIVATIVES[name].of}."
    return kernel


def potential(element: Any, x: Any) -> Any:
    """U, which an element's `potential` returns as one or several terms."""
    return sum(np.ravel(np.array(element.potential(x), dtype=object)))


def conservative_force(element: Any, x: Any, v: Any, t: Any) -> tuple[Block, ...]:
    """Q = -U_q of an element with a potential."""
    kind: Any = type(element)
    grid = _replayed(_conservative_force_of(kind), _inputs(element, {"q": x}))
    return tuple(block for (block,) in grid)


@cache
def _conservative_force_of(kind: Any) -> Recipe:
    from .evaluation import partition, symbols

    graph = Graph()
    element, operands = symbols(graph, kind)
    slopes = gradient(graph, potential(element, partition(kind, operands["q"])), operands["q"])
    blocks = np.split(-np.array(slopes, dtype=object), np.cumsum(kind.coordinates())[:-1])
    return Recipe(graph, tuple((None if _vanishes(block) else block,) for block in blocks))


def potential_rate(element: Any, x: Any, v: Any) -> Any:
    """The change with time of an element's potential, U_q v."""
    blocks = zip(conservative_force(element, x, v, 0), v, strict=True)
    return -sum(block @ rate for block, rate in blocks if block is not None)


def strain_rate(element: Any, x: Any, v: Any) -> Array:
    """ε_q v of an element with a vector `strains`."""
    kind: Any = type(element)
    (line,) = _replayed(_strain_slopes(kind), _inputs(element, {"q": x}))
    terms = [block @ rate for block, rate in zip(line, v, strict=True) if block is not None]
    return sum(terms[1:], terms[0])


def strain_force(element: Any, x: Any, load: Array) -> tuple[Block, ...]:
    """-ε_qᵀ load."""
    kind: Any = type(element)
    (line,) = _replayed(_strain_slopes(kind), _inputs(element, {"q": x}))
    return tuple(None if block is None else -(load @ block) for block in line)


@cache
def _strain_slopes(kind: Any) -> Recipe:
    from .evaluation import partition, symbols

    graph = Graph()
    element: Any
    element, operands = symbols(graph, kind)
    strains = element.strains(partition(kind, operands["q"]))
    return Recipe(graph, _differentiated(graph, [strains], [len(strains)], operands["q"], kind.coordinates()))


def _passes_t(operator: Any) -> bool:
    """Forces take the time as an argument; constraints hold it in a field."""
    return bool(operator.family == "force")


@cache
def recipe_of(kind: Any, name: str) -> Recipe:
    """Record the operator that `name` is the derivative of, and differentiate: along a direction, in one sweep.

    Derivatives commute: (f_q ξ)_w, w being q, v, b or t, is the derivative of f_w along ξ. What is no derivative, as
    M, is contracted with the direction and differentiated by each variable.
    """
    from .evaluation import grid, partition, symbols, widths

    rule = kind.rules[name]
    graph = Graph()
    element, operands = symbols(graph, kind)
    inner = kind.rules.get(rule.of)
    if rule.along is not None and inner is not None:
        twin = Derivative(inner.of, inner.along, rule.by)
        of = next(other for other, known in kind.rules.items() if known == twin)
        pairs = list(zip(operands[inner.by], operands[rule.along], strict=True))
        lines = grid(element, OPERATORS[of], operands)
        return Recipe(graph, tuple(tuple(_along(graph, block, pairs) for block in line) for line in lines))
    lines = grid(element, OPERATORS[rule.of], operands)
    if rule.along is not None:
        along = partition(kind, operands[rule.along])
        lines = tuple((_contracted(line, along),) for line in lines)
    by = _variables(kind, operands, rule.by)
    columns = {"b": kind.widths(), "t": (1,)}.get(rule.by, kind.coordinates())
    heights = widths(kind, OPERATORS[name].axes[0])
    return Recipe(graph, _differentiated(graph, [line[0] for line in lines], heights, by, columns))


def _along(graph: Graph, block: Block, pairs: Sequence[tuple[Expression, Expression]]) -> Block:
    """The derivative of a block along a direction."""
    if block is None:
        return None
    rates = np.array(directional(graph, np.ravel(block).tolist(), pairs), dtype=object).reshape(block.shape)
    return None if _vanishes(rates) else rates


def _contracted(line: tuple[Block, ...], along: Any) -> Block:
    terms = [block @ part for block, part in zip(line, along, strict=True) if block is not None]
    return sum(terms[1:], terms[0]) if terms else None


def _variables(kind: Any, operands: Mapping[str, Any], by: str) -> list[Expression | None]:
    """The variables of the differentiation; None for a number that is held constant."""
    if by == "b":
        fields = zip(kind.fields.values(), kind.widths(), strict=True)
        held = [field in HELD for field, width in fields for _ in range(width)]
        return [None if hold else number for hold, number in zip(held, operands["numbers"], strict=True)]
    return [operands["t"]] if by == "t" else list(operands[by])


def _differentiated(
    graph: Graph,
    vectors: Sequence[Block],
    heights: Sequence[int],
    by: Sequence[Expression | None],
    columns: tuple[int, ...],
) -> tuple[tuple[Block, ...], ...]:
    """The block rows: derivatives of vectors, cut into columns; all from the same sweeps, one for each variable."""
    given = [vector for vector in vectors if vector is not None]
    flat = [entry for vector in given for entry in np.ravel(vector)]
    entries = graph.expressions(flat)
    ends = np.cumsum([height for vector, height in zip(vectors, heights, strict=True) if vector is not None])
    parts = iter(np.split(jacobian(graph, entries, by), ends[:-1]))
    return tuple(
        (None,) * len(columns) if vector is None else _cut(next(parts), columns) for vector in vectors
    )


def _cut(matrix: Array, columns: tuple[int, ...]) -> tuple[Block, ...]:
    """The blocks of one block row; one column alone is a vector."""
    cuts = np.split(matrix, np.cumsum(columns), axis=1)[: len(columns)]
    blocks = [None if _vanishes(cut) else cut for cut in cuts]
    return tuple(cut[:, 0] if cut is not None and columns == (1,) else cut for cut in blocks)


def _vanishes(block: Array) -> bool:
    return (
        all((e.constant if isinstance(e, Expression) else e) == 0 for e in block.flat) if block.size else True
    )


def _inputs(element: Any, operands: Mapping[str, Any]) -> dict[tuple[Any, ...], Any]:
    """Values of a recipe's inputs, by name."""
    values: dict[tuple[Any, ...], Any] = {("t",): operands.get("t", 0)}
    for key, operand in operands.items():
        if key != "t":
            flat = (
                operand
                if isinstance(operand, np.ndarray)
                else np.concatenate([np.asarray(part) for part in operand])
            )
            values.update({(key, n): value for n, value in enumerate(flat)})
    at = 0
    for (field, kind), width in zip(element.fields.items(), element.widths(), strict=True):
        value = getattr(element, field)
        if kind == "Time":
            values[("t",)] = value
            continue
        parts = np.ravel(value) if width > 1 else [value]
        for part in parts:
            values[("numbers", at)] = part
            at += 1
    return values


def _replayed(recipe: Recipe, inputs: dict[tuple[Any, ...], Any]) -> tuple[tuple[Block, ...], ...]:
    flat = [e for line in recipe.grid for block in line if block is not None for e in block.flat]
    wanted = [e for e in flat if isinstance(e, Expression)]
    found = iter(replay(recipe.graph, wanted, inputs))

    def filled(block: Block) -> Block:
        if block is None:
            return None
        values = np.empty(block.shape, dtype=object)
        for place in np.ndindex(*block.shape):
            values[place] = next(found) if isinstance(block[place], Expression) else block[place]
        return _plain(values)

    return tuple(tuple(filled(block) for block in line) for line in recipe.grid)


def _plain(values: Array) -> Array:
    """Floats and complex numbers as NumPy holds them; other kinds stay objects."""
    if all(isinstance(value, int | float | complex) for value in values.flat):
        return np.array(values.tolist())
    return values
