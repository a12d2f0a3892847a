"""Roots of equations in formulas: the number u with g(u) = 0, as one operation with exact derivatives.

The equation is recorded as operations of its own, of u and of the numbers x on which it depends, with its derivatives.
That of the root is the one of the implicit function, u_x = -g_x/g_u, of which all orders follow; none depends on the
start.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from .differentiate import jacobian
from .expression import Equation, Expression, Graph
from .functions import newton
from .replay import CURVES, SURFACES, needed

JUMPS = ("positive", "nearest")  # which would hide a switch from the integration


def root(g: Callable[[Any], Any], start: Any, scale: float = 1.0) -> Any:
    """The number u with g(u) = 0 that Newton's method finds from a start; not a number if it does not in 50 steps.

    Parameters
    ----------
    g : a formula of u, smooth, and with a slope that is not zero at the root
    start : a number near the root; it has no influence on derivatives
    scale : size of u in its unit below which its digits do not matter

    Raises
    ------
    TypeError
        If the formula of a kernel has a table, a sign, an absolute value or another corner of u.
    """
    value = g(start)
    if not isinstance(value, Expression):
        return newton(g, start, scale)
    graph = value.graph
    u = graph.input("root", len(graph.nodes))
    smooth, graph.smooth = graph.smooth, True
    try:
        equation, numbers = _equation(g(u), u, scale)
    finally:
        graph.smooth = smooth
    return graph.node("root", *graph.expressions([start]), *numbers, value=equation)


def _equation(g: Expression, u: Expression, scale: float) -> tuple[Equation, list[Expression]]:
    """The operations that depend on u, and the results of others that they take."""
    graph, own, numbers = u.graph, Graph(), list[Expression]()
    places = {u.id: own.input("u")}
    moving = {u.id}
    for identity in needed(graph, [g]):
        op, args, value = graph.nodes[identity]
        if not moving.intersection(args):
            continue
        if op in JUMPS or op in CURVES or op in SURFACES:
            raise TypeError(
                "the equation of a root must be a smooth formula of its unknown. Keep tables, abs, min, max, step and "
                "other signs of the unknown out of it."
            )
        for arg in args:
            if arg not in places and graph.nodes[arg].op == "constant":
                places[arg] = own.constant(graph.nodes[arg].value)
            elif arg not in places:
                places[arg] = own.input("x", len(numbers))
                numbers.append(Expression(graph, arg))
        moving.add(identity)
        places[identity] = own.node(op, *(places[arg] for arg in args), value=value)
    if g.id not in moving:
        raise TypeError("the equation of a root does not depend on its unknown. Return a formula of it.")
    own_g = places[g.id]
    slopes = jacobian(own, [own_g], [places[u.id], *(own.input("x", n) for n in range(len(numbers)))])[0]
    results = (own_g, *own.expressions(slopes))
    return Equation(tuple(own.nodes), tuple(result.id for result in results), float(scale)), numbers
