"""The linker: globals are resolved by imports, and no module waits to be filled."""

from __future__ import annotations

import ast
import dis
import importlib
import pkgutil
import re
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FunctionType
from typing import Any

import numpy as np
import pytest

import sarrus
from sarrus._jit.kernels.scalars import Scalars
from sarrus._jit.linking.link import _arguments, compiled, fingerprint, link, marked

SOURCES = Path(sarrus.__file__).parent
FACTOR = 2.0


@compiled
def scale(x: Any) -> Any:
    """Called by two others."""
    return FACTOR * x


@compiled
def shift(x: Any) -> Any:
    """Calls nothing."""
    return x + 1.0


@compiled(entry=True)
def both(x: Any) -> Any:
    """Calls two others."""
    return scale(x) + shift(x)


@compiled(entry=True)
def above(x: Any) -> Any:
    """Calls the one that calls them."""
    return both(x) + scale(x)


def test_a_linked_function_does_what_the_plain_one_does() -> None:
    assert link(above)(3.0) == above(3.0) == 16.0


def test_functions_share_what_they_call() -> None:
    own, others = link(above).py_func.__globals__, link(both).py_func.__globals__  # type: ignore[attr-defined]
    assert own["scale"] is others["scale"]
    assert own["both"] is link(both)
    assert own["scale"] is not link(scale)  # which Python can call


def test_a_fingerprint_depends_on_constants_of_what_is_called(monkeypatch: pytest.MonkeyPatch) -> None:
    before = fingerprint(above), fingerprint(shift)
    monkeypatch.setattr("test_link.FACTOR" if __name__ == "test_link" else f"{__name__}.FACTOR", 3.0)
    assert fingerprint(above) != before[0]
    assert fingerprint(shift) == before[1]


def made(source: str, **scope: Any) -> Callable[..., Any]:
    """A marked function of a source, with these globals."""
    found = dict(scope)
    exec(source, found)
    function = next(
        f for f in found.values() if isinstance(f, FunctionType) and f.__code__.co_filename == "<string>"
    )
    return compiled(function)


def test_documentation_and_annotations_do_not_matter_but_code_and_kinds_of_constants_do() -> None:
    names = [
        fingerprint(made(source, C=1.0, __name__="m"))
        for source in (
            'def f(x):\n    "Short."\n    return C * x',
            'def f(x: float) -> float:\n\n    "Another text."\n    return C * x',
            "def f(x):\n    return C * x * 1.0",
        )
    ]
    assert names[0] == names[1] != names[2]
    source = "def f(x):\n    return C * x"
    kinds = (1, 1.0, True, np.uint64(1), (1,))
    assert len({fingerprint(made(source, C=kind, __name__="m")) for kind in kinds}) == len(kinds)


@pytest.mark.parametrize(
    ("source", "scope", "message"),
    [
        (
            "def f(x):\n    return g(x)",
            {"g": lambda x: x},
            "g is neither a compiled function nor a constant. Mark",
        ),
        ("def f(x):\n    return g + x", {"g": np.ones(1)}, "g is neither a compiled function nor a constant"),
        (
            "def f(x):\n    return g.FACTOR * x",
            {"g": sarrus},
            "g is neither a compiled function nor a constant",
        ),
        ("def f(x):\n    return g(x)", {}, "g is not defined. Import it"),
        ("def f(x):\n    return f(x - 1)", {}, "in a circle: f → f"),
    ],
)
def test_what_cannot_be_linked_is_refused(source: str, scope: dict[str, Any], message: str) -> None:
    wrong = made(source, **scope, __name__="m")
    for _ in range(2):  # the same message each time
        with pytest.raises(TypeError, match=message):
            link(wrong)


def test_what_a_name_refers_to_when_it_is_linked_is_called() -> None:
    """As in a notebook, whose cells are executed again."""
    scope: dict[str, Any] = {"__name__": "m"}

    def cell(source: str, name: str) -> Any:
        exec(source, scope)
        return compiled(scope[name])

    cell("def g(x):\n    return x + 1.0", "g")
    cell("def f(x):\n    return 2.0 * g(x)", "f")
    assert link(cell("def first(x):\n    return f(x)", "first"))(3.0) == 8.0
    cell("def g(x):\n    return x - 1.0", "g")
    outer = cell("def h(x):\n    return f(x)", "h")
    assert link(outer)(3.0) == outer(3.0) == 4.0


def test_an_unmarked_function_is_refused() -> None:
    with pytest.raises(TypeError, match=r"cannot be linked\. Mark it"):
        link(made)


@compiled
def same(x: Any) -> Any:
    """An argument, without counting references."""
    return x


