"""A formula of one variable as numbers: what `curves` evaluates."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from .curves import CODES, OPERATIONS, STEPS
from .expression import Expression, Graph
from .replay import needed


def program(function: Callable[[Any], Any]) -> tuple[float, ...]:
    """The steps of a formula, by calling it once with a recorded variable.

    Parameters
    ----------
    function : of one variable, made of arithmetic and the functions of `sarrus._jit.formulas.functions` (or NumPy's)

    Raises
    ------
    TypeError
        If it branches on its argument or uses what cannot be recorded.
    ValueError
        If it is longer than a stored formula may be.
    """
    graph = Graph()
    result = function(graph.input("x"))
    return program_of(result if isinstance(result, Expression) else graph.constant(float(result)))


def program_of(wanted: Expression) -> tuple[float, ...]:
    """The steps of a recorded formula."""
    graph, order = wanted.graph, needed(wanted.graph, [wanted])
    if len(order) > STEPS:
        raise ValueError(f"the formula has {len(order)} steps, more than {STEPS}. Pass a table instead.")
    place = {identity: n for n, identity in enumerate(order)}
    steps: list[float] = []
    for identity in order:
        node = graph.nodes[identity]
        if node.op not in CODES:
            raise TypeError(
                f"a formula of one variable cannot use {node.op}. Choose from {', '.join(OPERATIONS[2:])}."
            )
        first = (
            float(node.value) if node.op == "constant" else float(place[node.args[0]]) if node.args else 0.0
        )
        second = float(place[node.args[1]]) if len(node.args) > 1 else 0.0
        steps += [float(CODES[node.op]), first, second]
    return (-float(len(order)), *steps)
