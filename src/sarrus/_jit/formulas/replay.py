"""A recorded graph computed again, on numbers of any kind, the inputs of another graph among them."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from .expression import Graph
from .functions import NUMERIC

CURVES: dict[str, Callable[..., Any]] = {
    "curve": lambda stored, x: stored(x),
    "curve_slope": lambda stored, x: stored.slope(x),
    "curve_bend": lambda stored, x: stored.bend(x),
    "curve_twist": lambda stored, x: stored.twist(x),
    "curve_moment": lambda stored, a, b: stored.moment(a, b),
}
OPERATIONS: dict[str, Callable[..., Any]] = {
    "add": operator.add,
    "sub": operator.sub,
    "mul": operator.mul,
    "div": operator.truediv,
    "neg": operator.neg,
    **NUMERIC,
    **CURVES,
}


def replay(graph: Graph, wanted: Sequence[Any], inputs: Mapping[tuple[Any, ...], Any]) -> list[Any]:
    """The values of recorded expressions, for given values of the graph's inputs.

    Parameters
    ----------
    graph : where the expressions were recorded
    wanted : the expressions, or plain numbers
    inputs : input name -> value; what a curve is stored at has the stored curve itself as its value
    """
    values, wanted = dict[int, Any](), graph.expressions(wanted)
    for identity in needed(graph, wanted):
        node = graph.nodes[identity]
        if node.op == "constant":
            values[identity] = node.value
        elif node.op == "input":
            values[identity] = inputs[node.value]
        else:
            values[identity] = OPERATIONS[node.op](*(values[arg] for arg in node.args))
    return [values[expression.id] for expression in wanted]


def needed(graph: Graph, wanted: Sequence[Any]) -> list[int]:
    """The nodes that expressions, or plain numbers, depend on, each after its arguments."""
    found: set[int] = set()
    stack = [expression.id for expression in graph.expressions(wanted)]
    while stack:
        identity = stack.pop()
        if identity not in found:
            found.add(identity)
            stack.extend(graph.nodes[identity].args)
    return sorted(found)
