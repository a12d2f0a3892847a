"""What the linker's compiler does with code: records are taken apart, and only entries have machine code."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple

import llvmlite.ir as llvm
import numpy as np
import pytest
from llvmlite.binding import Linkage
from numba import njit, types
from numpy.typing import NDArray

from sarrus._jit.linking.compiler import LinkedCompiler
from sarrus._jit.linking.link import compiled, link
from sarrus._jit.linking.record_lowering import FoldingBuilder, leave_out_unused

Values = NDArray[np.float64]


class Pair(NamedTuple):
    """Two arrays."""

    a: Values
    b: Values


class Both(NamedTuple):
    """A record in a record, and a number."""

    pair: Pair
    other: Pair
    scale: float


@compiled
def total(pair: Pair) -> float:
    """Sum of products."""
    value = 0.0
    for k in range(len(pair.a)):
        value += pair.a[k] * pair.b[k]
    return value


@compiled
def chosen(both: Both, n: int) -> float:
    """Records that are chosen on the way, made, handed on, and used in other blocks than those that assign them."""
    pair = both.pair if n % 2 else both.other
    crossed = Pair(both.pair.a, both.other.b)
    value = 0.0
    for k in range(n):
        value += total(pair) if k % 2 else both.scale * total(crossed)
        if k == 3:
            pair = both.pair
    if n > 2:
        last = pair
    for _ in range(2):
        if n > 2:
            value += last.a[0]
    return value


def cubes(x: Values) -> float:
    """Sum of cubes, in a loop that LLVM could unroll."""
    value = 0.0
    for k in range(len(x)):
        value += x[k] * x[k] * x[k]
    return value


@compiled(entry=True)
def use(both: Both, n: int) -> float:
    """An entry, whose argument is used after it was handed on."""
    found = chosen(both, n)
    if found > 0.0:
        return found + both.pair.a[1]
    return found - total(both.other)


@compiled
def power(x: float, n: int) -> float:
    """A function that is called with constants."""
    return x**n


@compiled(entry=True)
def returned(both: Both, n: int) -> Values:
    """An array of an argument."""
    pair = both.pair
    return pair.a if n > 0 else both.other.b


def record() -> Both:
    x = np.arange(1.0, 5.0)
    return Both(Pair(x, x * x), Pair(x + 10.0, x - 7.0), 0.5)


@pytest.mark.parametrize("n", range(7))
def test_records_have_the_values_that_python_gives_them(n: int) -> None:
    assert link(use)(record(), n) == use(record(), n)


def test_arrays_of_records_keep_their_references() -> None:
    both = record()
    before = sys.getrefcount(both.pair.a)
    for _ in range(50):
        found = link(returned)(both, 1)
    assert np.shares_memory(found, both.pair.a)
    del found
    after = sys.getrefcount(both.pair.a)
    assert after == before
    assert both.pair.a.tolist() == [1.0, 2.0, 3.0, 4.0]


def test_a_function_is_compiled_once_for_all_constants() -> None:
    """Numba has a type for each constant, and would compile the function for each."""
    inner: Any = link(power)
    for n in (2, 3):
        _, _, kinds, _ = inner.get_call_template((types.float64, types.literal(n)), {})
        assert kinds == (types.float64, types.int64)
    assert len(inner.overloads) == 1


def test_only_entries_have_machine_code() -> None:
    entry: Any = link(use)
    entry(record(), 1)
    inner = entry.py_func.__globals__["chosen"]
    (found,) = entry.overloads.values()
    symbols = found.library.codegen._engine
    assert symbols.is_symbol_defined(found.fndesc.llvm_func_name)
    assert not [
        one for one in inner.overloads.values() if symbols.is_symbol_defined(one.fndesc.llvm_func_name)
    ]


def test_an_entry_that_is_part_of_another_is_found_by_its_name() -> None:
    """Its copy there takes other arguments: those that it uses."""
    options: dict[str, Any] = {"pipeline_class": LinkedCompiler, "no_cfunc_wrapper": True}
    compiler: Any = njit
    scope: dict[str, Any] = {"math": math}
    step = "    value = math.sin(value) + math.exp(value * math.cos(x[0] - value))\n"
    exec(
        f"def long(x, unused):\n    value = 0.0\n{100 * step}    return value", scope
    )  # too long to be copied
    inner = compiler(**options)(scope["long"])

    def outer(x: Values) -> float:
        return inner(x, 1.0) - inner(x[1:], 2.0)  # type: ignore[no-any-return]

    def address() -> int:
        (found,) = inner.overloads.values()
        return int(found.library.get_pointer_to_function(found.fndesc.llvm_func_name))

    x = np.linspace(0.0, 1.0, 5)
    value, before = inner(x, 3.0), address()
    assert compiler(**options)(outer)(x) == pytest.approx(value - scope["long"](x[1:], 0.0), rel=1e-9)
    assert address() == before


def test_entries_hold_private_functions_and_a_plain_way_from_python() -> None:
    options: dict[str, Any] = {"pipeline_class": LinkedCompiler, "no_cfunc_wrapper": True}
    compiler: Any = njit
    inner = compiler(**options, _nrt=False, no_cpython_wrapper=True)(cubes)

    def entry(x: Values) -> float:
        return 2.0 * inner(x)  # type: ignore[no-any-return]

    call: Any = compiler(**options)(entry)
    x = np.linspace(0.5, 1.5, 7)
    assert call(x) == pytest.approx(2.0 * (x**3).sum(), rel=1e-14)
    (found,) = call.overloads.values()
    functions = {one.name: one for one in found.library.get_defined_functions()}
    unoptimized = {name for name, one in functions.items() if b"optnone" in b" ".join(one.attributes)}
    assert unoptimized == {found.fndesc.llvm_cpython_wrapper_name}
    assert {one.linkage for one in functions.values()} == {Linkage.external, Linkage.private}
    assert found.library.get_llvm_str().count("fmul double") == 3  # with copies of the loop there are more


SCRIPT = """
import sys
import numpy as np
from sarrus._jit.linking.compiler import LinkedCompiler
from sarrus._jit.linking.link import compiled, link

