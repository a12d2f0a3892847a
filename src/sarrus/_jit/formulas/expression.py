"""Recording arithmetic: numbers that remember how they were computed.

A kernel is a NumPy formula. Called once with `Expression` entries in its arrays it leaves behind the list of scalar
operations that it does, each once (equal operations are one node) and without those on structural zeros and ones.
That list is what `emit` compiles.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import wraps
from typing import Any, NamedTuple

import numpy as np

# In place of a base of zero: its logarithm is finite, and so are three derivatives of its powers
TINY = 1e-90


class Node(NamedTuple):
    """One scalar operation: its name, the nodes that it takes, and for constants and inputs their value or address."""

    op: str
    args: tuple[int, ...]
    value: Any = None


class Equation(NamedTuple):
    """An equation g(u, x) = 0 for u: operations, the places of g, g_u and all g_x among them, and the scale of u."""

    nodes: tuple[Node, ...]
    results: tuple[int, ...]
    scale: float

    @property
    def graph(self) -> Graph:
        """The operations, of inputs ``("u",)`` and ``("x", n)``."""
        graph = Graph()
        graph.nodes.extend(self.nodes)
        return graph

    def inputs(self, u: Any, x: Sequence[Any]) -> dict[tuple[Any, ...], Any]:
        """Values of the inputs by their names."""
        return {("u",): u} | {("x", n): value for n, value in enumerate(x)}


class Graph:
    """The operations recorded so far, in the order of their creation; equal operations share one node."""

    def __init__(self) -> None:
        self.nodes: list[Node] = []
        self.kinked: list[bool] = []  # whether a node depends on the sign of another
        self.smooth = False  # whether what is recorded has no corner, as the equation of a root
        self._known: dict[Node, int] = {}

    def node(self, op: str, *args: Expression, value: Any = None) -> Expression:
        """The expression of one operation, new or already known."""
        key = Node(op, tuple(arg.id for arg in args), value)
        if key not in self._known:
            self._known[key] = len(self.nodes)
            self.nodes.append(key)
            self.kinked.append(op == "positive" or any(self.kinked[arg.id] for arg in args))
        return Expression(self, self._known[key])

    def at(self, place: int) -> Expression:
        """The expression of a node."""
        return Expression(self, place)

    def constant(self, value: Any) -> Expression:
        """The expression of a number."""
        return self.node("constant", value=value.item() if isinstance(value, np.generic) else value)

    def expressions(self, values: Iterable[Any]) -> list[Expression]:
        """Recorded values, which are plain numbers where nothing was left to record, as expressions."""
        return [x if isinstance(x, Expression) else self.constant(x) for x in values]

    def input(self, *name: Any) -> Expression:
        """The expression of one number that is read at run time, e.g. ``input("q", 0, 3)``."""
        return self.node("input", value=name)

    def inputs(self, name: str, *shape: int) -> np.ndarray[Any, Any]:
        """An object array of inputs, called by their place: ``inputs("lam", 3)``."""
        entries = np.empty(shape, dtype=object)
        for place in np.ndindex(*shape):
            entries[place] = self.input(name, *place)
        return entries


def _between_scalars(operation: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
    """Turn plain numbers into constants first, and leave arrays to NumPy."""

    @wraps(operation)
    def wrapped(self: Expression, other: Any) -> Any:
        if isinstance(other, np.ndarray):
            return NotImplemented
        return operation(self, other if isinstance(other, Expression) else self.graph.constant(other))

    return wrapped


class Expression:
    """A scalar that is known only at run time. Arithmetic on it records nodes in its graph."""

    __slots__ = ("graph", "id")

    def __init__(self, graph: Graph, node: int) -> None:
        self.graph = graph
        self.id = node

    @property
    def constant(self) -> Any:
        """The number that this expression is, or None where it is known only at run time."""
        node = self.graph.nodes[self.id]
        return node.value if node.op == "constant" else None

    @property
    def negated(self) -> Expression | None:
        """The expression that this one is the negative of, or None."""
        node = self.graph.nodes[self.id]
        return Expression(self.graph, node.args[0]) if node.op == "neg" else None

    def _commutative(self, op: str, other: Expression) -> Expression:
        first, second = (self, other) if self.id <= other.id else (other, self)
        return self.graph.node(op, first, second)

    @_between_scalars
    def __add__(self, other: Expression) -> Expression:
        if (folded := _fold(self, other, lambda a, b: a + b)) is not None:
            return folded
        if self.constant == 0:
            return other
        if other.constant == 0:
            return self
        if other.negated is not None:
            return self - other.negated
        if self.negated is not None:
            return other - self.negated
        return self._commutative("add", other)

    @_between_scalars
    def __sub__(self, other: Expression) -> Expression:
        if (folded := _fold(self, other, lambda a, b: a - b)) is not None:
            return folded
        if other.constant == 0:
            return self
        if self.constant == 0:
            return -other
        if other.negated is not None:
            return self + other.negated
        if self.negated is not None:
            return -(self.negated + other)
        if self.id == other.id:
            return self.graph.constant(0)
        if self.id > other.id and self.constant is None and other.constant is None:  # 1 - 1 is 0, not -0
            return -self.graph.node("sub", other, self)
        return self.graph.node("sub", self, other)

    @_between_scalars
    def __mul__(self, other: Expression) -> Expression:
        if (folded := _fold(self, other, lambda a, b: a * b)) is not None:
            return folded
        for a, b in ((self, other), (other, self)):
            if a.constant is not None and a.constant == 0:
                return a
            if a.constant == 1:
                return b
            if a.constant is not None and a.constant < 0:
                return -((-a) * b)
            if a.negated is not None:
                return -(a.negated * b)
        return self._commutative("mul", other)

    @_between_scalars
    def __truediv__(self, other: Expression) -> Expression:
        if self.constant == 0 or other.constant == 1:
            return self
        return self.graph.node("div", self, other)

    def __neg__(self) -> Expression:
        if self.constant is not None:
            return self.graph.constant(-self.constant)
        return self.negated if self.negated is not None else self.graph.node("neg", self)

    def __abs__(self) -> Any:
        return self * (2 * self.call("positive") - 1)

    __radd__ = __add__
    __rmul__ = __mul__

    @_between_scalars
    def __rsub__(self, other: Expression) -> Expression:
        return other - self

    @_between_scalars
    def __rtruediv__(self, other: Expression) -> Expression:
        return other / self

    def __pow__(self, exponent: Any) -> Expression:
        if isinstance(exponent, int) and exponent >= 0:
            return self._whole_power(exponent)
        if isinstance(exponent, int):
            return 1 / self._whole_power(-exponent)
        return self.call("sqrt") if exponent == 0.5 else self.real_power(exponent)

    def real_power(self, exponent: Any) -> Expression:
        """A power by the logarithm; that of zero has slopes where the exponent allows them."""
        slopes = not isinstance(exponent, (int, float)) or exponent >= 1 or (exponent > 0 and self._kinked)
        base = self._beside_zero() if slopes else self
        return (exponent * base.call("log")).call("exp")

    def _beside_zero(self) -> Expression:
        """This, and a tiny number in place of zero: powers of a base that stays zero have slopes along it, of zero."""
        return self if self.graph.smooth else self + TINY * (1 - self.call("positive"))

    @property
    def _kinked(self) -> bool:
        """Whether this may be zero on one side of a corner, as max(0, x)."""
        return self.graph.kinked[self.id]

    def _whole_power(self, exponent: int) -> Expression:
        if exponent == 0:
            return self.graph.constant(1)
        half = self._whole_power(exponent // 2)
        return half * half * self if exponent % 2 else half * half

    def _branch(self, *others: Any) -> Any:
        raise TypeError(
            "a formula must not branch on values known only at run time. Use abs, or minimum, maximum and step of "
            "sarrus.functions in place of min, max and if."
        )

    __bool__ = __eq__ = __ne__ = __lt__ = __le__ = __gt__ = __ge__ = _branch
    __hash__ = None  # type: ignore[assignment]

    def call(self, function: str, *others: Any) -> Expression:
        """A function of `sarrus._jit.formulas.functions` of this and other expressions."""
        own = self._beside_zero() if function == "sqrt" and self._kinked else self
        return self.graph.node(
            function, own, *(o if isinstance(o, Expression) else self.graph.constant(o) for o in others)
        )


def _method(function: str) -> Callable[[Expression], Expression]:
    return lambda self: self.call(function)


for _ufunc, _function in {
    "sqrt": "sqrt", "sin": "sin", "cos": "cos", "tan": "tan", "exp": "exp", "log": "log", "tanh": "tanh",
    "arcsin": "asin", "arccos": "acos", "arctan": "atan",
}.items():  # fmt: skip
    setattr(Expression, _ufunc, _method(_function))  # what numpy.sin calls on object arrays


def _fold(a: Expression, b: Expression, operation: Any) -> Expression | None:
    if a.constant is None or b.constant is None:
        return None
    return a.graph.constant(operation(a.constant, b.constant))
