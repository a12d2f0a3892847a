"""Derivatives of recorded graphs, exact: the chain rule over the list of operations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .expression import Expression, Graph
from .replay import needed


def jacobian(graph: Graph, wanted: Sequence[Any], by: Sequence[Expression | None]) -> np.ndarray[Any, Any]:
    """Derivatives of expressions, or plain numbers, to inputs, recorded in the same graph (wanted, by).

    None represents a column of zeros.
    """
    wanted = graph.expressions(wanted)
    order = needed(graph, wanted)
    result = np.zeros((len(wanted), len(by)), dtype=object)
    for column, variable in enumerate(by):
        slopes = _sweep(graph, order, [(variable, graph.constant(1))]) if variable is not None else {}
        for row, expression in enumerate(wanted):
            result[row, column] = slopes.get(expression.id, 0)
    return result


def directional(
    graph: Graph, wanted: Sequence[Any], pairs: Sequence[tuple[Expression, Expression]]
) -> list[Any]:
    """Derivatives of expressions, or plain numbers, along a direction, given as pairs of an input and its rate."""
    wanted = graph.expressions(wanted)
    slopes = _sweep(graph, needed(graph, wanted), pairs)
    return [slopes.get(expression.id, 0) for expression in wanted]


def _sweep(
    graph: Graph, order: Sequence[int], pairs: Sequence[tuple[Expression, Expression]]
) -> dict[int, Expression]:
    """Derivatives of all nodes along a direction; those that vanish are left out."""
    slopes = {variable.id: rate for variable, rate in pairs}
    for identity in order:
        node = graph.nodes[identity]
        terms = [
            _partial(graph, identity, arg) * slopes[arg] for arg in dict.fromkeys(node.args) if arg in slopes
        ]
        if terms:
            total = sum(terms[1:], terms[0])
            if total.constant is None or total.constant != 0:
                slopes[identity] = total
    return slopes


def _partial(graph: Graph, identity: int, by: int) -> Any:
    """Derivative of one operation to an argument, which a square has twice."""
    node = graph.nodes[identity]
    args = [Expression(graph, arg) for arg in node.args]
    partials = PARTIALS[node.op](Expression(graph, identity), *args)
    return sum(partials[place] for place, arg in enumerate(node.args) if arg == by)


def _atan2(f: Expression, y: Expression, x: Expression) -> tuple[Any, Any]:
    square = x * x + y * y
    return x / square, -y / square


class _Jounce:
    """Partial derivatives of a curve's fourth derivative: none to its place, and that to x is refused."""

    def __getitem__(self, place: int) -> int:
        if place == 0:
            return 0
        raise TypeError(
            "the fifth derivative of a curve does not exist. Use the curve, or its slope, in the formula."
        )


PARTIALS: dict[str, Any] = {
    "add": lambda f, a, b: (1, 1),
    "sub": lambda f, a, b: (1, -1),
    "mul": lambda f, a, b: (b, a),
    "div": lambda f, a, b: (1 / b, -f * (1 / b)),  # one division for both
    "neg": lambda f, a: (-1,),
    "sqrt": lambda f, a: (1 / (2 * f),),
    "sin": lambda f, a: (a.call("cos"),),
    "cos": lambda f, a: (-a.call("sin"),),
    "tan": lambda f, a: (1 + f * f,),
    "asin": lambda f, a: (1 / (1 - a * a).sqrt(),),
    "acos": lambda f, a: (-1 / (1 - a * a).sqrt(),),
    "atan": lambda f, a: (1 / (1 + a * a),),
    "exp": lambda f, a: (f,),
    "log": lambda f, a: (1 / a,),
    "tanh": lambda f, a: (a.call("sech2"),),
    "sech2": lambda f, a: (-2 * f * a.call("tanh"),),
    "atan2": _atan2,
    "nearest": lambda f, a: (0,),
    "positive": lambda f, a: (0,),
    "curve": lambda f, at, x: (0, at.call("curve_slope", x)),
    "curve_slope": lambda f, at, x: (0, at.call("curve_bend", x)),
    "curve_bend": lambda f, at, x: (0, at.call("curve_twist", x)),
    "curve_twist": lambda f, at, x: (0, at.call("curve_jounce", x)),
    "curve_jounce": lambda f, at, x: _Jounce(),
}
