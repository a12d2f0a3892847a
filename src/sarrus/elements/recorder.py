"""Recording an element's kernels: which blocks an operator has, and what is compiled for a group of operators."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np

from .._jit.formulas.expression import Expression, Graph
from .._jit.kernels.emit import Output, Recording
from ..algebra import Array
from .element import RIGID, Element, ElementError, Kind
from .evaluation import BODY_OPERANDS, element_from, grid, partition
from .operators import ALIASES, OPERATORS, Axis, Operator

SCALARS = ("t",)
GROUND = tuple(x for kind in RIGID for x in kind.ground)


def operands_of(names: tuple[str, ...]) -> tuple[str, ...]:
    """All operands of a group of operators, q first, in a fixed order."""
    alias = ALIASES.get(names, {})
    wanted = {alias.get(operand, operand) for name in names for operand in OPERATORS[name].operands}
    return ("q", *(operand for operand in ("xi", "eta", "v", "a", "lam", "t") if operand in wanted))


@dataclass(frozen=True)
class Variant:
    """An element type, and for each of its bodies which of its moving bodies that is: 0, 1, ..., or -1 for ground.

    Ground is known when recording, so that all that it makes constant is folded away and its blocks are not computed; a
    body that an element meets twice has its blocks added.
    """

    kind: type[Element]
    slots: tuple[int, ...]

    @classmethod
    def of(cls, kind: type[Element], bodies: Sequence[int]) -> Variant:
        """The variant of an element on bodies given by number, 0 being the ground."""
        moving = distinct(bodies)
        return cls(kind, tuple(moving.index(body) if body else -1 for body in bodies))

    @property
    def moving(self) -> int:
        """How many moving bodies it has."""
        return max(self.slots) + 1

    @cached_property
    def owners(self) -> tuple[tuple[Kind, ...], ...]:
        """The kinds of the blocks of each moving body."""
        blocks = dict(zip(self.slots, self.kind.owners(), strict=True))
        return tuple(blocks[slot] for slot in range(self.moving))

    @cached_property
    def widths(self) -> tuple[int, ...]:
        """How many coordinates each moving body has."""
        return tuple(sum(len(kind.parts) for kind in blocks) for blocks in self.owners)

    @cached_property
    def blocks(self) -> tuple[tuple[int, int], ...]:
        """All blocks of the moving bodies: which body, and where in its coordinates the block begins."""
        return tuple(place for slot, blocks in enumerate(self.owners) for place in _places(slot, blocks))

    @cached_property
    def pieces(self) -> tuple[int, ...]:
        """For each block that the kind touches, its place among those of the moving bodies; negative for ground."""
        touched = zip(self.slots, self.kind.owners(), strict=True)
        places = [place for slot, blocks in touched for place in _places(slot, blocks)]
        return tuple(self.blocks.index(place) if place[0] >= 0 else -1 for place in places)

    def inputs(self, graph: Graph, name: str) -> Array:
        """Inputs for the coordinates of all moving bodies, or for a direction in them."""
        places = [(slot, n) for slot, width in enumerate(self.widths) for n in range(width)]
        return np.array([graph.input(name, *place) for place in places], dtype=object)

    def split(self, flat: Array | list[Any]) -> list[Array]:
        """One vector for each moving body, from one for all of them."""
        return np.split(np.array(flat, dtype=object), np.cumsum(self.widths)[:-1]) if self.widths else []

    def gathered(self, flat: Array, name: str) -> Array:
        """Coordinates of all bodies that the kind has, or a direction in them, from those of the moving ones."""
        parts = self.split(flat)
        ground = [
            [x if name == "q" else 0 for kind in blocks for x in kind.ground] for blocks in self.kind.owners()
        ]
        return np.concatenate(
            [
                parts[slot] if slot >= 0 else np.array(rest, dtype=object)
                for slot, rest in zip(self.slots, ground, strict=True)
            ]
        )

    @property
    def name(self) -> str:
        return "_".join([self.kind.__name__, *("g" if slot < 0 else str(slot) for slot in self.slots)])


def _places(slot: int, blocks: Sequence[Kind]) -> list[tuple[int, int]]:
    """The blocks of a body, and where each begins."""
    return [(slot, sum(len(kind.parts) for kind in blocks[:n])) for n in range(len(blocks))]


def distinct(bodies: Sequence[int]) -> list[int]:
    """The moving bodies among those given, each once."""
    return list(dict.fromkeys(body for body in bodies if body))


def variants(kind: type[Element]) -> tuple[Variant, ...]:
    """The usual variants of an element type, in a fixed order; none for rare types and more than two bodies."""
    if kind.rare:
        return ()
    slots: dict[int, tuple[tuple[int, ...], ...]] = {1: ((0,),), 2: ((0, 1), (-1, 0), (0, -1))}
    return tuple(Variant(kind, chosen) for chosen in slots.get(kind.bodies, ()))


def record(variant: Variant, names: tuple[str, ...]) -> Recording:
    """Record the operators `names` of an element type in one graph.

    Raises
    ------
    ElementError
        For a user's kernel that computes something else when it is called again.
    """
    _refuse_changing(variant)
    return _recorded(variant, names)


@cache
def _refuse_changing(variant: Variant) -> None:
    """Call a user's formula twice: one with random numbers would be compiled as it was the first time."""
    kind = variant.kind
    if kind.__module__.startswith("sarrus.elements"):
        return
    for name in ("Phi", "Q", "M", "S"):
        if OPERATORS[name] in kind.family:
            first, again = (_recorded(variant, (name,)).fingerprint() for _ in range(2))
            if first != again:
                raise ElementError(
                    f"element {kind.__name__}: {name} is another formula each time it is called, as with random "
                    "numbers. Draw them first, and hand them over in fields or as a law over time."
                )


