"""Jumps of laws, by `sign` or `step` of one argument: refused where the motion decides about them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from ..._jit.formulas.expression import TINY, Graph
from ..._jit.formulas.expression import Expression as Recorded
from ..._jit.formulas.replay import needed
from ..errors import ModelError
from ..expression import Call, Expression, Name
from ..show import quote

TIME = "t"
PERIODIC = ("floor", "mod")
JUMPING = ("positive", "nearest")  # recorded operations that jump
ZERO_AT_ZERO = {"add", "sub", "neg", "sqrt", "sin", "tan", "asin", "atan", "tanh"}


def refuse_jumps(tree: Expression, field: str) -> None:
    """Refuse a formula that jumps with the state: integration cannot step over it, and it has no derivative there.

    Raises
    ------
    ModelError
    """
    for call in _jumps(tree):
        if others := sorted(set(call.names()) - {TIME}):
            message = f"{field} has {quote(str(call))}, which jumps with {', '.join(others)}"
            raise ModelError(f"{message} and not only with t. {_remedy(call.function.name)}", field=field)


def _remedy(name: str) -> str:
    if name in PERIODIC:
        return "For what repeats use a periodic table, or sin and cos."
    return "Use tanh(x/width) or step(x, x0, h0, x1, h1)."


def refuse_recorded_jumps(result: Recorded, field: str) -> None:
    """Refuse a Python function whose value jumps with anything but the time; see `refuse_jumps`.

    It records `positive(a)`, which is 1 or 0, for corners as well, but with a factor that is 0 where it jumps.

    Raises
    ------
    ModelError
    """
    if jumps(result, TIME):
        message = (
            f"{field} has a sign, floor or mod, or a step of one argument, which jumps with the motion or a "
        )
        raise ModelError(f"{message}parameter and not only with t. {_remedy('sign')}", field=field)


def jumps(result: Recorded, *still: str, by: Sequence[str] = JUMPING) -> bool:
    """Return whether a recorded value jumps, by some operations, with anything but the inputs of these kinds."""
    nodes, order = result.graph.nodes, needed(result.graph, [result])
    moved: set[int] = set()  # those that depend on more than these
    for n in order:
        op, args, value = nodes[n]
        if value[0] not in still if op == "input" else not moved.isdisjoint(args):
            moved.add(n)
    jumping = [n for n in order if nodes[n].op in by and nodes[n].args[0] in moved]
    users: dict[int, list[int]] = {n: [] for n in order if jumping}
    for user in order if jumping else ():
        for n in set(nodes[user].args):
            users[n].append(user)
    return not all(_is_continuous(result, n, users) for n in jumping)


def _is_continuous(result: Recorded, jump: int, users: Mapping[int, list[int]]) -> bool:
    """Whether each product that a jump is in, before the result, has a factor that is 0 where it jumps."""
    graph = result.graph
    root = _unscaled(graph, graph.nodes[jump].args[0])
    waiting, seen = [jump], {jump}
    while waiting:
        if (n := waiting.pop()) == result.id or graph.nodes[jump].op == "nearest":
            return False
        for user in users[n]:
            op, args, _ = graph.nodes[user]
            other = args[-1] if args[0] == n else args[0]
            tiny = graph.nodes[other].value == TINY
            if op == "mul" and (tiny or _unscaled(graph, other) == root or _vanishes(graph, other, root)):
                continue
            bounded = op == "mul" and _is_bounded(graph, other, root)
            divided = op == "div" and args[1] != n and root not in _all_of(graph, other)
            if not (bounded or divided or op in ("add", "sub", "neg")):
                return False
            if user not in seen:
                seen.add(user)
                waiting.append(user)
    return True


def _all_of(graph: Graph, n: int) -> list[int]:
    return needed(graph, [Recorded(graph, n)])


def _unscaled(graph: Graph, n: int) -> int:
    """The node without its sign and constant factors."""
    while True:
        op, args, _ = graph.nodes[n]
        free = [arg for arg in args if graph.nodes[arg].op != "constant"]
        if len(free) != 1 or not (op in ("neg", "mul") or (op == "div" and free == [args[0]])):
            return n
        n = free[0]


def _is_bounded(graph: Graph, n: int, root: int) -> bool:
    """Whether a number has no division by what depends on the root, which may be 0."""
    divisors = (graph.nodes[one].args[1] for one in _all_of(graph, n) if graph.nodes[one].op == "div")
    return all(root not in _all_of(graph, one) for one in divisors)


def _vanishes(graph: Graph, n: int, root: int) -> bool:
    """Whether a number is 0 where the root is."""
    zeros = {root}
    for one in _all_of(graph, n):
        op, args, _ = graph.nodes[one]
        factor = (op == "mul" and not zeros.isdisjoint(args)) or (op == "div" and args[0] in zeros)
        if factor or (op in ZERO_AT_ZERO and zeros.issuperset(args)):
            zeros.add(one)
    return n in zeros and _is_bounded(graph, n, root)


def names_in_jumps(tree: Expression) -> set[str]:
    """Return the names in arguments of jumps; the n-th number of the formula is called ``#n``, counted from 1."""
    marked = tree.exchanged(lambda n, number: Name(f"#{n + 1}"))  # type: ignore[arg-type, return-value]
    return {name for call in _jumps(marked) for name in call.names()}


def _jumps(tree: Expression) -> Iterator[Call]:
    for node in tree.nodes():
        if isinstance(node, Call) and (
            node.function.name in ("sign", *PERIODIC)
            or (node.function.name == "step" and len(node.args) == 1)
        ):
            yield node
