"""A formula's text to its tree, by recursive descent. Nothing is ever handed to Python's own ``eval``.

sum = product {(+|-) product};  product = unary {(*|/) unary};  unary = {+|-} power;  power = atom [** unary]
atom = number [unit] | path | A[path, path] | function(sum {, sum}) | (sum) | ${sum}
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import NamedTuple

from ..errors import ModelError
from ..show import quote, suggest
from .functions import CONSTANTS, FUNCTIONS
from .tree import REGISTRY, Call, Expression, Function, Name, Number, call
from .units import UnitFactor, in_si

DEEPEST = 48  # brackets within brackets
CLOSING = {"(": ")", "${": "}"}
POWERS = ("**", "^")
NAMES = ("name", "quoted")
NUMBERED = re.compile(r"\.\d+")
LONGEST = 4000  # characters of one formula

TOKEN = re.compile(
    r"(?P<number>(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?)"
    r"|(?P<entry>(?:[A-D]|magnitude|phase|real|imaginary)\[[^\[\]]*\]"  # of a linearization
    r"|relative\[[^\[\]]*\][.\w]*)"
    r"|(?P<name>[^\W\d]\w*|°)"
    r"|'(?P<quoted>[^']*)'"
    r"|(?P<sign>\*\*|\$\{|[-+*/^(){}.,·])"
)
SPACE = re.compile(r"\s*")


def parse_expression(text: str, variables: Iterable[str] = ()) -> Expression:
    """Return the tree of a formula.

    Parameters
    ----------
    text
        For example ``"step(t, 0, 0, 1 s, 30 deg) + 0.1*sin(2*pi*t)"``. It may use ``+ - * /``, ``**`` or ``^``,
        brackets, pi, numbers with units, and the functions of ``FUNCTIONS``.
    variables
        The names that it may use.

    Raises
    ------
    ModelError
        In one message, if the text is no formula or uses another name.

    Examples
    --------
    >>> parse_expression("2*t**2", ["t"]).derivative("t").value({"t": 3.0})
    12.0
    """
    if not isinstance(text, str):
        raise TypeError(f"text must be a text, got {text!r:.40}. Give one in quotes.")
    given: object = variables
    if not isinstance(given, Iterable) or getattr(given, "ndim", 1) != 1:
        raise TypeError(f'variables must be a list of names, got {variables!r:.40}. Give one, as in ["t"].')
    tree = parse(text)
    known = tuple(map(str, variables))
    for name in tree.names():
        if name not in known:
            raise ModelError(f"has the unknown name {quote(name)}. {suggest(name, known)}")
    return tree


def parse(text: str, *, functions: Mapping[str, Function] | None = None) -> Expression:
    """Return the tree of a formula whose names are looked up later; ``functions`` are known beside the usual ones."""
    return _Parser(text, functions or {}).whole()


class _Parser:
    """Reads tokens from left to right; ``at`` is the next one."""

    def __init__(self, text: str, functions: Mapping[str, Function]) -> None:
        self.text = text
        self.functions = functions
        self.tokens = tokens(text)
        self.at = 0
        self.depth = 0

    def whole(self) -> Expression:
        result = self._sum()
        if self._next.kind != "end":
            raise self._wrong(f"{quote(self._next.text)} is out of place")
        return result

    @property
    def _next(self) -> Token:
        return self.tokens[self.at]

    def _taken(self, *signs: str) -> str:
        """Step over the next sign if it is one of these, and return it."""
        token = self._next
        if token.kind != "sign" or token.text not in signs:
            return ""
        self.at += 1
        return token.text

    def _expect(self, sign: str) -> None:
        if not self._taken(sign):
            raise self._wrong(f"{quote(sign)} is missing")

    def _wrong(self, reason: str) -> ModelError:
        return ModelError(f"holds a formula in which {reason}. Check {quote(self.text)}.")

    def _sum(self) -> Expression:
        result = self._product()
        while sign := self._taken("+", "-"):
            result = call(sign, result, self._product())
        return result

    def _product(self) -> Expression:
        result = self._unary()
        while sign := self._taken("*", "/", "·"):
            result = call(sign.replace("·", "*"), result, self._unary())
        return result

    def _unary(self) -> Expression:
        self.depth += 1
        if self.depth > DEEPEST:
            raise ModelError(f"holds a formula of more than {DEEPEST} levels of brackets. Use parameters.")
        sign = self._taken("+", "-")
        inner = self._unary() if sign else self._power()
        self.depth -= 1
        return call("neg", inner) if sign == "-" else inner

    def _power(self) -> Expression:
        base = self._atom()
        return call("**", base, self._unary()) if self._taken(*POWERS) else base

    def _atom(self) -> Expression:
        token = self._next
        if opening := self._taken(*CLOSING):
            inner = self._sum()
            self._expect(CLOSING[opening])
            return inner
        if token.kind not in ("number", "entry", *NAMES):
            raise self._wrong(
                "a number or a name is missing" + (f" before {quote(token.text)}" * bool(token.text))
            )
        self.at += 1
        if token.kind == "entry":
            return Name(token.text)
        return self._number(token) if token.kind == "number" else self._named(token)

    def _number(self, token: Token) -> Expression:
        if self._next.kind != "name":
            return Number(float(token.text), written=token.text)
        factors = list(self._unit())
        unit = self.text[factors[0].start : self.tokens[self.at - 1].end]
        number, kind = in_si(float(token.text), factors)
        return Number(number, kind, f"{token.text} {unit}")

    def _unit(self) -> Iterable[UnitFactor]:
        """Yield the factors of a unit: it goes on over spaces, and over * and / without spaces around them."""
        sign = "*"
        while sign and self._next.kind == "name":
            token = self._next
            self.at += 1
            exponent = self._exponent() if self._taken(*POWERS) else 1
            yield UnitFactor(token.text, exponent if sign != "/" else -exponent, token.start)
            sign = self._joined()

    def _joined(self) -> str:
        sign, after, behind = (self.tokens[min(self.at + n, len(self.tokens) - 1)] for n in range(3))
        close = self.tokens[self.at - 1].end == sign.start and sign.end == after.start
        if sign.kind == "name":
            return "*"
        unit = close and after.kind == "name" and behind.text not in CLOSING  # of a function
        return self._taken("*", "/", "·") if unit else ""

    def _exponent(self) -> int:
        sign, token = self._taken("-"), self._next
        if token.kind != "number" or not token.text.isdigit() or len(token.text) > 2:
            raise self._wrong("the power of a unit is no whole number")
        self.at += 1
        return -int(token.text) if sign else int(token.text)

    def _named(self, token: Token) -> Expression:
        if token.kind == "name" and self._taken("("):
            return self._function(token.text)
        path = token.text + self._steps()
        return Number(CONSTANTS[path], written=path) if path in CONSTANTS else Name(path)

    def _steps(self) -> str:
        """The steps of a path, ``.force.x``; a step may be a number, ``.multiplier.1``."""
        path = ""
        while (
            numbered := self._next.kind == "number" and NUMBERED.fullmatch(self._next.text)
        ) or self._taken("."):
            path += self._next.text if numbered else "." + self._step()
            self.at += bool(numbered)
        return path

    def _step(self) -> str:
        token = self._next
        if token.kind not in NAMES:
            raise self._wrong("a name after a point is missing")
        self.at += 1
        return token.text

    def _function(self, name: str) -> Expression:
        args = [self._sum()]
        while self._taken(","):
            args.append(self._sum())
        self._expect(")")
        if steps := self._steps():  # a point of a body, tool(0.1, 0, 0).x
            return Name(f"{name}({', '.join(f'{arg.value()!r}' for arg in args)}){steps}")
        own = self.functions.get(name)
        if own and len(args) in own.counts:
            return Call(own, tuple(args))
        if name not in FUNCTIONS:
            known = (*FUNCTIONS, *self.functions)
            message = f"calls {name} with {len(args)} arguments. Give it {own.counts[0]}." if own else ""
            raise ModelError(message or f"calls the unknown function {quote(name)}. {suggest(name, known)}")
        return _called(name, args)


def _called(name: str, args: list[Expression]) -> Expression:
    function = REGISTRY[name]
    if name in ("min", "max") and len(args) > 1:
        result = args[0]
        for arg in args[1:]:
            result = call(name, result, arg)
        return result
    if len(args) not in function.counts:
        message = f"calls {name} with {len(args)} arguments. Give it {function.counts[0]}."
        raise ModelError(message)
    return Call(function, tuple(args))


class Token(NamedTuple):
    """A piece of a formula: its kind (number, entry, name, quoted name, sign or end) and its position."""

    kind: str
    text: str
    start: int
    end: int


def tokens(text: str) -> list[Token]:
    """Return the pieces of a formula, the last of kind ``end``.

    Raises
    ------
    ModelError
        If there is a sign that no formula has.
    """
    if len(text) > LONGEST:
        raise ModelError(f"holds a formula of more than {LONGEST} characters. Split it into parameters.")
    found, at = [], _spaced(text, 0)
    while at < len(text):
        match = TOKEN.match(text, at)
        if match is None:
            raise ModelError(f"holds {quote(text[at])}, which no formula has. Check {quote(text)}.")
        found.append(Token(str(match.lastgroup), match[str(match.lastgroup)], at, match.end()))
        at = _spaced(text, match.end())
    return [*found, Token("end", "", at, at)]


def _spaced(text: str, at: int) -> int:
    space = SPACE.match(text, at)
    return space.end() if space else at
