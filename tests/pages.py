"""Run the code of a page of the documentation and compare what it prints with what the page shows.

Blocks of a page in Markdown:

- ``python``: run in order, in one namespace; ``py`` marks fragments that are not run;
- ``console``: lines that begin with ``$ sarrus`` are run, and their output is compared with the lines below them;
- ``yaml`` that begins with ``# name.yaml``: written to this file;
- ``text``: printed output of the Python since the previous ``text`` block. `...` at the end of a line stands for its
  rest, and a line `...` for any lines.
"""

from __future__ import annotations

import contextlib
import io
import re
import shlex
from collections.abc import Iterator
from pathlib import Path

from sarrus.cli import main

BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.DOTALL | re.MULTILINE)
NAMED = re.compile(r"# (\w+\.yaml)\n")
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
NEAR = 1e-4  # relative: other machines round differently
ROUND_OFF = 1e-12


def blocks(text: str, language: str) -> list[str]:
    """The code blocks of one language."""
    return [code for kind, code in BLOCK.findall(text) if kind == language]


def execute(page: Path, replaced: dict[str, str] | None = None) -> dict[str, object]:
    """Run a page, compare its outputs, and return the namespace; `replaced` makes its code quicker."""
    names: dict[str, object] = {"__name__": "__main__"}
    output = ""
    for language, code in BLOCK.findall(page.read_text(encoding="utf-8")):
        if language == "python":
            for old, new in (replaced or {}).items():
                code = code.replace(old, new)
            output += captured(lambda code=code: exec(compile(code, page.name, "exec"), names))
        elif language == "yaml" and (file := NAMED.match(code)):
            Path(file[1]).write_text(code, encoding="utf-8")
        elif language == "text":
            compare(code, output)
            output = ""
        elif language == "console":
            for command, expected in commands(code):
                compare(expected, captured(lambda command=command: main(shlex.split(command)[1:])))
    return names


def captured(action) -> str:  # type: ignore[no-untyped-def]
    """What an action prints."""
    with contextlib.redirect_stdout(io.StringIO()) as stream:
        action()
    return stream.getvalue()


def commands(code: str) -> Iterator[tuple[str, str]]:
    """The commands of a console block, with the output below each."""
    for part in re.split(r"^\$ ", code, flags=re.MULTILINE)[1:]:
        command, _, expected = part.partition("\n")
        yield command, expected


def compare(expected: str, output: str) -> None:
    """Fail unless the expected lines appear in the output, in this order."""
    lines = iter(output.splitlines())
    for line in expected.splitlines():
        if line.strip() and line.strip() != "...":
            assert any(same(line, found) for found in lines), f"not printed in this order: {line}\n\n{output}"


def same(line: str, found: str) -> bool:
    """Whether two lines have the same words, and the same numbers to within rounding."""
    line = line.rstrip()
    if line.endswith("..."):
        line = line[:-3].rstrip()
        words, numbers = parts(line)
        text, values = parts(found)
        return text.startswith(words) and near(numbers, values[: len(numbers)])
    words, numbers = parts(line)
    text, values = parts(found)
    return words == text and near(numbers, values)


def parts(line: str) -> tuple[str, list[float]]:
    """A line without its numbers and spaces, and its numbers."""
    return re.sub(r"\s+", " ", NUMBER.sub("#", line)).strip(), [float(x) for x in NUMBER.findall(line)]


def near(numbers: list[float], values: list[float]) -> bool:
    return len(numbers) == len(values) and all(
        abs(a - b) <= max(ROUND_OFF, NEAR * abs(a)) for a, b in zip(numbers, values, strict=True)
    )
