"""Formulas with one term deleted, put in place of the right ones for a moment.

A mutant is one change to the source of a function in `sarrus.euler`, `sarrus.algebra` or an element file: one operand
of a sum or difference left out; one minus sign, one factor 2, 3, 4 or 8, or one transpose dropped; or a field of body i
taken for that of body j. It is applied by exchanging the function's code object, so that nothing is imported anew, and
taken back after the checks.
"""

import ast
import copy
import importlib
import inspect
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import CodeType, FunctionType

from tests.elements.checks import all_checks

import sarrus
from sarrus.elements import BUILT_IN
from sarrus.elements.derived import recipe_of

PACKAGE = Path(sarrus.__file__).parent
NO_FORMULAS = {
    "__init__",
    "curve",
    "element",
    "evaluation",
    "operators",
    "recorder",
}  # of the elements' folder
FACTORS = (2, 3, 4, 8)
# h_i·s_i is a constant of the displacement, and the inertia depends on its derivatives only
EQUIVALENT = {("DisplacementInertia.coordinate", "self.s_i -> self.s_j")}
OTHER_BODY = {f"{x}_{i}": f"{x}_{j}" for x in "rpasfh" for i, j in ("ij", "ji")}


@dataclass(frozen=True)
class Mutant:
    """One change: where it is and what it does to the line."""

    module: str
    function: str
    line: int
    change: str
    code: Callable[[], CodeType]  # compiles the changed module

    def __str__(self) -> str:
        return f"{self.module}:{self.line} {self.function}: {self.change}"


def modules() -> list[str]:
    """Names of the modules that hold formulas."""
    files = [path for path in sorted((PACKAGE / "elements").rglob("*.py")) if path.stem not in NO_FORMULAS]
    names = [".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts) for path in files]
    return ["sarrus.algebra", "sarrus.euler", *names]


def mutants(name: str) -> Iterator[Mutant]:
    """All mutants of a module."""
    file = inspect.getfile(importlib.import_module(name))
    tree = ast.parse(Path(file).read_text(encoding="utf-8"))
    for function, node in _functions(tree):
        for place, inner in enumerate(ast.walk(node)):
            for n, replacement in enumerate(_changes(inner)):
                code = partial(_compiled, tree, node, place, n, function, file)
                change = f"{ast.unparse(inner)} -> {ast.unparse(replacement)}"
                if (function, change) not in EQUIVALENT:
                    yield Mutant(name, function, inner.lineno, change, code)


def _functions(tree: ast.Module) -> Iterator[tuple[str, ast.FunctionDef]]:
    for node in tree.body:
        if isinstance(node, ast.FunctionDef):
            yield node.name, node
        elif isinstance(node, ast.ClassDef):
            yield from ((f"{node.name}.{m.name}", m) for m in node.body if isinstance(m, ast.FunctionDef))


def _changes(node: ast.AST) -> list[ast.expr]:
    """What may stand in the place of an expression."""
    match node:
        case ast.BinOp(left, ast.Add(), right):
            return [left, right]
        case ast.BinOp(left, ast.Sub(), right):
            return [left, ast.UnaryOp(ast.USub(), right)]
        case ast.BinOp(ast.Constant(value), ast.Mult(), right) if value in FACTORS:
            return [right]
        case ast.BinOp(left, ast.Mult(), ast.Constant(value)) if value in FACTORS and not isinstance(
            left, ast.Tuple
        ):
            return [left]
        case ast.UnaryOp(ast.USub(), operand):
            return [operand]
        case ast.Attribute(value, "T"):
            return [value]
        case ast.Attribute(value, name, context) if name in OTHER_BODY:
            return [ast.Attribute(value, OTHER_BODY[name], context)]
    return []


def _replaced(tree: ast.Module, function: ast.FunctionDef, place: int, n: int) -> ast.Module:
    """A copy of a module with the expression at a place of a function changed."""
    body = list(ast.walk(tree)).index(function)
    changed = copy.deepcopy(tree)
    target = list(ast.walk(list(ast.walk(changed))[body]))[place]
    replacement = ast.copy_location(_changes(target)[n], target)

    class Exchange(ast.NodeTransformer):
        def visit(self, node: ast.AST) -> ast.AST:
            return replacement if node is target else self.generic_visit(node)

    return ast.fix_missing_locations(Exchange().visit(changed))


def _compiled(
    tree: ast.Module, node: ast.FunctionDef, place: int, n: int, function: str, file: str
) -> CodeType:
    code = compile(_replaced(tree, node, place, n), file, "exec")
    for name in function.split("."):
        code = next(c for c in code.co_consts if isinstance(c, CodeType) and c.co_name == name)
    return code


@contextmanager
def applied(mutant: Mutant) -> Iterator[None]:
    """The mutant in the place of the right function."""
    function = _function(mutant)
    right = function.__code__
    function.__code__ = mutant.code()
    recipe_of.cache_clear()  # or what was differentiated before would be used
    try:
        yield
    finally:
        function.__code__ = right
        recipe_of.cache_clear()


def _function(mutant: Mutant) -> FunctionType:
    owner = importlib.import_module(mutant.module)
    for name in mutant.function.split("."):
        owner = inspect.getattr_static(owner, name)
    return getattr(owner, "__func__", owner)


def killer(mutant: Mutant) -> str | None:
    """The check that notices a mutant, and how; those of the elements in its own file are asked first."""
    near = {kind for kind in BUILT_IN if kind.__module__ == mutant.module}
    checks = sorted(CHECKS, key=lambda c: (c.kind not in near, not mutant.function.endswith(c.name)))
    with applied(mutant):
        for check in checks:
            try:
                check.run()
            except AssertionError:
                return f"{check.name}: wrong number"
            except Exception as error:
                return f"{check.name}: {type(error).__name__}"
    return None


CHECKS = all_checks(quick=True)