@compiled
def halves(x: Any) -> Any:
    """Parts of an array; Numba itself refuses one that is not in a tuple."""
    return x[: len(x) // 2], x[len(x) // 2 :]


@compiled(entry=True)
def doubled(x: Any) -> Any:
    """A new array."""
    return 2.0 * x


@compiled
def sum_of_first_half(x: Any) -> Any:
    """A number from a part, which stays among functions without counts."""
    return halves(x)[0].sum()


@compiled
def sum_of_doubled(x: Any) -> Any:
    """Would never release what `doubled` returns."""
    return doubled(x)[0]


@compiled(entry=True)
def calls_same(x: Any) -> Any:
    """Would release memory that it does not own."""
    return same(x)[0]


@compiled(entry=True)
def calls_halves(x: Any) -> Any:
    """The same, in a tuple."""
    return halves(x)[1][0]


@compiled(entry=True)
def calls_leak(x: Any) -> Any:
    """The other way round."""
    return sum_of_doubled(x)


@compiled(entry=True)
def calls_numbers(x: Any) -> Any:
    """What is allowed."""
    return sum_of_first_half(x) + doubled(x)[0]


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (calls_same, "same: calls_same counts references, and would release the array"),
        (calls_halves, "halves: calls_halves counts references, and would release the array"),
        (halves, "halves: Python counts references, and would release the array"),
        (calls_leak, "doubled: sum_of_doubled counts no references, and would never release the array"),
    ],
)
def test_arrays_are_not_returned_across_reference_counts(function: Callable[..., Any], message: str) -> None:
    """Memory was freed that was in use, and nothing showed it."""
    with pytest.raises(TypeError, match=rf"{message} that .* returns\. Let .* write into an argument"):
        link(function)(np.ones(4))
    assert link(calls_numbers)(np.ones(4)) == calls_numbers(np.ones(4)) == 4.0


def test_a_function_that_uses_variables_of_another_is_refused() -> None:
    factor = 2.0

    @compiled
    def inner(x: float) -> float:
        return factor * x

    with pytest.raises(TypeError, match="inner uses factor of an enclosing function"):
        link(inner)


def test_threads_link_one_function() -> None:
    fresh, found, ready = made("def f(x):\n    return x + 4.5", __name__="m"), [], threading.Barrier(4)

    def work() -> None:
        ready.wait()
        found.append((link(fresh), link(fresh)(1.0)))

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len({id(function) for function, _ in found}) == 1
    assert [value for _, value in found] == [5.5] * 4


class Control(Scalars):
    """Scalars of a loop."""

    t: float
    steps: int
    ready: bool


@compiled(entry=True)
def advance(control: Control, h: float) -> None:
    """One step."""
    control.t += h
    control.steps += 1
    control.ready = control.t > 0.4


def test_scalars_have_one_memory_in_python_and_compiled_code() -> None:
    control, plain = Control.zeros(), Control.zeros()
    for _ in range(2):
        link(advance)(control, 0.25)
        advance(plain, 0.25)
    assert (control.t, control.steps, control.ready) == (plain.t, plain.steps, plain.ready) == (0.5, 2, True)
    plain.clear()
    assert plain.as_array().tolist() == [0.0, 0.0, 0.0]
    plain.assign(control.as_array())
    assert plain == control
    with pytest.raises(TypeError, match="size is a name of NumPy's records"):
        type("Wrong", (Scalars,), {"__annotations__": {"size": float}})


def test_everything_that_compiled_functions_of_the_package_name_is_compiled_too() -> None:
    """Without compiling them."""
    for module in pkgutil.walk_packages([str(SOURCES / "analyses")], "sarrus.analyses."):
        importlib.import_module(module.name)
    own = [function for function in marked() if function.__module__.startswith("sarrus.analyses.")]
    assert len(own) > 100
    assert all(fingerprint(function) for function in own)


def filled_later(tree: ast.Module) -> Iterator[str]:
    """Globals of a module that are None, and functions of modules that are looked up by names in variables."""
    modules = {
        alias.asname or alias.name
        for node in tree.body
        if isinstance(node, ast.ImportFrom) and node.level
        for alias in node.names
    }
    for node in tree.body:
        match node:
            case ast.Assign(value=ast.Constant(value=None)) | ast.AnnAssign(value=ast.Constant(value=None)):
                yield ast.unparse(node)
    for node in ast.walk(tree):
        match node:
            case ast.Call(func=ast.Name(id="getattr" | "setattr"), args=[ast.Name(id=subject), name, *_]):
                if subject in modules and subject.islower() and not isinstance(name, ast.Constant):
                    yield ast.unparse(node)


def test_no_module_waits_to_be_filled() -> None:
    """A call in a compiled loop names its function; no other file puts it in place, or keeps a list of names."""
    assert list(
        filled_later(ast.parse("from . import loop\nA: int = None\n[getattr(loop, n) for n in 'ab']"))
    )
    sources = {file: file.read_text() for file in SOURCES.rglob("*.py")}
    able = re.compile(r"^\w[^=]*= None\b|[gs]etattr\(", re.MULTILINE)  # others need not be parsed
    texts = {str(f): text for f, text in sources.items() if "_jit" in text and able.search(text)}
    found = {name: list(filled_later(ast.parse(text))) for name, text in texts.items()}
    assert {name: lines for name, lines in found.items() if lines} == {}


def test_instructions_are_read_as_dis_reads_them() -> None:
    """Also where an argument needs several bytes: a function of 400 globals."""
    scope: dict[str, Any] = {}
    exec(f"def long():\n    return {' + '.join(f'name_{n}' for n in range(400))}", scope)
    importlib.import_module("sarrus.analyses.dynamics.integrators.described")
    for function in [scope["long"], *marked()]:
        code = function.__code__
        by_dis = [step.argval for step in dis.get_instructions(code) if step.opname == "LOAD_GLOBAL"]
        assert [code.co_names[n >> 1] for n in _arguments(code.co_code, dis.opmap["LOAD_GLOBAL"])] == by_dis
