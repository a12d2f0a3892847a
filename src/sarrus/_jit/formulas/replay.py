"""A recorded graph computed again, on numbers of any kind, the inputs of another graph among them."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from .expression import Equation, Expression, Graph
from .functions import NUMERIC, newton
from .surfaces import ORDERS

CURVES: dict[str, Callable[..., Any]] = {
    "curve": lambda stored, x: stored(x),
    "curve_slope": lambda stored, x: stored.slope(x),
    "curve_bend": lambda stored, x: stored.bend(x),
    "curve_twist": lambda stored, x: stored.twist(x),
    "curve_moment": lambda stored, a, b: stored.moment(a, b),
}
SURFACES: dict[str, Callable[..., Any]] = {
    name: lambda stored, x, y, i=i, j=j: stored.derivative(x, y, i, j) for name, (i, j) in ORDERS.items()
}
OPERATIONS: dict[str, Callable[..., Any]] = {
    "constant": lambda value: value,
    "add": operator.add,
    "sub": operator.sub,
    "mul": operator.mul,
    "div": operator.truediv,
    "neg": operator.neg,
    **NUMERIC,
    **CURVES,
    **SURFACES,
}
ARRAYS: dict[str, Callable[..., Any]] = OPERATIONS | {
    "constant": float,  # fractions are recorded, too
    **{name: getattr(np, name) for name in ("sin", "cos", "tan", "exp", "log", "tanh", "sqrt")},
    **{f"a{name}": getattr(np, f"arc{name}") for name in ("sin", "cos", "tan", "tan2")},
}  # of arrays, and of numbers that have NumPy's functions
SIGNS = {"add": "+", "sub": "-", "mul": "*", "div": "/"}


def replay(
    graph: Graph,
    wanted: Sequence[Any],
    inputs: Mapping[tuple[Any, ...], Any],
    operations: Mapping[str, Callable[..., Any]] = OPERATIONS,
    order: Sequence[int] | None = None,
) -> list[Any]:
    """The values of recorded expressions, for given values of the graph's inputs.

    Parameters
    ----------
    graph : where the expressions were recorded
    wanted : the expressions, or plain numbers
    inputs : input name -> value; what a curve is stored at has the stored curve itself as its value
    operations : for a kind of number
    order : the nodes that the expressions need, if they are known
    """
    values, wanted = dict[int, Any](), graph.expressions(wanted)
    for identity in order or needed(graph, wanted):
        op, args, value = graph.nodes[identity]
        if op == "input":
            values[identity] = inputs[value]
        elif op == "root":
            values[identity] = root_again(value, operations, *map(values.__getitem__, args))
        else:
            values[identity] = operations[op](
                *([value] if op == "constant" else map(values.__getitem__, args))
            )
    return [values[expression.id] for expression in wanted]


def root_again(equation: Equation, operations: Mapping[str, Callable[..., Any]], start: Any, *x: Any) -> Any:
    """The root of a recorded equation for numbers of any kind: recorded, or found by Newton's method."""
    recorded = next((one for one in (start, *x) if isinstance(one, Expression)), None)
    if recorded is not None:
        graph = recorded.graph
        return graph.node("root", *graph.expressions([start, *x]), value=equation)
    g = equation.graph.at(equation.results[0])
    return newton(lambda u: replay(g.graph, [g], equation.inputs(u, x), operations)[0], start, equation.scale)


def function_of(
    graph: Graph, wanted: Sequence[Any], known: Mapping[int, str]
) -> Callable[..., tuple[Any, ...]]:
    """Recorded expressions as a Python function, for arrays, of nodes that are known, by the names of its arguments."""
    wanted, lines = graph.expressions(wanted), [f"def function({', '.join(known.values())}):"]
    scope: dict[str, Any] = dict(ARRAYS)
    for identity in needed(graph, wanted):
        op, args, value = graph.nodes[identity]
        terms = [f"n{arg}" for arg in args]
        if identity in known or op == "constant":
            term = known.get(identity) or repr(float(value))
        elif op == "root":
            scope[f"root{identity}"] = partial(root_again, value, ARRAYS)
            term = f"root{identity}({', '.join(terms)})"
        elif op == "neg":
            term = f"-{terms[0]}"
        else:
            term = f" {SIGNS[op]} ".join(terms) if op in SIGNS else f"{op}({', '.join(terms)})"
        lines.append(f"    n{identity} = {term}")
    exec("\n".join([*lines, f"    return ({' '.join(f'n{x.id},' for x in wanted)})"]), scope)
    function: Callable[..., tuple[Any, ...]] = scope["function"]
    return function


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
