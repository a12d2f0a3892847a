"""Jumps of laws, by `sign` or `step` of one argument: refused where the motion decides about them."""

from __future__ import annotations

from collections.abc import Iterator

from ..._jit.formulas.expression import Expression as Recorded
from ..._jit.formulas.replay import needed
from ..errors import ModelError
from ..expression import Call, Expression, Name
from ..show import quote

TIME = "t"


def refuse_jumps(tree: Expression, field: str) -> None:
    """Refuse a formula that jumps with the state: integration cannot step over it, and it has no derivative there.

    Raises
    ------
    ModelError
    """
    for call in _jumps(tree):
        if others := sorted(set(call.names()) - {TIME}):
            message = f"{field} has {quote(str(call))}, which jumps with {', '.join(others)}"
            remedy = "Use tanh(x/width) or step(x, x0, h0, x1, h1)."
            raise ModelError(f"{message} and not only with t. {remedy}", field=field)


def refuse_recorded_jumps(result: Recorded, field: str) -> None:
    """Refuse a Python function whose value jumps with anything but the time; see `refuse_jumps`.

    It records `positive(a)`, which is 1 or 0, for corners as well, but as a factor of a.

    Raises
    ------
    ModelError
    """
    nodes, order = result.graph.nodes, needed(result.graph, [result])
    users = {n: [user for user in order if n in nodes[user].args] for n in order if nodes[n].op != "constant"}

    def vanishes(n: int, a: int) -> bool:
        """Whether all that is done with a number is a product with ``a``, or a sum or product with constants before."""
        return n != result.id and all(factor(user, n, a) for user in users[n])

    def factor(user: int, n: int, a: int) -> bool:
        op, args, _ = nodes[user]
        others = [arg for arg in args if arg != n]
        if op == "mul" and others in ([a], [*nodes[a].args] if nodes[a].op == "neg" else None):
            return True
        linear = op in ("add", "sub", "mul", "neg") and all(nodes[one].op == "constant" for one in others)
        return linear and vanishes(user, a)

    for n in order:
        if nodes[n].op == "positive" and not vanishes(n, a := nodes[n].args[0]):
            inputs = (nodes[one] for one in needed(result.graph, [Recorded(result.graph, a)]))
            if any(one.op == "input" and one.value != (TIME,) for one in inputs):
                message = f"{field} has a sign, or a step of one argument, which jumps with the motion or a parameter"
                remedy = "Use tanh(x/width) or step(x, x0, h0, x1, h1)."
                raise ModelError(f"{message} and not only with t. {remedy}", field=field)


def names_in_jumps(tree: Expression) -> set[str]:
    """Return the names in arguments of jumps; the n-th number of the formula is called ``#n``, counted from 1."""
    marked = tree.exchanged(lambda n, number: Name(f"#{n + 1}"))  # type: ignore[arg-type, return-value]
    return {name for call in _jumps(marked) for name in call.names()}


def _jumps(tree: Expression) -> Iterator[Call]:
    for node in tree.nodes():
        if isinstance(node, Call) and (
            node.function.name == "sign" or (node.function.name == "step" and len(node.args) == 1)
        ):
            yield node