@compiled
def deep(x):
    if x < 0.0:
        raise ValueError("negative")
    return x * x

@compiled
def middle(x):
    return deep(x) + 1.0

@compiled(entry=True)
def first(x):
    return middle(x)

@compiled(entry=True)
def second(x):
    return 2.0 * middle(x)

print(link(globals()[sys.argv[1]])(3.0))
try:
    link(globals()[sys.argv[1]])(-1.0)
except ValueError as error:
    print(error)
"""


def test_what_a_process_has_stored_without_code_is_linked_by_another(tmp_path: Path) -> None:
    """`second` calls functions that the first process has compiled for its own entry."""
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    (cache := tmp_path / "cache").mkdir(mode=0o700)
    for name, value in ("first", "10.0"), ("second", "20.0"), ("second", "20.0"):
        done = subprocess.run(
            [sys.executable, script, name],
            env={**os.environ, "SARRUS_CACHE_DIR": str(cache)},
            capture_output=True,
            text=True,
            check=True,
        )
        assert done.stdout.split() == [value, "negative"]


def function_with_a_structure() -> tuple[Any, Any, Any]:
    """A function of two numbers, its builder, and the structure that it puts them into, the second within another."""
    number = llvm.DoubleType()
    inner = llvm.LiteralStructType([number])
    function = llvm.Function(
        llvm.Module(), llvm.FunctionType(number, [number, number, llvm.PointerType(inner)]), "f"
    )
    builder = FoldingBuilder(function.append_basic_block())
    whole = llvm.Constant(llvm.LiteralStructType([number, inner]), llvm.Undefined)
    whole = builder.insert_value(whole, function.args[0], 0)
    return function, builder, builder.insert_value(whole, function.args[1], [1, 0])


def test_parts_are_taken_from_where_they_were_put() -> None:
    function, builder, whole = function_with_a_structure()
    assert builder.extract_value(whole, 0) is function.args[0]
    assert builder.extract_value(whole, [1, 0]) is function.args[1]
    part = builder.extract_value(whole, 1)  # of which one number was put in, not all
    assert isinstance(part, llvm.instructions.ExtractValue)
    again = builder.insert_value(whole, part, 1)
    assert builder.extract_value(again, [1, 0]).aggregate is part


def test_what_nobody_uses_is_left_out_and_what_has_an_effect_stays() -> None:
    function, builder, whole = function_with_a_structure()
    builder.store(builder.extract_value(whole, 1), function.args[2])
    builder.insert_value(whole, function.args[1], 0)
    builder.ret(builder.extract_value(whole, 0))
    leave_out_unused(function)
    assert [one.opname for one in function.blocks[0].instructions] == [
        "insertvalue", "insertvalue", "extractvalue", "store", "ret",
    ]  # fmt: skip


@compiled(entry=True)
def zeros(n: int) -> Values:
    """A function of Numba that may fail."""
    return np.zeros(n)


def test_functions_of_numba_without_code_of_their_own_serve_other_compiled_functions() -> None:
    made: Any = link(zeros)
    assert made.py_func(2).tolist() == made(2).tolist() == [0.0, 0.0]
    other = njit(lambda n: np.zeros(n).sum())
    assert other(3) == 0.0
    for function in (made, other):
        with pytest.raises(ValueError, match="negative dimensions"):
            function(-1)
