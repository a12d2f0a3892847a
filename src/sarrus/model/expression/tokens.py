"""The words and signs of a formula."""

from __future__ import annotations

import re
from typing import NamedTuple

from ..errors import ModelError
from ..show import quote

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
