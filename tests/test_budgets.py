"""Budgets of size for every floor of the house: they may fall, and are raised only with a decision.

python -m tests.test_budgets      # prints what stands today, to be pasted below
"""

import ast
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parents[1] / "src" / "sarrus"
LARGE = 8  # positional parameters of a function; more belong into a NamedTuple
ROOM = 1.02  # a budget that is larger than this times what is found has to fall


class Size(NamedTuple):
    """Lines that hold code, files, module constants that are numbers, functions with too many parameters."""

    lines: int
    files: int
    numbers: int
    large: int


BUDGETS = {
    ".": Size(282, 12, 2, 0),
    "_jit": Size(2230, 36, 19, 1),
    "analyses": Size(319, 5, 4, 0),
    "analyses/driven": Size(853, 6, 25, 0),
    "analyses/dynamics": Size(6856, 68, 168, 4),
    "analyses/equations": Size(1242, 13, 17, 0),
    "analyses/equilibria": Size(1312, 10, 21, 5),
    "analyses/forward": Size(1040, 13, 2, 7),
    "analyses/optimization": Size(1437, 11, 28, 0),
    "analyses/position": Size(1242, 12, 28, 0),
    "analyses/redundancy": Size(348, 4, 10, 0),
    "analyses/sensitivity": Size(7122, 67, 54, 12),
    "analyses/workspace": Size(3433, 32, 66, 0),
    "bridges": Size(158, 5, 0, 0),
    "cli": Size(1513, 28, 11, 0),
    "elements": Size(2766, 59, 14, 0),
    "io": Size(5764, 65, 28, 0),
    "linalg": Size(1509, 16, 24, 0),
    "mechanisms": Size(10, 1, 0, 0),
    "model": Size(11750, 136, 61, 0),
    "outputs": Size(1322, 15, 1, 2),
    "results": Size(2518, 38, 12, 0),
    "studies": Size(1799, 15, 12, 0),
    "system": Size(1951, 24, 24, 1),
    "vehicles": Size(1847, 17, 18, 0),
    "views": Size(3084, 37, 47, 0),
}

WITH_DOCSTRING = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


def code_lines(text: str, tree: ast.Module) -> int:
    """Lines that are not blank and no comment, docstring or import."""
    without = set[int]()
    for node in ast.walk(tree):
        if isinstance(node, WITH_DOCSTRING) and ast.get_docstring(node, clean=False) is not None:
            without |= lines_of(node.body[0])
        elif isinstance(node, ast.Import | ast.ImportFrom):
            without |= lines_of(node)
    lines = enumerate(text.split("\n"), 1)
    return sum(n not in without and bool(line.strip()) and line.lstrip()[0] != "#" for n, line in lines)


def lines_of(node: ast.stmt) -> set[int]:
    return set(range(node.lineno, (node.end_lineno or node.lineno) + 1))


def is_number(value: ast.expr | None) -> bool:
    """Whether an expression is a number, or arithmetic of numbers."""
    if isinstance(value, ast.BinOp):
        return is_number(value.left) and is_number(value.right)
    if isinstance(value, ast.UnaryOp):
        return is_number(value.operand)
    return isinstance(value, ast.Constant) and type(value.value) in (int, float)


def numbers_of(tree: ast.Module) -> Iterator[str]:
    """Names at the top of a module whose values are numbers, also several in one statement."""
    for node in tree.body:
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        for target in targets:
            value = getattr(node, "value", None)
            both = isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple)
            pairs = zip(target.elts, value.elts, strict=False) if both else [(target, value)]
            yield from (one.id for one, what in pairs if isinstance(one, ast.Name) and is_number(what))


def is_large(node: ast.AST) -> bool:
    if not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
        return False
    names = [argument.arg for argument in (*node.args.posonlyargs, *node.args.args)]
    return len(names) - (names[:1] in (["self"], ["cls"])) > LARGE


def floor_of(path: Path) -> str:
    """The top folder; of analyses, the folder below."""
    folders = path.relative_to(ROOT).parts[:-1]
    return "/".join(folders[: 2 if folders[:1] == ("analyses",) else 1]) or "."


def found() -> dict[str, Size]:
    """What stands today, by floor."""
    sizes: dict[str, Size] = defaultdict(lambda: Size(0, 0, 0, 0))
    for path in sorted(ROOT.rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        tree = ast.parse(text)
        large = sum(map(is_large, ast.walk(tree)))
        one = Size(code_lines(text, tree), 1, len([*numbers_of(tree)]), large)
        sizes[floor_of(path)] = Size(*map(sum, zip(sizes[floor_of(path)], one, strict=True)))
    return dict(sizes)


FOUND = found()


@pytest.mark.parametrize("floor", sorted({*FOUND, *BUDGETS}))
def test_budgets(floor: str) -> None:
    """No floor grows, and no budget stays behind a floor that has shrunk."""
    size, budget = FOUND.get(floor, Size(0, 0, 0, 0)), BUDGETS.get(floor, Size(0, 0, 0, 0))
    for what, have, may in zip(Size._fields, size, budget, strict=True):
        assert have <= may, (
            f"{floor}: {have} {what}, budget {may}. Remove some, or name a decision in docs/decisions."
        )
        assert may <= max(ROOM * have, have + 1), f"{floor}: {have} {what}, budget {may}. Lower the budget."


def test_what_is_counted() -> None:
    """Neither blank lines, comments, docstrings nor imports; numbers also where several have one line."""
    code = ["A, B = 1e-3, -2  # both", "C: float = 2 * 3.0", "D = True", "E = A"]
    text = "\n".join(['"""Text."""', "import a", "", "# no code", *code, 'F = """x', "", 'y"""'])
    tree = ast.parse(text)
    assert (code_lines(text, tree), [*numbers_of(tree)]) == (6, ["A", "B", "C"])
    eight = "a, b, c, d, e, f, g, h"
    functions = ast.parse(
        "\n".join(f"def x({names}): ..." for names in (eight, f"self, {eight}", f"{eight}, i"))
    )
    assert [is_large(node) for node in functions.body] == [False, False, True]


if __name__ == "__main__":
    for floor, size in sorted(FOUND.items()):
        print(f'    "{floor}": Size({", ".join(map(str, size))}),')
    print("#", Size(*map(sum, zip(*FOUND.values(), strict=True))))
