"""Derivatives of recorded graphs, exact: the chain rule over the list of operations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .expression import Expression, Graph
from .replay import needed, replay
from .surfaces import HIGHEST, ORDERS, surface_name


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


class _Fourth:
    """Partial derivatives of the fourth derivative of a table: none to its place, and that to x is refused."""

    def __getitem__(self, place: int) -> int:
        if place == 0:
            return 0
        raise TypeError(
            "the fifth derivative of a table does not exist. Use the table, or its slope, in the formula."
        )


def _of_surface(i: int, j: int) -> Any:
    """The partial derivatives of ∂ⁱ⁺ʲz/∂xⁱ∂yʲ of a surface, by its place, x and y."""
    if i + j > HIGHEST:
        return lambda f, at, x, y: _Fourth()
    return lambda f, at, x, y: (
        0,
        at.call(surface_name(i + 1, j), x, y),
        at.call(surface_name(i, j + 1), x, y),
    )


def _root(u: Expression, start: Expression, *x: Expression) -> tuple[Any, ...]:
    """-g_x/g_u of the equation that u solves; the start has no influence."""
    equation = u.graph.nodes[u.id].value
    slopes = [equation.graph.at(place) for place in equation.results[1:]]
    by_u, *by_x = replay(slopes[0].graph, slopes, equation.inputs(u, x))
    return 0, *(-slope / by_u for slope in by_x)


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
    "root": _root,
    "curve": lambda f, at, x: (0, at.call("curve_slope", x)),
    "curve_slope": lambda f, at, x: (0, at.call("curve_bend", x)),
    "curve_bend": lambda f, at, x: (0, at.call("curve_twist", x)),
    "curve_twist": lambda f, at, x: (0, at.call("curve_jounce", x)),
    "curve_jounce": lambda f, at, x: _Fourth(),
    **{name: _of_surface(*orders) for name, orders in ORDERS.items()},
}
