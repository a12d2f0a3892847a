"""JSON text to a document, with line numbers, which the standard reader does not give."""

from __future__ import annotations

import json
import re
from bisect import bisect_right

from ...checks.findings import Origin, Path
from .document import Document, refusal, refuse_deep, refuse_repeated

TOKEN = re.compile(r'"(?:[^"\\\n]|\\.)*"|[\[\]{},:]|[^\s\[\]{},:"]+')


def read_json(text: str, file: str) -> Document:
    """Return the document of a JSON text. NaN and Infinity, which are no JSON, are left to the check of the number.

    Raises
    ------
    ModelError
        If the text is not JSON, nests too deep, or repeats a key.
    """
    try:
        data = json.loads(text, parse_int=float)
    except json.JSONDecodeError as error:
        reason = error.msg[:1].lower() + error.msg[1:].removesuffix(" at")
        message = f"is not valid JSON, {reason}. Check commas, quotes and brackets."
        raise refusal(message, file, error.lineno) from None
    except RecursionError:
        data = None  # its depth is refused below
    return Document(data, Origin(file, _lines_of_entries(text, file)))


def _lines_of_entries(text: str, file: str) -> dict[Path, int]:
    """Return the line of every entry of a valid text, with its depth and keys checked."""
    breaks = [match.start() for match in re.finditer("\n", text)]
    lines: dict[Path, int] = {}
    steps: list[str | int] = []  # a key or an index in each open bracket
    before_key = False
    for token in TOKEN.finditer(text):
        sign, line, path = token[0], bisect_right(breaks, token.start()) + 1, tuple(steps)
        if sign == "," and steps:
            before_key = isinstance(steps[-1], str)
            steps[-1] = "" if isinstance(steps[-1], str) else steps[-1] + 1
        elif sign in "]}":
            steps = steps[:-1]
        elif before_key and sign[0] == '"':
            key = str(json.loads(sign))
            refuse_repeated(key, lines.get((*path[:-1], key)), file, line, path[:-1])
            steps[-1], before_key = key, False
            lines[*path[:-1], key] = line
        elif sign not in ",:":
            lines.setdefault(path, line)
            refuse_deep(len(path), file, line, path)
            before_key = sign == "{"
            steps += [""] if sign == "{" else [0] if sign == "[" else []
    return lines
