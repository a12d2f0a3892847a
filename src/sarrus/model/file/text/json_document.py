"""JSON text to a document, with line numbers, which the standard reader does not give."""

from __future__ import annotations

import re
from bisect import bisect_right
from json import JSONDecodeError
from json.decoder import scanstring  # type: ignore[attr-defined]
from typing import Any

from ...checks.findings import Origin, Path
from .document import Document, refusal, refuse_deep, refuse_repeated

SPACE = re.compile(r"[ \t\r\n]*")
NUMBER = re.compile(r"-?(0|[1-9][0-9]*)(\.[0-9]+)?([eE][-+]?[0-9]+)?(?![0-9A-Za-z_.])")
WORD = re.compile(r"-?[A-Za-z]+")
# NaN and Infinity are no JSON; they are read so that the check of the number can name its part.
WORDS = {
    "null": None,
    "true": True,
    "false": False,
    "NaN": float("nan"),
    "Infinity": float("inf"),
    "-Infinity": float("-inf"),
}


def read_json(text: str, file: str) -> Document:
    """Return the document of a JSON text.

    Raises
    ------
    ModelError
        If the text is not JSON, nests too deep, or repeats a key.
    """
    return _Reader(text, file).document()


class _Reader:
    """A recursive reader; ``at`` is the place in the text."""

    def __init__(self, text: str, file: str) -> None:
        self.text = text
        self.file = file
        self.at = 0
        self.lines: dict[Path, int] = {}
        self.breaks = [match.start() for match in re.finditer("\n", text)]

    def document(self) -> Document:
        data = self._value(())
        if self._peek():
            raise self._invalid("something follows the end of the model")
        return Document(data, Origin(self.file, self.lines))

    def _value(self, path: Path) -> Any:
        start = self._peek()
        self.lines.setdefault(path, self._line())
        refuse_deep(len(path), self.file, self._line(), path)
        if start == "{":
            return self._mapping(path)
        if start == "[":
            return self._sequence(path)
        return self._string() if start == '"' else self._word()

    def _mapping(self, path: Path) -> dict[str, Any]:
        values: dict[str, Any] = {}
        self.at += 1
        while not self._closes("}", first=not values):
            self._peek()
            line, key = self._line(), self._string()
            refuse_repeated(key, self.lines.get((*path, key)), self.file, line, path)
            self.lines[(*path, key)] = line
            self._expect(":")
            values[key] = self._value((*path, key))
        return values

    def _sequence(self, path: Path) -> list[Any]:
        values: list[Any] = []
        self.at += 1
        while not self._closes("]", first=not values):
            values.append(self._value((*path, len(values))))
        return values

    def _closes(self, bracket: str, first: bool) -> bool:
        """Step over the closing bracket, or over the comma between two entries."""
        if self._peek() == bracket:
            self.at += 1
            return True
        if not first:
            self._expect(",")
        return False

    def _expect(self, sign: str) -> None:
        if self._peek() != sign:
            raise self._invalid(f'a "{sign}" is missing')
        self.at += 1

    def _string(self) -> str:
        if self._peek() != '"':
            raise self._invalid("a text in double quotes is missing")
        try:
            text, self.at = scanstring(self.text, self.at + 1, True)
        except JSONDecodeError as error:
            raise self._invalid(error.msg[:1].lower() + error.msg[1:].removesuffix(" at")) from None
        return str(text)

    def _word(self) -> float | bool | None:
        if number := NUMBER.match(self.text, self.at):
            self.at = number.end()
            return float(number[0])
        word = WORD.match(self.text, self.at)
        if word is None or word[0] not in WORDS:
            raise self._invalid("a value is missing or not valid")
        self.at = word.end()
        return WORDS[word[0]]

    def _peek(self) -> str:
        space = SPACE.match(self.text, self.at)
        self.at = space.end() if space else self.at
        return self.text[self.at : self.at + 1]

    def _line(self) -> int:
        return bisect_right(self.breaks, self.at) + 1

    def _invalid(self, reason: str) -> Exception:
        message = f"is not valid JSON, {reason}. Check commas, quotes and brackets."
        return refusal(message, self.file, self._line())
