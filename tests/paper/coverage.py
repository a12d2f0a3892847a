"""The paper's numbered equations, where each is in Sarrus, and which test verifies it: makes `docs/equations.md`.

    python -m tests.paper.coverage

Nothing is listed by hand but `FOLLOWS`: the tests name their equations (`test_eq_082_...`), the formulas carry theirs
in a comment or docstring ("Eq. (82)", "Eqs. (64)-(72)").
"""

import ast
import io
import re
import sys
import tokenize
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SOURCE, PAGE = ROOT / "src" / "sarrus", ROOT / "docs" / "equations.md"
NUMBERS = range(9, 117)
FORMULAS = ("algebra.py", "euler.py", "elements/**/*.py", "model/joints/*.py")

# Not contained in Sarrus, because they follow from other equations.
FOLLOWS = {
    27: "equal to (88) on unit p",
    37: "from (36) by (18)",
    41: "`gamma` is its negative, from (38)",
    42: "`gamma_v` is its negative, from (38)",
    49: "`gamma_q` is its negative",
    50: "`gamma_v` is its negative, from (47)",
    84: "`gamma_q` is its negative, from (83)",
    85: "`gamma_v` is its negative, from (82)",
    87: "equal to (88) on unit p",
    92: "`gamma_q` is its negative, from (91)",
    93: "`gamma_v` is its negative, from (90)",
    101: "`gamma_q` is its negative, from (100)",
    102: "`gamma_v` is its negative, from (99)",
}

HEAD = """# The paper's equations

This page lists the equations 9 to 116 of R. Serban and E. J. Haug, *Analytical Derivatives for Multibody System
Analyses*, each with its place in Sarrus and its test. The test compares the printed equation or, if that is wrong, the
[corrected one](errata.md), with an independent value: in exact fractions, or with 70 digits for roots and angles.

* **coded**: a formula of Sarrus is this equation; the files are in `src/sarrus`;
* **follows**: Sarrus does not contain the equation, because it follows from others;
* **test only**: a step of the paper's derivation, or a definition, that the tests use.

The tests are in `tests/paper`. `python -m tests.paper.coverage` generates this page from them and from the sources.
"""


def mentioned(text: str) -> Iterator[int]:
    """Equation numbers in a text: "Eq. (5)", "Eqs. (29), (34)-(44)"."""
    for found in re.findall(r"Eqs?\.\s((?:\(\d+\)(?:-|,\s|\sand\s)?)+)", text):
        for first, last in re.findall(r"\((\d+)\)(?:-\((\d+)\))?", found):
            yield from range(int(first), int(last or first) + 1)


def notes(file: Path) -> Iterator[str]:
    """Comments, and docstrings of classes and functions; of a joint also that of its file."""
    text = file.read_text(encoding="utf-8")
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            yield token.string
    whole_file = (ast.Module,) if file.parent.name == "joints" else ()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.FunctionDef, ast.ClassDef, *whole_file)):
            yield ast.get_docstring(node) or ""


def coded() -> dict[int, list[str]]:
    """Equation number -> files in which a formula carries it."""
    files: dict[int, list[str]] = {}
    for pattern in FORMULAS:
        for file in sorted(SOURCE.glob(pattern)):
            for number in sorted({n for note in notes(file) for n in mentioned(note)}):
                files.setdefault(number, []).append(file.relative_to(SOURCE).as_posix())
    return files


def find_tests() -> dict[int, tuple[str, str, str]]:
    """Equation number -> file of its test, the test's name and what it says the equation is."""
    found: dict[int, tuple[str, str, str]] = {}
    for file in sorted(Path(__file__).parent.glob("test_*.py")):
        for node in ast.parse(file.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.FunctionDef) and (match := re.match(r"test_eq((?:_\d{3})+)_", node.name)):
                what = (ast.get_docstring(node) or "").split("\n")[0].removesuffix(".")
                for number in match[1].split("_")[1:]:
                    if int(number) in found:
                        raise ValueError(
                            f"Eq. ({int(number)}) has two tests: {found[int(number)][1]} and {node.name}"
                        )
                    found[int(number)] = (file.name, node.name, what)
    return found


def status(number: int, files: dict[int, list[str]]) -> str:
    """Coded, follows or test only, and where or from what."""
    elsewhere = [file for file in files.get(number, []) if file != "elements/follows.py"]
    if number in FOLLOWS:
        return f"follows: {FOLLOWS[number]}"
    if elsewhere:
        return "coded in " + ", ".join(f"`{file}`" for file in elsewhere)
    return "follows, in `elements/follows.py`" if number in files else "test only"


def page() -> str:
    """The page as it should be."""
    files, checks = coded(), find_tests()
    states = {number: status(number, files) for number in NUMBERS}
    lines, section = [HEAD], ""
    counts = {
        word: sum(s.startswith(word) for s in states.values()) for word in ("coded", "follows", "test only")
    }
    lines.append(
        f"{len(NUMBERS)} equations: " + ", ".join(f"{n} {word}" for word, n in counts.items()) + ".\n"
    )
    for number in NUMBERS:
        file, name, what = checks[number]
        if file != section:
            section = file
            lines += [
                f"\n## {_title(file)}\n",
                "| Eq. | content | in Sarrus | test |",
                "|---|---|---|---|",
            ]
        lines.append(f"| {number} | {what.replace('|', chr(92) + '|')} | {states[number]} | `{name}` |")
    return "\n".join(lines) + "\n"


def _title(file: str) -> str:
    text = ast.get_docstring(ast.parse((Path(__file__).parent / file).read_text(encoding="utf-8"))) or ""
    title = text.split(", Eqs.")[0].split(": ", 1)[1]
    return f"{title[0].upper()}{title[1:]} (`{file}`)"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    sys.stdout.write(f"wrote {PAGE}\n")