def _recorded(variant: Variant, names: tuple[str, ...]) -> Recording:
    graph, kind = Graph(), variant.kind
    operands = {name: _symbols(graph, variant, name) for name in operands_of(names)}
    operands |= {name: operands[same] for name, same in ALIASES.get(names, {}).items()}
    element = element_from(kind, graph.inputs("numbers", kind.size()), t=operands.get("t", 0))
    taken = operands_of(names)
    arrays = tuple(name for name in taken if name not in SCALARS)
    scalars = tuple(name for name in taken if name in SCALARS)
    title = f"{variant.name}.{'+'.join(names)}"
    recording = Recording(title, graph, variant.moving, kind.size(), arrays, scalars)
    for name in names:
        blocks = _blocks(variant, element, OPERATORS[name], operands)
        recording.outputs.append(Output(list(blocks.values()), OPERATORS[name].sums))
    return recording


@cache
def record_scalars(variant: Variant, method: str, arguments: int = 1) -> Recording:
    """Record a method of the first of (x, v, t) that returns scalars, as `remember` does: a block for each."""
    graph, kind = Graph(), variant.kind
    element = element_from(kind, graph.inputs("numbers", kind.size()), t=graph.input("t"))
    arrays = ("q", "v")[:arguments]
    operands = [partition(kind, _symbols(graph, variant, name)) for name in arrays]
    found = getattr(element, method)(*operands, *[graph.input("t")][: max(arguments - 2, 0)])
    recording = Recording(f"{variant.name}.{method}", graph, variant.moving, kind.size(), arrays, ("t",))
    blocks = [np.array([value], dtype=object) for value in np.ravel(np.array(found, dtype=object))]
    recording.outputs.append(Output(blocks, False))
    return recording


@cache
def structure(variant: Variant, operator: Operator) -> tuple[tuple[int, int], ...]:
    """Places (row block, column block) of an operator's blocks that are not always zero, in the recorded order."""
    graph = Graph()
    operands = {name: _symbols(graph, variant, name) for name in operands_of((operator.name,))}
    element = element_from(variant.kind, graph.inputs("numbers", variant.kind.size()), t=operands.get("t", 0))
    return tuple(_blocks(variant, element, operator, operands))


def _symbols(graph: Graph, variant: Variant, name: str) -> Any:
    if name in SCALARS:
        return graph.input(name)
    if name not in BODY_OPERANDS:
        return graph.inputs(name, variant.kind.rows)
    return variant.gathered(variant.inputs(graph, name), name)


def _blocks(
    variant: Variant, element: Element, operator: Operator, operands: dict[str, Any]
) -> dict[tuple[int, int], Array]:
    """The blocks that are neither always zero nor ground's, by place; places along coordinates count moving bodies."""
    row_axis, column_axis = operator.axes if len(operator.axes) == 2 else (operator.axes[0], Axis.ROWS)
    found: dict[tuple[int, int], Array] = {}
    for m, line in enumerate(grid(element, operator, operands)):
        for n, block in enumerate(line):
            place = (
                variant.pieces[m] if row_axis is Axis.COORDINATES else m,
                variant.pieces[n] if column_axis is Axis.COORDINATES else n,
            )
            if block is not None and min(place) >= 0:
                found[place] = found[place] + block if place in found else block
    return {place: block for place, block in found.items() if not is_zero(block)}


def is_zero(block: Array) -> bool:
    """Whether a recorded block is zero whatever the state."""
    return all((e.constant if isinstance(e, Expression) else e) == 0 for e in np.ravel(block))
