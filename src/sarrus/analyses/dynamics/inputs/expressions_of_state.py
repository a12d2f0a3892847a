"""Expressions of one quantity of the state in formulas of forces, such as a field over a place: laws over the state.

A node of a formula depends on outputs through a single quantity u if all its arguments do, or are numbers.
exp(-(x - 5)²/w²) depends on them through x, and exp(-(x² + y²)/w²) through the exponent.
"""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

from ...._jit.formulas.expression import Expression, Graph
from ...._jit.formulas.replay import needed, replay
from ....elements.operators import OPERATORS
from ....elements.recorder import Variant, record_scalars
from ....system.curves.curve_derivatives import entries_of
from .features import Law, numbers_of

NUMBER = -1  # in place of a quantity
NUMBERS = "number", "numbers"  # inputs of formulas and of elements
POLYNOMIAL = {"add", "sub", "mul", "neg"}  # operations that make no feature of their own


class StateExpression(NamedTuple):
    """An expression over a quantity, a node of a formula; the expression on a graph where the quantity is an input."""

    quantity: int
    graph: Graph
    value: Expression

    @property
    def variable(self) -> str:
        """The name of that input."""
        return _variable(self.quantity)


@cache
def expressions_of_state(variant: Variant) -> tuple[StateExpression, ...]:
    """The largest expressions of one quantity of the state in the formulas of a load, without polynomials.

    Also those in the recorded force of a user's own element.
    """
    kind = variant.kind
    own = _has_formulas(variant) or not kind.__module__.startswith("sarrus.")
    if not own or OPERATORS["Q"] not in kind.family:
        return ()
    graph, results = _formulas(variant)
    order = needed(graph, results)
    over = _quantities(graph, order)
    largest = {one.id for one in results}
    largest |= {arg for n in order for arg in graph.nodes[n].args if over[arg] != over[n]}
    moved, made = Graph(), dict[int, Expression]()
    return tuple(
        StateExpression(over[n], moved, _copied(graph, over, n, moved, made))
        for n in sorted(largest)
        if over[n] not in (NUMBER, n) and _is_of_state(graph, over[n]) and _has_features(graph, over, n)
    )


def law_of(variant: Variant, one: StateExpression, values: tuple[Any, ...]) -> Law:
    """Such an expression in an element with these values of its fields."""
    inputs = (one.graph.nodes[n] for n in needed(one.graph, [one.value]))
    names = [node.value for node in inputs if node.op == "input" and node.value[0] in NUMBERS]
    numbers = _formula_numbers(variant, values) if _has_formulas(variant) else numbers_of(values)
    used = {name: float(numbers[name[1]]) for name in names}
    key = variant, one.variable, one.value.id, *used.items()
    return Law(key, one.graph, one.value, one.variable, used)


def _formula_numbers(variant: Variant, values: tuple[Any, ...]) -> list[Any]:
    """The numbers of formulas among the values of the fields of an element."""
    names, fields = variant.kind.structure.numbers, list(variant.kind.fields)  # type: ignore[attr-defined]
    return [values[fields.index(name)] for name in names]


def _has_formulas(variant: Variant) -> bool:
    return hasattr(variant.kind, "structure")


def quantities(variant: Variant, graph: Graph) -> list[Expression]:
    """The quantities of these expressions, on the graph of the recorded force."""
    found = expressions_of_state(variant)
    if not found or not _has_formulas(variant):
        return [Expression(graph, one.quantity) for one in found]
    recording = record_scalars(variant, "signals", 3)
    outputs = [Expression(recording.graph, x.id) for block in recording.outputs[0].blocks for x in block]
    inputs = {n.value: graph.input(*n.value) for n in recording.graph.nodes if n.op == "input"}
    at = dict(zip(variant.kind.fields, _starts(variant), strict=True))
    names = variant.kind.structure.numbers  # type: ignore[attr-defined]
    given: dict[tuple[Any, ...], Any] = {("t",): graph.input("t")}
    given |= {("number", n): graph.input("numbers", at[name]) for n, name in enumerate(names)}
    given |= {("signal", n): x for n, x in enumerate(replay(recording.graph, outputs, inputs))}
    formulas, _ = _formulas(variant)
    return replay(formulas, [Expression(formulas, one.quantity) for one in found], given)


def _formulas(variant: Variant) -> tuple[Graph, list[Expression]]:
    """The formulas of a load as they are recorded, over signals, numbers and the time; or the force of an element."""
    if not _has_formulas(variant):
        recorded, _, entries = entries_of(variant, "Q")
        return recorded, entries
    graph, own = Graph(), variant.kind.structure.operations  # type: ignore[attr-defined]
    graph.nodes.extend(own.nodes)
    return graph, [Expression(graph, n) for n in own.results]


def _starts(variant: Variant) -> list[int]:
    """The place of the first number of each field."""
    widths = variant.kind.widths()
    return [sum(widths[:n]) for n in range(len(widths))]


def _quantities(graph: Graph, order: list[int]) -> dict[int, int]:
    """For each node the one through which it depends on the outputs and the time: itself if there are several."""
    over = dict[int, int]()
    for n in order:
        node = graph.nodes[n]
        if node.op == "input":
            over[n] = NUMBER if node.value[0] in (*NUMBERS, "curve") else n
        else:
            own = {over[arg] for arg in node.args} - {NUMBER}
            alone = len(own) == 1 and not node.op.startswith("curve")  # tables are laws of their own
            over[n] = own.pop() if alone else n if own else NUMBER
    return over


def _is_of_state(graph: Graph, quantity: int) -> bool:
    """Whether a quantity is not the time, and no function of tables."""
    nodes = [graph.nodes[n] for n in needed(graph, [Expression(graph, quantity)])]
    return graph.nodes[quantity].value != ("t",) and not any(node.op.startswith("curve") for node in nodes)


def _has_features(graph: Graph, over: dict[int, int], n: int) -> bool:
    """Whether an expression is no polynomial of its quantity."""
    stack = [n]
    while stack:
        node = graph.nodes[m := stack.pop()]
        if m != over[n] and over[m] == over[n]:
            if node.op not in POLYNOMIAL and not (node.op == "div" and over[node.args[1]] == NUMBER):
                return True
            stack += node.args
    return False


def _copied(
    graph: Graph, over: dict[int, int], n: int, moved: Graph, made: dict[int, Expression]
) -> Expression:
    """An expression on another graph, with its quantity as an input."""
    for m in needed(graph, [Expression(graph, n)]):
        if m not in made and over[m] in (NUMBER, over[n]):
            node = graph.nodes[m]
            made[m] = (
                moved.input(_variable(m))
                if m == over[n]
                else moved.node(node.op, *(made[arg] for arg in node.args), value=node.value)
            )
    return made[n]


def _variable(quantity: int) -> str:
    return f"x{quantity}"
