"""Functions of time in an element: laws in its fields, and expressions in its formulas."""

from __future__ import annotations

from copy import deepcopy
from functools import cache

import numpy as np

from ...._jit.formulas.differentiate import jacobian
from ...._jit.formulas.expression import Expression, Graph
from ...._jit.formulas.replay import needed
from ....elements import OPERATORS
from ....elements.recorder import Variant, record

FIXED, OF_TIME, MOVES = range(3)  # what a recorded number depends on: numbers, the time too, or the state


@cache
def fields_of_time(variant: Variant) -> list[int]:
    """Return the fields of an element that are curves over the time."""
    kinds = [kind for kind in variant.kind.fields.values() if kind != "Time"]
    if "Curve" not in kinds or not variant.kind.family:
        return []
    nodes = _recorded(variant).nodes
    called = {
        nodes[node.args[0]].value[1]
        for node in nodes
        if node.op == "curve" and nodes[node.args[1]].value == ("t",)
    }
    widths = [
        width
        for width, kind in zip(variant.kind.widths(), variant.kind.fields.values(), strict=True)
        if kind != "Time"
    ]
    starts = np.cumsum([0, *widths])
    return [n for n in range(len(kinds)) if int(starts[n]) in called]


@cache
def expressions_of_time(variant: Variant) -> tuple[Graph, list[Expression]]:
    """The largest expressions of the time and of numbers alone, without curves."""
    if not variant.kind.rows and OPERATORS["Q"] not in variant.kind.family:
        return Graph(), []
    graph = _recorded(variant)
    levels: list[int] = []
    for node in graph.nodes:
        if node.op == "input":
            levels.append({"t": OF_TIME, "numbers": FIXED}.get(node.value[0], MOVES))
        else:
            levels.append(
                MOVES if node.op.startswith("curve") else max((levels[n] for n in node.args), default=FIXED)
            )
    inner = {
        n for node, level in zip(graph.nodes, levels, strict=True) if level == OF_TIME for n in node.args
    }
    own = [n for n, level in enumerate(levels) if level == OF_TIME and n not in inner and graph.nodes[n].args]
    return graph, [Expression(graph, n) for n in own]


@cache
def slopes_of_time(variant: Variant) -> tuple[Graph, list[tuple[int, Expression]]]:
    """Derivatives of these expressions by the numbers in them, with the places of these."""
    graph, own = expressions_of_time(variant)
    graph = deepcopy(graph)
    found = list[tuple[int, Expression]]()
    for value in (Expression(graph, one.id) for one in own):
        inputs = [Expression(graph, n) for n in needed(graph, [value]) if graph.nodes[n].op == "input"]
        numbers = [one for one in inputs if graph.nodes[one.id].value[0] == "numbers"]
        slopes = jacobian(graph, [value], numbers)[0]
        found += [
            (graph.nodes[one.id].value[1], slope)
            for one, slope in zip(numbers, slopes, strict=True)
            if isinstance(slope, Expression)
        ]
    return graph, found


def _recorded(variant: Variant) -> Graph:
    return record(variant, ("Phi",) if variant.kind.rows else ("Q",)).graph
