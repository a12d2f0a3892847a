"""The tree of a formula: numbers, names and calls of functions; its value and its exact derivative.

Nothing here recurses: a formula of any length, and the derivative of a derivative, is worked off in one loop over its
nodes, each of them once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any, ClassVar, TypeAlias

from ..arithmetic import Numeric
from ..errors import ModelError
from ..show import quote
from ..tape import value_of

Values: TypeAlias = dict["Expression", Any]
Partials: TypeAlias = "Callable[..., tuple[Expression, ...]]"

WHOLE = 2**53  # below this a float that is a whole number is exactly that
ATOM = 9  # precedence of what needs no brackets
BESIDE_UNIT = 3  # that of a number with a unit, which an exponent would be part of


@dataclass(frozen=True, eq=False)
class Function:
    """A function of formulas.

    Parameters
    ----------
    name
        As it is written; operators are functions too.
    counts
        The numbers of arguments that it takes.
    value
        Its value for any kind of number.
    partials
        Its derivatives with respect to each argument, as trees.
    precedence
        Of an operator; 0 for a function that is called by name.
    """

    name: str
    counts: tuple[int, ...]
    value: Callable[..., Numeric]
    partials: Partials
    precedence: int = 0

    def __reduce__(self) -> tuple[Callable[[str], Function], tuple[str]]:
        return function_named, (self.name,)


REGISTRY: dict[str, Function] = {}  # filled in functions.py


class Expression:
    """An immutable formula; arithmetic on formulas returns formulas."""

    args: tuple[Expression, ...] = ()
    context: ClassVar[SimpleNamespace]  # its functions, for `sarrus.functions`

    def value(self, env: Mapping[str, Any] | None = None) -> Any:
        """Return the formula's value.

        Parameters
        ----------
        env
            A number for every name: floats, arrays, complex numbers, recorded numbers, or any type with arithmetic
            and methods such as ``x.sin()``.

        Raises
        ------
        ModelError
            If a name has no number, or a plain number is divided by zero or outside a function's domain.
        """
        values: Values = {}
        for node in self.nodes():
            values[node] = node._value(env or {}, values)
        return values[self]

    def derivative(self, name: str) -> Expression:
        """Return the exact derivative with respect to a name, as a formula.

        At the kinks of ``min``, ``max`` and ``abs`` it is the derivative of the side that is taken there.
        """
        found: dict[Expression, Expression] = {}
        for node in self.nodes():
            found[node] = node._derivative(name, found)
        return found[self]

    def names(self) -> tuple[str, ...]:
        """Return the names in the formula, each once, in their order."""
        return tuple(dict.fromkeys(node.name for node in self.nodes() if isinstance(node, Name)))

    def replaced(self, new: Mapping[str, Expression]) -> Expression:
        """Return the formula with formulas in the place of names."""
        return self.rebuilt(lambda node: new.get(node.name) if isinstance(node, Name) else None)

    def rebuilt(self, change: Callable[[Expression], Expression | None]) -> Expression:
        """Return the formula with what `change` returns in the place of each node; for None the node remains."""
        made: dict[Expression, Expression] = {}
        for node in self.nodes():
            new = change(node)
            if new is None and isinstance(node, Call):
                args = tuple(made[arg] for arg in node.args)
                new = node if args == node.args else Call(node.function, args)
            made[node] = node if new is None else new
        return made[self]

    def exchanged(self, change: Callable[[int, Number], Number]) -> Expression:
        """Return the formula with its nth constant replaced by ``change(n, number)``, counted from 0.

        Exponents and constants such as pi are left as they are.
        """
        fixed = {
            node.args[1] for node in self.nodes() if isinstance(node, Call) and node.function.name == "**"
        }
        constants = (node for node in self.nodes() if isinstance(node, Number) and node not in fixed)
        counted = enumerate(node for node in constants if not node.written.isidentifier())
        changed: dict[Expression, Expression] = {node: change(n, node) for n, node in counted}
        return self.rebuilt(lambda node: changed.get(node))

    def renamed(self, values: Mapping[str, float]) -> Expression:
        """Return the formula of a function with the names of parameters in the place of their values."""

        def named(node: Expression) -> Name | None:
            of_one = isinstance(node, Number) and node.of and values.get(node.of) == node.number
            return Name(node.of) if isinstance(node, Number) and of_one else None

        return self.rebuilt(named)

    def nodes(self) -> Iterator[Expression]:
        """Yield every node once, arguments before the nodes that use them."""
        done: set[Expression] = set()
        waiting: list[tuple[Expression, bool]] = [(self, False)]
        while waiting:
            node, ready = waiting.pop()
            if node not in done and (ready or not node.args):
                done.add(node)
                yield node
            elif node not in done:
                waiting.append((node, True))
                waiting.extend((arg, False) for arg in reversed(node.args))

    def __str__(self) -> str:
        texts: dict[Expression, tuple[str, int]] = {}
        for node in self.nodes():
            texts[node] = node._text(texts)
        return texts[self][0]

    def __add__(self, other: Expression | float) -> Expression:
        a, b = self, lift(other)
        if is_number(a, 0):
            return b
        return a if is_number(b, 0) else call("+", a, b)

    def __sub__(self, other: Expression | float) -> Expression:
        a, b = self, lift(other)
        if is_number(b, 0):
            return a
        return -b if is_number(a, 0) else call("-", a, b)

    def __mul__(self, other: Expression | float) -> Expression:
        a, b = self, lift(other)
        if is_number(a, 0) or is_number(b, 1):
            return a
        return b if is_number(b, 0) or is_number(a, 1) else call("*", a, b)

    def __truediv__(self, other: Expression | float) -> Expression:
        b = lift(other)
        return self if is_number(self, 0) or is_number(b, 1) else call("/", self, b)

    def __pow__(self, other: Expression | float) -> Expression:
        b = lift(other)
        return self if is_number(b, 1) else call("**", self, b)

    def __neg__(self) -> Expression:
        if isinstance(self, Number) and not self.of:
            return Number(-self.number)
        return call("neg", self)

    def __radd__(self, other: float) -> Expression:
        return lift(other) + self

    def __rsub__(self, other: float) -> Expression:
        return lift(other) - self

    def __rmul__(self, other: float) -> Expression:
        return lift(other) * self

    def __rtruediv__(self, other: float) -> Expression:
        return lift(other) / self

    def _value(self, env: Mapping[str, Any], values: Values) -> Any:
        raise NotImplementedError

    def _derivative(self, name: str, found: Mapping[Expression, Expression]) -> Expression:
        return Number(0.0)

    def _text(self, texts: Mapping[Expression, tuple[str, int]]) -> tuple[str, int]:
        raise NotImplementedError


@dataclass(frozen=True, eq=False)
class Number(Expression):
    """A number, in SI units if it was written with a unit; in a function the value of the parameter ``of``, if any.

    It may be traced: then the formula has its value.
    """

    number: float
    unit: str = ""
    written: str = field(default="", repr=False)
    of: str = ""

    def _value(self, env: Mapping[str, Any], values: Values) -> Any:
        number = float(value_of(self.number))
        whole = number.is_integer() and abs(number) < WHOLE
        return int(number) if whole else number

    def _text(self, texts: Mapping[Expression, tuple[str, int]]) -> tuple[str, int]:
        if self.unit in ("", "1"):
            text = self.written or f"{self._value({}, {})}"
            return text, 1 if text.startswith("-") else ATOM
        text = self.written or f"{self._value({}, {})} {self.unit}"
        return text, 1 if text.startswith("-") else BESIDE_UNIT


@dataclass(frozen=True, eq=False)
class Name(Expression):
    """A name whose number is given when the formula is evaluated; it may be a path, as in ``rod.position.x``."""

    name: str

    def _value(self, env: Mapping[str, Any], values: Values) -> Any:
        if self.name not in env:
            raise ModelError(f"{quote(self.name)} has no value. Give it one.")
        return env[self.name]

    def _derivative(self, name: str, found: Mapping[Expression, Expression]) -> Expression:
        return Number(1.0 if name == self.name else 0.0)

    def _text(self, texts: Mapping[Expression, tuple[str, int]]) -> tuple[str, int]:
        if "-" not in self.name or "(" in self.name or "[" in self.name:
            return self.name, ATOM
        return ".".join(f"'{step}'" if "-" in step else step for step in self.name.split(".")), ATOM


@dataclass(frozen=True, eq=False)
class Call(Expression):
    """A function or an operator with its arguments."""

    function: Function
    args: tuple[Expression, ...]

    def _value(self, env: Mapping[str, Any], values: Values) -> Any:
        try:
            return self.function.value(*(values[arg] for arg in self.args))
        except ZeroDivisionError:
            raise self._refusal("divides by zero") from None
        except OverflowError:
            raise self._refusal("is too large") from None
        except ValueError:
            raise self._refusal("has no real value there") from None

    def _refusal(self, reason: str) -> ModelError:
        return ModelError(f"holds {quote(str(self))}, which {reason}. Change its numbers.")

    def _derivative(self, name: str, found: Mapping[Expression, Expression]) -> Expression:
        result: Expression = Number(0.0)
        if any(not is_number(found[arg], 0) for arg in self.args):
            for partial, arg in zip(self.function.partials(*self.args), self.args, strict=True):
                result = result + partial * found[arg]
        return result

    def _text(self, texts: Mapping[Expression, tuple[str, int]]) -> tuple[str, int]:
        own = self.function.precedence
        if not own:
            return f"{self.function.name}({', '.join(texts[arg][0] for arg in self.args)})", ATOM
        if len(self.args) == 1:
            return "-" + _bracketed(texts[self.args[0]], own), own
        left, right = (texts[arg] for arg in self.args)
        to_right = self.function.name == "**"
        sides = _bracketed(left, own + to_right), _bracketed(right, own + (not to_right))
        spaced = own == 1 or _ends_in_unit(self.args[0])
        return f" {self.function.name} ".join(sides) if spaced else self.function.name.join(sides), own


def function_named(name: str) -> Function:
    """Return the function of a name; trees are pickled by it."""
    return REGISTRY[name]


def call(function: str, *args: Expression) -> Call:
    """Return the call of a function by its name."""
    return Call(REGISTRY[function], args)


def lift(value: Expression | float) -> Expression:
    """Return a plain number as a formula, and a formula as it is."""
    return value if isinstance(value, Expression) else Number(float(value))


def is_number(expression: Expression, number: float) -> bool:
    """Return whether a formula is just this number, and not the value of a parameter, which may change."""
    return isinstance(expression, Number) and not expression.of and expression.number == number


def _ends_in_unit(node: Expression) -> bool:
    """Return whether the text of a formula ends in a unit, of which a sign without spaces would be part."""
    while isinstance(node, Call) and node.function.precedence:
        node = node.args[-1]
    return isinstance(node, Number) and node.unit not in ("", "1")


def _bracketed(text: tuple[str, int], least: int) -> str:
    return text[0] if text[1] >= least else f"({text[0]})"
