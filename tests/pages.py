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
from pathlib import Path

from sarrus.cli import main

BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.DOTALL | re.MULTILINE)
COMMAND = re.compile(r"^(\$ (.*)\n)((?:(?!\$ ).*\n)*)", re.MULTILINE)
NAMED = re.compile(r"# (\w+\.yaml)\n")
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
NEAR = 1e-4  # relative: other machines round differently
ROUND_OFF = 5e-12  # residuals of constraints, too


def blocks(text: str, language: str) -> list[str]:
    """The code blocks of one language."""
    return [code for kind, code in BLOCK.findall(text) if kind == language]


def has_code(page: Path) -> bool:
    """Whether a page has code that is run."""
    text = page.read_text(encoding="utf-8")
    return bool(blocks(text, "python") or any(code.startswith("$ ") for code in blocks(text, "console")))


def executed(page: Path, replaced: dict[str, str] | None = None) -> tuple[str, dict[str, object]]:
    """Run a page; its text with the lines that were printed, and the namespace. `replaced` makes its code quicker.

    Raises
    ------
    AssertionError
        If a line of the page is not printed.
    """
    names: dict[str, object] = {"__name__": "__main__"}
    output = ""

    def block(found: re.Match[str]) -> str:
        nonlocal output
        language, code = found.groups()
        if language == "python":
            for old, new in (replaced or {}).items():
                code = code.replace(old, new)
            output += captured(lambda: exec(compile(code, page.name, "exec"), names))
        elif language == "yaml" and (file := NAMED.match(code)):
            Path(file[1]).write_text(code, encoding="utf-8")
        elif language == "text":
            code, output = printed(code, output), ""
        elif language == "console":
            code = re.sub(COMMAND, lambda one: one[1] + printed(one[3], called(one[2])), code)
        return found[0] if language != "text" and language != "console" else f"```{language}\n{code}```"

    return BLOCK.sub(block, page.read_text(encoding="utf-8")), names


def called(command: str) -> str:
    """What a command of the shell prints."""
    return captured(lambda: main(shlex.split(command)[1:]))


def captured(action) -> str:  # type: ignore[no-untyped-def]
    """What an action prints."""
    with contextlib.redirect_stdout(io.StringIO()) as stream:
        action()
    return stream.getvalue()


def printed(expected: str, output: str) -> str:
    """The expected lines as they appear in the output, in this order; an assertion fails unless they do."""
    lines, shown = iter(output.splitlines()), list[str]()
    for line in expected.splitlines():
        if not line.strip() or line.strip() == "...":
            shown.append(line)
            continue
        found = next((one for one in lines if same(line, one)), None)
        assert found is not None, f"not printed in this order: {line}\n\n{output}"
        shown.append(begun(found, line.rstrip()) if line.rstrip().endswith("...") else found)
    return "".join(f"{line}\n" for line in shown)


def begun(line: str, expected: str) -> str:
    """As much of a line as is expected, which ends with three dots: so many words, or characters of the last word."""
    if not expected.endswith(" ..."):
        return f"{line[: len(expected) - 3]}..."
    words = re.findall(r"\s*\S+", line)[: len(expected.split()) - 1]
    return f"{''.join(words)} ..."


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
