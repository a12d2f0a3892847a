"""The gradient of one recorded expression by all its inputs in one sweep backwards, recorded in the same graph."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from .differentiate import PARTIALS
from .expression import Expression, Graph
from .replay import needed


def gradient(graph: Graph, of: Any, by: Sequence[Expression]) -> list[Any]:
    """Derivatives of an expression (or plain number) by inputs; 0 where it does not depend on one."""
    if not isinstance(of, Expression):
        return [0] * len(by)
    bars: dict[int, Any] = {of.id: graph.constant(1)}
    for identity in reversed(needed(graph, [of])):
        node = graph.nodes[identity]
        if identity not in bars or not node.args:
            continue
        args = [Expression(graph, arg) for arg in node.args]
        partials = PARTIALS[node.op](Expression(graph, identity), *args)
        for place, arg in enumerate(node.args):
            term = partials[place] * bars[identity]
            if _counts(term):
                bars[arg] = bars[arg] + term if arg in bars else term
    return [bars.get(variable.id, 0) for variable in by]


def _counts(term: Any) -> bool:
    """Whether a term is not plainly zero."""
    constant = term.constant if isinstance(term, Expression) else term
    return constant is None or constant != 0
